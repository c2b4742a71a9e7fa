"""What steps of a calibration have found, as people ask for it: tables of numbers with their standard deviations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from tfsat_host.angles import wrap_angle
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.response import across
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import AXES, StepKind
from tfsat_host.next_step import Advice
from tfsat_host.quantity import UNKNOWN, Column, Columns, Table, fields, plus_minus, records, vector
from tfsat_host.robot import RobotModel

Row = dict[str, Any]


def bias_row(gyro: GyroCalibration) -> Row:
    """Bias of one gyro, sensor axes."""
    std = np.rad2deg(np.sqrt(np.diag(gyro.covariance)[:3]))
    return {
        "body": gyro.body,
        "bias_deg_s": np.rad2deg(gyro.bias_rad_s),
        "std_deg_s": std,
        "temperature_c": gyro.temperature_c,
    }


def zero_row(sensors: JointSensors, before: JointSensors | None = None) -> Row:
    """Build the row of a joint's zero points: each sensor's reading at joint angle zero, 0 to 360 deg.

    `disagreement_deg` is the joint's angle by the first sensor less that by the second, by the zero points
    known before; None if none were.
    """
    disagreement = None
    if before is not None and before.zero_taken is not None:
        # Read the new zeros by the old calibration: what sets both sensors apart is a slip since then.
        by_each = before.each(sensors.zero_rad[None, :])[0]
        disagreement = float(np.rad2deg(wrap_angle(by_each[:1] - by_each[1:])[0]))
    return {
        "joint": sensors.joint,
        "zero_deg": np.rad2deg(sensors.zero_rad) % 360.0,
        "std_deg": np.rad2deg(np.sqrt(np.diag(sensors.zero_covariance))),
        "disagreement_deg": disagreement,
    }


def axis_rows(gyros: Sequence[GyroCalibration], swing: Evidence, model: RobotModel) -> list[Row]:
    """Build the rows of the joint's axis in the frame of each gyro that a swing moved.

    `angle_deg` is the angle between the axis and `nominal_sensor`, its direction if the gyro is mounted as
    designed; `std_deg` the standard deviation of the axis's direction, per transverse direction; `cross_axis`
    the two transverse components, in x, y, z order, relative to the component along the main axis.
    """
    joint_axis = model.joint_axis[swing.step.moving_joint - 1]
    rows = []
    for gyro in (gyros[body - 1] for body in swing.step.moved):
        axis = gyro.rotation.T @ joint_axis
        nominal = model.imus[gyro.body - 1].sensor_to_body.T @ joint_axis
        # A rotation vector along the axis leaves it where it is; one across moves it by as much.
        variance = float(np.trace(across(axis) @ gyro.covariance[3:6, 3:6] @ across(axis))) / 2.0
        rates = swing.recording.rate_rad_s[:, gyro.body - 1] - gyro.bias_rad_s
        # The component along the design's main axis is what the other two are compared with.
        bias, main = bias_row(gyro), int(np.argmax(np.abs(nominal)))
        rows.append(
            {
                "body": gyro.body,
                "axis_sensor": axis,
                "nominal_sensor": nominal,
                "angle_deg": _apart_deg(axis, nominal),
                "std_deg": float(np.rad2deg(np.sqrt(variance))),
                "cross_axis": tuple(float(axis[i] / axis[main]) for i in range(3) if i != main),
                "rms_rate_deg_s": float(np.rad2deg(np.sqrt((rates**2).sum(axis=1).mean()))),
                "bias_deg_s": bias["bias_deg_s"],
                "bias_std_deg_s": bias["std_deg_s"],
            }
        )
    return rows


def scale_rows(gyros: Sequence[GyroCalibration], moved: Evidence, model: RobotModel) -> list[Row]:
    """Reading over truth of each gyro that a sweep or a turn moved, about the body axis nearest to the rotation's."""
    step = moved.step
    index = AXES.index(step.axis) if step.axis else _main_axis(model, step.moving_joint)
    rows = []
    for body in step.moved:
        scale, std = gyros[body - 1].scale_about(index)
        rows.append({"body": body, "axis": AXES[index], "frame": "body", "scale": scale, "std": std})
    return rows


def bend_rows(calibration: Calibration, steps: Iterable[Evidence]) -> list[Row]:
    """Amplitudes of sin, cos, sin 2 and cos 2 of the angle shown, of both sensors of each joint that was swept."""
    joints = {evidence.step.joint for evidence in steps if evidence.step.kind == StepKind.SWEEP}
    rows = []
    for sensors in (sensor_pair for sensor_pair in calibration.joints if sensor_pair.joint in joints):
        stds = np.sqrt(np.diag(sensors.bend_covariance)).reshape(2, 4)
        for number, (bend, std) in enumerate(zip(sensors.bend, stds, strict=True), 1):
            of = {"joint": sensors.joint, "sensor": number}
            rows.append(of | {"bend_deg": np.rad2deg(bend), "std_deg": np.rad2deg(std)})
    return rows


