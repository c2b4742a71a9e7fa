"""The emulated robot's C interface as Python sees it: declared in tools/emulator/src/api.h, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from cffi import FFI

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.build import native_root
from tfsat_host.emulated.imperfections import GYRO_WANDER_S, Imperfections
from tfsat_host.errors import TfsatError
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


@cache
def interface() -> FFI:
    """Return the types and functions that api.h declares; in SI units, with matrices row-major in one array."""
    header = (native_root() / "tools" / "emulator" / "src" / "api.h").read_text(encoding="utf-8")
    declared = FFI()
    # Between the two blocks for C++ are plain declarations, all that cffi takes.
    declared.cdef(header.split("#endif")[1].split("#ifdef")[0])
    return declared


@cache
def load_library(path: Path) -> Any:
    """Load the library and check that it lays its structures out as cffi does."""
    library = interface().dlopen(str(path))
    # Two compilers lay out the same structure: a difference in padding must fail here, not corrupt memory.
    if library.tfsat_config_bytes() != interface().sizeof("TfsatRobotConfig"):
        raise RuntimeError("cffi and the compiler disagree on TfsatRobotConfig")
    if library.tfsat_truth_row_bytes() != interface().sizeof("double") * TRUTH_COLUMNS:
        raise RuntimeError("library.py and api.h disagree on a row of truth")
    return library


def vector(components: FloatArray | Sequence[float]) -> Any:
    """Return (3,) components as C doubles. Raises ValueError for another number of them."""
    if len(components) != 3:
        raise ValueError(f"a vector has 3 components, not {len(components)}")
    return interface().new("double[3]", list(map(float, components)))


def read_bytes(size: int, read: Callable[..., None], *selection: Any) -> bytes:
    """Return the `size` bytes that a function of the library copies, of the robot or file that is selected."""
    data = interface().new("uint8_t[]", size)
    read(*selection, data, size)
    return bytes(interface().buffer(data))


def robot_config(model: RobotModel, wrong: Imperfections, seed: int, session_seed: int) -> Any:
    """Return a new `TfsatRobotConfig`, in SI units and the robot file's frames.

    The model has as many bodies, joints and sensors as the structure has room for, and a servo with pulses on
    every joint. `seed` is for noise and contact bounce, `session_seed` for the logger's session ids.
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
    fields = interface().typeof("TfsatRobotConfig").fields
    # A value that the robot does not give is the error of the same name.
    arrays = {
        name: np.reshape(values[name] if name in values else getattr(wrong, name), _shape(field.type))
        for name, field in fields
    }
    return interface().new("TfsatRobotConfig*", {name: array.tolist() for name, array in arrays.items()})


def _shape(declared: Any) -> tuple[int, ...]:
    """Return the sizes of a declared C array, outermost first; () for a number."""
    return (declared.length, *_shape(declared.item)) if declared.kind == "array" else ()


def require_pulses(model: RobotModel) -> None:
    """Raises EmulationError for a robot whose servos the sequencer cannot command."""
    for joint, servo in zip(model.joint_names, model.servos, strict=True):
        if servo.pulses is None:
            raise EmulationError(
                what=f"{model.path}: the servo of {joint} has no pulses.",
                meaning="The sequencer commands servos by pulses, so this robot cannot be emulated; nothing was run.",
                next_step="Add pulse_range_us, reference and pulse_us_per_deg to its [joint.servo], as in "
                "robots/drop_tower.toml.",
            )
