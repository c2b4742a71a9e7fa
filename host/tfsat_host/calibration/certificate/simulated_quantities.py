"""A certificate that a rehearsal drew from an emulated robot's truth: what recordings measure takes the drawn place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tfsat_host.calibration.baseline import Baseline
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.robot import RobotModel

_TELLS = {StepKind.REST: "bias", StepKind.ZERO: "zero"}
"""What takes the place of what was drawn; motions are not rehearsed."""
BESIDE_SIMULATED = {*_TELLS, StepKind.STROKES}
"""Recordings of other kinds begin a certificate of their own."""


def with_measured(calibration: Calibration, evidence: Sequence[Evidence], model: RobotModel) -> Calibration:
    """Replace drawn biases and zero points with those of rests and zeros, by the solver of `calibrate`.

    Everything else stays as drawn.

    Raises:
        CalibrationError: something moved that should rest; says which body, and how.
    """
    # The solver of real campaigns: a rehearsal refuses what they would refuse.
    measured = Baseline(evidence, model)
    return replace(
        calibration,
        gyros=tuple(measured.gyros(calibration.gyros)),
        joints=tuple(measured.joints(calibration.joints)),
    )


def measured_by(evidence: Sequence[Evidence]) -> tuple[str, ...]:
    """Return the names in `QUANTITY_NAMES` that `with_measured` takes from these recordings."""
    kinds = {entry.step.kind for entry in evidence}
    return tuple(name for kind, name in _TELLS.items() if kind in kinds)
