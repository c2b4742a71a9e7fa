"""Mismatches between a robot and its files: each changes what it says, by its size, and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.evaluation.drops import MODEL
from tests.fixtures.emulated_drop import Drop, drop
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.spatial_momentum import locked_inertia
from tfsat_host.emulated.emulated_certificate import careful_certificate
from tfsat_host.emulated.emulated_robot import EmulatedRobot
from tfsat_host.emulated.imperfections import ideal
from tfsat_host.emulated.library import interface, robot_config
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.day import CALIBRATED
from tfsat_host.rehearsal.faults.fault import Fault, Moment
from tfsat_host.rehearsal.faults.fault_catalog import FAULTS, GROUPS, fault_named
from tfsat_host.rehearsal.faults.model_mismatches import strained_inertia
from tfsat_host.rehearsal.hidden import HiddenDrop, draw_hidden, hidden_drop
from tfsat_host.rehearsal.truth import Truth, drawn_truth

SEED = 5
SCHEDULE = schedule_maneuver(four_stroke(59.0, 70.0))
BUILT = [fault for fault in FAULTS if fault.hidden is not None]
IDEAL = Truth(SEED, MODEL, ideal(), np.zeros(3))
# MPU-6050 at ±500 deg/s: 65.5 counts for each deg/s (PS-MPU-6000A 6.1).
COUNT_DEG_S = 1.0 / 65.5
# By fault, the fields that it may touch; any other would hide its cause.
CHANGED: Mapping[str, set[str]] = {
    "wrong-masses": {"mass_kg"},
    "wrong-inertias": {"inertia_kg_m2"},
    "wrong-hinge-points": {"joint_point_m"},
    "wrong-hinge-axes": {"joint_axis"},
    "wrong-com-of-body-4": {"com_m"},
    "wrong-coms": {"com_m"},
    "robot-file-uncertain": {"mass_kg", "inertia_kg_m2", "joint_point_m", "joint_axis", "com_m"},
    "gyro-scale-changed": {"gyro_scale"},
    "gyro-scale-bends": {"gyro_bend_s"},
    "gyro-g-sensitive": {"gyro_g_sensitivity_rad_s_g"},
    "gyro-cross-axis": {"gyro_cross_axis"},
    "imu-late": {"imu_late_s"},
    "imu-clocks": {"imu_clock_ppm"},
    "gyro-saturated-unflagged": {"gyro_front_end_limit_rad_s"},
    "mount-ripple": {"mount_ripple_s"},
}
each_built = pytest.mark.parametrize("fault", BUILT, ids=lambda fault: fault.name)


def differing_fields(first: object, other: object) -> set[str]:
    names = [field.name for field in fields(first) if field.name != "shape_m"]  # type: ignore[arg-type]
    return {name for name in names if not np.array_equal(getattr(first, name), getattr(other, name))}


@each_built
def test_a_mismatch_changes_what_it_says_and_nothing_else(fault: Fault) -> None:
    was = drawn_truth(MODEL, SEED)
    flies = fault.apply(was)
    assert (
        differing_fields(flies.model, was.model) | differing_fields(flies.imperfections, was.imperfections)
        == CHANGED[fault.name]
    )
    # A scale that changed after the calibration: the certificate is of the gyro before.
    assert flies.calibrated is (was.imperfections if fault.name == "gyro-scale-changed" else None)
    again = fault.apply(drawn_truth(MODEL, SEED))
    assert config_of(again) == config_of(flies)
    if fault.name != "mount-ripple":  # which leaves nothing to draw
        # Another seed draws another robot, or all days would have the same error.
        others = [replace(was, seed=seed) for seed in (6, 7, 8)]
        assert any(config_of(fault.apply(other)) != config_of(flies) for other in others)


def config_of(truth: Truth) -> bytes:
    """Return the emulator's whole input."""
    config = robot_config(truth.model, truth.imperfections, SEED, SEED)
    return bytes(interface().buffer(config))


@each_built
def test_of_size_zero_the_emulator_is_given_the_same_to_the_last_bit(fault: Fault) -> None:
    was = drawn_truth(MODEL, SEED)
    assert fault.hidden is not None
    assert config_of(fault.hidden(was, 0.0, np.random.default_rng(1))) == config_of(was)
    assert fault_named(f"{fault.name}=0").apply(was) is was


