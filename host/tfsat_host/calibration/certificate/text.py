"""The text of a certificate: what people read of it, and what `certificate_file` reads back without loss."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.matrices import RAD_PER_DEG
from tfsat_host.calibration.gyros.gyro import GyroCalibration
from tfsat_host.calibration.joints.joint_sensors import JointSensors
from tfsat_host.calibration.servos.servo_map import ServoMap

FloatArray = NDArray[np.float64]

MARK = "# tfsat calibration"
"""In the first line: by it the commands know their own file."""
_SEAL = "# sha256 of all that stands above: "
FORMAT: Final = 1
DIGITS: Final = 12
"""Of every number: far below every uncertainty, and 0.02 stays 0.02."""
GYRO_ORDER = {
    "order": ["bias x y z", "rotation vector x y z", "scale x y z"],
    "unit": ["deg/s", "deg", "1"],
    "frame": "sensor",
}
"""Of the rows and columns of a gyro's covariance."""
BEND_ORDER = ["sin", "cos", "sin 2", "cos 2"]
"""Of the angle shown: the columns of a joint's bend."""
SERVO_ORDER = {"order": ["middle", "slope", "backlash"], "unit": ["deg", "deg/us", "deg"], "frame": "joint"}
GYRO_TO_SI = np.repeat([RAD_PER_DEG, RAD_PER_DEG, 1.0], 3)
SERVO_TO_SI = np.full(3, RAD_PER_DEG)


def format_calibration(calibration: Calibration) -> str:
    """The file's text; `parse_calibration` gives the same calibration back."""
    subject = calibration.subject
    blocks = [
        [
            f"{MARK}: values with their uncertainty, in the unit and frame that stand beside them.",
            "# A key that is not there was never measured. std: one standard deviation, by the covariance.",
            "# measured: body axis, and when the direction of it, or the scale factor about it, was measured.",
            *_pairs(
                format=FORMAT,
                written=calibration.written,
                robot=subject.robot,
                logger_serial=subject.logger_serial,
                who_am_i=subject.who_am_i,
                emulated=subject.emulated,
                tool_version=calibration.tool_version,
                protocol_hash=calibration.protocol_hash,
                logger_image=calibration.logger_image,
            ),
            *_drawn(calibration),
        ]
    ]
    for gyro in calibration.gyros:
        blocks += _gyro(gyro)
    for sensors in calibration.joints:
        blocks += _joint(sensors)
    for servo_map, taken in zip(calibration.servo_maps, calibration.servo_taken, strict=True):
        blocks += _servo(servo_map, taken)
    for paper in calibration.papers:
        blocks.append(
            _table("[[recording]]", step=paper.step, taken=paper.taken, file=paper.file, sha256=paper.sha256)
        )
    for landing in calibration.landings:
        blocks.append(_table("[[landing]]", at=landing.at, told_by=landing.told_by))
    return sealed("\n\n".join("\n".join(block) for block in blocks) + "\n")


def sealed(text: str) -> str:
    """With a line that tells whether the rest was changed since: values are computed, not edited."""
    return f'{text}\n{_SEAL}"{seal_of(text)}"\n'


def seal_of(text: str) -> str:
    """SHA-256 of a certificate's text, hexadecimal; its seal and the kind of its line ends do not count."""
    lines = [line for line in text.splitlines() if not line.startswith(_SEAL)]
    return hashlib.sha256("\n".join(lines).rstrip().encode()).hexdigest()


def seal_in(text: str) -> str | None:
    """What the text says of itself."""
    found = [line for line in text.splitlines() if line.startswith(_SEAL)]
    return found[0].removeprefix(_SEAL).strip().strip('"') if len(found) == 1 else None


def _drawn(calibration: Calibration) -> list[str]:
    """Only where something was: of a real robot nothing ever is."""
    if not calibration.drawn:
        return []
    return [
        "# drawn: never measured; a rehearsal drew it from the emulated robot's hidden truth.",
        *_pairs(drawn=list(calibration.drawn)),
    ]


