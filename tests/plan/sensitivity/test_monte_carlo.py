"""Samples follow what is stated, stay physical, agree with first order where errors are small, and never change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.plan.sensitivity.studies import EXACT, parameters_of, scale_uncertainty, stated_by, study_of
from tfsat_host.plan.error_sources import error_sources
from tfsat_host.plan.spread import TimeLimit, derivatives, linear_spread, summary
from tfsat_host.plan.study import CHUNK, Outcomes, run_chunk, run_locally
from tfsat_host.robot import RobotModel, Uncertainty
from tfsat_host.robot.model import MAX_RELATIVE


def _same(outcomes: Outcomes, other: Outcomes) -> bool:
    return (
        np.array_equal(outcomes.quaternion_xyzw, other.quaternion_xyzw)
        and np.array_equal(outcomes.moving_time_s, other.moving_time_s)
        and np.array_equal(outcomes.end_s, other.end_s)
    )


@pytest.mark.parametrize(
    "stated",
    [
        Uncertainty(0.002, 2e-4, 0.003, 5e-5, 1e-3, 1e-3, 0.004, 0.002),
        *(
            pytest.param(uncertainty, marks=pytest.mark.prove)
            for uncertainty in (
                replace(EXACT, mass_relative=0.002),
                replace(EXACT, inertia_relative=0.003),
                replace(EXACT, joint_axis_rad=1e-3, joint_point_m=1e-4),
                replace(EXACT, stroke_relative=0.004),
            )
        ),
    ],
    ids=["all", "mass", "inertia", "joints", "servo scale"],
)
def test_small_errors_spread_as_first_order_says(robot: RobotModel, stated: Uncertainty) -> None:
    study = study_of(robot, stated, samples=1000, seed=5)
    partials = derivatives(study.parameters)
    linear = linear_spread(partials, study.sources)
    summed = summary(study, run_locally(study, workers=1), partials.quaternion_xyzw, ())
    turned = summed.outputs["reorientation_deg"]
    assert turned.std.value == pytest.approx(linear.reorientation_deg, abs=4.0 * turned.std.standard_error)
    assert turned.mean.value == pytest.approx(
        partials.reorientation_deg, abs=4.0 * turned.mean.standard_error + 0.01 * linear.reorientation_deg
    )
    np.testing.assert_allclose(summed.variance_shares, linear.shares, atol=0.05)
    for axis, letter in enumerate("xyz"):
        component = summed.outputs[f"rotation_{letter}_deg"].std
        assert component.value == pytest.approx(
            linear.rotation_vector_deg[axis], abs=4.0 * component.standard_error
        )


def test_without_errors_nothing_spreads(robot: RobotModel) -> None:
    study = study_of(robot, EXACT, samples=50)
    outcomes = run_locally(study, workers=1)
    nominal = derivatives(study.parameters).quaternion_xyzw
    assert (outcomes.quaternion_xyzw == outcomes.quaternion_xyzw[0]).all()
    assert outcomes.attitude_error_deg(nominal).max() < 1e-9
    summed = summary(study, outcomes, nominal, (TimeLimit("fall", "end_s", 2.5),))
    assert summed.outputs["end_s"].std.value == pytest.approx(0.0, abs=1e-12)
    assert summed.exceeded[0][1].value == 0.0
    assert not summed.variance_shares.any() and not summed.rank_correlation.any()


def test_the_largest_errors_leave_every_body_physical(robot: RobotModel) -> None:
    largest = Uncertainty(MAX_RELATIVE, 0.02, MAX_RELATIVE, 0.02, 0.2, 0.2, MAX_RELATIVE, MAX_RELATIVE)
    study = study_of(robot, largest, samples=4 * CHUNK)
    for chunk in range(study.chunks):
        vectors = study.vectors(study.deviates(chunk))
        bodies, moves = study.parameters.robots(vectors), study.parameters.motion(vectors)
        moments = np.linalg.eigvalsh(bodies.inertia_kg_m2)
        assert (bodies.mass_kg > 0.0).all()
        assert (moments > 0.0).all()
        assert (moments[..., 0] + moments[..., 1] >= moments[..., 2]).all()
        np.testing.assert_allclose(np.linalg.norm(bodies.joint_axis, axis=-1), 1.0, atol=1e-12)
        assert (moves.end_s >= moves.start_s).all() and np.isfinite(moves.end_s).all()
    assert abs(study.deviates(0)).max() > 3.0


def test_samples_spread_as_stated(robot: RobotModel) -> None:
    study = study_of(robot, stated_by(robot), samples=10_000)
    vectors = np.vstack([study.vectors(study.deviates(chunk)) for chunk in range(study.chunks)])
    sigma = study.sources.parameter_sigma
    np.testing.assert_allclose(vectors.std(axis=0), sigma, rtol=0.04, atol=1e-9)
    np.testing.assert_allclose(vectors.mean(axis=0), study.parameters.nominal, atol=4.0 * sigma.max() / 100.0)


def test_a_servo_s_scale_is_the_same_there_and_back(robot: RobotModel) -> None:
    study = study_of(robot, replace(EXACT, stroke_relative=0.07), samples=200)
    ends = study.vectors(study.deviates(0))[:, study.parameters.part["stroke_end"]]
    assert ends[:, 0].std() > 3.0
    assert not ends[:, 2:].any(), "a joint that opened too far must still come back to where it began"


def test_play_is_drawn_anew_for_every_stroke(robot: RobotModel) -> None:
    study = study_of(robot, replace(EXACT, stroke_rad=0.02), samples=CHUNK)
    ends = study.vectors(study.deviates(0))[:, study.parameters.part["stroke_end"]]
    assert (np.abs(np.corrcoef(ends.T) - np.eye(4)) < 0.2).all()


def test_a_slow_servo_delays_the_end_and_changes_the_rotation(robot: RobotModel) -> None:
    study = study_of(robot, replace(EXACT, servo_speed_relative=0.15), samples=CHUNK)
    outcomes = run_chunk(study, 0)
    assert outcomes.end_s.std() > 0.03
    speeds = study.vectors(study.deviates(0))[:, study.parameters.part["speed"]]
    all_in_time = (speeds > 170.0).all(axis=1)
    changes = np.abs(outcomes.reorientation_deg - derivatives(study.parameters).reorientation_deg)
    # Whoever is fast enough goes the same way through the joint angles; whoever is late cuts its corners.
    assert 50 < all_in_time.sum() < 200
    assert changes[all_in_time].max() < 1e-4
    assert changes.max() > 0.1


def test_on_a_spinning_robot_the_speed_matters_even_without_overlap(robot: RobotModel) -> None:
    speed = replace(EXACT, servo_speed_relative=0.02)
    spread_deg = []
    for rate in (None, np.radians([0.0, 0.0, 10.0])):
        parameters = parameters_of(robot, rate)
        spread = linear_spread(derivatives(parameters), error_sources(parameters, speed))
        spread_deg.append(spread.attitude_deg)
    assert spread_deg[0] < 1e-6
    assert spread_deg[1] > 5e-3


def test_the_same_seed_gives_the_same_bits_and_another_seed_others(robot: RobotModel) -> None:
    first, again, other = (
        run_chunk(study_of(robot, stated_by(robot), samples=CHUNK, seed=seed), 0) for seed in (1, 1, 2)
    )
    assert _same(first, again)
    assert not _same(first, other)


def test_workers_change_no_bit(robot: RobotModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tfsat_host.plan.study._WORTH_A_PROCESS", 1)
    study = study_of(robot, stated_by(robot), samples=2 * CHUNK - 123)
    sample_counts: list[float] = []
    by_two = run_locally(study, workers=2, progress=sample_counts.append)
    assert _same(by_two, run_locally(study, workers=1))
    assert len(by_two) == sum(sample_counts) == study.samples


def test_a_longer_study_begins_with_the_shorter_one(robot: RobotModel) -> None:
    short = study_of(robot, stated_by(robot), samples=CHUNK)
    long = study_of(robot, stated_by(robot), samples=3 * CHUNK)
    assert _same(run_chunk(short, 0), run_chunk(long, 0))
    few, outcomes = run_chunk(study_of(robot, stated_by(robot), samples=3), 0), run_chunk(short, 0)
    assert len(few) == 3 and np.array_equal(few.quaternion_xyzw, outcomes.quaternion_xyzw[:3])
    assert not np.array_equal(long.deviates(0), long.deviates(1))


def test_one_kind_of_error_less_leaves_the_others_as_they_were(robot: RobotModel) -> None:
    with_all = study_of(robot, stated_by(robot), samples=10)
    without = study_of(robot, replace(stated_by(robot), com_m=0.0), samples=10)
    part = with_all.parameters.part["inertia"]
    inertia_vectors, other = (study.vectors(study.deviates(0))[:, part] for study in (with_all, without))
    assert np.array_equal(inertia_vectors, other)


def test_exceeded_limits_are_counted(robot: RobotModel) -> None:
    study = study_of(robot, scale_uncertainty(stated_by(robot), 0.5), samples=1000)
    outcomes = run_locally(study, workers=1)
    limits = (TimeLimit("strokes", "moving_time_s", 1.5), TimeLimit("fall", "end_s", 2.2))
    exceeded = dict(summary(study, outcomes, outcomes.quaternion_xyzw[0], limits).exceeded)
    assert exceeded[limits[0]].value == np.mean(outcomes.moving_time_s > 1.5)
    assert exceeded[limits[1]].value == np.mean(outcomes.end_s > 2.2)
    assert 0.0 < exceeded[limits[1]].value < 1.0
