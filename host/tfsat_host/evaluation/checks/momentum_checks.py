"""The angular momentum in the fall: nothing from outside can change it, so what changes it is an error or a touch."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

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
    yield _constant(motion, fit)
    yield _before_after(motion, fit, base)


def _constant(motion: Motion, fit: ModelFit) -> Check:
    t = motion.t_s[motion.t_s >= SETTLED_S]
    blocks = Blocks.of(t, BLOCK_S)
    # Residual of the base's rate: means over blocks, (k, 3).
    residual = blocks.mean(fit.residual_rad_s)
    # The model does not know ringing frames: a floor under each block's noise.
    noise = blocks.mean(fit.derivatives.noise) / blocks.counts[:, None, None]
    variance = noise + RATE_FLOOR_RAD_S**2 * np.eye(3)
    rms_deg_s = float(np.rad2deg(np.sqrt((residual**2).mean())))
    expected = float(np.sqrt(np.trace(variance.mean(axis=0)) / 3.0))
    worst_s = t[blocks.edges][np.linalg.norm(residual, axis=1).argmax()]
    sentence = f"Residual of the base's rate: {rms_deg_s:.3f} deg/s rms, largest at {worst_s:.1f} s."
    return CONSTANT.judge(rms_deg_s, float(np.rad2deg(expected * rms_limit(residual.size))), sentence)


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
        f"Change of momentum over the maneuver: {np.rad2deg(value):.3f} deg/s of the base beyond the model."
    )
    return BEFORE_AFTER.judge(float(np.rad2deg(value)), float(np.rad2deg(limit)), sentence)
