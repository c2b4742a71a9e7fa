"""The sensors while the robot hangs still: IMUs and angle sensors there, plausible, in agreement; the start pose.

The limits of stillness are those of `calibrate bias` (calibration/bias.py).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.bias import DRIFT_RAD_S, GRAVITY_G, SHAKE_G, STILL_RATE_RAD_S
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.zero import MAX_DISAGREEMENT_RAD
from tfsat_host.dynamics import Multibody, poses
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.live_sensors import (
    Sensors,
    certificate_of_these,
    joint_angles,
    merge_sensor_angles,
    sensors_of,
)
from tfsat_host.preflight.preflight_check import PreflightCheck, judge, not_made
from tfsat_host.preflight.preflight_evidence import Evidence, require
from tfsat_host.protocol.imus import IMU_PARTS
from tfsat_host.protocol.limits import START_POSE_TOLERANCE_CDEG
from tfsat_host.robot.absent_parts import bodies_of, bodies_with_imu, describe_imus
from tfsat_host.units import STANDARD_GRAVITY_M_S2

MAX_BIAS_DEG_S = 20.0
"""Zero-rate output of an MPU-6050 at 25 deg C (PS-MPU-6000A rev. 3.4, section 6.1)."""
MAX_BIAS_CHANGE_DEG_S = 0.5
"""After power-up a bias comes back within some tenths of that; more is another sensor, or a broken one."""
MAX_BIAS_DRIFT_DEG_S_C = 20.0 / 62.5
"""And moves with the die's temperature: by 20 deg/s from 25 to -40 or +85 deg C (the same table)."""
MAX_GRAVITY_DIFFERENCE_DEG = 12.0
"""Zero-g outputs within 50 mg, 80 mg for z (section 6.2), tilt what two accelerometers call down by up to so much."""


def check_imus(evidence: Evidence) -> PreflightCheck:
    """Check that each IMU is a known part, answered with a measurement at every sample, and did not clip."""
    who = require(evidence.logger).later.who_am_i
    counts = sensors_of(evidence).live.counts
    wrong = []
    sensed = bodies_with_imu(evidence.robot)
    for body in (number - 1 for number in sensed):
        name, valid = f"IMU of body {body + 1}", counts.imu_valid[:, body]
        # 0 is an IMU that does not answer at all, which its validity shows below.
        if who[body] and who[body] not in IMU_PARTS:
            wrong.append(f"{name}: unknown part (WHO_AM_I 0x{who[body]:02x})")
        elif not valid.any():
            wrong.append(f"{name}: no response, or one reading repeated")
        elif not valid.all():
            wrong.append(f"{name}: no data in {100 * (1 - valid.mean()):.2g} % of the samples")
        elif counts.clipped[:, body].any():
            wrong.append(f"{name}: at the end of its range")
    return judge(
        wrong,
        "{}.",
        Advice(
            NextStep("status"),
            " and monitor show which; check its plug, wires and address jumper (docs/wiring.md), "
            "switch the power off and on.",
        ),
        describe_imus(evidence.robot, f"valid in {len(counts.t_us)} samples"),
        who_am_i=[f"{byte:02x}" for byte in who],
        samples=len(counts.t_us),
        valid_samples=counts.imu_valid.sum(axis=0).tolist(),
        clipped_samples=counts.clipped.sum(axis=0).tolist(),
    )


def check_stillness(evidence: Evidence) -> PreflightCheck:
    """Check that the robot hangs still, on sound sensors.

    No gyro scatters or drifts, no accelerometer shakes, and each reads 1 g.
    """
    sensors = sensors_of(evidence)
    bodies = sensors.responding_imus()
    # (n, m, 3) of the m bodies whose IMU answered.
    rates = sensors.si.rate_rad_s[:, bodies]
    forces_g = sensors.si.accel_m_s2[:, bodies] / STANDARD_GRAVITY_M_S2
    # Half against half shows a slow turn or a warming die, which the scatter does not.
    first, second = (half.mean(axis=0) for half in np.array_split(rates, 2))
    scatter = rates.std(axis=0).max(axis=1)
    drift = np.abs(second - first).max(axis=1)
    shake = forces_g.std(axis=0).max(axis=1)
    weight = np.linalg.norm(forces_g.mean(axis=0), axis=1)
    # A gyro always has noise: one value throughout measures nothing.
    constant = ~np.ptp(rates, axis=0).any(axis=1)
    wrong = []
    for k, body in enumerate(bodies + 1):
        if constant[k]:
            wrong.append(f"gyro of body {body}: one value repeated")
        # One cause for each sensor: motion to and fro explains a drift, shaking a wrong weight.
        if scatter[k] > STILL_RATE_RAD_S:
            wrong.append(
                f"body {body}: rate scatter {np.rad2deg(scatter[k]):.1f} deg/s "
                f"(limit {np.rad2deg(STILL_RATE_RAD_S):g} deg/s)"
            )
        elif drift[k] > DRIFT_RAD_S:
            wrong.append(
                f"body {body}: rate drift {np.rad2deg(drift[k]):.2f} deg/s (limit {np.rad2deg(DRIFT_RAD_S):g} deg/s)"
            )
        if shake[k] > SHAKE_G:
            wrong.append(f"body {body}: acceleration scatter {shake[k]:.2f} g (limit {SHAKE_G:g} g)")
        elif not GRAVITY_G[0] <= weight[k] <= GRAVITY_G[1]:
            wrong.append(
                f"accelerometer of body {body}: {weight[k]:.2f} g (limits {GRAVITY_G[0]:g} to {GRAVITY_G[1]:g} g)"
            )
    return judge(
        wrong,
        "Not at rest, or a sensor is faulty: {}.",
        "Let the robot hang without touching it, then run this preflight again. If one body alone stays so, replace "
        "its IMU.",
        f"At rest: rate scatter at most {np.rad2deg(scatter.max()):.2f} deg/s, all accelerometers at 1 g.",
        bodies=(bodies + 1).tolist(),
        scatter_deg_s=np.rad2deg(scatter).tolist(),
        drift_deg_s=np.rad2deg(drift).tolist(),
        shake_g=shake.tolist(),
        gravity_g=weight.tolist(),
    )


