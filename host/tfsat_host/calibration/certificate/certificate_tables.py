"""The tables of a certificate: gyros, joints, servos, recordings and landings, with their units and frames."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Recording
from tfsat_host.calibration.certificate.layout import (
    Item,
    check_rotation,
    check_std,
    covariance,
    deviation,
    numbers,
    read_values,
    text,
    times,
    whole,
    written_values,
)
from tfsat_host.calibration.replacements import PARTS
from tfsat_host.calibration.sensors.gyro import (
    BIAS,
    MOUNTING,
    PARAMETERS,
    SCALE,
    SHARED,
    SKEW,
    SKEW_STD,
    GyroCalibration,
)
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.servos.dynamics_fit import MeasuredDynamics
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.config import Table
from tfsat_host.config.table import shorten_value
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT
from tfsat_host.protocol.messages import ServoSetting

_DEG = np.pi / 180.0
# Sixteen bits: no count or setting needs more.
_MAX_VALUE = 65_535
# Bounds of plausibility: the widest range of any gyro; a sensor beyond 45 deg shows no angle.
_MAX_BIAS_RAD_S, _MAX_NONLINEARITY_RAD = 2000.0 * _DEG, 45.0 * _DEG
_MAX_SKEW = 0.25
_BODY_UNITS = np.repeat([_DEG, _DEG, 1.0, 1.0], 3)
"""Of the rows and columns of a gyro's covariance."""
_GYRO = {
    "body": whole("body", 1, IMU_COUNT),
    "absent?": Item("absent", Table.flag),
    "bias": {
        "value": numbers("bias_rad_s", 3, si=_DEG),
        "std": numbers("bias_std", 3),
        "unit": "deg/s",
        "frame": "sensor",
        "temperature_c?": numbers("temperature_c"),
        "taken?": Item("bias_recorded_at", Table.time),
    },
    "noise?": {"value": numbers("noise_rad_s", 3, si=_DEG), "unit": "deg/s", "frame": "sensor"},
    "mounting": {
        "rotation": numbers("rotation", 3, 3),
        "unit": "1",
        "frame": "sensor to body",
        "std": numbers("mounting_std", 3),
        "std_unit": "deg",
        "std_frame": "sensor",
        "measured?": times("axes"),
        "measured_frame": "body",
    },
    "scale": {
        "value": numbers("scale", 3),
        "std": numbers("scale_std", 3),
        "unit": "1",
        "frame": "sensor",
        "measured?": times("scaled"),
        "measured_frame": "body",
    },
    "skew": {
        "value": numbers("skew", 3),
        "std": numbers("skew_std", 3),
        "unit": "1",
        "frame": "sensor",
        "order": ["yz", "zx", "xy"],
    },
    "covariance": {
        "value": numbers("covariance", PARAMETERS, PARAMETERS, si=np.outer(_BODY_UNITS, _BODY_UNITS)),
        "order": ["bias x y z", "rotation vector x y z", "scale x y z", "skew yz zx xy"],
        "unit": ["deg/s", "deg", "1", "1"],
        "frame": "sensor",
    },
    "shared?": {
        "value": numbers("shared", 9, SHARED, si=_BODY_UNITS[3:, None]),
        "order": ["rotation vector x y z", "scale x y z", "skew yz zx xy"],
        "by": ["tilts of joint 1", "of joint 2", "of joint 3", "of turns about x", "about y", "about z"],
        "unit": ["deg", "1", "1"],
        "frame": "sensor",
    },
}
_WITHOUT_SKEW = {
    **{key: item for key, item in _GYRO.items() if key != "skew"},
    "covariance": {
        "value": numbers("covariance", 9, 9, si=np.outer(_BODY_UNITS[:9], _BODY_UNITS[:9])),
        "order": ["bias x y z", "rotation vector x y z", "scale x y z"],
        "unit": ["deg/s", "deg", "1"],
        "frame": "sensor",
    },
}
"""As 0.2.0 wrote it: the skews were not estimated."""
_STD_OF_GYRO = {"bias": BIAS, "mounting": MOUNTING, "scale": SCALE, "skew": SKEW}
_JOINT = {
    "joint": whole("joint", 1, JOINT_COUNT),
    "absent?": Item("absent", Table.flag),
    "direction": numbers("direction", 2),
    "zero": {
        "value": numbers("zero_rad", 2, si=_DEG),
        "std": numbers("zero_std", 2),
        "unit": "deg",
        "frame": "sensor",
        "covariance": numbers("zero_covariance", 2, 2, si=_DEG**2),
        "taken?": Item("zero_recorded_at", Table.time),
    },
    "bend": {
        "value": numbers("bend", 2, 4, si=_DEG),
        "unit": "deg",
        "frame": "sensor",
        "order": ["sin", "cos", "sin 2", "cos 2"],  # of the angle shown
        "covariance": numbers("bend_covariance", 8, 8, si=_DEG**2),
        "taken?": Item("bend_recorded_at", Table.time),
    },
    "noise?": {"value": numbers("noise_rad", 2, si=_DEG), "unit": "deg", "frame": "sensor"},
}
_IN_DEG = {"unit": "deg", "frame": "joint"}
_STD_OF_SERVO = ("middle", "slope", "backlash")
_SERVO = {
    "joint": whole("joint", 1, JOINT_COUNT),
    "taken": Item("recorded_at", Table.time),
    "places": whole("places", 0, _MAX_VALUE),
    "repeats": whole("repeats", 0, _MAX_VALUE),
    "pulse_range_us": numbers("pulse_range_us", 2),
    "middle": {
        "pulse_us": numbers("middle_us"),
        "value": numbers("middle_rad", si=_DEG),
        "std": numbers("middle_std"),
        **_IN_DEG,
    },
    "slope": {
        "value": numbers("slope_rad_per_us", si=_DEG),
        "std": numbers("slope_std"),
        "unit": "deg/us",
        "frame": "joint",
    },
    "backlash": {"value": numbers("backlash_rad", si=_DEG), "std": numbers("backlash_std"), **_IN_DEG},
    "covariance": {
        "value": numbers("covariance", 3, 3, si=_DEG**2),
        "order": list(_STD_OF_SERVO),
        "unit": ["deg", "deg/us", "deg"],
        "frame": "joint",
    },
    "repeatability": {"value": deviation("repeatability_rad", _DEG), **_IN_DEG},
    "nonlinearity": {"value": deviation("nonlinearity_rad", _DEG), **_IN_DEG},
    "setting": {
        "zero_us": whole("zero_us", 0, _MAX_VALUE),
        "ns_per_deg": whole("ns_per_deg", 0, _MAX_VALUE),
        "reversed": Item("reversed", Table.flag),
        "min_cdeg": whole("min_cdeg", -_MAX_VALUE, _MAX_VALUE),
        "max_cdeg": whole("max_cdeg", -_MAX_VALUE, _MAX_VALUE),
    },
}
_OF_DYNAMICS = (
    ("speed", "max_rate_rad_s", "deg/s", _DEG),
    ("acceleration", "acceleration_rad_s2", "deg/s^2", _DEG),
    ("delay", "delay_s", "ms", 1e-3),
)
"""Key, attribute, unit, and what one of it is in SI; in the order of the covariance."""
_DYNAMICS_UNITS = np.array([si for *_, si in _OF_DYNAMICS])
_DYNAMICS = {
    "joint": whole("joint", 1, JOINT_COUNT),
    "direction": Item("direction", lambda table, key: table.choice(key, (-1, 1))),
    "taken": Item("recorded_at", Table.time),
    "strokes": whole("strokes", 1, _MAX_VALUE),
    **{
        key: {"value": numbers(name, si=si), "std": numbers(f"{key}_std"), "unit": unit, "frame": "joint"}
        for key, name, unit, si in _OF_DYNAMICS
    },
    "covariance": {
        "value": numbers("covariance", 3, 3, si=np.outer(_DYNAMICS_UNITS, _DYNAMICS_UNITS)),
        "order": [key for key, *_ in _OF_DYNAMICS],
        "unit": [unit for *_, unit, _ in _OF_DYNAMICS],
        "frame": "joint",
    },
    "residual": {"value": deviation("residual_rad", _DEG), **_IN_DEG},
}
RECORDING = {
    "step": text("step"),
    "taken": Item("recorded_at", Table.time),
    "file": text("file"),
    "sha256": text("sha256"),
}
LANDING = {"at": Item("at", Table.time), "told_by": text("told_by")}