def test_of_size_zero_what_happens_in_a_fall_changes_no_byte_either() -> None:
    def inject_zero_faults(robot: EmulatedRobot) -> None:
        robot.faults.gyro_bias_step(2, np.zeros(3))
        robot.faults.angle_sensor(3, "turned", 0.0)

    assert np.array_equal(fly_truth(IDEAL).log.imu_counts, flies(IDEAL, inject_zero_faults).log.imu_counts)
    assert np.array_equal(
        fly_truth(IDEAL).log.angle_counts, flies(IDEAL, inject_zero_faults).log.angle_counts
    )


def test_more_mismatches_change_nothing_of_the_others() -> None:
    was = drawn_truth(MODEL, SEED)
    masses, points = fault_named("wrong-masses"), fault_named("wrong-hinge-points")
    both = masses.apply(points.apply(was)).model
    assert np.array_equal(both.mass_kg, masses.apply(was).model.mass_kg)
    assert np.array_equal(both.joint_point_m, points.apply(was).model.joint_point_m)
    twice = fault_named("wrong-masses=4").apply(was).model.mass_kg
    # Masses are log-normal: twice the size doubles the logarithm.
    assert np.log(twice / MODEL.mass_kg) == pytest.approx(2.0 * np.log(both.mass_kg / MODEL.mass_kg))


def test_inertias_are_those_of_bodies_that_can_be() -> None:
    random = np.random.default_rng(2)
    for inertia in MODEL.inertia_kg_m2:
        for strain in random.standard_normal((50, 3, 3)):
            tensor = strained_inertia(inertia, strain + strain.T)
            least, middle, greatest = np.linalg.eigvalsh(tensor)
            # Principal moments of a body obey the triangle inequality.
            assert least > 0.0 and greatest < least + middle
            assert np.allclose(tensor, tensor.T, rtol=1e-12)


def test_sizes_are_standard_deviations() -> None:
    # 400 robots give each standard deviation to 2 or 3 %; 10 % are allowed.
    truths = [draw_hidden(MODEL, seed) for seed in range(400)]
    mass = np.array([truth.model.mass_kg for truth in truths]) / MODEL.mass_kg - 1.0
    points = 1e3 * (np.array([truth.model.joint_point_m for truth in truths]) - MODEL.joint_point_m)
    axes = np.array([truth.model.joint_axis for truth in truths])
    com = 1e3 * (np.array([truth.model.com_m for truth in truths]) - MODEL.com_m)
    # With unit inertias the strain's own entries can be read.
    cube = replace(MODEL, inertia_kg_m2=np.tile(np.eye(3), (4, 1, 1)))
    cubes = np.array([draw_hidden(cube, seed).model.inertia_kg_m2 for seed in range(400)])
    assert mass.std() == pytest.approx(0.02, rel=0.1)
    assert com.std(axis=(0, 2)) == pytest.approx(np.full(4, 3.0), rel=0.1)
    moments = cubes[:, :, range(3), range(3)]
    assert moments.std() == pytest.approx(0.03, rel=0.1)
    # Along its axis a hinge may shift freely: no motion changes, so nothing is drawn there.
    assert np.abs(np.einsum("sjk,jk->sj", points, MODEL.joint_axis)).max() < 1e-12
    assert points[:, 0, 1:].std() == pytest.approx(0.5, rel=0.1)
    assert np.linalg.norm(axes, axis=2) == pytest.approx(1.0)
    assert np.rad2deg(axes[:, 0, 1:]).std() == pytest.approx(0.5, rel=0.1)


def test_a_hidden_robot_is_as_its_file_may_be_with_mismatches_on_top() -> None:
    plain, late = draw_hidden(MODEL, SEED), draw_hidden(MODEL, SEED, [fault_named("imu-late=3")])
    assert differing_fields(plain.model, late.model) == set()
    assert differing_fields(plain.imperfections, late.imperfections) == {"imu_late_s"}
    assert sorted(late.imperfections.imu_late_s) == [0.0, 0.0, 0.0, 0.003]
    exact = draw_hidden(MODEL, SEED, uncertainty=replace(MODEL.uncertainty, mass_relative=0.0))  # type: ignore[type-var]
    assert np.array_equal(exact.model.mass_kg, MODEL.mass_kg)
    assert exact.model.uncertainty is MODEL.uncertainty


