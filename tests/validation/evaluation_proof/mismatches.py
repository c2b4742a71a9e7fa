"""Drops of robots and sensors that are not as filed, and whether each evaluation of them knew how far off it is.

All else of a robot is drawn from its file's `[uncertainty]` and the certificate's covariance, as in simulation-based
calibration. A row that draws a figure of the file anew draws it instead of the file's own, not on top of it: masses 2 %
off are as wrong as their file says, masses 5 % off by two and a half times as much.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.errors import errors_of
from tests.validation.evaluation_proof.hidden import hidden
from tests.validation.simulation_based_calibration.drops import (
    CHIPS,
    FILED,
    draw_one_at_a_time,
    draw_together,
)
from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.result.model_result import worth_of
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.maneuver import Schedule
from tfsat_host.robot import Uncertainty
from tfsat_host.sdlog import DropLog

DROPS = 40
FIRST_SEED = 10_001
"""Of the first row; no two drops have the same."""
PROTECTED = {
    "reorientation of body 1": "attitudes",
    "reorientation of bodies 2 to 4": "attitudes",
    "final attitude of body 1": "attitudes",
    "initial rate": "rates",
    "joint angle": "strokes",
    "stroke": "strokes",
    "CoM": "offsets",
}
"""The quantities of a row, and as what each is withheld. What the corrected model misses is none of them: where a model
is wrong that is a finding, not an estimate of zero."""
_GYRO = slice(4, 7)
"""Words of an IMU's sample."""


@dataclass(frozen=True, slots=True)
class Row:
    """One mismatch.

    Attributes:
        name: In words.
        faults: As typed.
        exact: Fields of the file's `Uncertainty` that are not drawn from it: the faults draw them.
        of_model: No sensor is wrong: reorientation and strokes, which rest on sensors alone, are to be given.
        flagged: The gyro that saturates says so.
    """

    name: str
    faults: tuple[str, ...] = (CHIPS,)
    exact: tuple[str, ...] = ()
    of_model: bool = False
    flagged: bool = False

    @property
    def right(self) -> bool:
        """Nothing is wrong."""
        return self.faults == (CHIPS,)


def _model(name: str, exact: str, *faults: str) -> Row:
    return Row(name, (CHIPS, *faults), (exact,), of_model=True)


def _sensors(name: str, *faults: str) -> Row:
    return Row(name, (CHIPS, *faults))


_SATURATED = "gyro-saturated-unflagged=100"
ROWS = (
    Row("nothing", of_model=True),
    _model("masses 2 %", "mass_relative", "wrong-masses=2"),
    _model("masses 5 %", "mass_relative", "wrong-masses=5"),
    _model("hinge points 0.5 mm", "joint_point_m", "wrong-hinge-points=0.5"),
    _model("centers of mass, body 4's too, 3 mm", "com_m", "wrong-coms=3", "wrong-com-of-body-4=3"),
    _model("inertias 3 %", "inertia_relative", "wrong-inertias=3"),
    _model("inertias 5 %", "inertia_relative", "wrong-inertias=5"),
    _model("hinge axes 0.5 deg", "joint_axis_rad", "wrong-hinge-axes=0.5"),
    _model("hinge axes 1 deg", "joint_axis_rad", "wrong-hinge-axes=1"),
    _sensors("g-sensitivity five times the data sheet's", "gyro-g-sensitive=0.49"),
    _sensors("an IMU 1 ms late", "imu-late=1"),
    _sensors("an IMU 2 ms late", "imu-late=2"),
    _sensors("an IMU 3 ms late", "imu-late=3"),
    _sensors("an angle sensor slips 1 deg in the fall", "angle-sensor-crept=1"),
    _sensors("a bias steps 0.3 deg/s in the fall", "gyro-bias-step=0.3"),
    _sensors("a gyro saturates unflagged", _SATURATED),
    Row("a gyro saturates, flagged", (CHIPS, _SATURATED), flagged=True),
    _sensors("certificate off by 3 times its ± more", "certificate-wrong=3"),
    _sensors("mounts ring", "mount-ripple=2"),
    _sensors("gyro cross-axis 1 %", "gyro-cross-axis=1"),
    _sensors("a gyro's scale changed by 1 %", "gyro-scale-changed=1"),
    Row("IMU clocks within 2 %", ("imu-clocks=2",)),
    _sensors("scale factors bend by 0.2 %", "gyro-scale-bends=0.2"),
    _sensors("a bias steps 0.06 deg/s in the fall", "gyro-bias-step=0.06"),
    _sensors("gyro cross-axis 0.12 %", "gyro-cross-axis=0.12"),
)
"""Wrong by what: as the issue that asked for this has it, and what the emulated sensors can have besides."""


