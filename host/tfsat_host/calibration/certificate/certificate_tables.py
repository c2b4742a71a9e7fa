"""How values stand in a certificate, declared once for reading and writing.

A layout has the keys of a table in their order; one that ends in `?` may be left out: its values were never measured.
To each key belongs an `Item`, the layout of a table inside, or a text or list that must stand there: a unit, a frame.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from datetime import datetime
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Landing, Paper
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.steps.step import AXES
from tfsat_host.config import Table
from tfsat_host.config.table import shorten_value
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT
from tfsat_host.protocol.messages import ServoSetting

DIGITS: Final = 12
"""Of every number: far below every uncertainty, and 0.02 stays 0.02."""
Layout = Mapping[str, Any]


@dataclass(frozen=True)
class Item:
    """One entry.

    Attributes:
        name: Of its value in memory.
        read: Takes it from its table, by its key.
        si: What one of the file's units is in SI.
    """

    name: str
    read: Callable[[Table, str], Any]
    si: float | NDArray[np.float64] = 1.0


def numbers(name: str, *shape: int, si: float | NDArray[np.float64] = 1.0) -> Item:
    """Build the item of an array of that shape, or of a number if no shape is given."""
    return Item(name, lambda table, key: table.array(key, *shape) if shape else table.number(key), si)


def deviation(name: str, si: float) -> Item:
    """Build the item of a standard deviation: a number, 0 or above."""
    return Item(name, partial(Table.number, least=0.0), si)


def whole(name: str, least: int, most: int) -> Item:
    """Build the item of a whole number from `least` to `most`."""
    return Item(name, partial(Table.integer, least=least, most=most))


def text(name: str) -> Item:
    """Build the item of a text, which may be empty."""
    return Item(name, partial(Table.text, empty=True))


def times(name: str) -> Item:
    """Build the item of the times at which a body's axes were measured, for those that were."""

    def read(table: Table, key: str) -> dict[str, datetime]:
        inner = table.table(key, " ".join(AXES))
        return {axis: inner.time(axis) for axis in AXES if inner.has(axis)}

    return Item(name, read)


def read_values(table: Table, layout: Layout) -> dict[str, Any]:
    """Read a table's values in SI units, by item name; None for an omitted entry.

    Raises:
        CalibrationError: an entry does not match the layout.
    """
    # Unknown keys first: a misspelt optional one would otherwise pass as never measured.
    table.only(" ".join(layout).replace("?", ""))
    values: dict[str, Any] = {}
    for key, item in layout.items():
        name = key.rstrip("?")
        if name != key and not table.has(name):
            # An optional table that is absent: none of its values was measured.
            values |= dict.fromkeys(leaf.name for leaf in _items(item))
        elif isinstance(item, Item):
            value = item.read(table, name)
            values[item.name] = value * item.si if isinstance(value, float | np.ndarray) else value
        elif isinstance(item, Mapping):
            values |= read_values(table.table(name), item)
        elif (stated := table.value(name, str(item))) != item:
            # A unit, frame or order must stand as written: converting silently would guess.
            table.fail(
                name,
                f"{shorten_value(stated)} is not {item!r}, which this program writes and reads",
                f"Convert the values to {item!r} and name that here, or move this file away: "
                "a step of tfsat-host calibrate writes it again from its recordings.",
            )
    return values


def written_values(layout: Layout, values: Mapping[str, Any]) -> dict[str, Any]:
    """Convert values to a table in the file's units, the inverse of `read_values`.

    Unknown values are omitted: None, NaN, no time at all.
    """
    entries = {}
    for key, item in layout.items():
        if isinstance(item, Item):
            value = _format_value(values[item.name], item.si)
        elif isinstance(item, Mapping):
            # A table of units without a value is left out as a whole.
            has_values = any(_format_value(values[leaf.name], leaf.si) is not None for leaf in _items(item))
            value = written_values(item, values) if has_values else None
        else:
            value = item
        if value is not None:
            entries[key.rstrip("?")] = value
    return entries


def _items(layout: Layout | Item) -> list[Item]:
    if isinstance(layout, Item):
        return [layout]
    return [item for item in layout.values() if isinstance(item, Item)]


def _format_value(value: Any, si: float | NDArray[np.float64]) -> Any:
    if isinstance(value, float | np.ndarray):
        # A NaN anywhere means not measured: the array is left out rather than written in part.
        rounded = _round_values((np.asarray(value) / si).tolist())
        return None if np.isnan(rounded).any() else rounded
    return None if value is None or value in ((), [], {}) else value


def _round_values(value: Any) -> Any:
    return (
        [_round_values(item) for item in value] if isinstance(value, list) else float(f"{value:.{DIGITS}g}")
    )


