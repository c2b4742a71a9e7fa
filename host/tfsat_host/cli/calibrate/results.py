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
from tfsat_host.cli.output import Output

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


def bias_numbers(measured: Measured) -> dict[str, Any]:
    """For `bias --json`."""
    found_biases = [BiasFound.of(gyro) for gyro in measured.calibration.gyros]
    return {
        "bodies": [
            {
                "body": one.body,
                "bias_deg_s": one.bias_deg_s,
                "std_deg_s": one.std_deg_s,
                "temperature_c": one.temperature_c,
            }
            for one in found_biases
        ]
    }


def show_bias(measured: Measured, out: Output) -> None:
    """A row for each gyro."""
    rows = [
        (
            f"body {one.body}",
            *(f"{value:+.3f} ± {std:.3f}" for value, std in zip(one.bias_deg_s, one.std_deg_s, strict=True)),
            f"{one.temperature_c:.1f}",
        )
        for one in map(BiasFound.of, measured.calibration.gyros)
    ]
    out.table(("gyro", "x / deg/s", "y / deg/s", "z / deg/s", "die / °C"), rows, title="Bias, sensor axes")


def zero_numbers(measured: Measured) -> dict[str, Any]:
    """For `zero --json`."""
    return {
        "joints": [
            {
                "joint": one.joint,
                "zero_deg": one.zero_deg,
                "std_deg": one.std_deg,
                "disagreement_deg": one.disagreement_deg,
            }
            for one in _zeros(measured)
        ]
    }


def show_zero(measured: Measured, out: Output) -> None:
    """A row for each joint."""
    rows = [
        (
            f"joint {one.joint}",
            *(f"{zero:.2f} ± {std:.3f}" for zero, std in zip(one.zero_deg, one.std_deg, strict=True)),
            "–" if one.disagreement_deg is None else f"{one.disagreement_deg:+.2f}",
        )
        for one in _zeros(measured)
    ]
    columns = ("zero of", "sensor 1 / deg", "sensor 2 / deg", "disagree since last / deg")
    out.table(columns, rows, title="Zero points")


def misalignment_numbers(measured: Measured) -> dict[str, Any]:
    """For `misalignment --json`."""
    return {
        "axes": [
            {
                "body": axis.body,
                "axis_sensor": axis.axis,
                "nominal_sensor": axis.nominal,
                "angle_deg": axis.angle_deg,
                "std_deg": axis.std_deg,
                "cross_axis": axis.cross_axis(),
                "rms_rate_deg_s": axis.rms_rate_deg_s,
                "bias_deg_s": axis.bias.bias_deg_s,
                "bias_std_deg_s": axis.bias.std_deg_s,
            }
            for axis in _axes(measured)
        ]
    }


def show_misalignment(measured: Measured, out: Output) -> None:
    """A row for each gyro that saw the joint turn."""
    rows = [
        (
            f"body {axis.body}",
            " ".join(f"{value:+.4f}" for value in axis.axis),
            f"{axis.angle_deg:.3f} ± {axis.std_deg:.3f}",
            " ".join(f"{100 * value:+.2f}" for value in axis.cross_axis()),
            f"{axis.rms_rate_deg_s:.0f}",
        )
        for axis in _axes(measured)
    ]
    joint = measured.of_kinds(StepKind.SWING)[0].step.joint
    columns = ("gyro", "joint axis in sensor frame", "misaligned / deg", "cross-axis / %", "rms deg/s")
    out.table(columns, rows, title=f"Joint {joint}")


def scale_numbers(measured: Measured) -> dict[str, Any]:
    """For `scale --json`."""
    return {
        "scales": [
            {"body": one.body, "axis": one.axis, "frame": "body", "scale": one.scale, "std": one.std}
            for one in _scales(measured)
        ],
        "sensors": [
            {"joint": one.joint, "sensor": sensor, "bend_deg": bend, "std_deg": std}
            for one in _bends(measured)
            for sensor, (bend, std) in enumerate(zip(one.bend_deg, one.std_deg, strict=True), 1)
        ],
    }


def show_scale(measured: Measured, out: Output) -> None:
    """A row for each axis; what the sweeps say of the angle sensors below."""
    rows = [
        (f"body {one.body}", one.axis, f"{one.scale:.4f} ± {one.std:.4f}", f"{100 * (one.scale - 1):+.2f}")
        for one in _scales(measured)
    ]
    out.table(("gyro", "about body axis", "reading over truth", "off / %"), rows, title="Scale factors")
    for bend in _bends(measured):
        first, second = bend.largest_deg()
        out.line(
            f"The angle sensors of joint {bend.joint} bend by at most {first:.2f} and {second:.2f} deg; "
            "the certificate takes it off."
        )


NUMBERS: dict[str, Callable[[Measured], dict[str, Any]]] = {
    "bias": bias_numbers,
    "zero": zero_numbers,
    "misalignment": misalignment_numbers,
    "scale": scale_numbers,
}
TABLES: dict[str, Callable[[Measured, Output], None]] = {
    "bias": show_bias,
    "zero": show_zero,
    "misalignment": show_misalignment,
    "scale": show_scale,
}


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
