"""Strokes as flown: against the truth of emulated drops, and motions that were bent on purpose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.evaluation import drops
from tests.evaluation.drops import few_of
from tests.fixtures.emulated_drop import DLPF_5_HZ, DLPF_42_HZ, Drop
from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.standing_joints import JointRest, standing_joints
from tfsat_host.evaluation.strokes import FlownStroke, falling_edge, rising_edge, strokes_flown
from tfsat_host.maneuver import Schedule
from tfsat_host.maneuver.schedule import TimedStroke

SEEDS = (1, 2, 3)
SETTINGS = (DLPF_42_HZ, DLPF_5_HZ)
SERVO_DEG_S = 200.0
"""The emulated servos' greatest rate."""


def logged_s(drop: Drop) -> list[float]:
    return [drop.log.seconds(event.t_us) for event in drop.log.events if event.name == "stroke"]


def estimate_strokes(seed: int, dlpf_cfg: int = DLPF_42_HZ) -> tuple[Drop, Motion, tuple[FlownStroke, ...]]:
    drop, motion = drops.fly_drop(seed, dlpf_cfg), drops.motion(seed, dlpf_cfg)
    return drop, motion, strokes_flown(motion, drop.schedule, logged_s(drop))


def with_strokes(schedule: Schedule, *strokes: TimedStroke) -> Schedule:
    return replace(schedule, strokes=strokes)


def bent(motion: Motion, joint: int, added_rad: Callable[[FloatArray], FloatArray]) -> Motion:
    """Return the motion with a function added to one joint's angle, and its derivative to the rate."""
    extra = added_rad(motion.t_s)
    joints = list(motion.joints)
    joints[joint - 1] = replace(joints[joint - 1], angle_rad=joints[joint - 1].angle_rad + extra)
    rate = motion.fused.joint_rate_rad_s.copy()
    rate[:, joint - 1] += np.gradient(extra, motion.t_s)
    fused = replace(motion.fused, joint_rate_rad_s=rate)
    return replace(motion, joints=tuple(joints), solved=replace(motion.solved, fused=fused))


def true_span(drop: Drop, stroke: FlownStroke) -> tuple[FloatArray, FloatArray]:
    """Time and angle of the stroke's joint, from its command to the same joint's next."""
    next_s = {1: 1.469, 2: 1.819, 3: 2.4, 4: 2.44}[stroke.number]
    t = drop.truth[:, 0]
    own = (t > stroke.scheduled_s - 0.02) & (t < next_s)
    return t[own], drop.truth[own, stroke.joint]


@pytest.mark.parametrize("dlpf_cfg", SETTINGS)
def test_size_is_the_joints_within_what_is_stated(dlpf_cfg: int) -> None:
    off = []
    for seed in SEEDS:
        drop, _, strokes = estimate_strokes(seed, dlpf_cfg)
        assert [stroke.remark for stroke in strokes] == [""] * 4
        for stroke in strokes:
            _, angle = true_span(drop, stroke)
            error = stroke.size_rad - (angle[-1] - angle[0])
            assert abs(error) < np.deg2rad(0.06)
            off.append(error / stroke.size_std_rad)
    # Twelve sizes: beyond it once in a thousand by chance.
    assert 0.2 < np.sqrt(np.mean(np.square(off))) < 1.66


@pytest.mark.parametrize("dlpf_cfg", few_of(*SETTINGS))
def test_start_end_and_speeds_are_the_servos(dlpf_cfg: int) -> None:
    for seed in SEEDS:
        drop, _, strokes = estimate_strokes(seed, dlpf_cfg)
        for stroke, seen_s in zip(strokes, logged_s(drop), strict=True):
            t, angle = true_span(drop, stroke)
            moving = np.flatnonzero(np.abs(np.diff(angle)) > np.deg2rad(1.0) * np.diff(t))
            start_s, end_s = t[moving[0]], t[moving[-1] + 1]
            assert stroke.start_s == pytest.approx(start_s, abs=1.5e-3)
            assert stroke.end_s == pytest.approx(end_s, abs=2e-3)
            assert 0.0 < stroke.start_std_s < 1.5e-3
            assert stroke.dead_time_s == stroke.start_s - seen_s
            assert 0.0 < stroke.dead_time_s < 3e-3, "the pulse itself lasts 1 to 2 ms"
            way = np.sign(stroke.commanded_rad)
            assert np.rad2deg(way * stroke.peak_rate_rad_s) == pytest.approx(SERVO_DEG_S, abs=4.0)
            mean = (angle[-1] - angle[0]) / (end_s - start_s)
            assert stroke.mean_rate_rad_s == pytest.approx(mean, rel=0.01)