def flies(truth: Truth, before: Callable[[EmulatedRobot], None] = lambda _: None) -> Drop:
    return drop(truth.model, truth.imperfections, model=MODEL, seed=SEED, before_drop=before)


@cache
def fly_truth(truth: Truth) -> Drop:
    return flies(truth)


def with_fault(fault_text: str) -> tuple[Truth, Drop]:
    truth = fault_named(fault_text).apply(IDEAL)
    return truth, fly_truth(truth)


def rates_deg_s(emulated_drop: Drop) -> FloatArray:
    """(n, 4, 3) as logged."""
    return np.asarray(emulated_drop.log.imu_counts[:, :, 4:7] * COUNT_DEG_S)


def times_s(emulated_drop: Drop) -> FloatArray:
    """(n,) after the release."""
    return np.array([emulated_drop.log.seconds(int(t_us)) for t_us in emulated_drop.log.t_us])


def test_g_sensitivity_shows_under_force_alone() -> None:
    _, emulated_drop = with_fault("gyro-g-sensitive")
    apart, t_s = rates_deg_s(emulated_drop) - rates_deg_s(fly_truth(IDEAL)), times_s(emulated_drop)
    # On the hook 1 g acts; in the fall none, until the first stroke at 0.7 s.
    on_hook, falls = apart[(t_s > -2.0) & (t_s < -0.1)], apart[(t_s > 0.1) & (t_s < 0.6)]
    assert np.abs(on_hook.mean(axis=0)).max() > 0.5
    # Rounding alone: both counts may differ by one.
    assert np.abs(falls).max() <= 1.5 * COUNT_DEG_S


def test_a_front_end_that_saturates_leaves_no_clip_flag() -> None:
    truth, emulated_drop = with_fault("gyro-saturated-unflagged")
    (body,) = np.flatnonzero(truth.imperfections.gyro_front_end_limit_rad_s)
    saturated_rates, free = rates_deg_s(emulated_drop)[:, body], rates_deg_s(fly_truth(IDEAL))[:, body]
    in_fall = (times_s(emulated_drop) > 0.0) & (times_s(emulated_drop) < 2.4)
    # Without the limit of 100 deg/s this body turns faster: the test would see nothing otherwise.
    assert np.abs(free[in_fall]).max() > 110.0
    assert np.abs(saturated_rates[in_fall]).max() == pytest.approx(100.0, abs=COUNT_DEG_S)
    # The converter is far from its end at 500 deg/s: only a comparison with other bodies can tell.
    assert not emulated_drop.log.clipped[in_fall].any()
    others = [other for other in range(4) if other != body]
    assert np.array_equal(emulated_drop.log.imu_counts[:, others], fly_truth(IDEAL).log.imu_counts[:, others])


def test_a_late_imu_shows_the_same_later() -> None:
    truth, emulated_drop = with_fault("imu-late=3")
    (body,) = np.flatnonzero(truth.imperfections.imu_late_s)
    t_s, was, late_rates = (
        times_s(emulated_drop),
        rates_deg_s(fly_truth(IDEAL))[:, body],
        rates_deg_s(emulated_drop)[:, body],
    )
    in_fall = (t_s > 0.1) & (t_s < 2.4)
    axis = int(np.abs(was[in_fall]).max(axis=0).argmax())

    def apart(late_s: float) -> float:
        earlier = np.interp(t_s[in_fall] - late_s, t_s, was[:, axis])
        return float(np.sqrt(np.mean((late_rates[in_fall, axis] - earlier) ** 2)))

    # The delay that fits best, in steps of 0.1 ms.
    lags_ms = np.arange(0.0, 6.0, 0.1)
    assert lags_ms[np.argmin([apart(1e-3 * lag) for lag in lags_ms])] == pytest.approx(3.0, abs=0.15)
    others = [other for other in range(4) if other != body]
    assert np.array_equal(emulated_drop.log.imu_counts[:, others], fly_truth(IDEAL).log.imu_counts[:, others])


