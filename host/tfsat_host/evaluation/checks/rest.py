"""What must be so while the robot hangs still: gravity is 1 g and down, gyros show their bias, joints start right."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.checks.check import Check, judged, not_possible, z_limit
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.stated_errors import StatedErrors
from tfsat_host.evaluation.fall.micro_gravity import ALARM_STDS, AtRest, check_gravity
from tfsat_host.evaluation.fall.rest import Hanging, angles_at_rest
from tfsat_host.evaluation.motion.gyro_signal import SHEET_DENSITY_RAD_S_RTHZ
from tfsat_host.protocol.limits import START_POSE_TOLERANCE_CDEG
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

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


START_POSE = "start pose"
TOLERANCE_RAD = np.deg2rad(START_POSE_TOLERANCE_CDEG / 100.0)
"""What ARM and the preflight allow: an uncalibrated servo's scale, its play, and a joint that sags, as the paper's
joint 1 by 6 deg, stay within it."""
LOOKED_AT_S = 0.5
BEFORE_RELEASE_S = 0.02
"""The releaser's springs may move a joint that is on its way out."""


def start_pose_check(log: DropLog, calibration: Calibration, model: RobotModel) -> Check:
    """Of one drop, by the medians of the last half second before the release.

    Args:
        log: The recording.
        calibration: That it is evaluated with. A joint without a zero point of its own tells nothing here: it is taken
            to have hung where its servo starts.
        model: Joints, sensors, and the servos' starts.
    """
    rows = (log.t_s >= -LOOKED_AT_S) & (log.t_s < -BEFORE_RELEASE_S)
    if not rows.any():
        return not_possible(
            START_POSE, "deg", "No sample was recorded in the half second before the release."
        )
    angles = angles_at_rest(log, rows, calibration, model)
    measured = np.array([sensors.zero_taken is not None for sensors in calibration.joints])
    off_deg = np.rad2deg(angles - np.array([servo.start_rad for servo in model.servos]))
    told = np.flatnonzero(measured & np.isfinite(off_deg))
    if not len(told):
        return not_possible(
            START_POSE,
            "deg",
            "No joint has a calibrated angle sensor that tells where it stood at the release.",
        )
    worst = int(told[np.abs(off_deg[told]).argmax()])
    std_deg = np.rad2deg(np.sqrt(calibration.joints[worst].zero_covariance.max()))
    start_deg, limit_deg = float(np.rad2deg(model.servos[worst].start_rad)), float(np.rad2deg(TOLERANCE_RAD))
    at = f"{start_deg + off_deg[worst]:+.2f} ± {max(std_deg, 0.01):.2f} deg"
    pose = f"{start_deg:g} ± {limit_deg:g} deg"
    sentence = (
        f"Just before the release joint {worst + 1} stood at {at}, the farthest from the start pose ({pose})."
    )
    if abs(off_deg[worst]) > limit_deg:
        sentence = (
            f"Wrong start pose: just before the release joint {worst + 1} stood at {at} instead of {pose}. The strokes "
            "began elsewhere than the maneuver means."
        )
    check = judged(START_POSE, float(abs(off_deg[worst])), limit_deg, "deg", sentence)
    return check.caused_by(
        f"servo of joint {worst + 1}: it turns the other way, did not hold its joint, or was not calibrated; or the "
        "zero point of the joint's angle sensors is another one",
        f"Without a drop: tfsat-host jog --joint {worst + 1} --from 0 --to 5 shows which way it turns; "
        f"then tfsat-host calibrate zero --joint {worst + 1}",
    )