def test_a_servo_that_stops_at_its_target_has_no_overshoot_and_settles_as_it_did() -> None:
    drop, _, strokes = estimate_strokes(1)
    for stroke in strokes:
        t, angle = true_span(drop, stroke)
        assert 0.0 <= stroke.overshoot_rad < np.deg2rad(0.05)
        inside = np.abs(angle - angle[-1]) <= 0.02 * abs(angle[-1] - angle[0])
        settled_s = t[np.flatnonzero(~inside)[-1] + 1]
        assert stroke.settling_s == pytest.approx(settled_s - stroke.start_s, abs=2.5e-3)


def test_ringing_is_overshoot_and_longer_settling() -> None:
    drop, motion, strokes = estimate_strokes(1)
    end_s = strokes[0].end_s

    def ring_angle(t: FloatArray) -> FloatArray:
        after = np.maximum(t - end_s, 0.0)
        return np.asarray(np.deg2rad(4.0) * np.exp(-after / 0.03) * np.sin(np.pi * after / 0.08) ** 2)

    fine = np.linspace(end_s, end_s + 0.1, 10_000)
    stroke = strokes_flown(bent(motion, 1, ring_angle), drop.schedule, logged_s(drop))[0]
    assert stroke.overshoot_rad == pytest.approx(ring_angle(fine).max(), abs=np.deg2rad(0.15))
    band = 0.02 * abs(stroke.size_rad)
    last_out_s = fine[np.abs(ring_angle(fine)) > band][-1]
    assert stroke.settling_s == pytest.approx(last_out_s - strokes[0].start_s, abs=5e-3)
    assert stroke.size_rad == pytest.approx(strokes[0].size_rad, abs=np.deg2rad(0.02))


def test_a_stroke_that_was_not_flown_says_so() -> None:
    drop, motion, _ = estimate_strokes(1)
    lost = TimedStroke(700_000, 3, 9000, 1_230_000)
    schedule = with_strokes(drop.schedule, lost, *drop.schedule.strokes)
    third = strokes_flown(motion, schedule, [logged_s(drop)[0], *logged_s(drop)])[0]
    assert not third.moved
    assert third.remark.startswith("Joint 3 did not move: ")
    assert "instead of +90 deg" in third.remark
    assert abs(third.size_rad) < np.deg2rad(0.05)
    assert np.isnan([third.start_s, third.end_s, third.peak_rate_rad_s, third.overshoot_rad]).all()


def test_a_joint_that_came_back_by_itself_says_so() -> None:
    drop, motion, _ = estimate_strokes(1)

    def there_and_back(t: FloatArray) -> FloatArray:
        return np.asarray(np.deg2rad(20.0) * np.exp(-(((t - 1.2) / 0.1) ** 2)))

    pushed = bent(motion, 3, there_and_back)
    commanded_stroke = TimedStroke(1_000_000, 3, 2000, 1_120_000)
    stroke = strokes_flown(pushed, with_strokes(drop.schedule, commanded_stroke))[0]
    assert not stroke.moved
    assert "Joint 3 moved and came back" in stroke.remark


def test_a_stroke_after_the_fall_is_not_judged() -> None:
    drop, motion, _ = estimate_strokes(1)
    late = TimedStroke(2_480_000, 3, 1000, 2_600_000)
    stroke = strokes_flown(motion, with_strokes(drop.schedule, late))[0]
    assert not stroke.moved
    assert np.isnan(stroke.size_rad)
    assert "due after the end of what can be evaluated" in stroke.remark


