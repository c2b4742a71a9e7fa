"""What gyros and angle sensors make of each other's holes, silence and slips, beside the emulated robot's truth.

Every error must lie within what is stated of it, and that must not be so wide that it says nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.corrupted import failed, unanswered, with_angles
from tests.evaluation.drops import (
    STDS,
    Drop,
    angle_off_deg,
    assert_angle_holds,
    certificate,
    flown,
    motion,
    moved,
    turn_off,
)
from tfsat_host.evaluation.checks import checks_of
from tfsat_host.evaluation.motion.motion import Motion, notes_of
from tfsat_host.sdlog import DropLog

HOLE_S = 0.05
HOLES = pytest.mark.parametrize(("seed", "from_s"), [(1, 1.045), (2, 1.10), (3, 1.38)])
"""The first stroke of joint 2 begins in the first, lasts all through the second, and ends in or after the third."""
SEEDS = pytest.mark.parametrize("seed", [1, 2, 3])


def motion_in(one: Drop, seed: int, log: DropLog) -> Motion:
    return moved(log, certificate(one, seed), one.model)


def no_gyro(log: DropLog, from_s: float, until_s: float) -> DropLog:
    for body in range(1, 5):
        log = unanswered(log, body, from_s, until_s)
    return log


def sensors_silent_after(log: DropLog, columns: slice, from_s: float) -> DropLog:
    valid = log.angle_valid.copy()
    valid[log.t_s >= from_s, columns] = False
    return replace(log, angle_valid=valid)


def slipped(log: DropLog, column: int, from_s: float, by_deg: float) -> DropLog:
    """From then on an angle sensor sits elsewhere on its shaft."""
    counts = log.angle_counts[:, column].astype(np.int64)
    counts[log.t_s >= from_s] += round(by_deg / 360.0 * log.header.angle_counts_per_turn)
    return with_angles(log, column, counts)


@HOLES
def test_a_hole_in_all_gyros_within_a_stroke_is_carried_over(seed: int, from_s: float) -> None:
    one = flown(seed)
    found = motion_in(one, seed, no_gyro(one.log, from_s, from_s + HOLE_S))
    for joint in (1, 2, 3):
        assert_angle_holds(one, found, joint, widest_deg=0.02)
    for body in (1, 2, 3, 4):
        off, without = turn_off(one, found, body), turn_off(one, motion(seed), body)
        assert off.stds < STDS
        assert off.std_deg > 5.0 * without.std_deg
        fastest_deg_s = np.rad2deg(np.linalg.norm(found.bodies[body - 1].rate_rad_s, axis=1).max())
        assert off.std_deg < fastest_deg_s * HOLE_S / np.sqrt(3.0), "it might have turned either way"


@HOLES
def test_where_no_angle_sensor_answers_the_others_tell_what_the_joint_turned_in_the_hole(
    seed: int, from_s: float
) -> None:
    """A wrong angle would show in the gyros off the joint's axis, and in the rates of its neighbours."""
    one = flown(seed)
    silent = sensors_silent_after(one.log, slice(2, 4), 0.9)
    found = motion_in(one, seed, no_gyro(silent, from_s, from_s + HOLE_S))
    assert_angle_holds(one, found, 2, widest_deg=0.05)
    std, without = (angle_off_deg(one, each, 2)[1] for each in (found, motion(seed)))
    assert std.max() > 1.5 * without.max()


@SEEDS
def test_over_a_hole_at_the_release_the_robot_turns_on_evenly(seed: int) -> None:
    one = flown(seed)
    found = motion_in(one, seed, no_gyro(one.log, -0.02, 0.095))
    for joint in (1, 2, 3):
        assert_angle_holds(one, found, joint, widest_deg=0.02)
    for body in (1, 2, 3, 4):
        off = turn_off(one, found, body, from_s=0.0)
        assert off.stds < STDS
        assert off.error_deg < 0.05, "it turned by 0.11 deg meanwhile"
        assert np.hypot(turn_off(one, motion(seed), body).std_deg, 0.015) < off.std_deg < 0.1


@SEEDS
@pytest.mark.parametrize(("body", "joint"), [(1, 1), (4, 3)])
def test_beside_a_dead_gyro_of_an_end_body_the_joint_angle_is_less_sure_and_right(
    seed: int, body: int, joint: int
) -> None:
    one = flown(seed)
    found = motion_in(one, seed, unanswered(one.log, body, -100.0, 100.0))
    for other in (1, 2, 3):
        assert_angle_holds(one, found, other, widest_deg=0.06)
    std, without = (angle_off_deg(one, each, joint)[1] for each in (found, motion(seed)))
    assert std.max() > 2.5 * without.max()
    assert (std > without).all()


@pytest.mark.parametrize(
    ("seed", "column", "by_deg"), [(1, 0, 20.0), (1, 3, -30.0), (2, 1, 20.0), (2, 2, 8.0)]
)
def test_an_angle_sensor_that_slipped_before_the_release_is_named_and_not_used(
    seed: int, column: int, by_deg: float
) -> None:
    one = flown(seed)
    found = motion_in(one, seed, slipped(one.log, column, -1.0, by_deg))
    joint, sensor = column // 2 + 1, column % 2
    distrusted = [sensed.distrusted for sensed in found.fusion.joints]
    assert distrusted == [sensor if number == joint else None for number in (1, 2, 3)]
    named = [
        note for note in notes_of(found) if note.startswith(f"Angle sensor {sensor + 1} of joint {joint} ")
    ]
    assert len(named) == 1
    assert not found.contradicted
    for other in (1, 2, 3):
        assert_angle_holds(one, found, other, widest_deg=0.02)


@pytest.mark.parametrize(("column", "from_s", "by_deg"), [(0, 0.9, 20.0), (1, 1.9, -8.0), (3, 1.2, 8.0)])
def test_a_check_fails_where_an_angle_sensor_slips_in_the_fall(
    column: int, from_s: float, by_deg: float
) -> None:
    one = flown(1)
    log = slipped(one.log, column, from_s, by_deg)
    found = failed(checks_of(motion_in(one, 1, log), None, log, certificate(one, 1), one.model))
    cause = found[f"angle sensors of joint {column // 2 + 1}"].cause or ""
    assert f"angle sensor {column % 2 + 1} of joint {column // 2 + 1}" in cause


@pytest.mark.parametrize(
    ("seed", "column", "from_s", "by_deg"),
    [(1, 0, 0.3, 20.0), (1, 3, 0.9, 20.0), (2, 1, 1.2, -30.0), (2, 2, 1.9, 20.0)],
)
def test_an_angle_sensor_that_slips_in_the_fall_is_named_and_not_used(
    seed: int, column: int, from_s: float, by_deg: float
) -> None:
    one = flown(seed)
    found = motion_in(one, seed, slipped(one.log, column, from_s, by_deg))
    joint, sensor = column // 2 + 1, column % 2
    assert [sensed.distrusted for sensed in found.fusion.joints][joint - 1] == sensor
    assert any(note.startswith(f"Angle sensor {sensor + 1} of joint {joint} ") for note in notes_of(found))
    assert not found.contradicted
    for other in (1, 2, 3):
        assert_angle_holds(one, found, other, widest_deg=0.02)
