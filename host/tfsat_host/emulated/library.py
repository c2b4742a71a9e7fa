"""The emulated robot's C interface (tools/emulator/src/api.h) as Python sees it."""

from __future__ import annotations

import ctypes
from ctypes import (
    POINTER,
    c_char_p,
    c_double,
    c_int,
    c_int32,
    c_size_t,
    c_ssize_t,
    c_uint,
    c_uint8,
    c_uint32,
    c_uint64,
    c_void_p,
)
from enum import IntEnum
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from tfsat_host.emulated.imperfections import GYRO_WANDER_S, Imperfections
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT, JOINT_COUNT
from tfsat_host.robot import RobotModel
from tfsat_host.units import STANDARD_GRAVITY_M_S2

TRUTH_COLUMNS = 32
"""Doubles in a row of truth: t_s, joint angles (3), attitudes (4 x xyzw), rates (4 x 3)."""


class EmulationError(TfsatError):
    """The emulated robot cannot do this, or its processor crashed."""


class BoardIndex(IntEnum):
    """Boards as api.h numbers them."""

    SEQUENCER = 0
    LOGGER = 1


class Reset(IntEnum):
    """Restarts of the sequencer with its supply on, as api.h numbers them."""

    WATCHDOG = 0
    BROWN_OUT = 1
    BUTTON = 2


class RobotConfig(ctypes.Structure):
    """TfsatRobotConfig of api.h: SI units, matrices row by row."""

    _fields_: ClassVar[list[tuple[str, Any]]] = [
        ("seed", c_uint64),
        ("session_seed", c_uint64),
        ("base_body", c_int32),
        ("joint_inner", c_int32 * 3),
        ("joint_outer", c_int32 * 3),
        ("angle_direction", c_int32 * 6),
        ("body_mass_kg", c_double * 4),
        ("body_com_m", c_double * 12),
        ("body_inertia_kg_m2", c_double * 36),
        ("body_origin_m", c_double * 12),
        ("joint_axis", c_double * 9),
        ("joint_point_m", c_double * 9),
        ("servo_reference_pulse_us", c_double * 3),
        ("servo_reference_angle_rad", c_double * 3),
        ("servo_pulse_us_per_rad", c_double * 3),
        ("servo_max_rate_rad_s", c_double * 3),
        ("servo_acceleration_rad_s2", c_double * 3),
        ("servo_gain", c_double * 3),
        ("servo_offset_rad", c_double * 3),
        ("servo_backlash_rad", c_double * 3),
        ("servo_repeat_rad", c_double * 3),
        ("servo_overshoot_rad", c_double * 3),
        ("joint_min_rad", c_double * 3),
        ("joint_max_rad", c_double * 3),
        ("imu_position_m", c_double * 12),
        ("imu_sensor_to_body", c_double * 36),
        ("gyro_bias_rad_s", c_double * 12),
        ("gyro_scale", c_double * 12),
        ("gyro_noise_rad_s_rthz", c_double),
        ("accel_noise_m_s2_rthz", c_double),
        ("gyro_g_sensitivity", c_double * 36),
        ("gyro_bias_slope_rad_s_c", c_double * 12),
        ("gyro_wander_rad_s", c_double),
        ("gyro_wander_s", c_double),
        ("gyro_shock_limit_m_s2", c_double),
        ("angle_zero_offset_rad", c_double * 6),
        ("angle_nonlinearity_rad", c_double * 24),
        ("angle_noise_rad", c_double),
        ("temperature_c", c_double),
        ("warming_c", c_double),
        ("warming_s", c_double),
        ("sequencer_clock_ppm", c_double),
        ("logger_clock_ppm", c_double),
        ("imu_who_am_i", c_uint8 * 4),
        ("logger_serial", c_uint8 * 8),
    ]


class HandsConfig(ctypes.Structure):
    """TfsatHands of api.h."""

    _fields_: ClassVar[list[tuple[str, Any]]] = [
        ("seed", c_uint64),
        ("lead_s", c_double),
        ("tremor_rad_s", c_double),
        ("sway_rad_s", c_double),
        ("reaction", c_double),
    ]


class LegConfig(ctypes.Structure):
    """TfsatLeg of api.h."""

    _fields_: ClassVar[list[tuple[str, Any]]] = [
        ("target_rad", c_double),
        ("duration_s", c_double),
        ("rest_s", c_double),
    ]


