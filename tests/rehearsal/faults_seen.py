"""One rehearsal with one fault, and where it was noticed: for the tests and for docs/faults.md."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.day import DROPPED, Drop, rehearse
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.truth import drawn_truth
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog, load
from tfsat_host.sdlog.summary import warnings

SEED = 1
SCHEDULE = schedule_maneuver(four_stroke(59.0, 70.0))


@dataclass(frozen=True, eq=False)
class Seen:
    """What became of it.

    Attributes:
        drop: The day.
        log: Of its recording; None: there is none.
        said: Where something was said, and what: a refusal, the log, the report.
    """

    drop: Drop
    log: DropLog | None
    said: dict[str, str]

    @property
    def moved_deg(self) -> float:
        """How far the joint that moved most went from where it began."""
        angles = self.drop.truth[:, 1:4]
        return float(np.rad2deg(np.abs(angles - angles[0]).max()))

    @property
    def moves_at_the_end(self) -> bool:
        """Some joint still moved in the last half second of the fall."""
        assert self.drop.landed_s is not None
        t = self.drop.truth[:, 0]
        last = (t > self.drop.landed_s - 0.5) & (t < self.drop.landed_s)
        angles = self.drop.truth[last, 1:4]
        return bool(np.rad2deg(np.ptp(angles, axis=0).max()) > 0.1)


@cache
def seen(fault: Fault) -> Seen:
    """Flown, decoded, evaluated."""
    filed = load_robot()
    drop = rehearse(SCHEDULE, filed, drawn_truth(filed, SEED), faults=(fault,))
    if drop.refused is not None:
        return Seen(drop, None, {"refusal": str(drop.refused.what)})
    with TemporaryDirectory() as folder:
        path = Path(folder) / "SD.bin"
        path.write_bytes(drop.card)
        log = load(path)
    said = {"log": " ".join(warnings(log))}
    try:
        found = evaluate(log, filed, drop.calibration, SCHEDULE, recorded=DROPPED)
        verdict = verdict_of(found)
        causes = [check.cause or "" for check in found.failed_checks]
        said["report"] = " ".join((verdict.sentence, *verdict.reasons, *found.notes, *causes))
    except TfsatError as error:
        said["report"] = f"{error.what} {error.meaning}"
    return Seen(drop, log, said)
