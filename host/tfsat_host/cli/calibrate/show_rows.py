"""What a certificate says of each quantity, in people's units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any

from tfsat_host.calibration.certificate.certificate import AXES_OF_BODIES, Calibration, quantities
from tfsat_host.quantity import vector

if TYPE_CHECKING:
    from tfsat_host.calibration.sensors.gyro import GyroCalibration
    from tfsat_host.calibration.sensors.joint_sensors import JointSensors
    from tfsat_host.calibration.servos.servo_map import ServoMap
    from tfsat_host.robot import RobotModel


@dataclass(frozen=True)
class Value:
    """A quantity's value.

    Attributes:
        value, std: In `unit`: a number, or one for each axis or sensor.
        unit: `deg/s`, `deg` or `1`.
        more: For `--json`, what else belongs to it.
    """

    value: float | list[float]
    std: float | list[float]
    unit: str
    more: dict[str, Any]

    @property
    def text(self) -> str:
        """Value, standard deviation and unit; of several the largest deviation."""
        values, std = ([one] if isinstance(one, float) else one for one in (self.value, self.std))
        backlash = f"{self.more['slope_deg_per_us']:+.4f} deg/us, backlash " if "is" in self.more else ""
        return f"{backlash}{vector(values, std)} {'' if self.unit == '1' else self.unit}".rstrip()


@dataclass(frozen=True)
class Row:
    """One quantity of a certificate.

    Attributes:
        name: Of the quantity.
        value: None if it was never measured.
        taken: When.
        state: `valid`, `stale` (a landing since) or `missing`.
        command: What measures it.
    """

    name: str
    value: Value | None
    taken: datetime | None
    state: str
    command: str


def rows_of(calibration: Calibration, model: RobotModel, options: str = "") -> list[Row]:
    """All that a drop needs, in the order in which it is measured; `options` end every command."""
    states = {one.name: one.reason for one in calibration.shortcomings()}
    values = dict(_values(calibration, model))
    return [
        Row(
            quantity.name,
            None if quantity.taken is None else values[quantity.name],
            quantity.taken,
            states.get(quantity.name, "valid"),
            f"tfsat-host calibrate {quantity.command}{options}",
        )
        for quantity in quantities(calibration)
    ]


def _values(calibration: Calibration, model: RobotModel) -> Iterator[tuple[str, Value]]:
    """By the names that `quantities` gives them."""
    for gyro in calibration.gyros:
        yield f"bias of body {gyro.body}", _bias(gyro)
        for axis in AXES_OF_BODIES[gyro.body]:
            yield f"misalignment of body {gyro.body} about {axis}", _misalignment(gyro, axis, model)
        for axis in "xyz":
            yield f"scale factor {axis} of body {gyro.body}", _scale(gyro, axis)
    for sensors in calibration.joints:
        yield f"zero point of joint {sensors.joint}", _zero(sensors)
    for servo_map in calibration.servo_maps:
        yield f"servo of joint {servo_map.joint}", _servo(servo_map)


def _bias(gyro: GyroCalibration) -> Value:
    import numpy as np

    value = np.rad2deg(gyro.bias_rad_s)
    std = np.rad2deg(np.sqrt(np.diag(gyro.covariance)[:3]))
    more = {"frame": "sensor", "temperature_c": gyro.temperature_c}
    return Value(value.tolist(), std.tolist(), "deg/s", more)


def _misalignment(gyro: GyroCalibration, axis: str, model: RobotModel) -> Value:
    """How far the body axis lies, in sensor axes, from where the design has it.

    A small rotation d (sensor axes) moves it by d x axis, whose covariance follows from that of d.
    """
    import numpy as np

    number = "xyz".index(axis)
    true = gyro.rotation[number]
    nominal = model.imus[gyro.body - 1].sensor_to_body[number]
    x, y, z = true
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    spread = cross @ gyro.covariance[3:6, 3:6] @ cross.T
    value = float(np.rad2deg(np.arctan2(np.linalg.norm(np.cross(true, nominal)), true @ nominal)))
    std = float(np.rad2deg(np.sqrt(np.linalg.eigvalsh(spread)[-1])))
    return Value(value, std, "deg", {"axis_sensor": true.tolist()})


def _scale(gyro: GyroCalibration, axis: str) -> Value:
    """For rotations about a body axis, however the sensor is mounted."""
    value, std = gyro.scale_about("xyz".index(axis))
    return Value(value, std, "1", {"frame": "body"})


def _zero(sensors: JointSensors) -> Value:
    import numpy as np

    value = np.rad2deg(sensors.zero_rad) % 360.0
    std = np.rad2deg(np.sqrt(np.diag(sensors.zero_covariance)))
    return Value(value.tolist(), std.tolist(), "deg", {"frame": "sensor"})


def _servo(servo_map: ServoMap) -> Value:
    import numpy as np

    value = float(np.rad2deg(servo_map.backlash_rad))
    std = float(np.rad2deg(servo_map.backlash_std_rad))
    slope = float(np.rad2deg(servo_map.slope_rad_per_us))
    more = {
        "is": "backlash",
        "slope_deg_per_us": slope,
        "middle_us": servo_map.middle_us,
        "middle_deg": float(np.rad2deg(servo_map.middle_rad)),
        "repeatability_deg": float(np.rad2deg(servo_map.repeatability_rad)),
    }
    return Value(value, std, "deg", more)
