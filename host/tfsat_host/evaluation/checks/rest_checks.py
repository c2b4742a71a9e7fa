"""What must be so while the robot hangs still: gravity is 1 g and down, gyros show their bias, joints start right."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.checks.check import Check, Kind, z_limit
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.stated_errors import StatedErrors
from tfsat_host.evaluation.micro_gravity import ALARM_STDS, AtRest, check_gravity
from tfsat_host.evaluation.motion.gyro_signal import SHEET_DENSITY_RAD_S_RTHZ
from tfsat_host.evaluation.rest import RestBeforeRelease, angles_at_rest
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import START_POSE_TOLERANCE_CDEG
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

_FLOATING = ("micro-gravity",)
GRAVITY, DOWN = Kind("gravity at rest", "g", _FLOATING), Kind("down at rest", "deg", _FLOATING)
BIAS = Kind("gyro bias at rest", "deg/s", ("rates", "attitudes", "offsets"))
NOISE = Kind("gyro noise", "deg/s/sqrt(Hz)", ())
NOISY = 4.0
"""Times the data sheet's density, which is typical and without a limit."""
START_POSE = Kind("start pose", "deg", ())
TOLERANCE_DEG = START_POSE_TOLERANCE_CDEG / 100.0
"""What ARM and the preflight allow: an uncalibrated servo's scale, its play, and a joint that sags, as the paper's
joint 1 by 6 deg, stay within it."""
LOOKED_AT_S = 0.5
BEFORE_RELEASE_S = 0.02
"""The releaser's springs may move a joint that is on its way out."""


