"""The angular momentum in the fall: nothing from outside can change it, so what changes it is an error or a touch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.checks.check import Check, Kind, rms_limit, z_limit
from tfsat_host.evaluation.checks.diagnosis import CLEARLY, ENDS_IT
from tfsat_host.evaluation.checks.stated_errors import RATE_FLOOR_RAD_S
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.motion.gyro_signal import BLOCK_S
from tfsat_host.evaluation.motion.motion import SETTLED_S, Motion
from tfsat_host.evaluation.motion.samples import Blocks

CONSTANT = Kind("momentum throughout the fall", "deg/s", ("offsets",))
BEFORE_AFTER = Kind("momentum before and after the maneuver", "deg/s", ("offsets",))
QUIET_RAD_S = np.deg2rad(5.0)
"""A joint that turns slower stands."""
LEAST_QUIET_S = 0.1
_MOMENTUM_STD_RAD_S = np.deg2rad(100.0)


def momentum_checks(motion: Motion, fit: ModelFit | None, base: int) -> Iterator[Check]:
    """Both, and why."""
    if fit is None:
        why = "No model was fitted to this drop."
        yield CONSTANT.not_possible(why)
        yield BEFORE_AFTER.not_possible(why)
        return
    left = _Left.of(motion, fit)
    checks = (_constant(left), _before_after(motion, fit, base))
    cause = _cause(left, fit) if any(check.failed for check in checks) else ("", "")
    yield from (check.caused_by(*cause) for check in checks)


@dataclass(frozen=True, eq=False)
class _Left:
    """What the fitted model does not explain, over k blocks, as a rate of the base.

    Attributes:
        t_s: (k,) where each begins.
        rate_rad_s: (k, 3) means.
        unfitted_rad_s: (k, 3) the same before the fit gave offsets and sensors' errors a share in it.
        variance: (k, 3, 3) of those, with a floor.
        by_momentum: (k, 3, 3).
        by_known: (k, 3, r) by offsets and errors of variance one, and by an unknown momentum.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    unfitted_rad_s: FloatArray
    variance: FloatArray
    by_momentum: FloatArray
    by_known: FloatArray

    @classmethod
    def of(cls, motion: Motion, fit: ModelFit) -> _Left:
        t = motion.t_s[motion.t_s >= SETTLED_S]
        blocks = Blocks.of(t, BLOCK_S)
        mean = blocks.mean
        found = fit.derivatives
        unfitted = fit.residual_rad_s - found.by_errors @ fit.errors - found.by_offsets @ fit.values
        by_momentum = mean(found.by_momentum)
        unit = _MOMENTUM_STD_RAD_S / np.abs(by_momentum).max()
        return cls(
            t[blocks.edges],
            mean(fit.residual_rad_s),
            mean(unfitted),
            mean(found.noise) / blocks.counts[:, None, None] + RATE_FLOOR_RAD_S**2 * np.eye(3),
            by_momentum,
            np.concatenate(
                [mean(found.by_offsets) * fit.offsets.prior_std, unit * by_momentum, mean(found.by_errors)],
                axis=2,
            ),
        )


def _constant(left: _Left) -> Check:
    rms = float(np.sqrt((left.rate_rad_s**2).mean()))
    expected = float(np.sqrt(np.trace(left.variance.mean(axis=0)) / 3.0))
    worst = int(np.linalg.norm(left.rate_rad_s, axis=1).argmax())
    sentence = (
        f"The model leaves {np.rad2deg(rms):.3f} deg/s rms of the base's rate unexplained, most of it at "
        f"{left.t_s[worst]:.1f} s."
    )
    limit = expected * rms_limit(left.rate_rad_s.size)
    return CONSTANT.judged(float(np.rad2deg(rms)), float(np.rad2deg(limit)), sentence)


def _before_after(motion: Motion, fit: ModelFit, base: int) -> Check:
    settled = motion.t_s >= SETTLED_S
    moving = np.flatnonzero((np.abs(motion.fused.joint_rate_rad_s[settled]) > QUIET_RAD_S).any(axis=1))
    t = motion.t_s[settled]
    if not len(moving):
        return BEFORE_AFTER.not_possible("No joint moved: there is no before and no after.")
    before, after = slice(0, int(moving[0])), slice(int(moving[-1]) + 1, None)
    if min(t[moving[0]] - t[0], t[-1] - t[moving[-1]]) < LEAST_QUIET_S:
        return BEFORE_AFTER.not_possible("The joints did not stand long enough before and after.")
    own = motion.bodies[base]
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
    return BEFORE_AFTER.judged(float(np.rad2deg(value)), float(np.rad2deg(limit)), sentence)


def _cause(left: _Left, fit: ModelFit) -> tuple[str, str]:
    """A push from outside at one time, offsets that want to go too far, or nothing that is known."""
    k = len(left.t_s)
    known = left.by_known.reshape(3 * k, -1)
    covariance = known @ known.T
    for block in range(k):
        part = slice(3 * block, 3 * block + 3)
        covariance[part, part] += left.variance[block]
    root = np.linalg.cholesky(covariance)
    white = np.linalg.solve(root, left.unfitted_rad_s.ravel())
    whole = float(white @ white)
    best, at_s = whole, 0.0
    for at in range(1, k - 1):
        step = left.by_momentum.copy()
        step[: at + 1] = 0.0
        # In the block of the push the momentum is neither the old nor the new one.
        during = np.zeros((k, 3, 3))
        during[at] = left.by_momentum[at]
        pushed = np.concatenate([step, during], axis=2).reshape(3 * k, 6)
        columns = np.linalg.solve(root, pushed)
        off = white - columns @ np.linalg.lstsq(columns, white, rcond=None)[0]
        if float(off @ off) < best:
            best, at_s = float(off @ off), float(left.t_s[at])
    if best / (3 * k - 7) <= ENDS_IT and whole - best > CLEARLY + 7 * np.log(3 * k):
        return (
            f"a push from outside at {at_s:.1f} s: something touched the robot",
            "Look at the video, and at what hangs on the robot in the fall",
        )
    if fit.at_bound.any():
        names = ", ".join(n for n, bound in zip(fit.offsets.names, fit.at_bound, strict=True) if bound)
        return (
            f"the robot file: {names} would have to be off by more than its bound",
            "Weigh the bodies, and compare masses and inertias: tfsat-host robot",
        )
    return (
        f"unknown; chi-square {whole / (3 * k):.3g} a number, with a push at the best time {best / (3 * k):.3g}",
        "Compare masses, inertias and joint positions of the robot file: tfsat-host robot",
    )
