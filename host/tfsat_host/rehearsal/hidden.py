"""One drop of a hidden robot, all of it drawn together: what an evaluation gets, and the truth that it is judged by.

The firmware's own logger records it, of a day without preflight and bench: a quarter of a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.maneuver import Schedule
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.faults.fault_catalog import fault_named
from tfsat_host.rehearsal.rehearsed_drop import rehearse
from tfsat_host.rehearsal.series import decode_drop
from tfsat_host.rehearsal.truth import Truth, drawn_truth
from tfsat_host.robot import RobotModel, Uncertainty
from tfsat_host.sdlog import DropLog


def draw_hidden(
    filed: RobotModel, seed: int, mismatches: Sequence[Fault] = (), uncertainty: Uncertainty | None = None
) -> Truth:
    """Draw a robot that its file's `[uncertainty]` allows, all parameters together, and add mismatches.

    `mismatches` are faults with a size; those that happen during a drop change nothing here. `uncertainty` is
    used instead of the file's.
    """
    stated = replace(filed, uncertainty=uncertainty or filed.uncertainty)
    truth = drawn_truth(stated, seed)
    # The file's uncertainty first, mismatches on top of it.
    for fault in (fault_named("robot-file-uncertain"), *mismatches):
        truth = fault.apply(truth)
    return replace(truth, model=replace(truth.model, uncertainty=filed.uncertainty))


@dataclass(frozen=True, eq=False)
class HiddenDrop:
    """One drop.

    Attributes:
        log: As decoded from the card.
        filed: The robot as its file has it.
        calibration: The certificate, as filed.
        schedule: What was flown.
        truth: The robot that flew: model, sensors, initial rate.
        rows: (n, 32) of `EmulatedRobot.truth`, each ms, times after the release.
        landed_s: After the release.
    """

    log: DropLog
    filed: RobotModel
    calibration: Calibration
    schedule: Schedule
    truth: Truth
    rows: FloatArray
    landed_s: float


def hidden_drop(
    schedule: Schedule, filed: RobotModel, truth: Truth, faults: Sequence[Fault] = ()
) -> HiddenDrop:
    """Flies a schedule with the robot of `draw_hidden`; `filed` is the robot as its file has it.

    `faults` happen meanwhile, such as a bias that steps; and mismatches on top. Raises TfsatError: a board
    refuses.
    """
    drop = rehearse(schedule, filed, truth, faults=faults, bench=False)
    if drop.released_s is None or drop.landed_s is None:
        assert drop.refused is not None
        raise drop.refused
    rows = drop.truth.copy()
    rows[:, 0] -= drop.released_s
    return HiddenDrop(
        decode_drop(drop),
        filed,
        drop.calibration,
        schedule,
        drop.robot,
        rows,
        drop.landed_s - drop.released_s,
    )