def _part(table: Table, key: str) -> str:
    requirement = f"one of {', '.join(PARTS)}"
    name = table.value(key, requirement)
    if name not in PARTS:
        table.fail(key, f"{shorten_value(name)} is not {requirement}")
    return str(name)


REPLACEMENT = {"at": Item("at", Table.time), "part": Item("part", _part), "was": text("was")}


def read_gyro(entry: Table) -> GyroCalibration:
    """Read one `[[gyro]]` table; raise CalibrationError if it is not as `gyro_table` writes it."""
    values = read_values(entry, _GYRO if entry.has("skew") else _WITHOUT_SKEW)
    if not entry.has("skew"):
        skew_std = np.full(3, SKEW_STD)
        values |= {"skew": np.zeros(3), "skew_std": skew_std}
        values["covariance"] = block_diag(values["covariance"], np.diag(skew_std**2))
    if (np.abs(values["bias_rad_s"]) > _MAX_BIAS_RAD_S).any():
        entry.fail("bias.value", "a bias is beyond the widest range of any gyro, 2000 deg/s")
    if (values["scale"] <= 0.0).any():
        entry.fail("scale.value", "a factor is not above zero")
    if (np.abs(np.log2(values["scale"])) > 1.0).any():
        entry.fail("scale.value", "a factor is not between 0.5 and 2: no gyro is so wrong")
    if (np.abs(values["skew"]) > _MAX_SKEW).any():
        entry.fail("skew.value", "a skew is beyond 0.25: no gyro is so wrong")
    # Check the covariance before the deviations that are derived from it.
    values["covariance"] = covariance(entry, "covariance.value", values["covariance"])
    for name, std in _stds_of_gyro(values["covariance"]).items():
        check_std(entry, f"{name}.std", values.pop(f"{name}_std"), std)
    check_rotation(entry, "mounting.rotation", values["rotation"])
    # What the file omits was never measured: NaN, or no time.
    values["noise_rad_s"] = _noise(entry, values["noise_rad_s"], 3)
    values["temperature_c"] = np.nan if values["temperature_c"] is None else values["temperature_c"]
    values |= {name: values[name] or {} for name in ("axes", "scaled")}
    values["absent"] = bool(values["absent"])
    # Where nothing is said the gyros were calibrated independently.
    by_shared, values["shared"] = values["shared"], np.zeros((PARAMETERS, SHARED))
    if by_shared is not None:
        values["shared"][MOUNTING.start :] = by_shared
    return GyroCalibration(**values)


