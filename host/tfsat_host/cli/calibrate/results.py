"""What a command of `calibrate` has found: a line for each accepted step, a table at the end, and JSON."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.calibration.certificate.certificate import commands_of, summarized
from tfsat_host.calibration.findings import (
    AxisFound,
    BendFound,
    BiasFound,
    ScaleFound,
    ZeroFound,
    axes_found,
    scales_found,
)
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.cli.calibrate.options import as_typed_here
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import Column, Columns, fields, plus_minus, records, vector

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.certificate import Calibration, Shortcoming
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.robot import RobotModel


@dataclass(frozen=True, eq=False)
class Measured:
    """One command's harvest.

    Attributes:
        evidence: Its accepted steps.
        before: What was known when it began; None: nothing.
        calibration: What is known now.
        model: The robot.
        file: The certificate.
    """

    evidence: Sequence[Evidence]
    before: Calibration | None
    calibration: Calibration
    model: RobotModel
    file: Path

    def of_kinds(self, *kinds: StepKind) -> list[Evidence]:
        """The steps of these kinds."""
        return [one for one in self.evidence if one.step.kind in kinds]


def found(evidence: Evidence, calibration: Calibration, model: RobotModel) -> list[str]:
    """What an accepted step has told, a line for each thing."""
    match evidence.step.kind:
        case StepKind.REST:
            worst = max(float(BiasFound.of(gyro).std_deg_s.max()) for gyro in calibration.gyros)
            return [f"biases of bodies 1 to 4, ± {worst:.4f} deg/s or better"]
        case StepKind.ZERO:
            chosen = [one for one in calibration.joints if evidence.step.joint in (None, one.joint)]
            zeros = [ZeroFound.of(one, None) for one in chosen]
            return [
                f"joint {one.joint}: zero at {one.zero_deg[0]:.2f} and {one.zero_deg[1]:.2f} deg, "
                f"± {one.std_deg.max():.3f}"
                for one in zeros
            ]
        case StepKind.SWING:
            return [
                f"body {one.body}: axis {one.angle_deg:.2f} deg off its design, ± {one.std_deg:.2f}"
                for one in axes_found(calibration, [evidence], model)
            ]
        case StepKind.SWEEP | StepKind.TURN:
            return [
                f"body {one.body}: scale factor {one.axis} {one.scale:.4f} ± {one.std:.4f}"
                for one in scales_found(calibration, [evidence], model)
            ]
        case StepKind.SERVO:
            return [f"servo of joint {evidence.step.joint}: {len(evidence.visits)} places visited"]


@dataclass(frozen=True)
class _Quantity:
    """How what was found of a quantity is named and listed."""

    key: str
    title: str
    columns: Columns
    rows: Callable[[Measured], Sequence[Any]]


def _of_body(one: Any) -> str:
    return f"body {one.body}"


def numbers(quantity: str, measured: Measured) -> dict[str, Any]:
    """What was found, for `--json`."""
    of = _QUANTITIES[quantity]
    result: dict[str, Any] = {of.key: records(of.columns, of.rows(measured))}
    if quantity == "scale":
        result["sensors"] = [
            {"joint": one.joint, "sensor": sensor, "bend_deg": bend, "std_deg": std}
            for one in _bends(measured)
            for sensor, (bend, std) in enumerate(zip(one.bend_deg, one.std_deg, strict=True), 1)
        ]
    return result


def show_found(quantity: str, measured: Measured, out: Output) -> None:
    """A row for each gyro, joint or axis; what the sweeps say of the angle sensors below."""
    of = _QUANTITIES[quantity]
    swings = measured.of_kinds(StepKind.SWING)
    title = f"{of.title} {swings[0].step.joint}" if quantity == "misalignment" else of.title
    show_rows(of.columns, of.rows(measured), out, title=title)
    for bend in _bends(measured) if quantity == "scale" else ():
        first, second = bend.largest_deg()
        out.line(
            f"The angle sensors of joint {bend.joint} bend by at most {first:.2f} and {second:.2f} deg; "
            "the certificate takes it off."
        )


def campaign_numbers(measured: Measured) -> dict[str, Any]:
    """The JSON keys that every quantity has."""
    keys = {one.step.key for one in measured.evidence}
    return {
        "emulated": measured.calibration.subject.emulated,
        "steps": [
            {"key": paper.step, "file": paper.file, "sha256": paper.sha256, "taken": paper.taken.isoformat()}
            for paper in measured.calibration.papers
            if paper.step in keys
        ],
        "missing": [_missing(one) for one in measured.calibration.shortcomings()],
        "file": str(measured.file),
    }


def show_end(measured: Measured, args: argparse.Namespace, out: Output) -> None:
    """What is still missing for a drop, and where it is written."""
    shortcomings = measured.calibration.shortcomings()
    if shortcomings:
        out.line(f"For a drop: {summarized(shortcomings)}.")
        out.line(f"Next: {as_typed_here(commands_of(shortcomings)[0], args)}")
    else:
        out.line("Nothing is missing for a drop.")
    if measured.calibration.subject.emulated:
        out.line("These are the errors of an emulated robot: of no use for a real one.")
    out.line(f"Written to {measured.file}.")


def _missing(one: Shortcoming) -> dict[str, str]:
    return {"name": one.name, "reason": one.reason, "command": f"tfsat-host calibrate {one.command}"}


def _zeros(measured: Measured) -> list[ZeroFound]:
    joints = {one.step.joint for one in measured.of_kinds(StepKind.ZERO)}
    before = None if measured.before is None else measured.before.joints
    return [
        ZeroFound.of(sensors, None if before is None else before[index])
        for index, sensors in enumerate(measured.calibration.joints)
        if None in joints or sensors.joint in joints
    ]


def _axes(measured: Measured) -> list[AxisFound]:
    return axes_found(measured.calibration, measured.of_kinds(StepKind.SWING), measured.model)


def _scales(measured: Measured) -> list[ScaleFound]:
    swept = measured.of_kinds(StepKind.SWEEP, StepKind.TURN)
    return scales_found(measured.calibration, swept, measured.model)


def _bends(measured: Measured) -> list[BendFound]:
    joints = {one.step.joint for one in measured.of_kinds(StepKind.SWEEP)}
    return [BendFound.of(one) for one in measured.calibration.joints if one.joint in joints]


_QUANTITIES = {
    "bias": _Quantity(
        "bodies",
        "Bias, sensor axes",
        (
            Column("body", "gyro", words=_of_body),
            Column("bias_deg_s", "x, y, z", words=lambda one: vector(one.bias_deg_s, one.std_deg_s, "+.3f")),
            *fields("std_deg_s"),
            Column("temperature_c", "die / °C", form=".1f"),
        ),
        lambda measured: [BiasFound.of(gyro) for gyro in measured.calibration.gyros],
    ),
    "zero": _Quantity(
        "joints",
        "Zero points",
        (
            Column("joint", "zero of", words=lambda one: f"joint {one.joint}"),
            Column("zero_deg", "sensors 1, 2", words=lambda one: vector(one.zero_deg, one.std_deg)),
            *fields("std_deg"),
            Column("disagreement_deg", "disagree since last", form="+.2f"),
        ),
        _zeros,
    ),
    "misalignment": _Quantity(
        "axes",
        "Joint",
        (
            Column("body", "gyro", words=_of_body),
            Column("axis_sensor", "joint axis in sensor frame", of="axis", form="+.4f"),
            Column("angle_deg", "misaligned", words=lambda one: plus_minus(one.angle_deg, one.std_deg)),
            Column(
                "cross_axis",
                "cross-axis / %",
                of=lambda one: one.cross_axis(),
                words=lambda one: vector((100 * value for value in one.cross_axis()), form="+.2f"),
            ),
            Column("rms_rate_deg_s", "rms rate", form=".0f"),
            *fields(
                "std_deg nominal_sensor=nominal bias_deg_s=bias.bias_deg_s bias_std_deg_s=bias.std_deg_s"
            ),
        ),
        _axes,
    ),
    "scale": _Quantity(
        "scales",
        "Scale factors",
        (
            Column("body", "gyro", words=_of_body),
            Column("axis", "about body axis"),
            Column("frame", of=lambda _: "body"),
            Column("scale", "reading over truth", words=lambda one: plus_minus(one.scale, one.std)),
            Column("", "off / %", words=lambda one: f"{100 * (one.scale - 1):+.2f}"),
            *fields("std"),
        ),
        _scales,
    ),
}
