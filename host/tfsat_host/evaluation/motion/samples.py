"""The samples of one drop, from just before the release to just before the landing, in body axes and SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.apply import apply_calibration, weightless
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.evaluation.errors import EvaluationError
from tfsat_host.protocol.limits import FALL_US, SAMPLE_RATE_HZ
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.droplog import rows_of

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

LEAD_S = 0.3
"""So much before the release belongs to it: differences of neighbouring samples need some on either side. The robot
still hangs then, and a gyro that feels its weight has another bias: its rates tell nothing of that in the fall."""
LANDING_GUARD_S = 0.05
"""The evaluation ends so long before the landing, as the release springs and the cushion are not the model's."""
LEAST_S = 0.05
"""Of less of a fall nothing can be said."""
GREATEST_GAP_S = 0.1
"""Over a longer hole in all gyros nothing is carried: a stroke turns the robot by 20 deg meanwhile."""


@dataclass(frozen=True, eq=False)
class Samples:
    """n samples at which at least one gyro answered; NaN where a sensor did not.

    Attributes:
        t_s: (n,) after the release, increasing; the true sample times.
        rate_rad_s: (n, 4, 3) body axes, as the gyros show it: late by their low-pass.
        rate_jacobian: (n, 4, 3, 9) by bias, rotation vector and scale of each gyro.
        parameter_covariance: (4, 9, 9) of those in the fall.
        hanging_covariance: (4, 9, 9) of those while the robot hangs, where a bias holds what its weight makes a gyro
            show, as it did when it was taken.
        sensor_angle_rad: (n, 6) what the angle sensors show.
        answered: (n, 4) the gyro answered and was not clipped.
        rate_hz: Sampling rate as commanded.
        until_s: The end of the evaluation, after the release.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    rate_jacobian: FloatArray
    parameter_covariance: FloatArray
    hanging_covariance: FloatArray
    sensor_angle_rad: FloatArray
    answered: BoolArray
    rate_hz: float
    until_s: float

    def __len__(self) -> int:
        return len(self.t_s)

    @property
    def fall(self) -> BoolArray:
        """(n,) after the release."""
        return self.t_s >= 0.0


def samples_of(log: DropLog, calibration: Calibration, model: RobotModel) -> Samples:
    """Cuts the drop out of a recording and calibrates it.

    Args:
        log: A decoded drop.
        calibration: Of its sensors.
        model: Their places in the log.

    Raises:
        EvaluationError: the recording holds no release, nothing of the fall, or a hole that no attitude can bridge.
    """
    if log.release_us is None:
        raise EvaluationError(
            what="The recording holds no release.",
            meaning="It is no drop, or its release is lost; nothing can be said about a maneuver.",
            next_step="See what it holds: tfsat-host decode",
        )
    until_s = end_of_fall_s(log) - LANDING_GUARD_S
    if until_s < LEAST_S:
        raise EvaluationError(
            what=f"The recording ends {until_s + LANDING_GUARD_S:.3f} s after the release.",
            meaning="It has nothing of the fall: there is nothing to evaluate.",
            next_step="See what it holds: tfsat-host decode; fetch the recording again: tfsat-host log fetch",
        )
    first, last = np.searchsorted(log.t_s, [-LEAD_S, until_s], side="right")
    part = rows_of(log, slice(int(first), int(last)))
    answered = part.imu_valid & ~part.clipped
    kept = np.flatnonzero(answered.any(axis=1))
    _require_no_hole(part.t_s[kept], until_s)
    counts = Counts.from_log(part)
    calibrated = apply_calibration(counts, calibration, model)
    # At the samples' times, which those of `DropLog` are not.
    shown = np.where(part.angle_valid, Recording.from_counts(counts).sensor_angle_rad, np.nan)
    rates = np.where(answered[..., None], calibrated.rate_rad_s, np.nan)
    return Samples(
        part.t_s[kept],
        rates[kept],
        calibrated.rate_jacobian[kept],
        weightless(calibrated.parameter_covariance),
        calibrated.parameter_covariance,
        shown[kept],
        answered[kept],
        float(log.header.rate_hz or SAMPLE_RATE_HZ),
        until_s,
    )


def end_of_fall_s(log: DropLog) -> float:
    """The landing that the logger saw, the end of the longest fall, or the last sample, after the release."""
    landings = [log.seconds(event.t_us) for event in log.events if event.name == "landing"]
    return float(min([FALL_US * 1e-6, float(log.t_s[-1]), *(t_s for t_s in landings if t_s > 0.0)]))


def _require_no_hole(t_s: FloatArray, until_s: float) -> None:
    edges = np.concatenate([[0.0], t_s[t_s > 0.0], [until_s]])
    holes = np.diff(edges)
    if len(t_s) < 2 or holes.max() > GREATEST_GAP_S:
        worst = int(holes.argmax())
        raise EvaluationError(
            what=f"No gyro has a sample between {edges[worst]:.3f} s and {edges[worst + 1]:.3f} s after the release.",
            meaning=f"Over more than {GREATEST_GAP_S:g} s no attitude can be carried: nothing can be evaluated.",
            next_step="Look at the gaps: tfsat-host decode; fetch the recording's second copy: tfsat-host log fetch",
        )
