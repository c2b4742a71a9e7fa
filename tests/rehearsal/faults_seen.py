"""One rehearsal with one fault, and where it was noticed: for the tests and for docs/faults.md."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.plan.facility import load_tower
from tfsat_host.rehearsal.checked import NoGo
from tfsat_host.rehearsal.day import DROPPED
from tfsat_host.rehearsal.drop import Drop
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.moment import Moment
from tfsat_host.rehearsal.noticed import BEFORE_PREFLIGHT, Said, said_of
from tfsat_host.rehearsal.preflight import Preflight
from tfsat_host.rehearsal.rehearse import rehearse
from tfsat_host.rehearsal.truth import drawn_truth
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog, load

SEED = 1
SCHEDULE = schedule_maneuver(four_stroke(59.0, 70.0))


@dataclass(frozen=True, eq=False)
class Seen:
    """What became of it.

    Attributes:
        no_go: Checks of the preflight that stood against the drop.
        drop: The day; with a preflight that says NO-GO, the day on which the team drops all the same.
        log: Of its recording; None: there is none.
        said: Where something was said, and what; see `tfsat_host.rehearsal.noticed.Said`.
    """

    no_go: tuple[str, ...]
    drop: Drop
    log: DropLog | None
    said: dict[str, str]


@cache
def _preflight(*, despite: bool) -> Preflight:
    return Preflight.of(SCHEDULE, load_robot(), load_tower(None), None, despite=despite)


def flown(fault: Fault, *, despite: bool) -> Drop:
    """A day with that fault, preflight and all."""
    filed = load_robot()
    truth = drawn_truth(filed, SEED)
    return rehearse(SCHEDULE, filed, truth, preflight=_preflight(despite=despite), faults=(fault,))


@cache
def no_go(fault: Fault) -> tuple[str, ...]:
    """Checks that stand against the drop when the fault is there in the morning already."""
    morning = fault if fault.moment in BEFORE_PREFLIGHT else fault.at(Moment.POWERED)
    drop = flown(morning, despite=False)
    assert drop.checked is not None
    assert isinstance(drop.refused, NoGo) == (not drop.checked.go)
    return tuple(check.name for check in drop.checked.wrong)


@cache
def seen(fault: Fault) -> Seen:
    """Flown, decoded, evaluated."""
    drop = flown(fault, despite=True)
    assert drop.checked is not None
    wrong = tuple(check.name for check in drop.checked.wrong)
    if drop.refused is not None:
        return Seen(wrong, drop, None, _joined(said_of(drop, None, None, None)))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "SD.bin"
        path.write_bytes(drop.card)
        log = load(path)
    try:
        found = evaluate(log, load_robot(), drop.calibration, SCHEDULE, recorded=DROPPED)
        said = said_of(drop, log, (found, verdict_of(found)), None)
    except TfsatError as error:
        said = said_of(drop, log, None, error)
    return Seen(wrong, drop, log, _joined(said))


def _joined(said: Said) -> dict[str, str]:
    return {who: " ".join(sentences) for who, sentences in said.items()}
