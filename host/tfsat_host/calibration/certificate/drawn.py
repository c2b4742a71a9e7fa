"""A certificate that a rehearsal drew, with what was measured in the place of what was drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tfsat_host.calibration.certificate.certificate import DRAWABLE, Calibration
from tfsat_host.calibration.in_force import InForce
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.robot import RobotModel

_TELLS = {StepKind.REST: "bias", StepKind.ZERO: "zero"}
"""What takes the place of what was drawn; motions are not rehearsed."""


def with_measured(drawn: Calibration, evidence: Sequence[Evidence], model: RobotModel) -> Calibration:
    """The same with the biases and zero points that rests and zeros tell, by the solver of `calibrate`.

    All else stays as it was drawn.

    Raises:
        CalibrationError: something moved that should rest; says which body, and how.
    """
    measured = InForce(evidence, model)
    return replace(
        drawn, gyros=tuple(measured.gyros(drawn.gyros)), joints=tuple(measured.joints(drawn.joints))
    )


def measured_by(evidence: Sequence[Evidence]) -> tuple[str, ...]:
    """Of `DRAWABLE`, what `with_measured` takes from these recordings."""
    kinds = {one.step.kind for one in evidence}
    return tuple(name for kind, name in _TELLS.items() if kind in kinds)


def in_words(names: Sequence[str]) -> str:
    """Some of `DRAWABLE` for people, such as `zero points, maps of the servos`."""
    return ", ".join(DRAWABLE[name] for name in names)