def check_biases(evidence: Evidence) -> PreflightCheck:
    """Check that each gyro's reading at rest is within its data sheet."""
    sensors = sensors_of(evidence)
    bodies = sensors.responding_imus()
    biases_deg_s = np.rad2deg(sensors.si.rate_rad_s[:, bodies].mean(axis=0))
    worst = np.abs(biases_deg_s).max(axis=1)
    beyond = [
        f"body {body} {bias_deg_s:.1f} deg/s"
        for body, bias_deg_s in zip(bodies + 1, worst, strict=True)
        if bias_deg_s > MAX_BIAS_DEG_S
    ]
    return judge(
        beyond,
        f"Gyro bias: {{}} (limit {MAX_BIAS_DEG_S:g} deg/s).",
        "Wait until the robot hangs still; if it stays so, replace that IMU and calibrate it.",
        f"Gyro biases: at most {worst.max():.1f} deg/s (limit {MAX_BIAS_DEG_S:g} deg/s).",
        bodies=(bodies + 1).tolist(),
        reading_deg_s=biases_deg_s.tolist(),
    )


def check_agreement(evidence: Evidence) -> PreflightCheck:
    """Calibrated, the gyros of the held robot read one rate, and the accelerometers point one way down.

    A body of which the calibration does not hold stands out: other IMU, plugs exchanged, mounting moved, gain lost.
    """
    sensors, calibration = sensors_of(evidence), certificate_of_these(evidence)
    bodies = np.flatnonzero(sensors.live.counts.imu_valid.any(axis=0))
    if len(bodies) < 2:
        return not_made("Fewer than two IMUs answered.", "See gyros-present.")
    angles = merge_sensor_angles(joint_angles(sensors, evidence))
    # A joint whose sensors are silent counts as closed.
    to_base = poses(Multibody.of(evidence.robot), np.where(np.isfinite(angles), angles, 0.0))[0]
    rates, warmer_c, down = _calibrate_rates(sensors, calibration, bodies, to_base)
    # How well a bias repeats after power-up, and its drift with the die's temperature since.
    allowed = MAX_BIAS_CHANGE_DEG_S + MAX_BIAS_DRIFT_DEG_S_C * warmer_c
    # About the median over the bodies, which one bad gyro does not shift.
    apart = np.abs(rates - np.median(rates, axis=0)).max(axis=1)
    middle = np.median(down, axis=0)
    # Clip the cosine: rounding may leave the domain of arccos.
    tilt = np.rad2deg(np.arccos(np.clip(down @ middle / np.linalg.norm(middle), -1.0, 1.0)))
    wrong = []
    for k, body in enumerate(bodies + 1):
        if apart[k] > allowed[k]:
            wrong.append(
                f"gyro of body {body}: {apart[k]:.1f} deg/s from the median (limit {allowed[k]:.1f} deg/s)"
            )
        if tilt[k] > MAX_GRAVITY_DIFFERENCE_DEG:
            wrong.append(
                f"IMU of body {body}: gravity {tilt[k]:.0f} deg from the median "
                f"(limit {MAX_GRAVITY_DIFFERENCE_DEG:g} deg)"
            )
    return judge(
        wrong,
        "Calibrated readings disagree: {}.",
        Advice(
            "Are two IMUs' plugs exchanged, was one replaced or moved? If not: ",
            NextStep("calibrate bias"),
            ", and misalignment of what was moved.",
        ),
        f"Calibrated readings agree: gyros within {2 * apart.max():.2f} deg/s, gravity within "
        f"{2 * tilt.max():.1f} deg.",
        bodies=(bodies + 1).tolist(),
        rate_deg_s=rates.tolist(),
        apart_deg_s=apart.tolist(),
        allowed_deg_s=allowed.tolist(),
        down_apart_deg=tilt.tolist(),
        allowed_down_deg=MAX_GRAVITY_DIFFERENCE_DEG,
    )