def test_a_joint_that_went_the_wrong_way_or_was_cut_short_says_so() -> None:
    drop, motion, _ = estimate_strokes(1)
    first, *others = drop.schedule.strokes
    mirrored = with_strokes(drop.schedule, replace(first, angle_cdeg=-5900), *others)
    stroke = strokes_flown(motion, mirrored, logged_s(drop))[0]
    assert stroke.moved
    assert "went the wrong way" in stroke.remark
    assert stroke.short_rad > np.deg2rad(100.0)
    # The same joint commanded again while it is on its way.
    again = replace(first, t_us=850_000)
    cut = strokes_flown(motion, with_strokes(drop.schedule, first, again))
    assert "had not come to rest" in cut[0].remark
    assert cut[0].size_std_rad > 10.0 * stroke.size_std_rad, "where it was then is not sharp"
    assert "still moving when it was commanded" in cut[1].remark


def test_without_a_logged_rise_the_schedule_gives_the_time() -> None:
    drop, motion, reference_strokes = estimate_strokes(1)
    rises_s = logged_s(drop)
    rises_s[1] = float("nan")
    strokes = strokes_flown(motion, drop.schedule, rises_s)
    assert "stroke line did not rise" in strokes[1].remark
    assert np.isnan(strokes[1].dead_time_s), (
        "a servo's dead time of a few ms is not to be had from a schedule"
    )
    assert strokes[1].size_rad == pytest.approx(reference_strokes[1].size_rad, abs=np.deg2rad(0.02))
    assert strokes[0] == reference_strokes[0]


def cut_off(motion: Motion, until_s: float) -> Motion:
    """Return the motion truncated to the samples before `until_s`."""
    n = int(np.searchsorted(motion.t_s, until_s))
    joints = tuple(
        replace(joint, angle_rad=joint.angle_rad[:n], basis=joint.basis[:n]) for joint in motion.joints
    )
    fused = replace(motion.fused, joint_rate_rad_s=motion.fused.joint_rate_rad_s[:n])
    samples = replace(motion.samples, t_s=motion.samples.t_s[:n])
    return replace(motion, samples=samples, joints=joints, solved=replace(motion.solved, fused=fused))


def test_a_stroke_that_the_recording_cuts_off_has_a_size_so_far_and_no_arrival() -> None:
    drop, motion, full_strokes = estimate_strokes(1)
    strokes = strokes_flown(cut_off(motion, 1.25), drop.schedule, logged_s(drop))
    cut = strokes[1]
    assert (cut.moved, cut.unfinished) == (True, True)
    assert cut.remark.startswith("It was still on its way when what can be evaluated ended")
    so_far = np.interp(1.25 - 0.015, motion.t_s, motion.angles_rad[:, 1]) - motion.angles_rad[0, 1]
    assert cut.size_rad == pytest.approx(so_far, abs=np.deg2rad(1.0))
    assert (cut.start_s, cut.dead_time_s) == pytest.approx(
        (full_strokes[1].start_s, full_strokes[1].dead_time_s), abs=1e-4
    )
    assert np.isnan([cut.end_s, cut.mean_rate_rad_s, cut.overshoot_rad, cut.settling_s]).all()
    assert [stroke.remark[:14] for stroke in strokes[2:]] == ["Not recorded: "] * 2
    assert not any(stroke.unfinished for stroke in full_strokes)
    standing = standing_joints(cut_off(motion, 1.25), strokes)
    assert [s.joint for s in standing] == [1, 1, 2, 3], "joint 2 does not stand after it"


