"""What must be so while the robot hangs still: gravity is 1 g and down for all bodies, and gyros show their bias."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.checks.check import Check, judged, not_possible, z_limit
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.hanging import Hanging
from tfsat_host.evaluation.checks.stated_errors import StatedErrors
from tfsat_host.evaluation.fall.gravity_check import ALARM_STDS, AtRest, check_gravity
from tfsat_host.evaluation.motion.noise import SHEET_DENSITY_RAD_S_RTHZ
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

GRAVITY, DOWN, BIAS, NOISE = "gravity at rest", "down at rest", "gyro bias at rest", "gyro noise"
NOISY = 4.0
"""Times the data sheet's density, which is typical and without a limit."""
_NEVER_STILL = "The robot never hung still before the release, or that was not recorded."


def rest_checks(of: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """Of one drop."""
    if of.rest is None:
        yield from (
            not_possible(*one, _NEVER_STILL) for one in ((GRAVITY, "g"), (DOWN, "deg"), (BIAS, "deg/s"))
        )
        return
    yield _gravity(of.rest)
    yield _down(of.rest, of.model)
    yield _bias(of, stated)


def _gravity(rest: Hanging) -> Check:
    """Accelerometers are not calibrated: three of their standard deviations hold 50 mg, 80 mg along z, and 3 %."""
    found = [check_gravity(b + 1, one, None, None) for b, one in enumerate(rest.force) if one is not None]
    if not found:
        return not_possible(GRAVITY, "g", "No accelerometer answered before the release.")
    worst = max(found, key=lambda one: abs(one.norm_g - 1.0) / one.norm_std_g)
    sentence = (
        f"At rest body {worst.body} feels {worst.norm_g:.3f} g, the farthest from 1 g of {len(found)} bodies."
    )
    check = judged(GRAVITY, abs(worst.norm_g - 1.0), ALARM_STDS * worst.norm_std_g, "g", sentence)
    return check.caused_by(
        f"accelerometer of body {worst.body}: its range or its scale is not the header's, or it is defective",
        "Compare the accelerometers live, the robot at rest: tfsat-host monitor",
    )


def _down(rest: Hanging, model: RobotModel) -> Check:
    directions = _directions(rest, model)
    if len(directions) < 3:
        return not_possible(DOWN, "deg", "Fewer than three accelerometers answered: none can be outvoted.")
    usual = np.median([direction for direction, _, _ in directions.values()], axis=0)
    usual /= np.linalg.norm(usual)
    off = {b: float(np.arccos(np.clip(d @ usual, -1.0, 1.0))) for b, (d, _, _) in directions.items()}
    spread = float(np.sqrt(np.mean([std**2 for _, std, _ in directions.values()])))
    body = max(off, key=lambda b: off[b] / directions[b][1])
    limit = ALARM_STDS * float(np.hypot(directions[body][1], spread))
    sentence = f"At rest body {body + 1} feels down {np.rad2deg(off[body]):.1f} deg away from the others."
    check = judged(DOWN, float(np.rad2deg(off[body])), float(np.rad2deg(limit)), "deg", sentence)
    turn = directions[body][2]
    felt, right = (_axis(turn.T @ vector) for vector in (directions[body][0], usual))
    return check.caused_by(
        f"accelerometer of body {body + 1} feels up along {felt} where it is {right}: "
        "its axes are exchanged or reversed"
        if felt != right
        else f"unknown; body {body + 1} hangs bent, or its accelerometer is off by more than its data sheet allows",
        "Compare the IMU's mounting with the robot file: tfsat-host robot",
    )


def _directions(rest: Hanging, model: RobotModel) -> dict[int, tuple[FloatArray, float, FloatArray]]:
    """By body: up in base axes, its standard deviation, and the body's rotation to base axes."""
    starts = [servo.start_rad for servo in model.servos]
    angles = np.where(np.isfinite(rest.angles_rad), rest.angles_rad, starts)
    rotation, _ = poses(Multibody.of(model), angles)
    return {
        b: (rotation[b] @ one.mean_g / np.linalg.norm(one.mean_g), _across_std(one), rotation[b])
        for b, one in enumerate(rest.force)
        if one is not None and np.linalg.norm(one.mean_g) > 0.0
    }


def _across_std(one: AtRest) -> float:
    """Of a direction, by the errors square to it, rad."""
    norm = float(np.linalg.norm(one.mean_g))
    along = (one.mean_g / norm) ** 2
    return float(np.sqrt(((1.0 - along) * one.std_g**2).sum())) / norm


def _axis(vector: FloatArray) -> str:
    """The axis that is nearest."""
    axis = int(np.abs(vector).argmax())
    return f"{'-' if vector[axis] < 0 else '+'}{'xyz'[axis]}"


def _bias(of: Consistency, stated: StatedErrors) -> Check:
    worst: tuple[float, float, float, int, int] | None = None
    rows = [(b, axis) for b in range(4) for axis in range(3) if stated.known[of.at_rest(b)][axis]]
    for body, axis in rows:
        row = of.at_rest(body).start + axis
        limit = z_limit(len(rows)) * float(np.sqrt(stated.covariance[row, row]))
        off = float(of.own_vector[row])
        if worst is None or abs(off) / limit > worst[0]:
            worst = (abs(off) / limit, off, limit, body, axis)
    if worst is None:
        return not_possible(BIAS, "deg/s", "No gyro answered before the release.")
    _, off, limit, body, axis = worst
    taken = of.calibration.gyros[body].bias_taken
    against = (
        f"the bias of {taken:%Y-%m-%d %H:%M} UTC" if taken else "no bias at all, for none was calibrated"
    )
    sentence = (
        f"At rest the gyro of body {body + 1} shows {np.rad2deg(off):+.3f} deg/s about its {'xyz'[axis]} "
        f"beside {against}."
    )
    return judged(BIAS, float(np.rad2deg(abs(off))), float(np.rad2deg(limit)), "deg/s", sentence)


def noise_check(densities_rad_s_rthz: FloatArray) -> Check:
    """Of the gyros, before the release: what a check may miss follows from their noise, so noise is checked itself."""
    ratio = densities_rad_s_rthz / SHEET_DENSITY_RAD_S_RTHZ
    body = int(ratio.argmax())
    value = float(np.rad2deg(densities_rad_s_rthz[body]))
    sentence = (
        f"The gyro of body {body + 1} is the noisiest: {value:.4f} deg/s/sqrt(Hz), "
        f"{ratio[body]:.1f} times its data sheet's."
    )
    limit = float(np.rad2deg(NOISY * SHEET_DENSITY_RAD_S_RTHZ))
    return judged(NOISE, value, limit, "deg/s/sqrt(Hz)", sentence).caused_by(
        f"gyro of body {body + 1}: its supply or its cable is disturbed, or the robot was shaken before the release",
        "Watch the rates at rest: tfsat-host monitor",
    )
