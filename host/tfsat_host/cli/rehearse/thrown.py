"""The faults that were thrown into a rehearsed day: when each struck, what must come of it, who noticed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun
    from tfsat_host.cli.output import Output
    from tfsat_host.errors import TfsatError
    from tfsat_host.rehearsal.drop import Drop
    from tfsat_host.rehearsal.faults.fault import Fault
    from tfsat_host.sdlog import DropLog

Json = dict[str, Any]


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

        told = None if evaluated is None else (evaluated.found, evaluated.verdict)
        said = said_of(drop, log, told, refusal)
        alone = len(self.faults) == 1
        good = evaluated is not None and evaluated.verdict.level == "good"
        return [
            {
                "name": fault.name,
                "what": fault.what,
                "moment": fault.moment.typed,
                "when": fault.moment.value,
                "struck_s": self._struck_s.get(fault.name),
                "outcome": fault.outcome.value,
                "to_be_noticed": bool(fault.noticed or fault.morning),
                "noticed_by": [
                    {"who": one.who, "what": one.what, "by_name": one.certain}
                    for one in notices_of(fault, drop, said, alone=alone, good=good)
                ]
                if fault.name in self._struck_s
                else [],
            }
            for fault in self.faults
        ]


_WHO = {
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

    return "" if fault["outcome"] == Outcome.NOT_DROPPED.value else ", if it is dropped"


def show_thrown(faults: Sequence[Json], out: Output) -> None:
    """A few lines each."""
    for fault in faults:
        out.line(f"Thrown in:            {fault['name']} ({fault['when']}): {fault['what']}")
        if fault["struck_s"] is None:
            out.line("                      It did not strike: the day ended before.")
            continue
        out.line(f"                      By design the robot then {fault['outcome']}{_if_dropped(fault)}.")
        for one in fault["noticed_by"]:
            unnamed = "" if one["by_name"] else ", not by the fault's name"
            out.line(f"                      Noticed by {_WHO[one['who']]}{unnamed}: {one['what']}")
        if not fault["noticed_by"]:
            why = "" if fault["to_be_noticed"] else " It changes nothing that is to be noticed."
            out.line(f"                      Noticed by nobody.{why}")
