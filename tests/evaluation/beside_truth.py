"""How far a motion is from the emulated robot's truth, beside how far it says that it may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.evaluation.drops import Drop
from tfsat_host.evaluation.motion.motion import Motion

FloatArray = NDArray[np.float64]

RAMPS_DEG = 0.03
"""What two moments of a low-pass leave of a servo's ramp in a joint's angle."""
STDS = 4.0


@dataclass(frozen=True, slots=True)
class TurnOff:
    """A body's last attitude.

    Attributes:
        error_deg: From the truth.
        std_deg: As stated, in the direction that is known least.
        stds: The error by its whole covariance.
    """

    error_deg: float
    std_deg: float
    stds: float


def turn_off(one: Drop, found: Motion, body: int, from_s: float | None = None) -> TurnOff:
    """Of body 1 to 4 since the first sample of the fall, or since `from_s`."""
    track = found.bodies[body - 1]
    true = one.true_turn(body, float(track.t_s[0]) if from_s is None else from_s, float(track.t_s[-1]))
    error = (track.attitude[-1] * true.inv()).as_rotvec()
    covariance = track.covariance()
    return TurnOff(
        float(np.rad2deg(np.linalg.norm(error))),
        float(np.rad2deg(np.sqrt(np.linalg.eigvalsh(covariance).max()))),
        float(np.sqrt(error @ np.linalg.solve(covariance, error))),
    )


def angle_off_deg(one: Drop, found: Motion, joint: int) -> tuple[FloatArray, FloatArray]:
    """(m,) errors of the angle of joint 1 to 3 in the fall, and (m,) their stated standard deviations."""
    fall = found.samples.fall
    error = (found.angles_rad - one.true_angles_rad(found.t_s))[fall, joint - 1]
    return np.rad2deg(error), np.rad2deg(found.joints[joint - 1].std_rad()[fall])


def assert_angle_holds(one: Drop, found: Motion, joint: int, widest_deg: float) -> None:
    """The truth lies within what is stated, and that is no wider than so much."""
    error, std = angle_off_deg(one, found, joint)
    assert (np.abs(error) < STDS * std + RAMPS_DEG).all(), np.abs(error).max()
    assert std.max() < widest_deg