def _calibrate_rates(
    sensors: Sensors, calibration: Calibration, bodies: NDArray[np.intp], to_base: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(m, 3) mean rates, base axes, deg/s; (m,) how much warmer or colder than calibrated, deg C; (m, 3) unit down."""
    rates, warmer, down = [], [], []
    for body in bodies:
        valid = sensors.live.counts.imu_valid[:, body]
        gyro = calibration.gyros[body]
        reading = sensors.si.rate_rad_s[valid, body].mean(axis=0)
        # By the calibration from sensor to body axes, by the joint angles from there to base axes.
        rates.append(np.rad2deg(to_base[body] @ gyro.body_rates(reading[None, :])[0]))
        temperature_c = float(sensors.si.temperature_c[valid, body].mean())
        # No temperature on file: no drift is allowed for.
        warmer.append(abs(temperature_c - gyro.temperature_c) if np.isfinite(gyro.temperature_c) else 0.0)
        # At rest an accelerometer reads the support's reaction: down is against it.
        force = to_base[body] @ gyro.rotation @ sensors.si.accel_m_s2[valid, body].mean(axis=0)
        down.append(-force / max(float(np.linalg.norm(force)), 1e-9))
    return np.array(rates), np.array(warmer), np.array(down)


START_POSE_DEG = START_POSE_TOLERANCE_CDEG / 100.0
_MIN_SAMPLES = 200
"""Noise of half a count lets a sensor show one value so many times with a probability below 1e-30."""


def check_sensors(evidence: Evidence) -> PreflightCheck:
    """Check that every angle sensor answers, shows noise, and agrees with the other one of its joint."""
    sensors = sensors_of(evidence)
    angles = joint_angles(sensors, evidence)
    valid = sensors.live.counts.angle_valid
    apart = np.abs(wrap_angle(angles[:, 0] - angles[:, 1]))
    frozen = _frozen(sensors, evidence)
    wrong = []
    for row, joint in enumerate(range(1, len(angles) + 1)):
        for k, column in enumerate(sensor_columns(evidence.robot, joint), 1):
            if not valid[:, column].all():
                wrong.append(f"angle sensor {k} of joint {joint}: invalid samples")
            elif column in frozen:
                wrong.append(f"angle sensor {k} of joint {joint}: one value without noise")
        # NaN where one of the two is silent, which is told above.
        if np.isfinite(apart[row]) and apart[row] > MAX_DISAGREEMENT_RAD:
            first, second = np.rad2deg(angles[row])
            wrong.append(
                f"angle sensors of joint {joint}: {first:+.1f} and {second:+.1f} deg "
                f"(limit {np.rad2deg(MAX_DISAGREEMENT_RAD):g} deg apart)"
            )
    return judge(
        wrong,
        "{}.",
        Advice(
            NextStep("monitor"),
            " shows them: check wire and magnet. One whose magnet had slipped needs ",
            NextStep("calibrate zero", ("--joint", "N", "--anew")),
        ),
        f"Angle sensors: both of each joint valid, within {np.rad2deg(apart.max()):.1f} deg of each other.",
        joint_deg=np.rad2deg(angles).tolist(),
        apart_deg=np.rad2deg(apart).tolist(),
        allowed_deg=float(np.rad2deg(MAX_DISAGREEMENT_RAD)),
        valid_samples=valid.sum(axis=0).tolist(),
    )


def check_start_pose(evidence: Evidence) -> PreflightCheck:
    """Check that each joint is at the start pose that ARM demands, by its calibrated sensors."""
    degrees = np.rad2deg(merge_sensor_angles(joint_angles(sensors_of(evidence), evidence)))
    if not np.isfinite(degrees).all():
        return not_made("Joint without a valid angle sensor.", "See joint-sensors.")
    away = [
        f"joint {joint} {angle:+.1f} deg"
        for joint, angle in enumerate(degrees, 1)
        if abs(angle) > START_POSE_DEG
    ]
    degrees = degrees[: len(bodies_of(evidence.robot)) - 1]
    return judge(
        [", ".join(away)] if away else [],
        f"Not at the start pose: {{}} (limit 0 ± {START_POSE_DEG:g} deg).",
        Advice(
            "Bring the joint to 0 deg by hand or with ", NextStep("jog"), ", then run this preflight again."
        ),
        f"Joints at the start pose: {', '.join(f'{angle:+.1f}' for angle in degrees)} deg.",
        joint_deg=degrees.tolist(),
        allowed_deg=START_POSE_DEG,
    )


def _frozen(sensors: Sensors, evidence: Evidence) -> set[int]:
    """Columns of sensors that showed one value, although their calibration found noise of half a count or more."""
    counts = sensors.live.counts
    if len(counts.t_us) < _MIN_SAMPLES:
        return set()
    # With less noise than half a count, one value is what a sound sensor shows.
    return {
        column
        for joint in certificate_of_these(evidence).joints
        for k, column in enumerate(sensor_columns(evidence.robot, joint.joint))
        if joint.noise_rad[k] >= 0.5 * sensors.si.angle_step_rad
        and not np.ptp(counts.angle_counts[:, column])
    }
