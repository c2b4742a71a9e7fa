"""The emulated robot's C interface as Python sees it: declared in tools/emulator/src/api.h, and nowhere else."""

from __future__ import annotations

import ctypes
import re
from enum import IntEnum
from functools import cache
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.emulated.build import native_root
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


_TYPES: dict[str, Any] = {
    "void": None,
    "int": ctypes.c_int,
    "unsigned": ctypes.c_uint,
    "double": ctypes.c_double,
    "size_t": ctypes.c_size_t,
    "ptrdiff_t": ctypes.c_ssize_t,
    "int32_t": ctypes.c_int32,
    "uint8_t": ctypes.c_uint8,
    "uint32_t": ctypes.c_uint32,
    "uint64_t": ctypes.c_uint64,
    "TfsatRobot*": ctypes.c_void_p,
    "char*": ctypes.c_char_p,
    "const uint8_t*": ctypes.c_char_p,
}
# Regular expressions suffice for the plain C of api.h, and keep it the interface's only declaration.
_STRUCTURE = re.compile(r"typedef struct \{([^}]*)\} (\w+);")
_FIELD = re.compile(r"(\w+) (\w+)((?:\[\d+\])*);")
_FUNCTION = re.compile(r"^(?:const )?(\w+\*?) (tfsat_\w+)\(([^)]*)\);", re.MULTILINE)
_PARAMETER = re.compile(r"((?:const )?\w+\*?) \w+(\[\d+\])?")


@cache
def _header() -> str:
    text = (native_root() / "tools" / "emulator" / "src" / "api.h").read_text(encoding="utf-8")
    # Drop comments first: prose may look like a declaration.
    return re.sub(r"//.*", "", text)


@cache
def structures() -> dict[str, Any]:
    """Parse the structures of api.h by name; in SI units, with matrices row-major in one array."""
    return {name: _structure(name, fields) for fields, name in _STRUCTURE.findall(_header())}


def _structure(name: str, fields: str) -> type[ctypes.Structure]:
    def typed(element: str, sizes: str) -> Any:
        # An array of several dimensions is one flat array, row-major as in C.
        count = prod(map(int, re.findall(r"\d+", sizes)))
        return _TYPES[element] * count if sizes else _TYPES[element]

    declared = [(field, typed(element, sizes)) for element, field, sizes in _FIELD.findall(fields)]
    return type(name, (ctypes.Structure,), {"_fields_": declared})


def _type(declared: str, array: str = "") -> Any:
    """Return the ctypes type of a declared result or parameter."""
    plain = declared.removeprefix("const ")
    # Try it with its const first: `const uint8_t*` takes Python bytes, `uint8_t*` a buffer to be filled.
    for name in (declared, plain):
        if name in _TYPES and not array:
            return _TYPES[name]
    element = plain.removesuffix("*")
    return ctypes.POINTER(structures().get(element) or _TYPES[element])


@cache
def load_library(path: Path) -> ctypes.CDLL:
    """Loads the library and checks that it lays its structures out as ctypes does."""
    library = ctypes.CDLL(str(path))
    for result, name, parameters in _FUNCTION.findall(_header()):
        function = getattr(library, name)
        # Undeclared results would be C ints, which cut a pointer to 32 bits.
        function.restype = _type(result)
        function.argtypes = [_type(*parameter) for parameter in _PARAMETER.findall(parameters)]
    # Two compilers lay out the same structure: a difference in padding must fail here, not corrupt memory.
    if library.tfsat_config_bytes() != ctypes.sizeof(structures()["TfsatRobotConfig"]):
        raise RuntimeError("ctypes and the compiler disagree on TfsatRobotConfig")
    if library.tfsat_truth_row_bytes() != ctypes.sizeof(ctypes.c_double) * TRUTH_COLUMNS:
        raise RuntimeError("library.py and api.h disagree on a row of truth")
    return library


def robot_config(model: RobotModel, wrong: Imperfections, seed: int, session_seed: int) -> ctypes.Structure:
    """`TfsatRobotConfig`, in SI units and the robot file's frames.

    Args:
        model: As many bodies, joints and sensors as the structure has room for, and a servo with pulses
            on every joint.
        wrong: The hidden errors, and the logger's serial number.
        seed: For noise and contact bounce.
        session_seed: For the logger's session ids.
    """
    servos, sensors = model.servos, model.angle_sensors
    pulses = [servo.pulses for servo in servos if servo.pulses is not None]
    # The mounting error acts in body axes, after the design's rotation from sensor to body.
    mounted = [turn @ imu.sensor_to_body for turn, imu in zip(wrong.mounting, model.imus, strict=True)]
    values: dict[str, Any] = {
        "seed": seed,
        "session_seed": session_seed,
        "base_body": model.base,
        "temperature_c": 25.0,
        "joint_inner": model.joint_inner,
        "joint_outer": model.joint_outer,
        "angle_direction": [sensor.direction for sensor in sensors],
        "body_mass_kg": model.mass_kg,
        "body_com_m": model.com_m,
        "body_inertia_kg_m2": model.inertia_kg_m2,
        "body_origin_m": model.origin_m,
        "joint_axis": model.joint_axis,
        "joint_point_m": model.joint_point_m,
        "servo_reference_pulse_us": [pulse_map.reference_pulse_us for pulse_map in pulses],
        "servo_reference_angle_rad": [pulse_map.reference_angle_rad for pulse_map in pulses],
        "servo_pulse_us_per_rad": [pulse_map.pulse_us_per_rad for pulse_map in pulses],
        "servo_max_rate_rad_s": [servo.max_rate_rad_s for servo in servos],
        "servo_acceleration_rad_s2": [servo.acceleration_rad_s2 for servo in servos],
        "joint_min_rad": model.joint_limits_rad[:, 0],
        "joint_max_rad": model.joint_limits_rad[:, 1],
        "imu_position_m": [imu.position_m for imu in model.imus],
        "imu_sensor_to_body": mounted,
        # From per g to per m/s^2, the unit of the specific force that it multiplies.
        "gyro_g_sensitivity": wrong.gyro_g_sensitivity_rad_s_g / STANDARD_GRAVITY_M_S2,
        "gyro_wander_s": GYRO_WANDER_S,
        "gyro_shock_limit_m_s2": wrong.gyro_shock_limit_g * STANDARD_GRAVITY_M_S2,
        "angle_zero_offset_rad": wrong.angle_zero_rad + [sensor.zero_offset_rad for sensor in sensors],
        "imu_who_am_i": list(wrong.imu_who_am_i),
        "logger_serial": list(wrong.logger_serial),
    }
    structure = structures()["TfsatRobotConfig"]
    config: ctypes.Structure = structure()
    for name, kind in structure._fields_:
        value = values[name] if name in values else getattr(wrong, name)  # the others have the error's name
        # Flatten in C order: api.h declares matrices as flat, row-major arrays.
        if issubclass(kind, ctypes.Array):
            getattr(config, name)[:] = np.ravel(np.asarray(value)).tolist()
        else:
            setattr(config, name, value)
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