ROUNDING = 1e-6
"""So far may a number that a person copied differ from what follows from another: more digits say nothing."""


def covariance(entry: Table, key: str, written: FloatArray) -> FloatArray:
    """Check the covariance (n, n) read from `key` and return it exactly symmetric.

    Raises:
        CalibrationError: it is not symmetric, or not positive.
    """
    variances = np.diag(written)
    if (variances < 0.0).any():
        entry.fail(key, "the covariance has a negative variance")
    # Compare relative to the deviations: the entries have different units.
    size = np.sqrt(np.outer(variances, variances))
    if (np.abs(written - written.T) > ROUNDING * size).any():
        entry.fail(key, "the covariance is not symmetric")
    # Correlations are free of units, so that one tolerance fits all eigenvalues.
    scaled = np.divide(written, size, out=np.zeros_like(written), where=size > 0.0)
    if (written[size == 0.0] != 0.0).any() or np.linalg.eigvalsh(scaled).min() < -ROUNDING:
        entry.fail(key, "the covariance is not positive: no errors can vary like that")
    return np.asarray((written + written.T) / 2.0)


def check_std(entry: Table, key: str, stated: FloatArray, derived: FloatArray) -> None:
    """Refuses a std that is not the covariance's: one of them was changed by hand; both in the file's units.

    Raises:
        CalibrationError: they differ.
    """
    if not np.allclose(stated, derived, rtol=ROUNDING, atol=0.0):
        derived_text = " ".join(f"{value:.6g}" for value in np.atleast_1d(derived))
        entry.fail(key, f"is not what its covariance says ({derived_text})")


def check_rotation(entry: Table, key: str, matrix: FloatArray) -> None:
    """Refuses a matrix (3, 3) that is no proper rotation.

    Raises:
        CalibrationError: its rows are not orthogonal, not of length 1, or mirrored.
    """
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > ROUNDING:
        entry.fail(key, "is no rotation: its rows are not perpendicular and of length 1")
    if np.linalg.det(matrix) < 0.0:
        entry.fail(key, "is no rotation but a mirror: two of its rows may be exchanged")