def gyro_table(gyro: GyroCalibration) -> dict[str, Any]:
    """Build the `[[gyro]]` table that `read_gyro` reads."""
    stds = {f"{name}_std": std for name, std in _stds_of_gyro(gyro.covariance).items()}
    shared = gyro.shared[MOUNTING.start :] if gyro.shared.any() else None
    return written_values(_GYRO, _attributes(gyro) | stds | {"shared": shared, "absent": gyro.absent or None})


def read_joint(entry: Table) -> JointSensors:
    """Read one `[[joint]]` table; raise CalibrationError if it is not as `joint_table` writes it."""
    values = read_values(entry, _JOINT)
    if (np.abs(values["direction"]) != 1.0).any():
        entry.fail("direction", "must be 1 or -1 for each sensor")
    if (np.abs(values["bend"]) > _MAX_NONLINEARITY_RAD).any():
        entry.fail("bend.value", "an amplitude is beyond 45 deg: such a sensor shows no angle")
    for name in ("zero", "bend"):
        key = f"{name}_covariance"
        values[key] = covariance(entry, f"{name}.covariance", values[key])
    check_std(entry, "zero.std", values.pop("zero_std"), _std(values["zero_covariance"], _DEG))
    values |= {"noise_rad": _noise(entry, values["noise_rad"], 2), "absent": bool(values["absent"])}
    return JointSensors(**values)


