"""The tables of a certificate, back to what they were written from."""

from __future__ import annotations

from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import Landing, Paper
from tfsat_host.calibration.certificate.entries import Entry
from tfsat_host.calibration.certificate.matrices import RAD_PER_DEG, check_std, covariance, rotation
from tfsat_host.calibration.certificate.text import (
    BEND_ORDER,
    GYRO_ORDER,
    GYRO_TO_SI,
    SERVO_ORDER,
    SERVO_TO_SI,
)
from tfsat_host.calibration.gyros.gyro import GyroCalibration
from tfsat_host.calibration.joints.joint_sensors import JointSensors
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.steps.step import AXES
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT
from tfsat_host.protocol.messages import ServoSetting

FloatArray = NDArray[np.float64]

_MEASURED = ("measured", "measured_frame")
_LARGEST = 65_535


def read_gyro(entry: Entry) -> GyroCalibration:
    """Of one `[[gyro]]`. Raises CalibrationError at whatever is not as `certificate_text` writes it."""
    entry.allow("body", "bias", "noise", "mounting", "scale", "covariance")
    body = entry.whole("body", 1, IMU_COUNT)
    entry.label = f"body {body}"
    bias = entry.table("bias", f"the bias of body {body}")
    bias.allow("value", "std", "unit", "frame", "temperature_c", "taken")
    bias.expect(unit="deg/s", frame="sensor")
    mounting = entry.table("mounting", f"the mounting of body {body}")
    mounting.allow("rotation", "unit", "frame", "std", "std_unit", "std_frame", *_MEASURED)
    mounting.expect(unit="1", frame="sensor to body", std_unit="deg", std_frame="sensor")
    scale = entry.table("scale", f"the scale of body {body}")
    scale.allow("value", "std", "unit", "frame", *_MEASURED)
    scale.expect(unit="1", frame="sensor")
    factors = scale.array("value", (3,))
    if (factors <= 0.0).any():
        scale.fail("value", f"{scale.label} has a factor that is not above zero")
    spread = entry.table("covariance", f"the covariance of body {body}")
    spread.allow("value", *GYRO_ORDER)
    spread.expect(**GYRO_ORDER)
    errors = covariance(spread, "value", GYRO_TO_SI)
    stated = np.sqrt(np.diag(errors)) / GYRO_TO_SI
    for table, of in ((bias, slice(0, 3)), (mounting, slice(3, 6)), (scale, slice(6, 9))):
        check_std(table, table.array("std", (3,)), stated[of])
    return GyroCalibration(
        body=body,
        bias_rad_s=bias.array("value", (3,)) * RAD_PER_DEG,
        rotation=rotation(mounting, "rotation"),
        scale=factors,
        covariance=errors,
        noise_rad_s=_noise(entry, "deg/s", 3),
        temperature_c=bias.number("temperature_c") if bias.has("temperature_c") else float("nan"),
        axes=_measured(mounting),
        scaled=_measured(scale),
        bias_taken=bias.time_or_none("taken"),
    )


def read_joint(entry: Entry) -> JointSensors:
    """Of one `[[joint]]`. Raises CalibrationError likewise."""
    entry.allow("joint", "direction", "zero", "bend", "noise")
    joint = entry.whole("joint", 1, JOINT_COUNT)
    entry.label = f"joint {joint}"
    direction = entry.array("direction", (2,))
    if (np.abs(direction) != 1.0).any():
        entry.fail("direction", f"direction of {entry.label} must be 1 or -1 for each sensor")
    zero = entry.table("zero", f"the zero point of joint {joint}")
    zero.allow("value", "std", "unit", "frame", "covariance", "taken")
    zero.expect(unit="deg", frame="sensor")
    bend = entry.table("bend", f"the bend of joint {joint}")
    bend.allow("value", "unit", "frame", "order", "covariance", "taken")
    bend.expect(unit="deg", frame="sensor", order=BEND_ORDER)
    return JointSensors(
        joint=joint,
        direction=direction,
        zero_rad=zero.array("value", (2,)) * RAD_PER_DEG,
        zero_covariance=covariance(zero, "covariance", np.full(2, RAD_PER_DEG), zero.array("std", (2,))),
        bend=bend.array("value", (2, 4)) * RAD_PER_DEG,
        bend_covariance=covariance(bend, "covariance", np.full(8, RAD_PER_DEG)),
        noise_rad=_noise(entry, "deg", 2),
        zero_taken=zero.time_or_none("taken"),
        bend_taken=bend.time_or_none("taken"),
    )


