"""What the sensors were calibrated with."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.quantity import UNKNOWN, Column, Table, vector
from tfsat_host.sdlog import DropLog

FloatArray = NDArray[np.float64]

_COLUMNS = tuple(Column(name, name) for name in ("quantity", "value", "unit", "taken"))


def release_time(log: DropLog) -> datetime | None:
    """None if the logger did not know the time of day, or recorded no release."""
    if log.release_us is None or log.unix_offset_us is None:
        return None
    return datetime.fromtimestamp((log.release_us + log.unix_offset_us) * 1e-6, UTC)


def utc(moment: datetime | None) -> str:
    """A time of day to the minute."""
    return UNKNOWN if moment is None else f"{moment.astimezone(UTC):%Y-%m-%d %H:%M} UTC"


def calibration_table(found: Evaluation) -> Table:
    """Of what was used, with when each quantity was measured."""
    calibration, taken = found.calibration, _Taken(found)
    rows = []
    for gyro in calibration.gyros:
        name = f"bias of body {gyro.body}"
        std = np.rad2deg(np.sqrt(np.diag(gyro.covariance)[:3]))
        rows.append([name, vector(np.rad2deg(gyro.bias_rad_s), std), "deg/s", taken(name)])
    rows += [
        [*_mounting(gyro, found), taken(f"misalignment of body {gyro.body}")] for gyro in calibration.gyros
    ]
    rows += [[*_scale(gyro), taken("scale factor", f"of body {gyro.body}")] for gyro in calibration.gyros]
    for joint in calibration.joints:
        name = f"zero point of joint {joint.joint}"
        std = np.rad2deg(np.sqrt(np.diag(joint.zero_covariance)))
        rows.append([name, vector(np.rad2deg(joint.zero_rad) % 360.0, std), "deg", taken(name)])
    return Table(
        "Calibration",
        _COLUMNS,
        [dict(zip(("quantity", "value", "unit", "taken"), row, strict=True)) for row in rows],
        "± is the greatest standard deviation of a row. What stands in for something that was never measured, "
        "or not since a landing, is told beside the verdict.",
    )


class _Taken:
    """When quantities were measured: the earliest of those that a row holds, and whether they hold yet."""

    def __init__(self, found: Evaluation) -> None:
        self._quantities = quantities(found.calibration)
        self._lacking = {
            one.name: one.reason for one in found.calibration.shortcomings(release_time(found.log))
        }

    def __call__(self, *parts: str) -> str:
        """Of the quantities in whose names all parts are."""
        of_row = [one for one in self._quantities if all(part in one.name for part in parts)]
        missing = sum(one.taken is None for one in of_row)
        if missing == len(of_row):
            return "never"
        earliest = min(one.taken for one in of_row if one.taken is not None)
        remarks = [f"{missing} of {len(of_row)} never"] if missing else []
        if any(self._lacking.get(one.name) == "stale" for one in of_row):
            remarks.append("before a landing")
        return ", ".join([utc(earliest), *remarks])


def _mounting(gyro: GyroCalibration, found: Evaluation) -> list[str]:
    """How far the sensor is turned from where the design has it."""
    turn = gyro.rotation @ found.model.imus[gyro.body - 1].sensor_to_body.T
    angle = np.rad2deg(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)))
    std = np.rad2deg(np.sqrt(np.linalg.eigvalsh(gyro.covariance[3:6, 3:6])))
    return [f"misalignment of body {gyro.body}", vector(np.array([angle]), std), "deg"]


def _scale(gyro: GyroCalibration) -> list[str]:
    """About each body axis."""
    values, std = np.array([gyro.scale_about(axis) for axis in range(3)]).T
    return [f"scale factors of body {gyro.body}", vector(values, std), "1"]