def _gyro(gyro: GyroCalibration) -> Iterator[list[str]]:
    written = gyro.covariance / np.outer(GYRO_TO_SI, GYRO_TO_SI)
    std = np.sqrt(np.diag(written))
    yield _table("[[gyro]]", body=gyro.body)
    yield _table(
        "[gyro.bias]",
        value=gyro.bias_rad_s / RAD_PER_DEG,
        std=std[0:3],
        unit="deg/s",
        frame="sensor",
        temperature_c=gyro.temperature_c,
        taken=gyro.bias_taken,
    )
    if not np.isnan(gyro.noise_rad_s).any():
        yield _table("[gyro.noise]", value=gyro.noise_rad_s / RAD_PER_DEG, unit="deg/s", frame="sensor")
    yield _table(
        "[gyro.mounting]",
        rotation=gyro.rotation,
        unit="1",
        frame="sensor to body",
        std=std[3:6],
        std_unit="deg",
        std_frame="sensor",
        measured=gyro.axes,
        measured_frame="body",
    )
    yield _table(
        "[gyro.scale]",
        value=gyro.scale,
        std=std[6:9],
        unit="1",
        frame="sensor",
        measured=gyro.scaled,
        measured_frame="body",
    )
    yield _table("[gyro.covariance]", value=written, **GYRO_ORDER)


def _joint(sensors: JointSensors) -> Iterator[list[str]]:
    written = sensors.zero_covariance / RAD_PER_DEG**2
    yield _table("[[joint]]", joint=sensors.joint, direction=sensors.direction)
    yield _table(
        "[joint.zero]",
        value=sensors.zero_rad / RAD_PER_DEG,
        std=np.sqrt(np.diag(written)),
        unit="deg",
        frame="sensor",
        covariance=written,
        taken=sensors.zero_taken,
    )
    yield _table(
        "[joint.bend]",
        value=sensors.bend / RAD_PER_DEG,
        unit="deg",
        frame="sensor",
        order=BEND_ORDER,
        covariance=sensors.bend_covariance / RAD_PER_DEG**2,
        taken=sensors.bend_taken,
    )
    if not np.isnan(sensors.noise_rad).any():
        yield _table("[joint.noise]", value=sensors.noise_rad / RAD_PER_DEG, unit="deg", frame="sensor")


def _servo(servo: ServoMap, taken: datetime) -> Iterator[list[str]]:
    written = servo.covariance / RAD_PER_DEG**2
    std = np.sqrt(np.diag(written))
    yield _table(
        "[[servo]]",
        joint=servo.joint,
        taken=taken,
        places=servo.places,
        repeats=servo.repeats,
        pulse_range_us=servo.pulse_range_us,
    )
    yield _table(
        "[servo.middle]",
        pulse_us=servo.middle_us,
        value=servo.middle_rad / RAD_PER_DEG,
        std=std[0],
        unit="deg",
        frame="joint",
    )
    yield _table(
        "[servo.slope]",
        value=servo.slope_rad_per_us / RAD_PER_DEG,
        std=std[1],
        unit="deg/us",
        frame="joint",
    )
    yield _table(
        "[servo.backlash]", value=servo.backlash_rad / RAD_PER_DEG, std=std[2], unit="deg", frame="joint"
    )
    yield _table("[servo.covariance]", value=written, **SERVO_ORDER)
    yield _table(
        "[servo.repeatability]", value=servo.repeatability_rad / RAD_PER_DEG, unit="deg", frame="joint"
    )
    yield _table(
        "[servo.nonlinearity]", value=servo.nonlinearity_rad / RAD_PER_DEG, unit="deg", frame="joint"
    )
    setting = servo.setting
    yield _table(
        "[servo.setting]",
        zero_us=setting.zero_us,
        ns_per_deg=setting.ns_per_deg,
        reversed=bool(setting.reversed),
        min_cdeg=setting.min_cdeg,
        max_cdeg=setting.max_cdeg,
    )


def _table(header: str, **values: object) -> list[str]:
    return [header, *_pairs(**values)]


def _pairs(**values: object) -> list[str]:
    """One line a key; what is not known, None, NaN or no time at all, has none."""
    known = {key: value for key, value in values.items() if not _is_unknown(value)}
    return [f"{key} = {_value(value)}" for key, value in known.items()]


def _is_unknown(value: object) -> bool:
    if isinstance(value, Mapping):
        return not value
    return value is None or (isinstance(value, float) and math.isnan(value))


def _value(value: object) -> str:
    if isinstance(value, np.ndarray):
        return _value(value.tolist())
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, datetime):
        return value.astimezone(UTC).isoformat().replace("+00:00", "Z")
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_value(item)}' for key, item in value.items())} }}"
    if isinstance(value, list | tuple):
        return _rows(list(value))
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, float):
        return repr(float(f"{value:.{DIGITS}g}"))
    return str(value)


def _rows(values: list[object]) -> str:
    """A list on one line, a matrix with a line for each of its rows."""
    items = [_value(value) for value in values]
    if values and isinstance(values[0], list):
        return "[\n" + "".join(f"    {item},\n" for item in items) + "]"
    return f"[{', '.join(items)}]"