def largest_bends_deg(bends: Iterable[Row]) -> dict[int, list[float]]:
    """Compute the largest possible error of each sensor due to its bend, deg, by joint."""
    bends_deg: dict[int, list[float]] = {}
    for row in bends:
        # Amplitudes of both harmonics add up at worst, whatever their phases.
        bend = row["bend_deg"]
        bends_deg.setdefault(row["joint"], []).append(float(np.hypot(*bend[:2]) + np.hypot(*bend[2:])))
    return bends_deg


def found_rows(
    steps: Sequence[Evidence], before: Calibration | None, now: Calibration, model: RobotModel
) -> list[Row]:
    """Build the rows of results of steps of one kind, for all their gyros, joints or axes."""
    kind = steps[0].step.kind
    if kind == StepKind.REST:
        return [bias_row(gyro) for gyro in now.gyros]
    if kind == StepKind.ZERO:
        joints = {evidence.step.joint for evidence in steps}
        earlier_joints = [None] * len(now.joints) if before is None else before.joints
        pairs = zip(now.joints, earlier_joints, strict=True)
        return [zero_row(sensors, old) for sensors, old in pairs if joints & {None, sensors.joint}]
    rows_of = axis_rows if kind == StepKind.SWING else scale_rows
    return [row for evidence in steps for row in rows_of(now.gyros, evidence, model)]


def outcome(
    quantity: str, steps: Sequence[Evidence], before: Calibration | None, now: Calibration, model: RobotModel
) -> tuple[dict[str, Any], tuple[Table | str, ...]]:
    """Build the results of a `calibrate` command, for JSON and for people.

    Args:
        quantity: `bias`, `zero`, `misalignment` or `scale`.
        steps: Accepted steps; those that do not measure the quantity are ignored.
        before: Calibration when the command began; None: nothing was known.
        now: Present calibration.
        model: The robot.
    """
    key, title, kinds, columns = _TABLES[quantity]
    # A rest may precede the motions: keep to the steps that measure this quantity.
    counted = [evidence for evidence in steps if evidence.step.kind in kinds]
    joint = f" {counted[0].step.joint}" if quantity == "misalignment" else ""
    table = Table(f"{title}{joint}", columns, found_rows(counted, before, now, model))
    bends = bend_rows(now, steps) if quantity == "scale" else []
    keys = {evidence.step.key for evidence in steps}
    result: dict[str, Any] = {
        key: records(columns, table.rows),
        **({"sensors": bends} if quantity == "scale" else {}),
        "emulated": now.subject.emulated,
        "steps": [
            {"key": paper.step, "file": paper.file, "sha256": paper.sha256, "taken": paper.taken.isoformat()}
            for paper in now.papers
            if paper.step in keys
        ],
        "missing": records(_MISSING, now.shortcomings()),
    }
    bent = (
        f"The angle sensors of joint {joint} bend by at most {first:.2f} and {second:.2f} deg; the certificate takes "
        "it off."
        for joint, (first, second) in largest_bends_deg(bends).items()
    )
    return result, (table, *bent)


def found_lines(step: Evidence, calibration: Calibration, model: RobotModel) -> list[str]:
    """Format the results of an accepted step, one line each."""
    if step.step.kind == StepKind.SERVO:
        return [f"servo of joint {step.step.joint}: {len(step.visits)} places visited"]
    rows = found_rows([step], None, calibration, model)
    if step.step.kind == StepKind.REST:
        return [
            f"biases of bodies 1 to 4, ± {max(row['std_deg_s'].max() for row in rows):.4f} deg/s or better"
        ]
    return [_LINES[step.step.kind](row) for row in rows]


def _apart_deg(first: Any, second: Any) -> float:
    # Accurate for small angles, where an arccosine is not.
    return float(np.rad2deg(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second)))


def _main_axis(model: RobotModel, joint: int) -> int:
    return int(np.argmax(np.abs(model.joint_axis[joint - 1])))