def joint_table(sensors: JointSensors) -> dict[str, Any]:
    """Build the `[[joint]]` table that `read_joint` reads."""
    derived = {"zero_std": _std(sensors.zero_covariance, _DEG), "absent": sensors.absent or None}
    return written_values(_JOINT, _attributes(sensors) | derived)


def read_servo(entry: Table) -> ServoMap:
    """Read one `[[servo]]` table; raise CalibrationError if it is not as `servo_table` writes it."""
    values = read_values(entry, _SERVO)
    values["covariance"] = covariance(entry, "covariance.value", values["covariance"])
    for name, std in zip(_STD_OF_SERVO, _std(values["covariance"], _DEG), strict=True):
        check_std(entry, f"{name}.std", values.pop(f"{name}_std"), std)
    if values["slope_rad_per_us"] == 0.0:
        entry.fail("slope.value", "is zero: such a servo would not move")
    setting = {field.name: int(values.pop(field.name)) for field in fields(ServoSetting)}
    values["pulse_range_us"] = tuple(values["pulse_range_us"].tolist())
    return ServoMap(**values, setting=ServoSetting(**setting))


def servo_table(servo: ServoMap) -> dict[str, Any]:
    """Build the `[[servo]]` table that `read_servo` reads."""
    stds = dict(zip((f"{name}_std" for name in _STD_OF_SERVO), _std(servo.covariance, _DEG), strict=True))
    extras = {"pulse_range_us": np.array(servo.pulse_range_us), "reversed": bool(servo.setting.reversed)}
    return written_values(_SERVO, _attributes(servo) | _attributes(servo.setting) | stds | extras)


def read_dynamics(entry: Table) -> MeasuredDynamics:
    """Read one `[[servo_dynamics]]` table; raise CalibrationError if it is not as `dynamics_table` writes it."""
    values = read_values(entry, _DYNAMICS)
    values["covariance"] = covariance(entry, "covariance.value", values["covariance"])
    for (key, name, *_), std in zip(_OF_DYNAMICS, _std(values["covariance"], _DYNAMICS_UNITS), strict=True):
        check_std(entry, f"{key}.std", values.pop(f"{key}_std"), std)
        if key != "delay" and values[name] <= 0.0:
            entry.fail(f"{key}.value", "is not above zero: such a servo would not move")
    return MeasuredDynamics(**values)


def dynamics_table(dynamics: MeasuredDynamics) -> dict[str, Any]:
    """Build the `[[servo_dynamics]]` table that `read_dynamics` reads."""
    pairs = zip(_OF_DYNAMICS, dynamics.std / _DYNAMICS_UNITS, strict=True)
    return written_values(_DYNAMICS, _attributes(dynamics) | {f"{key}_std": std for (key, *_), std in pairs})


def read_recording(entry: Table) -> Recording:
    """Read one `[[recording]]` table; raise CalibrationError if it is invalid."""
    recording = Recording(**read_values(entry, RECORDING))
    # A bare name: a path could lead out of the recordings' folder.
    if not recording.file or "/" in recording.file or "\\" in recording.file:
        entry.fail("file", "is no name of a file in the folder next to the certificate")
    if len(recording.sha256) != 64 or set(recording.sha256) - set("0123456789abcdef"):
        entry.fail("sha256", "is not 64 hexadecimal digits")
    return recording


def _attributes(of: Any) -> dict[str, Any]:
    return {field.name: getattr(of, field.name) for field in fields(of)}


def _std(spread: FloatArray, si: float | FloatArray) -> FloatArray:
    """(n,) standard deviations by a covariance, in the file's units."""
    return np.asarray(np.sqrt(np.diag(spread)) / si)


def _stds_of_gyro(spread: FloatArray) -> dict[str, FloatArray]:
    std = _std(spread, _BODY_UNITS)
    return {name: std[of] for name, of in _STD_OF_GYRO.items()}


def _noise(entry: Table, noise: FloatArray | None, count: int) -> FloatArray:
    """(count,) in SI; NaN where nothing rested."""
    if noise is None:
        return np.full(count, np.nan)
    if (noise < 0.0).any():
        entry.fail("noise.value", "noise is negative")
    return noise
