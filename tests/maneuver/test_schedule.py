"""The schedule rule: the paper's times, and what holds for every maneuver."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.maneuver import (
    Defect,
    Maneuver,
    ManeuverError,
    Schedule,
    Stroke,
    four_stroke,
    schedule_maneuver,
)
from tfsat_host.maneuver.schedule import STROKES
from tfsat_host.protocol.limits import FALL_US, JOINT_ANGLE_MAX_CDEG, PAUSE_MIN_US, SCHEDULE_GRID_US
from tfsat_host.quantity import records


def test_the_drop_experiment() -> None:
    schedule = schedule_maneuver(four_stroke(59, 70))
    # The paper's experiment: 59 / 170 = 0.347 s, up to the next 10 ms: 1.05 s; and so on.
    assert records(STROKES, schedule.strokes) == [
        {"t_s": 0.7, "joint": 1, "angle_deg": 59.0},
        {"t_s": 1.05, "joint": 2, "angle_deg": 70.0},
        {"t_s": 1.47, "joint": 1, "angle_deg": -59.0},
        {"t_s": 1.82, "joint": 2, "angle_deg": -70.0},
    ]
    assert schedule.end_us == 2_231_765  # 1.82 s + 70 / 170 s, rounded up to a microsecond
    assert schedule.end_s == 2.23
    assert schedule.notices == ()


@pytest.mark.parametrize("angle_deg", range(1, 46))
def test_a_stroke_that_fills_the_grid_exactly_is_not_rounded_up(angle_deg: int) -> None:
    # 1 deg at 100 deg/s takes exactly 10 ms: every start lies on the grid.
    maneuver = Maneuver((Stroke(1, angle_deg), Stroke(1, -angle_deg)), speed_deg_s=100.0)
    assert schedule_maneuver(maneuver).strokes[1].t_us == 700_000 + angle_deg * 10_000


@pytest.mark.parametrize(("angle_deg", "angle_cdeg"), [(58.745, 5874), (58.755, 5876), (58.7549, 5875)])
def test_an_angle_is_rounded_half_to_even_and_it_is_said(angle_deg: float, angle_cdeg: int) -> None:
    schedule = schedule_maneuver(Maneuver((Stroke(1, angle_deg), Stroke(1, -angle_deg))))
    assert [stroke.angle_cdeg for stroke in schedule.strokes] == [angle_cdeg, -angle_cdeg]
    assert len(schedule.notices) == 2
    assert str(angle_deg) in schedule.notices[0]


@pytest.mark.parametrize("angle_deg", [58.75, 0.01, 0.29, 1.1, 70.29, 89.99, 90])
def test_hundredths_of_a_degree_are_exact(angle_deg: float) -> None:
    schedule = schedule_maneuver(Maneuver((Stroke(2, angle_deg), Stroke(2, -angle_deg)), speed_deg_s=400))
    assert schedule.notices == ()
    assert schedule.strokes[0].angle_deg == angle_deg


def test_explicit_times_are_kept_and_moved_up_to_the_grid_with_a_notice() -> None:
    # 0.71 s lies on the grid; 1.2301 s does not and moves up, never down.
    schedule = schedule_maneuver(Maneuver((Stroke(1, 10, t_s=0.71), Stroke(1, -10, t_s=1.2301))))
    assert [stroke.t_s for stroke in schedule.strokes] == [0.71, 1.24]
    assert len(schedule.notices) == 1
    assert "stroke 2" in schedule.notices[0]


def test_a_maneuver_that_does_not_close_is_allowed_and_noted() -> None:
    # Allowed: a panel may stay open. Noted: a forgotten return stroke looks the same.
    notices = schedule_maneuver(Maneuver((Stroke(3, 20), Stroke(3, -5)))).notices
    assert notices == ("Joint 3 ends at 15.00 deg, not at 0: the maneuver is not a closed loop.",)


def test_the_fall_may_be_used_to_its_last_microsecond() -> None:
    # 34 deg at 170 deg/s take 0.2 s: from 2.30 s to the end of the fall at 2.50 s.
    assert schedule_maneuver(Maneuver((Stroke(1, 34, t_s=2.30),))).end_us == FALL_US
    # 0.01 deg more takes 59 us more: the fall ends while the joint still moves.
    late = Stroke(1, 34.01, t_s=2.30)
    for strokes in ((late,), (Stroke(2, 10, t_s=0.7), late)):
        with pytest.raises(ManeuverError) as caught:
            schedule_maneuver(Maneuver(strokes))
        assert (caught.value.code, caught.value.stroke) == (Defect.OUTLASTS_FALL, len(strokes))


def test_a_joint_may_start_again_when_its_last_stroke_ends_and_no_earlier() -> None:
    # 17 deg take exactly 0.1 s.
    back = Stroke(1, -17, t_s=0.8)
    assert schedule_maneuver(Maneuver((Stroke(1, 17, t_s=0.7), back))).strokes[1].t_us == 800_000
    # 59 us too long; another joint's stroke between the two does not matter.
    with pytest.raises(ManeuverError, match=r"0\.800059") as caught:
        schedule_maneuver(Maneuver((Stroke(1, 17.01, t_s=0.7), Stroke(2, 5, t_s=0.75), back)))
    assert (caught.value.code, caught.value.stroke) == (Defect.OVERLAP, 3)


def test_strokes_of_different_joints_overlap_begin_together_or_10_ms_apart() -> None:
    maneuver = Maneuver((Stroke(1, 90, t_s=0.7), Stroke(2, 90, t_s=0.7), Stroke(3, 10, t_s=0.71)))
    schedule = schedule_maneuver(maneuver)
    assert [stroke.t_us for stroke in schedule.strokes] == [700_000, 700_000, 710_000]
    # The first two end last.
    assert schedule.end_us == schedule.strokes[0].end_us == 1_229_412


# 3 and 8 ms apart, which rounding to the grid would make 10 ms or nothing; and in another order than their times.
@pytest.mark.parametrize(("first_s", "second_s"), [(0.7, 0.703), (0.704, 0.712), (0.701, 0.709), (1.5, 0.8)])
def test_other_distances_are_refused_as_they_were_given(first_s: float, second_s: float) -> None:
    with pytest.raises(ManeuverError) as caught:
        schedule_maneuver(Maneuver((Stroke(1, 5, t_s=first_s), Stroke(2, 5, t_s=second_s))))
    assert (caught.value.code, caught.value.stroke) == (Defect.STARTS_TOO_CLOSE, 2)
    assert f"starts at {second_s:.3f}".rstrip("0") in caught.value.what


# Anything, then what is near the limits: plain floats alone would hardly ever pass.
any_number = st.floats() | st.floats(-100, 100) | st.integers(-90, 90).map(float)
any_stroke = st.builds(
    Stroke, st.integers(-1, 5) | st.integers(1, 3), any_number, st.none() | st.floats(0.6, 3.0) | st.floats()
)
any_maneuver = st.builds(
    Maneuver,
    st.lists(any_stroke, max_size=20).map(tuple),
    speed_deg_s=st.floats() | st.floats(1, 450),
    pause_s=st.floats() | st.floats(0.6, 1.5),
)
likely_maneuver = st.builds(
    four_stroke,
    st.decimals("0.01", 90, places=2).map(float),
    st.decimals("0.01", 90, places=2).map(float),
    speed_deg_s=st.decimals(150, 400, places=2).map(float),
)


def _check(schedule: Schedule) -> None:
    pose_cdeg = {1: 0, 2: 0, 3: 0}
    # Products of us and cdeg/s are whole numbers: no rounding can hide a microsecond.
    free_at = PAUSE_MIN_US * schedule.speed_cdeg_s
    for stroke in schedule.strokes:
        assert stroke.t_us % SCHEDULE_GRID_US == 0
        assert stroke.t_us * schedule.speed_cdeg_s >= free_at
        free_at = stroke.t_us * schedule.speed_cdeg_s + abs(stroke.angle_cdeg) * 1_000_000
        pose_cdeg[stroke.joint] += stroke.angle_cdeg
        # Beyond 0 to 90 deg a servo is driven against its stop.
        assert 0 <= pose_cdeg[stroke.joint] <= JOINT_ANGLE_MAX_CDEG
        assert stroke.angle_cdeg != 0
    assert free_at <= FALL_US * schedule.speed_cdeg_s
    # Rounded up to a microsecond, and by less than one.
    assert (schedule.end_us - 1) * schedule.speed_cdeg_s < free_at <= schedule.end_us * schedule.speed_cdeg_s


@given(any_maneuver)
def test_whatever_is_asked_is_refused_by_name_or_safe_to_fly(maneuver: Maneuver) -> None:
    try:
        schedule = schedule_maneuver(maneuver)
    except ManeuverError as error:
        assert error.code in Defect
    else:
        _check(schedule)


@given(likely_maneuver)
def test_each_start_is_the_first_of_the_grid_after_the_stroke_before(maneuver: Maneuver) -> None:
    try:
        schedule = schedule_maneuver(maneuver)
    except ManeuverError as error:
        assert error.code == Defect.OUTLASTS_FALL
        return
    _check(schedule)
    for before, after in zip(schedule.strokes, schedule.strokes[1:], strict=False):
        # The stroke has ended by the next start, and had not one grid step earlier.
        work = abs(before.angle_cdeg) * 1_000_000
        assert (after.t_us - before.t_us) * schedule.speed_cdeg_s >= work
        assert (after.t_us - SCHEDULE_GRID_US - before.t_us) * schedule.speed_cdeg_s < work


@pytest.mark.parametrize("noise", [-4e-15, 4e-15])
def test_the_noise_of_radians_is_no_rounding(noise: float) -> None:
    # An angle that went to radians and back is off by its last bits: no notice, no other stroke.
    strokes = (Stroke(1, 20 + noise), Stroke(1, -20 - noise))
    schedule = schedule_maneuver(Maneuver(strokes, speed_deg_s=30 + noise))
    assert (schedule.speed_deg_s, schedule.notices) == (30.0, ())
    assert schedule_maneuver(Maneuver(strokes, speed_deg_s=400.00000000000006)).speed_deg_s == 400.0
