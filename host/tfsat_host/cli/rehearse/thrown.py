"""The faults that were thrown into a rehearsed day: when each struck, what must come of it, who noticed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from tfsat_host.quantity import fields, record, records

if TYPE_CHECKING:
    from tfsat_host.errors import TfsatError
    from tfsat_host.present.output import Output
    from tfsat_host.rehearsal.drop import Drop
    from tfsat_host.rehearsal.faults.fault import Fault
    from tfsat_host.run.evaluated import EvaluatedRun
    from tfsat_host.sdlog import DropLog

Json = dict[str, Any]

FAULT = fields("name what moment=moment.typed when=moment.value outcome=outcome.value")
"""Of a fault, for JSON."""


class Thrown:
    """The faults of one day.

    Attributes:
        faults: To rehearse with: they tell when they strike.
    """

    def __init__(self, faults: Sequence[Fault]) -> None:
        self._struck_s: dict[str, float] = {}
        self.faults = tuple(
            fault.telling(partial(self._struck_s.__setitem__, fault.name)) for fault in faults
        )

    def facts(
        self, drop: Drop, log: DropLog | None, evaluated: EvaluatedRun | None, refusal: TfsatError | None
    ) -> list[Json]:
        """Of each, in the order in which they were named; times as in truth.json.

        Args:
            drop: The day.
            log: Of its recording; None: there is none.
            evaluated: None: it was not.
            refusal: Why it could not be evaluated.
        """
        from tfsat_host.rehearsal.noticed import notices_of, said_of
        from tfsat_host.rehearsal.outcome import came_of, designed_for, moved_deg

        told = None if evaluated is None else (evaluated.found, evaluated.verdict)
        said = said_of(drop, log, told, refusal)
        alone = len(self.faults) == 1
        good = evaluated is not None and evaluated.verdict.level == "good"
        designed = designed_for(self.faults, self._struck_s)
        return [
            {
                **record(FAULT, fault),
                "struck_s": self._struck_s.get(fault.name),
                "came_of_it": came_of(fault.outcome, drop) if fault.name in self._struck_s else None,
                "outcome_of_all": designed.value,
                "all_came_of_it": came_of(designed, drop),
                "joints_moved_true_deg": [float(moved) for moved in moved_deg(drop)],
                "to_be_noticed": bool(fault.noticed or fault.morning),
                "noticed_by": records(
                    fields("who what by_name=certain"),
                    notices_of(fault, drop, said, alone=alone, good=good)
                    if fault.name in self._struck_s
                    else (),
                ),
            }
            for fault in self.faults
        ]


WHO = {
    "preflight": "the preflight's checks",
    "refusal": "a board, which refused to go on",
    "board": "a board after the landing",
    "log": "the log",
    "report": "the evaluation",
    "report refuses": "the evaluation, which refused",
}


def _if_dropped(fault: Json) -> str:
    """What it does if the preflight lets it go, or nobody listens to that."""
    from tfsat_host.rehearsal.faults.fault import Outcome

    judged = fault["came_of_it"] is not None
    return "" if judged or fault["outcome"] == Outcome.NOT_DROPPED.value else ", if it is dropped"


def _came_of(fault: Json) -> str:
    """Whether it did; nothing where nothing was dropped that could have."""
    from tfsat_host.rehearsal.faults.fault import Outcome

    if fault["came_of_it"] is None:
        return ""
    if fault["outcome"] == Outcome.NOT_DROPPED.value:
        return " It was not." if fault["came_of_it"] else " It WAS."
    if fault["came_of_it"]:
        return " It did."
    if fault["outcome"] != fault["outcome_of_all"] and fault["all_came_of_it"]:
        return f" It did not, for another fault: with that it {fault['outcome_of_all']}, and it did."
    moved = ", ".join(f"{moved:.1f}" for moved in fault["joints_moved_true_deg"])
    return f" It did NOT: in truth joints 1, 2, 3 moved by up to {moved} deg."


def broke_design(faults: Sequence[Json]) -> bool:
    """The robot did not do what it must with all of them together."""
    return any(fault["struck_s"] is not None and fault["all_came_of_it"] is False for fault in faults)


def show_thrown(faults: Sequence[Json], out: Output) -> None:
    """A few lines each."""
    for fault in faults:
        out.line(f"Thrown in:            {fault['name']} ({fault['when']}): {fault['what']}")
        if fault["struck_s"] is None:
            out.line("                      It did not strike: the day ended before.")
            continue
        out.line(
            f"                      By design the robot then {fault['outcome']}{_if_dropped(fault)}.{_came_of(fault)}"
        )
        for one in fault["noticed_by"]:
            unnamed = "" if one["by_name"] else ", not by the fault's name"
            out.line(f"                      Noticed by {WHO[one['who']]}{unnamed}: {one['what']}")
        if not fault["noticed_by"]:
            out.line(f"                      {_unnoticed(fault, faults)}")


def _unnoticed(fault: Json, faults: Sequence[Json]) -> str:
    """Why nobody noticed it, if that is plain."""
    if not fault["to_be_noticed"]:
        return "Noticed by nobody. It changes nothing that is to be noticed."
    others = [one["name"] for one in faults if one is not fault and one["noticed_by"]]
    if not others:
        return "Noticed by nobody."
    return f"Noticed by nobody by its own name. What {' and '.join(others)} did may hide it: rehearse it by itself."
