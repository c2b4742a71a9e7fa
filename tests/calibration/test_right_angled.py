"""Sensors that are mounted along other axes of the body than their own: all words are about the body's axes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.calibration.bench_day import MODEL, change_counts, day, true_scale, turn_sensor
from tests.calibration.some_calibration import whole_calibration
from tfsat_host.calibration.certificate.certificate import Calibration, commands_of
from tfsat_host.calibration.findings import GyroAxis, certificate_values, scale_axes
from tfsat_host.calibration.sensors.gyro import SCALE_STD
from tfsat_host.calibration.solution import Solution, solve
from tfsat_host.calibration.steps.step import StepKind

TURNED = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Sensor to body: the body's x lies along the sensor's z, its y along x, its z along y."""
TURNED_MODEL = replace(MODEL, imus=tuple(replace(imu, sensor_to_body=TURNED) for imu in MODEL.imus))


@cache
def solve_day(*left_out: StepKind) -> Solution:
    """Solve a day's steps with four such sensors."""
    turns = [turn_sensor(body, TURNED) for body in (1, 2, 3, 4)]
    return solve(
        [change_counts(evidence, *turns) for evidence in day(StepKind.SERVO, *left_out)], TURNED_MODEL
    )


def certificate(solution: Solution) -> Calibration:
    return replace(whole_calibration(), gyros=solution.gyros, joints=solution.joints)


def test_without_a_turn_the_scale_factors_about_the_bodies_z_are_missing() -> None:
    missing = certificate(solve_day(StepKind.TURN)).shortcomings()
    assert [gap.name for gap in missing] == [f"scale factor z of body {body}" for body in (1, 2, 3, 4)]
    assert {gap.state for gap in missing} == {"missing"}
    assert [*map(str, commands_of(missing))] == ["tfsat-host calibrate scale --turn z 360"]


def test_a_turn_makes_it_whole() -> None:
    assert certificate(solve_day()).shortcomings() == ()


def test_what_is_shown_of_a_scale_factor_is_about_the_bodys_axis() -> None:
    rows = certificate_values(certificate(solve_day()), TURNED_MODEL)
    for body in (1, 2, 3, 4):
        for axis, letter in enumerate("xyz"):
            row = rows[f"scale factor {letter} of body {body}"]
            assert isinstance(row, GyroAxis) and row.scale_std < 0.005
            assert row.scale == pytest.approx(true_scale(body, axis), abs=4.0 * row.scale_std)


def test_a_sweep_and_a_turn_tell_of_the_axis_that_they_were_about() -> None:
    moved = [
        evidence
        for evidence in solve_day().used_evidence
        if evidence.step.kind in (StepKind.SWEEP, StepKind.TURN)
    ]
    for evidence in moved:
        axis = evidence.step.axis or "xyx"[(evidence.step.joint or 0) - 1]
        for row in scale_axes(solve_day().gyros, evidence, TURNED_MODEL):
            assert row.axis == axis
            true = true_scale(row.gyro.body, "xyz".index(axis))
            assert row.scale == pytest.approx(true, abs=4.0 * row.scale_std)


def test_what_no_sweep_was_about_stays_doubtful() -> None:
    for gyro in solve_day(StepKind.TURN).gyros:
        # A sensor that sits askew by some degrees sees a little of it.
        assert gyro.scale_about(2)[1] > 0.7 * SCALE_STD
        assert max(gyro.scale_about(axis)[1] for axis in (0, 1)) < 0.005
