"""The sensors' residual as a function of the hinges' axes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.corrupted import healthy_drop
from tests.evaluation.drops import MODEL, estimate_motion
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.checks.consistency import Consistency, consistency_of
from tfsat_host.evaluation.rest import hanging_before_release


@pytest.fixture(scope="module")
def data() -> Consistency:
    healthy = healthy_drop()
    log = healthy.drop.log
    motion = estimate_motion(log, healthy.calibration, MODEL)
    rest = hanging_before_release(log, healthy.calibration, MODEL)
    return consistency_of(motion, rest, LowPass.of(log.header), healthy.calibration, MODEL)


# Coordinate axes, the diagonal of a plane and of space: there a choice by the greatest component is a tie.
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (-1, 1, 1)], ids=str)
def test_its_change_with_a_tilt_is_its_derivative(data: Consistency, axis: tuple[float, ...]) -> None:
    """A jump would let a tilt's column explain any disagreement of the sensors, and no check would see it."""
    axes: FloatArray = np.tile(np.array(axis) / np.linalg.norm(axis), (3, 1))

    def residual(tilt_rad: FloatArray) -> FloatArray:
        tilted = Multibody.of(replace(MODEL, joint_axis=axes)).tilt_hinges(tilt_rad).joint_axis
        return replace(data, model=replace(MODEL, joint_axis=tilted), tilt_rad=np.zeros((3, 2))).residual

    filed = replace(data, model=replace(MODEL, joint_axis=axes), tilt_rad=np.zeros((3, 2)))
    # Both ways, half a milliradian: several times what the derivative is taken over.
    tilt_rad = 5e-4 * np.array([(1.0, -0.7), (-0.4, 0.9), (0.8, 0.5)])
    for sign in (1.0, -1.0):
        change = residual(sign * tilt_rad) - residual(np.zeros((3, 2)))
        predicted = filed.tilt_jacobian @ (sign * tilt_rad).ravel()
        assert np.linalg.norm(change - predicted) < 2e-3 * np.linalg.norm(change)