def read_servo(entry: Entry) -> tuple[ServoMap, datetime]:
    """Of one `[[servo]]`, and when it was measured. Raises CalibrationError likewise."""
    parts = ("middle", "slope", "backlash", "covariance", "repeatability", "nonlinearity", "setting")
    entry.allow("joint", "taken", "places", "repeats", "pulse_range_us", *parts)
    joint = entry.whole("joint", 1, JOINT_COUNT)
    entry.label = f"the servo of joint {joint}"
    middle = _of_servo(entry, "middle", "deg", "std", "pulse_us")
    slope = _of_servo(entry, "slope", "deg/us", "std")
    backlash = _of_servo(entry, "backlash", "deg", "std")
    spread = entry.table("covariance", f"the covariance of the servo of joint {joint}")
    spread.allow("value", *SERVO_ORDER)
    spread.expect(**SERVO_ORDER)
    errors = covariance(spread, "value", SERVO_TO_SI)
    stated = np.sqrt(np.diag(errors)) / SERVO_TO_SI
    for number, table in enumerate((middle, slope, backlash)):
        check_std(table, table.array("std", ()), stated[number])
    if slope.number("value") == 0.0:
        slope.fail("value", f"{slope.label} is zero: such a servo would not move")
    low_us, high_us = entry.array("pulse_range_us", (2,)).tolist()
    servo_map = ServoMap(
        joint=joint,
        middle_us=middle.number("pulse_us"),
        middle_rad=middle.number("value") * RAD_PER_DEG,
        slope_rad_per_us=slope.number("value") * RAD_PER_DEG,
        backlash_rad=backlash.number("value") * RAD_PER_DEG,
        covariance=errors,
        repeatability_rad=_of_servo(entry, "repeatability", "deg").deviation("value") * RAD_PER_DEG,
        repeats=entry.whole("repeats", 0, _LARGEST),
        nonlinearity_rad=_of_servo(entry, "nonlinearity", "deg").deviation("value") * RAD_PER_DEG,
        places=entry.whole("places", 0, _LARGEST),
        pulse_range_us=(low_us, high_us),
        setting=_setting(entry.table("setting", f"the setting of the servo of joint {joint}")),
    )
    return servo_map, entry.time("taken")


def read_paper(entry: Entry) -> Paper:
    """Of one `[[recording]]`. Raises CalibrationError likewise."""
    entry.allow("step", "taken", "file", "sha256")
    file = entry.text("file")
    if not file or "/" in file or "\\" in file:
        entry.fail("file", f"file of {entry.label} is no name of a file in the folder beside the certificate")
    digest = entry.text("sha256")
    if len(digest) != 64 or set(digest) - set("0123456789abcdef"):
        entry.fail("sha256", f"sha256 of {entry.label} is not 64 hexadecimal digits")
    return Paper(entry.text("step"), entry.time("taken"), file, digest)


def read_landing(entry: Entry) -> Landing:
    """Of one `[[landing]]`. Raises CalibrationError likewise."""
    entry.allow("at", "told_by")
    return Landing(entry.time("at"), entry.text("told_by"))


def _measured(entry: Entry) -> dict[str, datetime]:
    """Body axis to when it was measured."""
    entry.expect(measured_frame="body")
    return entry.times("measured", AXES)


def _noise(entry: Entry, unit: str, count: int) -> FloatArray:
    """(count,) in SI; NaN where nothing rested."""
    if not entry.has("noise"):
        return np.full(count, np.nan)
    noise = entry.table("noise", f"the noise of {entry.label}")
    noise.allow("value", "unit", "frame")
    noise.expect(unit=unit, frame="sensor")
    values = noise.array("value", (count,))
    if (values < 0.0).any():
        noise.fail("value", f"{noise.label} is negative")
    return np.asarray(values * RAD_PER_DEG)


def _of_servo(entry: Entry, key: str, unit: str, *more: str) -> Entry:
    table = entry.table(key, f"the {key} of {entry.label}")
    table.allow("value", "unit", "frame", *more)
    table.expect(unit=unit, frame="joint")
    return table


def _setting(entry: Entry) -> ServoSetting:
    entry.allow("zero_us", "ns_per_deg", "reversed", "min_cdeg", "max_cdeg")
    return ServoSetting(
        entry.whole("zero_us", 0, _LARGEST),
        entry.whole("ns_per_deg", 0, _LARGEST),
        int(entry.flag("reversed")),
        entry.whole("min_cdeg", -_LARGEST, _LARGEST),
        entry.whole("max_cdeg", -_LARGEST, _LARGEST),
    )