def test_imus_with_clocks_of_their_own_show_outputs_of_changing_age() -> None:
    """IMUs with clocks of their own show outputs of changing age.

    The logger reads the last output that a chip finished, so what it reads is up to 1 ms older.
    """
    _, emulated_drop = with_fault("imu-clocks")
    apart = rates_deg_s(emulated_drop) - rates_deg_s(fly_truth(IDEAL))
    t_s = times_s(emulated_drop)
    moving, on_hook = (t_s > 0.6) & (t_s < 2.3), (t_s > -2.0) & (t_s < -0.1)
    assert np.abs(apart[on_hook]).max() <= COUNT_DEG_S
    # The servos reach 200 deg/s at 4000 deg/s^2: 1 ms is 4 deg/s.
    assert 0.5 < np.abs(apart[moving]).max() < 8.0


def test_a_bias_steps_and_stays() -> None:
    def step(robot: EmulatedRobot) -> None:
        robot.faults.gyro_bias_step(2, np.deg2rad([0.3, -0.2, 0.1]))

    emulated_drop = flies(IDEAL, step)
    apart, t_s = rates_deg_s(emulated_drop) - rates_deg_s(fly_truth(IDEAL)), times_s(emulated_drop)
    # Injected 1 s after arming, just before the release: nothing changes until then.
    assert not apart[t_s < -0.05].any()
    assert not apart[:, [0, 2, 3]].any()
    assert apart[(t_s > 0.1) & (t_s < 2.4), 1].mean(axis=0) == pytest.approx([0.3, -0.2, 0.1], abs=0.005)


def test_mounts_ring_after_strokes_and_bodies_do_not() -> None:
    _, emulated_drop = with_fault("mount-ripple=10")
    apart, t_s = rates_deg_s(emulated_drop) - rates_deg_s(fly_truth(IDEAL)), times_s(emulated_drop)
    # Falling, and before the first stroke at 0.7 s: nothing excites the mounts.
    assert np.abs(apart[(t_s > 0.05) & (t_s < 0.69)]).max() <= COUNT_DEG_S
    assert 5.0 < np.abs(apart[(t_s > 0.7) & (t_s < 1.0)]).max() < 100.0
    # Only what the IMUs stand on rings: the bodies' motion is the same to the last bit.
    assert np.array_equal(emulated_drop.truth, fly_truth(IDEAL).truth)


def test_cross_axis_shows_a_share_of_the_other_rates() -> None:
    truth, emulated_drop = with_fault("gyro-cross-axis=5")
    apart, was = rates_deg_s(emulated_drop) - rates_deg_s(fly_truth(IDEAL)), rates_deg_s(fly_truth(IDEAL))
    in_fall = (times_s(emulated_drop) > 0.0) & (times_s(emulated_drop) < 2.4)
    # Rate of the other axes times the drawn matrix, for each body and sample.
    share = np.einsum("brc,tbc->tbr", truth.imperfections.gyro_cross_axis, was[in_fall])
    assert np.abs(apart[in_fall] - share).max() < 3.0 * COUNT_DEG_S
    assert np.abs(share).max() > 3.0


def test_a_scale_factor_bends_with_the_magnitude_of_the_rate() -> None:
    truth, emulated_drop = with_fault("gyro-scale-bends=2")
    apart, was = rates_deg_s(emulated_drop) - rates_deg_s(fly_truth(IDEAL)), rates_deg_s(fly_truth(IDEAL))
    t_s = times_s(emulated_drop)
    # In the middle of the strokes, where rates are steady: 2 % of 170 deg/s there.
    steady = (t_s > 0.8) & (t_s < 0.9)
    bent = np.deg2rad(truth.imperfections.gyro_bend_s) * was[steady] * np.abs(was[steady])
    assert np.abs(apart[steady] - bent).max() < 3.0 * COUNT_DEG_S
    assert np.abs(bent).max() > 0.5