def rest_checks(data: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """Check gravity, the downward direction and the gyros' biases at rest before the release."""
    if data.rest is None:
        why = "The robot never hung still before the release, or that was not recorded."
        yield from (kind.not_possible(why) for kind in (GRAVITY, DOWN, BIAS))
        return
    yield _gravity(data.rest)
    yield _down(data.rest, data.model)
    yield _bias(data, stated)


def _gravity(rest: RestBeforeRelease) -> Check:
    """Accelerometers are not calibrated: three of their standard deviations hold 50 mg, 80 mg along z, and 3 %."""
    gravity_checks = [check_gravity(b + 1, force) for b, force in enumerate(rest.force) if force is not None]
    if not gravity_checks:
        return GRAVITY.not_possible("No accelerometer answered before the release.")
    # The farthest by its own uncertainty, which differs from axis to axis.
    worst = max(gravity_checks, key=lambda check: abs(check.norm_g - 1.0) / check.norm_std_g)
    sentence = (
        f"Body {worst.body} at rest: {worst.norm_g:.3f} g, the largest deviation from 1 g of "
        f"{len(gravity_checks)} bodies."
    )
    return GRAVITY.judge(abs(worst.norm_g - 1.0), ALARM_STDS * worst.norm_std_g, sentence).caused_by(
        f"accelerometer of body {worst.body}: its range or its scale is not the header's, or it is defective",
        Advice("Compare the accelerometers live, the robot at rest: ", NextStep("monitor")),
    )


def _down(rest: RestBeforeRelease, model: RobotModel) -> Check:
    directions = _directions(rest, model)
    if len(directions) < 3:
        return DOWN.not_possible("Fewer than three accelerometers answered: none can be outvoted.")
    # The median of the directions: one accelerometer that is wrong hardly moves it.
    usual = np.median([direction for direction, _, _ in directions.values()], axis=0)
    usual /= np.linalg.norm(usual)
    off = {b: float(np.arccos(np.clip(d @ usual, -1.0, 1.0))) for b, (d, _, _) in directions.items()}
    spread = float(np.sqrt(np.mean([std**2 for _, std, _ in directions.values()])))
    body = max(off, key=lambda b: off[b] / directions[b][1])
    limit = ALARM_STDS * float(np.hypot(directions[body][1], spread))
    sentence = (
        f"Body {body + 1} at rest: down differs by {np.rad2deg(off[body]):.1f} deg from the other bodies'."
    )
    # In the suspect's own axes, where an exchange or reversal shows by the axis that is nearest.
    turn = directions[body][2]
    felt, right = (_axis(turn.T @ vector) for vector in (directions[body][0], usual))
    cause = (
        f"unknown; body {body + 1} hangs bent, or its accelerometer is off by more than its data sheet allows"
    )
    if felt != right:
        cause = (
            f"accelerometer of body {body + 1} feels up along {felt} where it is {right}: "
            "its axes are exchanged or reversed"
        )
    step = Advice("Compare the IMU's mounting with the robot file: ", NextStep("robot"))
    return DOWN.judge(float(np.rad2deg(off[body])), float(np.rad2deg(limit)), sentence).caused_by(cause, step)


def _directions(
    rest: RestBeforeRelease, model: RobotModel
) -> dict[int, tuple[FloatArray, float, FloatArray]]:
    """Compute by body: up in base axes, its standard deviation, and the body's rotation to base axes."""
    starts = [servo.start_rad for servo in model.servos]
    # A joint that no sensor tells is taken to hang where its servo starts.
    angles = np.where(np.isfinite(rest.angles_rad), rest.angles_rad, starts)
    rotation, _ = poses(Multibody.of(model), angles)
    return {
        b: (rotation[b] @ force.mean_g / np.linalg.norm(force.mean_g), across_std(force), rotation[b])
        for b, force in enumerate(rest.force)
        if force is not None and np.linalg.norm(force.mean_g) > 0.0
    }


def across_std(force: AtRest) -> float:
    """Compute the standard deviation of a direction from the errors perpendicular to it, rad."""
    norm = float(np.linalg.norm(force.mean_g))
    # Only errors square to the force tilt it: per axis one less its squared direction cosine.
    along = (force.mean_g / norm) ** 2
    return float(np.sqrt(((1.0 - along) * force.std_g**2).sum())) / norm


def _axis(vector: FloatArray) -> str:
    """Return the signed name of the axis nearest to a vector, such as `+x`."""
    axis = int(np.abs(vector).argmax())
    return f"{'-' if vector[axis] < 0 else '+'}{'xyz'[axis]}"


def _bias(data: Consistency, stated: StatedErrors) -> Check:
    rows = np.flatnonzero(data.rows(*map(data.at_rest, range(data.bodies))) & stated.known)
    if not len(rows):
        return BIAS.not_possible("No gyro answered before the release.")
    limits = z_limit(len(rows)) * np.sqrt(np.diag(stated.covariance)[rows])
    worst = int((np.abs(data.residual[rows]) / limits).argmax())
    # Rows are ordered by body, then by axis.
    body, axis = divmod(int(rows[worst]) - data.at_rest(0).start, 3)
    off_deg, bias_time = np.rad2deg(data.residual[rows[worst]]), data.calibration.gyros[body].bias_recorded_at
    against = "zero (bias never calibrated)"
    if bias_time:
        against = f"the bias of {bias_time:%Y-%m-%d %H:%M} UTC"
    sentence = (
        f"Gyro of body {body + 1} at rest: {off_deg:+.3f} deg/s about {'xyz'[axis]} relative to {against}."
    )
    return BIAS.judge(float(abs(off_deg)), float(np.rad2deg(limits[worst])), sentence)


def noise_check(densities_rad_s_rthz: FloatArray) -> Check:
    """Check the gyros' noise before the release.

    The smallest fault that the other checks can detect depends on this noise, so it is checked itself.
    """
    ratio = densities_rad_s_rthz / SHEET_DENSITY_RAD_S_RTHZ
    body = int(ratio.argmax())
    value = float(np.rad2deg(densities_rad_s_rthz[body]))
    sentence = (
        f"Noisiest gyro: body {body + 1}, {value:.4f} {NOISE.unit} ({ratio[body]:.1f} times the data sheet)."
    )
    return NOISE.judge(value, float(np.rad2deg(NOISY * SHEET_DENSITY_RAD_S_RTHZ)), sentence).caused_by(
        f"gyro of body {body + 1}: its supply or its cable is disturbed, or the robot was shaken before the release",
        Advice("Watch the rates at rest: ", NextStep("monitor")),
    )


def start_pose_check(log: DropLog, calibration: Calibration, model: RobotModel) -> Check:
    """Check that the joints stood at the start pose, where every maneuver begins.

    The angles are medians over the last half second before the release.

    A joint without a zero point of its own in the calibration says nothing here: it is assumed to have hung
    where its servo starts.
    """
    rows = (log.t_s >= -LOOKED_AT_S) & (log.t_s < -BEFORE_RELEASE_S)
    if not rows.any():
        return START_POSE.not_possible("No sample was recorded in the half second before the release.")
    angles = angles_at_rest(log, rows, calibration, model)
    measured = np.array([sensors.has_zero and not sensors.absent for sensors in calibration.joints])
    off_deg = np.rad2deg(angles - np.array([servo.start_rad for servo in model.servos]))
    measured_joints = np.flatnonzero(measured & np.isfinite(off_deg))
    if not len(measured_joints):
        why = "No joint has a calibrated angle sensor that tells where it stood at the release."
        return START_POSE.not_possible(why)
    worst = int(measured_joints[np.abs(off_deg[measured_joints]).argmax()])
    std_deg = np.rad2deg(np.sqrt(calibration.joints[worst].zero_covariance.max()))
    start_deg, value = float(np.rad2deg(model.servos[worst].start_rad)), float(abs(off_deg[worst]))
    at = f"{start_deg + off_deg[worst]:+.2f} ± {max(std_deg, 0.01):.2f} deg"
    stood, pose = f"the release joint {worst + 1} stood at {at}", f"{start_deg:g} ± {TOLERANCE_DEG:g} deg"
    sentence = f"Just before {stood}, the farthest from the start pose ({pose})."
    if value > TOLERANCE_DEG:
        sentence = (
            f"Wrong start pose: just before {stood} instead of {pose}. The strokes began elsewhere than the maneuver "
            "means."
        )
    return START_POSE.judge(value, TOLERANCE_DEG, sentence).caused_by(
        f"servo of joint {worst + 1}: it turns the other way, did not hold its joint, or was not calibrated; or the "
        "zero point of the joint's angle sensors is another one",
        Advice(
            "Without a drop: ",
            NextStep("jog", ("--joint", str(worst + 1), "--from", "0", "--to", "5")),
            " shows which way it turns; then ",
            NextStep("calibrate zero", ("--joint", str(worst + 1))),
        ),
    )