def value_rows(calibration: Calibration, model: RobotModel) -> dict[str, Row]:
    """Value, standard deviation and unit of everything in a certificate, by the names that `quantities` has for it."""
    rows: dict[str, Row] = {}
    for gyro in calibration.gyros:
        bias = bias_row(gyro)
        rows[f"bias of body {gyro.body}"] = {
            "value": bias["bias_deg_s"].tolist(),
            "std": bias["std_deg_s"].tolist(),
            "unit": "deg/s",
            "frame": "sensor",
            "temperature_c": gyro.temperature_c,
        }
        for index, axis in enumerate(AXES):
            value, std = gyro.scale_about(index)
            rows[f"scale factor {axis} of body {gyro.body}"] = {
                "value": value,
                "std": std,
                "unit": "1",
                "frame": "body",
            }
            # How far the body axis lies, in sensor axes, from where the design has it. A small rotation d moves it by
            # d x axis.
            true = gyro.rotation[index]
            cross = np.cross(np.eye(3), true)
            # Covariance of the axis's direction; its largest eigenvalue is the worst way across.
            spread = cross @ gyro.covariance[3:6, 3:6] @ cross.T
            rows[f"misalignment of body {gyro.body} about {axis}"] = {
                "value": _apart_deg(true, model.imus[gyro.body - 1].sensor_to_body[index]),
                "std": float(np.rad2deg(np.sqrt(np.linalg.eigvalsh(spread)[-1]))),
                "unit": "deg",
                "axis_sensor": true.tolist(),
            }
    for sensors in calibration.joints:
        zero = zero_row(sensors)
        rows[f"zero point of joint {sensors.joint}"] = {
            "value": zero["zero_deg"].tolist(),
            "std": zero["std_deg"].tolist(),
            "unit": "deg",
            "frame": "sensor",
        }
    for servo in calibration.servo_maps:
        rows[f"servo of joint {servo.joint}"] = {
            "value": float(np.rad2deg(servo.backlash_rad)),
            "std": float(np.rad2deg(servo.backlash_std_rad)),
            "unit": "deg",
            "is": "backlash",
            "slope_deg_per_us": float(np.rad2deg(servo.slope_rad_per_us)),
            "middle_us": servo.middle_us,
            "middle_deg": float(np.rad2deg(servo.middle_rad)),
            "repeatability_deg": float(np.rad2deg(servo.repeatability_rad)),
        }
    return rows


def value_text(row: Mapping[str, Any]) -> str:
    """Value, standard deviation and unit of such a row; of several the largest deviation."""
    if row["value"] is None:
        return UNKNOWN
    values, stds = (
        [numbers] if isinstance(numbers, float) else numbers for numbers in (row["value"], row["std"])
    )
    slope = f"{row['slope_deg_per_us']:+.4f} deg/us, backlash " if "is" in row else ""
    return f"{slope}{vector(values, stds)} {'' if row['unit'] == '1' else row['unit']}".rstrip()


def _scale_line(row: Row) -> str:
    return f"body {row['body']}: scale factor {row['axis']} {row['scale']:.4f} ± {row['std']:.4f}"


_LINES: Final[dict[StepKind, Callable[[Row], str]]] = {
    StepKind.ZERO: lambda row: (
        f"joint {row['joint']}: zero at {row['zero_deg'][0]:.2f} and {row['zero_deg'][1]:.2f} deg, "
        f"± {row['std_deg'].max():.3f}"
    ),
    StepKind.SWING: lambda row: (
        f"body {row['body']}: axis {row['angle_deg']:.2f} deg off its design, ± {row['std_deg']:.2f}"
    ),
    StepKind.SWEEP: _scale_line,
    StepKind.TURN: _scale_line,
}
_MISSING = (
    *fields("name reason"),
    Column("command", of=lambda gap: Advice(gap.command)),
)
_BODY = Column("body", "gyro", words=lambda row: f"body {row['body']}")
_TABLES: Final[dict[str, tuple[str, str, tuple[StepKind, ...], Columns]]] = {
    "bias": (
        "bodies",
        "Bias, sensor axes",
        (StepKind.REST,),
        (
            _BODY,
            Column(
                "bias_deg_s", "x, y, z", words=lambda row: vector(row["bias_deg_s"], row["std_deg_s"], "+.3f")
            ),
            *fields("std_deg_s"),
            Column("temperature_c", "die / °C", form=".1f"),
        ),
    ),
    "zero": (
        "joints",
        "Zero points",
        (StepKind.ZERO,),
        (
            Column("joint", "zero of", words=lambda row: f"joint {row['joint']}"),
            Column("zero_deg", "sensors 1, 2", words=lambda row: vector(row["zero_deg"], row["std_deg"])),
            *fields("std_deg"),
            Column("disagreement_deg", "disagree since last", form="+.2f"),
        ),
    ),
    "misalignment": (
        "axes",
        "Joint",
        (StepKind.SWING,),
        (
            _BODY,
            Column("axis_sensor", "joint axis in sensor frame", form="+.4f"),
            Column("angle_deg", "misaligned", words=lambda row: plus_minus(row["angle_deg"], row["std_deg"])),
            Column(
                "cross_axis",
                "cross-axis / %",
                words=lambda row: vector((100 * value for value in row["cross_axis"]), form="+.2f"),
            ),
            Column("rms_rate_deg_s", "rms rate", form=".0f"),
            *fields("std_deg nominal_sensor bias_deg_s bias_std_deg_s"),
        ),
    ),
    "scale": (
        "scales",
        "Scale factors",
        (StepKind.SWEEP, StepKind.TURN),
        (
            _BODY,
            Column("axis", "about body axis"),
            Column("scale", "reading over truth", words=lambda row: plus_minus(row["scale"], row["std"])),
            Column("", "off / %", words=lambda row: f"{100 * (row['scale'] - 1):+.2f}"),
            *fields("frame std"),
        ),
    ),
}
"""By quantity: its name in JSON, title, its steps, columns."""