def test_a_stroke_that_was_commanded_just_before_the_end_is_not_said_to_have_stood_still() -> None:
    drop, motion, _ = estimate_strokes(1)
    late = TimedStroke(1_000_000, 3, 2000, 1_120_000)
    schedule = with_strokes(drop.schedule, late)
    stroke = strokes_flown(cut_off(motion, 1.05), schedule)[0]
    assert not stroke.moved
    assert np.isnan(stroke.size_rad)
    assert "Not recorded: what can be evaluated ends 4" in stroke.remark
    assert "ms after its command" in stroke.remark
    assert "Joint 3 did not move" in strokes_flown(cut_off(motion, 1.2), schedule)[0].remark


def test_logged_times_that_belong_to_no_stroke_in_particular_are_refused() -> None:
    drop, motion, _ = estimate_strokes(1)
    with pytest.raises(ValueError, match="3 logged times for 4 strokes"):
        strokes_flown(motion, drop.schedule, logged_s(drop)[:3])


def test_joints_that_stand_are_quiet() -> None:
    for seed in SEEDS:
        _, motion, strokes = estimate_strokes(seed)
        standing = standing_joints(motion, strokes)
        assert [s.joint for s in standing] == [1, 1, 1, 2, 2, 2, 3]
        assert [s.remark for s in standing] == [""] * 7
        for first, other in pairwise(standing):
            assert first.joint < other.joint or first.until_s < other.from_s


def test_creep_between_strokes_is_measured() -> None:
    drop, motion, _ = estimate_strokes(1)

    def creep(t: FloatArray) -> FloatArray:
        return np.asarray(np.deg2rad(0.4) * np.clip((t - 1.1) / 0.4, 0.0, 1.0))

    crept = bent(motion, 1, creep)
    standing = standing_joints(crept, strokes_flown(crept, drop.schedule, logged_s(drop)))
    findings = [s for s in standing if s.remark]
    assert len(findings) == 1
    assert (findings[0].joint, findings[0].crept, findings[0].unexpected) == (1, True, False)
    drift_rad = creep(np.array([findings[0].until_s]))[0] - creep(np.array([findings[0].from_s]))[0]
    # Means over eight samples at either end.
    assert findings[0].drift_rad == pytest.approx(drift_rad, abs=np.deg2rad(0.04))
    assert "Joint 1 crept by +0.3" in findings[0].remark


def test_a_motion_that_nobody_commanded_is_found() -> None:
    drop, motion, _ = estimate_strokes(1)
    joint_1 = [stroke for stroke in drop.schedule.strokes if stroke.joint == 1]
    rises_s = [logged_s(drop)[0], logged_s(drop)[2]]
    strokes = strokes_flown(motion, with_strokes(drop.schedule, *joint_1), rises_s)
    assert all(stroke.moved for stroke in strokes)
    unexpected = [s for s in standing_joints(motion, strokes) if s.unexpected]
    assert [s.joint for s in unexpected] == [2]
    assert np.rad2deg(unexpected[0].greatest_rad) == pytest.approx(68.2, abs=0.3)
    assert 1.4 < unexpected[0].greatest_at_s < 1.83
    assert "where nothing commanded it" in unexpected[0].remark


def test_a_small_drift_is_no_creep_unless_it_is_certain() -> None:
    certain = JointRest(1, 0.0, 1.0, np.deg2rad(0.1), np.deg2rad(0.01), 0.0, 0.5)
    assert certain.crept
    assert not replace(certain, drift_std_rad=np.deg2rad(0.05)).crept
    assert not replace(certain, drift_rad=np.deg2rad(0.04)).crept


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.9])
def test_edges_of_a_trapezoid_are_where_they_are(phase: float) -> None:
    t = np.asarray((np.arange(300) + phase) / 280.0, dtype=np.float64)
    rate = np.asarray(200.0 * np.clip(np.minimum((t - 0.31) / 0.05, (0.77 - t) / 0.04), 0.0, 1.0))
    first, last = rising_edge(t, rate), falling_edge(t, rate)
    assert (first.t_s, last.t_s) == pytest.approx((0.31, 0.77), abs=2e-4)
    assert first.whole
    assert last.whole
    moving = rising_edge(t[120:], rate[120:])
    assert not moving.whole
    assert moving.t_s == t[120]