_DEG = np.pi / 180.0
# Sixteen bits: no count or setting needs more.
_MAX_VALUE = 65_535
# Bounds of plausibility: the widest range of any gyro; a sensor beyond 45 deg shows no angle.
_MAX_BIAS_RAD_S, _MAX_NONLINEARITY_RAD = 2000.0 * _DEG, 45.0 * _DEG
_BODY_UNITS = np.repeat([_DEG, _DEG, 1.0], 3)
"""Of the rows and columns of a gyro's covariance."""
_GYRO = {
    "body": whole("body", 1, IMU_COUNT),
    "bias": {
        "value": numbers("bias_rad_s", 3, si=_DEG),
        "std": numbers("bias_std", 3),
        "unit": "deg/s",
        "frame": "sensor",
        "temperature_c?": numbers("temperature_c"),
        "taken?": Item("bias_taken", Table.time),
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
    "covariance": {
        "value": numbers("covariance", 9, 9, si=np.outer(_BODY_UNITS, _BODY_UNITS)),
        "order": ["bias x y z", "rotation vector x y z", "scale x y z"],
        "unit": ["deg/s", "deg", "1"],
        "frame": "sensor",
    },
}
_STD_OF_GYRO = {"bias": slice(0, 3), "mounting": slice(3, 6), "scale": slice(6, 9)}
_JOINT = {
    "joint": whole("joint", 1, JOINT_COUNT),
    "direction": numbers("direction", 2),
    "zero": {
        "value": numbers("zero_rad", 2, si=_DEG),
        "std": numbers("zero_std", 2),
        "unit": "deg",
        "frame": "sensor",
        "covariance": numbers("zero_covariance", 2, 2, si=_DEG**2),
        "taken?": Item("zero_taken", Table.time),
    },
    "bend": {
        "value": numbers("bend", 2, 4, si=_DEG),
        "unit": "deg",
        "frame": "sensor",
        "order": ["sin", "cos", "sin 2", "cos 2"],  # of the angle shown
        "covariance": numbers("bend_covariance", 8, 8, si=_DEG**2),
        "taken?": Item("bend_taken", Table.time),
    },
    "noise?": {"value": numbers("noise_rad", 2, si=_DEG), "unit": "deg", "frame": "sensor"},
}
_IN_DEG = {"unit": "deg", "frame": "joint"}
_STD_OF_SERVO = ("middle", "slope", "backlash")
_SERVO = {
    "joint": whole("joint", 1, JOINT_COUNT),
    "taken": Item("taken", Table.time),
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
_PAPER = {
    "step": text("step"),
    "taken": Item("taken", Table.time),
    "file": text("file"),
    "sha256": text("sha256"),
}
_LANDING = {"at": Item("at", Table.time), "told_by": text("told_by")}


def read_gyro(entry: Table) -> GyroCalibration:
    """Read one `[[gyro]]` table; raise CalibrationError if it is not as `gyro_table` writes it."""
    values = read_values(entry, _GYRO)
    if (np.abs(values["bias_rad_s"]) > _MAX_BIAS_RAD_S).any():
        entry.fail("bias.value", "a bias is beyond the widest range of any gyro, 2000 deg/s")
    if (values["scale"] <= 0.0).any():
        entry.fail("scale.value", "a factor is not above zero")
    if (np.abs(np.log2(values["scale"])) > 1.0).any():
        entry.fail("scale.value", "a factor is not between 0.5 and 2: no gyro is so wrong")
    # Check the covariance before the deviations that are derived from it.
    values["covariance"] = covariance(entry, "covariance.value", values["covariance"])
    for name, std in _stds_of_gyro(values["covariance"]).items():
        check_std(entry, f"{name}.std", values.pop(f"{name}_std"), std)
    check_rotation(entry, "mounting.rotation", values["rotation"])
    # What the file omits was never measured: NaN, or no time.
    values["noise_rad_s"] = _noise(entry, values["noise_rad_s"], 3)
    values["temperature_c"] = np.nan if values["temperature_c"] is None else values["temperature_c"]
    values |= {name: values[name] or {} for name in ("axes", "scaled")}
    return GyroCalibration(**values)


def gyro_table(gyro: GyroCalibration) -> dict[str, Any]:
    """Build the `[[gyro]]` table that `read_gyro` reads."""
    stds = {f"{name}_std": std for name, std in _stds_of_gyro(gyro.covariance).items()}
    return written_values(_GYRO, _attributes(gyro) | stds)


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
    return JointSensors(**values | {"noise_rad": _noise(entry, values["noise_rad"], 2)})


def joint_table(sensors: JointSensors) -> dict[str, Any]:
    """Build the `[[joint]]` table that `read_joint` reads."""
    return written_values(_JOINT, _attributes(sensors) | {"zero_std": _std(sensors.zero_covariance, _DEG)})


def read_servo(entry: Table) -> tuple[ServoMap, datetime]:
    """Read one `[[servo]]` table: the servo map and the time it was measured.

    Raises CalibrationError if it is not as `servo_table` writes it.
    """
    values = read_values(entry, _SERVO)
    values["covariance"] = covariance(entry, "covariance.value", values["covariance"])
    for name, std in zip(_STD_OF_SERVO, _std(values["covariance"], _DEG), strict=True):
        check_std(entry, f"{name}.std", values.pop(f"{name}_std"), std)
    if values["slope_rad_per_us"] == 0.0:
        entry.fail("slope.value", "is zero: such a servo would not move")
    setting = {field.name: int(values.pop(field.name)) for field in fields(ServoSetting)}
    taken_at, pulse_range_us = values.pop("taken"), tuple(values.pop("pulse_range_us").tolist())
    return ServoMap(**values, setting=ServoSetting(**setting), pulse_range_us=pulse_range_us), taken_at


def servo_table(servo: ServoMap, taken_at: datetime) -> dict[str, Any]:
    """Build the `[[servo]]` table that `read_servo` reads."""
    stds = dict(zip((f"{name}_std" for name in _STD_OF_SERVO), _std(servo.covariance, _DEG), strict=True))
    extras = {
        "taken": taken_at,
        "pulse_range_us": np.array(servo.pulse_range_us),
        "reversed": bool(servo.setting.reversed),
    }
    return written_values(_SERVO, _attributes(servo) | _attributes(servo.setting) | stds | extras)


def read_paper(entry: Table) -> Paper:
    """Read one `[[recording]]` table; raise CalibrationError if it is invalid."""
    paper = Paper(**read_values(entry, _PAPER))
    # A bare name: a path could lead out of the recordings' folder.
    if not paper.file or "/" in paper.file or "\\" in paper.file:
        entry.fail("file", "is no name of a file in the folder next to the certificate")
    if len(paper.sha256) != 64 or set(paper.sha256) - set("0123456789abcdef"):
        entry.fail("sha256", "is not 64 hexadecimal digits")
    return paper


def read_landing(entry: Table) -> Landing:
    """Read one `[[landing]]` table; raise CalibrationError if it is invalid."""
    return Landing(**read_values(entry, _LANDING))


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
