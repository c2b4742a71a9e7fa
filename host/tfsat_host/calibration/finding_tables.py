"""How what steps of a calibration have found is shown: by quantity the columns for people and for JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final

import numpy as np

from tfsat_host.calibration.certificate.certificate import Calibration, Recording
from tfsat_host.calibration.findings import SensorBend, sensor_bends, step_findings
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.servos.servo_findings import DYNAMICS
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.next_step import Advice
from tfsat_host.quantity import Column, Columns, Table, fields, plus_minus, vector
from tfsat_host.robot import RobotModel


@dataclass(frozen=True, slots=True)
class QuantityTable:
    """How the steps that measure a quantity are shown.

    Attributes:
        key: Of the rows in JSON.
        title: Of their table.
        kinds: The steps that measure it.
        columns: Of a row of `step_findings`.
    """

    key: str
    title: str
    kinds: tuple[StepKind, ...]
    columns: Columns


def _bias_text(gyro: GyroCalibration) -> str:
    return vector(np.rad2deg(gyro.bias_rad_s), np.rad2deg(gyro.bias_std_rad_s), "+.3f")


_BODY = Column("body", "gyro", of="gyro.body", words=lambda row: f"body {row.gyro.body}")
TABLES: Final[Mapping[str, QuantityTable]] = {
    "bias": QuantityTable(
        "bodies",
        "Bias, sensor axes",
        (StepKind.REST,),
        (
            Column("body", "gyro", words=lambda gyro: f"body {gyro.body}"),
            Column("bias_deg_s", "x, y, z", words=_bias_text),
            *fields("std_deg_s=bias_std_rad_s"),
            Column("temperature_c", "chip / °C", form=".1f"),
        ),
    ),
    "zero": QuantityTable(
        "joints",
        "Zero points",
        (StepKind.ZERO,),
        (
            Column("joint", "zero of", words=lambda row: f"joint {row.joint}"),
            Column("zero_deg", "sensors 1, 2", words=lambda row: vector(row.zero_deg, row.std_deg)),
            *fields("std_deg"),
            Column("disagreement_deg", "sensor 1 − sensor 2", form="+.2f"),
        ),
    ),
    "misalignment": QuantityTable(
        "axes",
        "Joint",
        (StepKind.SWING,),
        (
            _BODY,
            Column("axis_sensor", "joint axis in sensor frame", form="+.4f"),
            Column("angle_deg", "misaligned", words=lambda row: plus_minus(row.angle_deg, row.std_deg)),
            Column(
                "cross_axis",
                "cross-axis / %",
                words=lambda row: vector((100 * value for value in row.cross_axis), form="+.2f"),
            ),
            Column("rms_rate_deg_s", "rms rate", form=".0f"),
            *fields("std_deg nominal_sensor bias_deg_s=gyro.bias_rad_s bias_std_deg_s=gyro.bias_std_rad_s"),
        ),
    ),
    "scale": QuantityTable(
        "scales",
        "Scale factors",
        (StepKind.SWEEP, StepKind.TURN),
        (
            _BODY,
            Column("axis", "about body axis"),
            Column("scale", "reading over truth", words=lambda row: plus_minus(row.scale, row.scale_std)),
            Column("", "error / %", words=lambda row: f"{100 * (row.scale - 1):+.2f}"),
            Column("frame", of=lambda _row: "body"),
            *fields("std=scale_std"),
        ),
    ),
    "servo": QuantityTable("servos", "Servos", (StepKind.STROKES,), DYNAMICS),
}
"""By quantity."""
_BENDS: Final = fields("joint sensor bend_deg std_deg")
_STEPS: Final = fields("key=step file sha256 taken=recorded_at")
_MISSING: Final = (
    *fields("name reason=state"),
    Column("command", of=lambda quantity: Advice(quantity.command)),
)


def _constant(key: str, text: str) -> Column:
    return Column(key, of=lambda _row: text)


def _constants(unit: str, frame: str = "") -> Columns:
    """Columns of the unit, and of the frame unless it is empty."""
    texts = {"unit": unit, **({"frame": frame} if frame else {})}
    return tuple(_constant(key, text) for key, text in texts.items())


VALUES: Final[Mapping[str, Columns]] = {
    "bias": (
        Column("value", of=lambda gyro: np.rad2deg(gyro.bias_rad_s)),
        Column("std", of=lambda gyro: np.rad2deg(gyro.bias_std_rad_s)),
        *_constants("deg/s", "sensor"),
        *fields("temperature_c"),
    ),
    "zero": (*fields("value=zero_deg std=std_deg"), *_constants("deg", "sensor")),
    "misalignment": (
        *fields("value=misalignment_deg std=misalignment_std_deg"),
        *_constants("deg"),
        *fields("axis_sensor"),
    ),
    "scale": (*fields("value=scale std=scale_std"), *_constants("1", "body")),
    "servo": (
        Column("value", of=lambda servo: float(np.rad2deg(servo.backlash_rad))),
        Column("std", of=lambda servo: float(np.rad2deg(servo.backlash_std_rad))),
        *_constants("deg"),
        _constant("is", "backlash"),
        Column("slope_deg_per_us", of=lambda servo: float(np.rad2deg(servo.slope_rad_per_us))),
        *fields("middle_us middle_deg repeatability_deg"),
    ),
}
"""By quantity: value, standard deviation and unit of an entry of `certificate_values`; more where it has more."""


@dataclass(frozen=True, eq=False)
class StepsResult:
    """The results of a `calibrate` command.

    Attributes:
        quantity: `bias`, `zero`, `misalignment` or `scale`.
        steps: Accepted steps; those that do not measure the quantity have no rows.
        before: Calibration when the command began; None: nothing was known.
        now: Present calibration.
        model: The robot.
    """

    quantity: str
    steps: Sequence[Evidence]
    before: Calibration | None
    now: Calibration
    model: RobotModel

    @property
    def table(self) -> Table:
        """Of the quantity, for people and, by `TABLES`, for JSON."""
        shown = TABLES[self.quantity]
        # A rest may precede the motions: keep to the steps that measure this quantity.
        counted = [evidence for evidence in self.steps if evidence.step.kind in shown.kinds]
        joint = f" {counted[0].step.joint}" if self.quantity == "misalignment" else ""
        findings = step_findings(counted, self.before, self.now, self.model)
        return Table(f"{shown.title}{joint}", shown.columns, findings)

    @property
    def bends(self) -> list[SensorBend]:
        """Of the joints that were swept."""
        return sensor_bends(self.now, self.steps) if self.quantity == "scale" else []

    @property
    def recordings(self) -> list[Recording]:
        """The certificate's entries of the steps."""
        keys = {evidence.step.key for evidence in self.steps}
        return [recording for recording in self.now.recordings if recording.step in keys]

    @property
    def columns(self) -> Columns:
        """Of the result in JSON."""
        shown = TABLES[self.quantity]
        return (
            Column(shown.key, of="table.rows", columns=shown.columns),
            *((Column("sensors", of="bends", columns=_BENDS),) if self.quantity == "scale" else ()),
            Column("emulated", of="now.subject.emulated"),
            Column("steps", of="recordings", columns=_STEPS),
            Column("missing", of=lambda result: result.now.shortcomings(), columns=_MISSING),
        )

    @property
    def bend_lines(self) -> list[str]:
        """The largest error of the angle sensors of each joint that was swept, for people."""
        by_joint = groupby(self.bends, key=lambda bend: bend.joint)
        return [
            f"Nonlinearity of the angle sensors of joint {joint}: max. "
            f"{' and '.join(f'{bend.largest_error_deg:.2f}' for bend in bends)} deg, compensated"
            for joint, bends in by_joint
        ]
