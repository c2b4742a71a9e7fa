"""What the emulated robot's library is told of a robot: its bodies, and what its sensors and servos do wrong."""

from __future__ import annotations

import numpy as np

from tfsat_host.emulated.imperfections import GYRO_WANDER_S, Imperfections
from tfsat_host.emulated.library import EmulationError, RobotConfig
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT, JOINT_COUNT
from tfsat_host.robot import RobotModel
from tfsat_host.units import STANDARD_GRAVITY_M_S2


def robot_config(model: RobotModel, wrong: Imperfections, seed: int, session_seed: int) -> RobotConfig:
    """The library's structure, in SI units and the robot file's frames.

    Args:
        model: As many bodies, joints and sensors as the structure has room for, and a servo with pulses
            on every joint.
        wrong: The hidden errors, and the logger's serial number.
        seed: For noise and contact bounce.
        session_seed: For the logger's session ids.
    """
    pulses = [servo.pulses for servo in model.servos if servo.pulses is not None]
    config = RobotConfig(seed=seed, session_seed=session_seed, base_body=model.base, temperature_c=25.0)
    values: dict[str, object] = {
        "joint_inner": model.joint_inner,
        "joint_outer": model.joint_outer,
        "angle_direction": [sensor.direction for sensor in model.angle_sensors],
        "body_mass_kg": model.mass_kg,
        "body_com_m": model.com_m,
        "body_inertia_kg_m2": model.inertia_kg_m2,
        "body_origin_m": model.origin_m,
        "joint_axis": model.joint_axis,
        "joint_point_m": model.joint_point_m,
        "servo_reference_pulse_us": [p.reference_pulse_us for p in pulses],
        "servo_reference_angle_rad": [p.reference_angle_rad for p in pulses],
        "servo_pulse_us_per_rad": [p.pulse_us_per_rad for p in pulses],
        "servo_max_rate_rad_s": [servo.max_rate_rad_s for servo in model.servos],
        "servo_acceleration_rad_s2": [servo.acceleration_rad_s2 for servo in model.servos],
        "servo_gain": wrong.servo_gain,
        "servo_offset_rad": wrong.servo_offset_rad,
        "servo_backlash_rad": wrong.servo_backlash_rad,
        "servo_repeat_rad": wrong.servo_repeat_rad,
        "servo_overshoot_rad": wrong.servo_overshoot_rad,
        "joint_min_rad": model.joint_limits_rad[:, 0],
        "joint_max_rad": model.joint_limits_rad[:, 1],
        "imu_position_m": [imu.position_m for imu in model.imus],
        "imu_sensor_to_body": [
            turn @ imu.sensor_to_body for turn, imu in zip(wrong.mounting, model.imus, strict=True)
        ],
        "gyro_bias_rad_s": wrong.gyro_bias_rad_s,
        "gyro_scale": wrong.gyro_scale,
        "gyro_g_sensitivity": wrong.gyro_g_sensitivity_rad_s_g / STANDARD_GRAVITY_M_S2,
        "gyro_bias_slope_rad_s_c": wrong.gyro_bias_slope_rad_s_c,
        "angle_zero_offset_rad": wrong.angle_zero_rad
        + [sensor.zero_offset_rad for sensor in model.angle_sensors],
        "angle_nonlinearity_rad": wrong.angle_nonlinearity_rad,
    }
    for name, value in values.items():
        field = getattr(config, name)
        field[:] = np.ravel(np.asarray(value)).tolist()
    config.gyro_noise_rad_s_rthz = wrong.gyro_noise_rad_s_rthz
    config.accel_noise_m_s2_rthz = wrong.accel_noise_m_s2_rthz
    config.gyro_wander_rad_s = wrong.gyro_wander_rad_s
    config.gyro_wander_s = GYRO_WANDER_S
    config.gyro_shock_limit_m_s2 = wrong.gyro_shock_limit_g * STANDARD_GRAVITY_M_S2
    config.warming_c = wrong.warming_c
    config.warming_s = wrong.warming_s
    config.angle_noise_rad = wrong.angle_noise_rad
    config.sequencer_clock_ppm = wrong.sequencer_clock_ppm
    config.logger_clock_ppm = wrong.logger_clock_ppm
    config.imu_who_am_i[:] = wrong.imu_who_am_i
    config.logger_serial[:] = wrong.logger_serial
    return config


def require_the_boards_numbers(model: RobotModel) -> None:
    """Raises EmulationError for a robot that the boards are not built for."""
    numbers = (model.n_bodies, model.n_joints, len(model.imus), len(model.angle_sensors))
    if numbers != (IMU_COUNT, JOINT_COUNT, IMU_COUNT, ANGLE_SENSOR_COUNT):
        raise EmulationError(
            what=f"{model.path}: {model.name} has {numbers[0]} bodies, {numbers[1]} joints, {numbers[2]} IMUs and "
            f"{numbers[3]} angle sensors.",
            meaning=f"The boards are built for {IMU_COUNT} bodies with an IMU each, and {JOINT_COUNT} joints with "
            f"{ANGLE_SENSOR_COUNT // JOINT_COUNT} angle sensors each; nothing was run.",
            next_step="Emulate robots/drop_tower.toml or one like it.",
        )
    for joint, servo in zip(model.joint_names, model.servos, strict=True):
        if servo.pulses is None:
            raise EmulationError(
                what=f"{model.path}: the servo of {joint} has no pulses.",
                meaning="The sequencer commands servos by pulses, so this robot cannot be emulated; nothing was run.",
                next_step="Add pulse_range_us, reference and pulse_us_per_deg to its [joint.servo], as in "
                "robots/drop_tower.toml.",
            )
