"""The angular momentum in the fall: nothing from outside can change it, so what changes it is an error or a touch."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.checks.check import Check, Kind, rms_limit, z_limit
from tfsat_host.evaluation.checks.stated_errors import RATE_FLOOR_RAD_S
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.motion.gyro_signal import BLOCK_S
from tfsat_host.evaluation.motion.motion import SETTLED_S, Motion
from tfsat_host.evaluation.motion.samples import Blocks

CONSTANT = Kind("momentum throughout the fall", "deg/s", ("offsets",))
BEFORE_AFTER = Kind("momentum before and after the maneuver", "deg/s", ("offsets",))
QUIET_RAD_S = np.deg2rad(5.0)
"""A joint that turns slower stands."""
MIN_QUIET_S = 0.1


def momentum_checks(motion: Motion, fit: ModelFit | None, base: int) -> Iterator[Check]:
    """Yield both checks of the momentum: that it is constant, and before against after."""
    if fit is None:
        why = "No model was fitted to this drop."
        yield CONSTANT.not_possible(why)
        yield BEFORE_AFTER.not_possible(why)
        return
    block_residuals = _Left.of(motion, fit)
    yield _constant(block_residuals)
    yield _before_after(motion, fit, base)


class _Left(NamedTuple):
    """What the fitted model does not explain, over k blocks, as a rate of the base.

    Attributes:
        t_s: (k,) where each begins.
        rate_rad_s: (k, 3) means.
        variance: (k, 3, 3) of those, with a floor.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    variance: FloatArray

    @classmethod
    def of(cls, motion: Motion, fit: ModelFit) -> _Left:
        t = motion.t_s[motion.t_s >= SETTLED_S]
        blocks = Blocks.of(t, BLOCK_S)
        # The model does not know ringing frames: a floor under each block's noise.
        noise = blocks.mean(fit.derivatives.noise) / blocks.counts[:, None, None]
        return cls(t[blocks.edges], blocks.mean(fit.residual_rad_s), noise + RATE_FLOOR_RAD_S**2 * np.eye(3))


def _constant(block_residuals: _Left) -> Check:
    rms = float(np.sqrt((block_residuals.rate_rad_s**2).mean()))
    expected = float(np.sqrt(np.trace(block_residuals.variance.mean(axis=0)) / 3.0))
    worst = int(np.linalg.norm(block_residuals.rate_rad_s, axis=1).argmax())
    sentence = (
        f"The model leaves {np.rad2deg(rms):.3f} deg/s rms of the base's rate unexplained, most of it at "
        f"{block_residuals.t_s[worst]:.1f} s."
    )
    limit = expected * rms_limit(block_residuals.rate_rad_s.size)
    return CONSTANT.judge(float(np.rad2deg(rms)), float(np.rad2deg(limit)), sentence)


def _before_after(motion: Motion, fit: ModelFit, base: int) -> Check:
    settled = motion.t_s >= SETTLED_S
    moving = np.flatnonzero((np.abs(motion.fused.joint_rate_rad_s[settled]) > QUIET_RAD_S).any(axis=1))
    t = motion.t_s[settled]
    if not len(moving):
        return BEFORE_AFTER.not_possible("No joint moved: there is no before and no after.")
    before, after = slice(0, int(moving[0])), slice(int(moving[-1]) + 1, None)
    if min(t[moving[0]] - t[0], t[-1] - t[moving[-1]]) < MIN_QUIET_S:
        return BEFORE_AFTER.not_possible("The joints did not stand long enough before and after.")
    own = motion.bodies[base]
    # Compare in inertial axes, in which the momentum is constant: the base has turned meanwhile.
    inertial = own.attitude[np.flatnonzero(own.t_s >= SETTLED_S)].apply(fit.residual_rad_s)
    change = inertial[after].mean(axis=0) - inertial[before].mean(axis=0)
    # A sample's noise is much the same in all directions: the greatest serves for each.
    noise = np.linalg.eigvalsh(fit.derivatives.noise)[:, -1]
    variance = sum(float(noise[part].mean()) / len(noise[part]) for part in (before, after))
    limit = z_limit(3) * float(np.sqrt(variance + 2.0 * RATE_FLOOR_RAD_S**2))
    value = float(np.abs(change).max())
    sentence = (
        f"Between before and after the maneuver the momentum changes by {np.rad2deg(value):.3f} deg/s of the base "
        "more than the model explains."
    )
    return BEFORE_AFTER.judge(float(np.rad2deg(value)), float(np.rad2deg(limit)), sentence)