@dataclass(frozen=True, eq=False)
class Judged:
    """One drop.

    Attributes:
        together: Joints of its maneuver moved together.
        errors: By the names in `PROTECTED`, of what was given.
        withheld: Names of results, as of `Check.protects`, that were not.
        good: The verdict.
        worth: Of the correction.
        failed: Names of the checks.
        widening: See `Evaluation`.
    """

    together: bool
    errors: Mapping[str, Errors]
    withheld: tuple[str, ...]
    good: bool
    worth: str
    failed: tuple[str, ...]
    widening: float

    @property
    def worst(self) -> float:
        """Greatest error of all that was given, in its own standard deviations."""
        return max(
            (float(np.abs(errors.error / errors.std).max()) for errors in self.errors.values()), default=0.0
        )


def seeds_of(row: Row, drops: int = DROPS) -> range:
    """Fixed beforehand: a row keeps its own however many are flown."""
    # A hundred seeds a row: more drops of one row never shift the next row's.
    first = FIRST_SEED + 100 * ROWS.index(row)
    return range(first, first + drops)


def moves_together(seed: int) -> bool:
    """In every second drop joints move together; the first seed of a row or of causes is odd."""
    return seed % 2 == 0


def draw_schedule(seed: int) -> Schedule:
    """Draw the maneuver of a drop."""
    return draw_together(seed) if moves_together(seed) else draw_one_at_a_time(seed)


def judge_drop(row: Row, seed: int) -> Judged:
    """Draws and flies a drop, and evaluates it; two seconds, several where a check fails."""
    stated = FILED.uncertainty or Uncertainty()
    # The faults draw these figures themselves: drawn twice they would be wrong by more than the row says.
    uncertainty = replace(stated, **dict.fromkeys(row.exact, 0.0))
    drop, calibration = hidden(draw_schedule(seed), FILED, seed, row.faults, uncertainty=uncertainty)
    limit_rad_s = drop.imperfections.gyro_front_end_limit_rad_s
    log = _flag_samples(drop.log, limit_rad_s) if row.flagged else drop.log
    evaluation = evaluate(log, FILED, calibration, drop.schedule)
    errors = errors_of(drop, evaluation)
    return Judged(
        moves_together(seed),
        {name: errors[name] for name, result in PROTECTED.items() if _is_given(evaluation, result)},
        tuple(sorted(evaluation.withheld)),
        verdict_of(evaluation).level == "good",
        worth_of(evaluation),
        tuple(check.name for check in evaluation.failed_checks),
        evaluation.widening,
    )


def _is_given(evaluation: Evaluation, result: str) -> bool:
    # Joints' angles and strokes are withheld with any result of the sensors.
    return evaluation.is_given() if result == "strokes" else evaluation.is_given(result)


def _flag_samples(log: DropLog, limit_rad_s: FloatArray) -> DropLog:
    """Flag readings as clipped like gyros whose range ends at the limit of their front end.

    Args:
        log: The log as recorded.
        limit_rad_s: (4,) limit of each front end; 0: no limit.
    """
    reading = np.abs(log.imu_counts[:, :, _GYRO].astype(np.float64)).max(axis=2)
    full = np.rad2deg(limit_rad_s) * log.header.gyro_lsb_per_deg_s
    # The limit need not be a whole number of counts.
    return replace(log, clipped=log.clipped | ((full > 0.0) & (reading > full - 1.0)))
