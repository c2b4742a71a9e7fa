"""What each number of a calibration does to the final attitude of a drop and to its reorientation.

After a drop the attitude by a gyro is held against the one that the model predicts. Bias, misalignment, scale, noise
and the times of the samples spoil the first; the joints' zero points and where their strokes end, the second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.evaluation.budget import gyro_errors, prediction_errors
from tfsat_host.evaluation.budget.attitude_errors import Turned, in_all
from tfsat_host.maneuver import Schedule
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.robot import RobotModel
from tfsat_host.units import s_from_us

RATE_HZ = 280.0
"""Of the logger (paper, section "Result")."""


@dataclass(frozen=True, slots=True)
class Accuracies:
    """One standard deviation of each number, for every axis, joint, stroke or sample by itself.

    Attributes:
        bias_deg_s, misalignment_deg, scale: Of the gyro; the scale as a share of 1.
        noise_deg_s_sqrt_hz: Density of its noise (PS-MPU-6000A rev. 3.4, section 6.1).
        time_s: Of the time of a sample.
        zero_deg: Of the angle of a joint at the release.
        stroke_deg: Of the angle that a stroke reaches.
    """

    bias_deg_s: float
    misalignment_deg: float
    scale: float
    zero_deg: float
    stroke_deg: float
    noise_deg_s_sqrt_hz: float = 0.005
    time_s: float = 1e-4


CALIBRATED = Accuracies(bias_deg_s=0.02, misalignment_deg=0.1, scale=0.002, zero_deg=0.1, stroke_deg=1.0)
"""What a calibration is asked to reach."""
UNCALIBRATED = Accuracies(
    bias_deg_s=1.0, misalignment_deg=1.5, scale=0.03 / 3.0**0.5, zero_deg=6.0, stroke_deg=4.2
)
"""Without: chips on frames screwed by hand; a scale anywhere within the datasheet's 3 % (PS-MPU-6000A rev. 3.4,
section 6.1); joint 1 hung 6 deg open and its first stroke reached 54.8 of 59 deg in the paper's drop (section
"Result")."""


@dataclass(frozen=True, slots=True)
class Effect:
    """What one source does.

    Attributes:
        source: For people.
        size: The same, one standard deviation with its unit.
        measured: Whether it spoils the gyro's attitude, or else the model's prediction.
        first_order, exact: Both should tell the same as long as errors are small.
    """

    source: str
    size: str
    measured: bool
    first_order: Turned
    exact: Turned


@dataclass(frozen=True, slots=True)
class Budget:
    """All sources for the gyro on one body (1 to 4)."""

    body: int
    effects: tuple[Effect, ...]

    def of_gyro(self) -> Turned:
        """The attitude by the gyro, all sources together, by the exact numbers."""
        return in_all([effect.exact for effect in self.effects if effect.measured])

    def of_prediction(self) -> Turned:
        """The attitude by the model."""
        return in_all([effect.exact for effect in self.effects if not effect.measured])

    def of_difference(self) -> Turned:
        """The one against the other."""
        return in_all([effect.exact for effect in self.effects])


def attitude_budget(robot: RobotModel, schedule: Schedule, body: int, accuracies: Accuracies) -> Budget:
    """The budget of a drop without angular momentum, from the release to the end of the longest fall.

    Args:
        robot: With a gyro on that body.
        schedule: Strokes that do not overlap.
        body: 1 to 4.
        accuracies: How well each number is known.
    """
    fall = gyro_errors.fall_of(robot, schedule, body, RATE_HZ, s_from_us(FALL_US))
    path = prediction_errors.Path.of(robot, schedule, body)
    a, rad = accuracies, np.radians
    return Budget(
        body,
        (
            _effect("bias", f"{a.bias_deg_s:g} deg/s", gyro_errors.bias(fall, rad(a.bias_deg_s))),
            _effect(
                "misalignment",
                f"{a.misalignment_deg:g} deg",
                gyro_errors.misalignment(fall, rad(a.misalignment_deg)),
            ),
            _effect("scale", f"{100.0 * a.scale:.3g} %", gyro_errors.scale(fall, a.scale)),
            _effect(
                "noise of the gyro",
                f"{a.noise_deg_s_sqrt_hz:g} deg/s/√Hz",
                gyro_errors.noise(fall, rad(a.noise_deg_s_sqrt_hz)),
            ),
            _effect("time of a sample", f"{1e3 * a.time_s:g} ms", gyro_errors.timing(fall, a.time_s)),
            _effect(
                "zero point",
                f"{a.zero_deg:g} deg",
                prediction_errors.zero_point(path, rad(a.zero_deg)),
                measured=False,
            ),
            _effect(
                "end of a stroke",
                f"{a.stroke_deg:g} deg",
                prediction_errors.stroke_ends(path, rad(a.stroke_deg)),
                measured=False,
            ),
        ),
    )


def _effect(source: str, size: str, turned: tuple[Turned, Turned], *, measured: bool = True) -> Effect:
    return Effect(source, size, measured, *turned)