_SIGNATURES: dict[str, tuple[Any, list[Any]]] = {
    "tfsat_config_bytes": (c_size_t, []),
    "tfsat_truth_row_bytes": (c_size_t, []),
    "tfsat_robot_new": (c_void_p, [POINTER(RobotConfig), c_char_p, c_char_p, c_size_t]),
    "tfsat_robot_free": (None, [c_void_p]),
    "tfsat_now_us": (c_uint64, [c_void_p]),
    "tfsat_advance_to": (c_int, [c_void_p, c_uint64]),
    "tfsat_crash": (c_char_p, [c_void_p]),
    "tfsat_pass_slowly": (None, [c_void_p, c_double]),
    "tfsat_write": (c_size_t, [c_void_p, c_int, c_char_p, c_size_t]),
    "tfsat_read": (c_size_t, [c_void_p, c_int, POINTER(c_uint8), c_size_t]),
    "tfsat_read_by": (c_ssize_t, [c_void_p, c_int, c_uint64, c_uint64, POINTER(c_uint8), c_size_t]),
    "tfsat_set_power": (None, [c_void_p, c_int, c_int]),
    "tfsat_set_cable": (None, [c_void_p, c_int, c_int]),
    "tfsat_set_port": (None, [c_void_p, c_int]),
    "tfsat_reset": (None, [c_void_p, c_int]),
    "tfsat_eeprom_get": (None, [c_void_p, POINTER(c_uint8), c_size_t]),
    "tfsat_eeprom_set": (None, [c_void_p, c_char_p, c_size_t]),
    "tfsat_eeprom_writes": (c_uint32, [c_void_p]),
    "tfsat_logger_memory_bytes": (c_size_t, [c_void_p]),
    "tfsat_logger_memory_get": (None, [c_void_p, POINTER(c_uint8), c_size_t]),
    "tfsat_logger_memory_set": (None, [c_void_p, c_char_p, c_size_t]),
    "tfsat_card_size": (c_size_t, [c_void_p]),
    "tfsat_card_read": (None, [c_void_p, POINTER(c_uint8), c_size_t]),
    "tfsat_card_next_file": (c_int, [c_void_p, c_int]),
    "tfsat_card_file_size": (c_size_t, [c_void_p, c_int]),
    "tfsat_card_file_read": (None, [c_void_p, c_int, POINTER(c_uint8), c_size_t]),
    "tfsat_card_put_file": (None, [c_void_p, c_int, c_char_p, c_size_t]),
    "tfsat_card_set_present": (None, [c_void_p, c_int]),
    "tfsat_card_set_defect": (None, [c_void_p, c_int]),
    "tfsat_card_fill": (None, [c_void_p, c_uint32]),
    "tfsat_card_set_mount": (None, [c_void_p, c_uint32]),
    "tfsat_fault_imu": (None, [c_void_p, c_int, c_int]),
    "tfsat_swap_imus": (None, [c_void_p, c_int, c_int]),
    "tfsat_glitch_imu": (None, [c_void_p, c_int]),
    "tfsat_fault_bus": (None, [c_void_p, c_int, c_int]),
    "tfsat_fault_angle_sensor": (None, [c_void_p, c_int, c_int]),
    "tfsat_slip_magnet": (None, [c_void_p, c_int, c_double]),
    "tfsat_fault_servo": (None, [c_void_p, c_int, c_int]),
    "tfsat_fault_switch": (None, [c_void_p, c_int, c_int]),
    "tfsat_set_bounce": (None, [c_void_p, c_uint64]),
    "tfsat_card_stalls": (None, [c_void_p, c_uint64, c_uint64]),
    "tfsat_set_clock": (c_int, [c_void_p, c_int, c_double]),
    "tfsat_seat": (None, [c_void_p]),
    "tfsat_hold": (c_int, [c_void_p, c_uint32]),
    "tfsat_swing": (c_int, [c_void_p, c_int, c_double, c_double, c_uint]),
    "tfsat_move_joint": (c_int, [c_void_p, POINTER(HandsConfig), c_int, POINTER(LegConfig), c_size_t]),
    "tfsat_turn": (None, [c_void_p, POINTER(HandsConfig), POINTER(c_double), POINTER(LegConfig), c_size_t]),
    "tfsat_hold_against": (None, [c_void_p, POINTER(HandsConfig), c_int]),
    "tfsat_set_joint": (c_int, [c_void_p, c_int, c_double]),
    "tfsat_swinging": (c_int, [c_void_p]),
    "tfsat_set_switch": (None, [c_void_p, c_int, c_int]),
    "tfsat_knock": (None, [c_void_p, c_int, c_uint64]),
    "tfsat_drop": (None, [c_void_p, POINTER(c_double), POINTER(c_double), c_uint64]),
    "tfsat_falling": (c_int, [c_void_p]),
    "tfsat_released_us": (c_uint64, [c_void_p]),
    "tfsat_joint_angle_rad": (c_double, [c_void_p, c_int]),
    "tfsat_com_position": (None, [c_void_p, POINTER(c_double)]),
    "tfsat_record_truth": (None, [c_void_p, c_uint64]),
    "tfsat_truth_rows": (c_size_t, [c_void_p]),
    "tfsat_truth_read": (None, [c_void_p, POINTER(c_double), c_size_t]),
}


def load_library(path: Path) -> ctypes.CDLL:
    """Loads the library and checks that it means the same structures."""
    library = ctypes.CDLL(str(path))
    for name, (result, arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    if library.tfsat_config_bytes() != ctypes.sizeof(RobotConfig):
        raise RuntimeError("library.py and api.h disagree on TfsatRobotConfig")
    if library.tfsat_truth_row_bytes() != 8 * TRUTH_COLUMNS:
        raise RuntimeError("library.py and api.h disagree on a row of truth")
    return library


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