def test_a_worse_certificate_states_what_it_stated() -> None:
    was = careful_certificate(MODEL, IDEAL.imperfections, SEED, CALIBRATED)

    class Day:
        calibration = was

    day = Day()
    fault = fault_named("certificate-wrong")
    fault.action(day, 3.0, np.random.default_rng(1))
    now = day.calibration
    deviations = [
        (new.bias_rad_s - old.bias_rad_s) / np.sqrt(np.diag(old.covariance)[:3])
        for new, old in zip(now.gyros, was.gyros, strict=True)
    ] + [
        (new.zero_rad - old.zero_rad) / np.sqrt(np.diag(old.zero_covariance))
        for new, old in zip(now.joints, was.joints, strict=True)
    ]
    # Three times the stated standard deviations, over 4 gyros and 3 joints.
    assert np.sqrt(np.mean(np.concatenate(deviations) ** 2)) == pytest.approx(3.0, rel=0.5)
    for new, old in zip(now.gyros, was.gyros, strict=True):
        # What makes it dangerous: it claims the same certainty as before.
        assert np.array_equal(new.covariance, old.covariance)
        assert new.rotation @ new.rotation.T == pytest.approx(np.eye(3), abs=1e-12)


@cache
def hidden(*fault_texts: str) -> HiddenDrop:
    faults = list(map(fault_named, fault_texts))
    return hidden_drop(SCHEDULE, MODEL, draw_hidden(MODEL, SEED), faults)


def test_a_hidden_drop_has_the_truth_that_it_is_judged_by() -> None:
    mismatched_drop = hidden()
    rows = mismatched_drop.rows
    starts_s = [stroke.t_s for stroke in SCHEDULE.strokes]
    for stroke, end_s in zip(SCHEDULE.strokes, [*starts_s[1:], mismatched_drop.landed_s - 0.05], strict=True):
        before, after = np.rad2deg(np.interp([stroke.t_s, end_s], rows[:, 0], rows[:, stroke.joint]))
        # Within 2 deg: the servos of the drawn robot have gains and offsets of their own.
        assert after - before == pytest.approx(stroke.angle_deg, abs=2.0)
    assert mismatched_drop.landed_s == pytest.approx(2.5, abs=1e-3)
    assert not np.array_equal(mismatched_drop.truth.model.mass_kg, mismatched_drop.filed.mass_kg)
    assert mismatched_drop.log.samples_lost == 0 and len(mismatched_drop.calibration.gyros) == 4
    # Without torque it stays in inertial axes what it was, whatever the strokes did.
    first, row = rows[np.searchsorted(rows[:, 0], [0.0, mismatched_drop.landed_s - 0.02])]
    body = Multibody.of(mismatched_drop.truth.model)
    momentum = [locked_inertia(body, at[1:4]) @ at[20:].reshape(4, 3)[body.base] for at in (first, row)]
    turns = Rotation.from_quat([at[4 + 4 * body.base :][:4] for at in (first, row)])
    assert turns[1].apply(momentum[1]) == pytest.approx(turns[0].apply(momentum[0]), rel=2e-3)


def test_a_hidden_drop_repeats_to_the_byte_and_changes_with_what_is_wrong() -> None:
    def counts(mismatched_drop: HiddenDrop) -> bytes:
        return bytes(mismatched_drop.log.imu_counts.tobytes() + mismatched_drop.log.angle_counts.tobytes())

    # A step of size zero is no step.
    again = hidden_drop(SCHEDULE, MODEL, draw_hidden(MODEL, SEED), [fault_named("gyro-bias-step=0")])
    assert counts(again) == counts(hidden())
    stepped = hidden("gyro-bias-step")
    before = [hidden().log.seconds(int(t_us)) < 0.0 for t_us in hidden().log.t_us]
    assert np.array_equal(stepped.log.imu_counts[before], hidden().log.imu_counts[before])
    assert counts(stepped) != counts(hidden())
    # A sensor's error moves no body.
    assert np.array_equal(stepped.rows, hidden().rows)
    # A wrong certificate changes what is made of the counts, not the counts.
    worse = hidden("certificate-wrong")
    assert counts(worse) == counts(hidden())
    assert not np.array_equal(worse.calibration.gyros[0].scale, hidden().calibration.gyros[0].scale)


def test_every_fault_that_is_declared_does_something() -> None:
    """Declare for every fault an act or another robot, and a size for those of model and sensors."""
    nothing = Fault("", "", Moment.POWERED, {}).action
    assert [fault.name for fault in FAULTS if (fault.action is nothing) is (fault.hidden is None)] == []
    sized = {fault.name for group in ("model-mismatch", "sensor-mismatch") for fault in GROUPS[group]}
    assert {fault.name for fault in FAULTS if fault.size is not None} == sized
