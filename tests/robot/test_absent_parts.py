"""A robot of fewer parts fits the boards: what is absent is filled in, moves nothing and says nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.calibration.some_calibration import whole_calibration
from tests.evaluation import drops
from tests.robot.fewer_parts import smaller_robot
from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.dynamics import Multibody, joint_momentum, locked_inertia
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.evaluation.com_fit.offsets import model_offsets
from tfsat_host.robot import load_robot
from tfsat_host.robot.absent_parts import (
    bodies_of,
    bodies_with_imu,
    describe_absent,
    fill_places,
    hash_wired_parts,
    ignore_absent,
    require_joint,
)


def test_a_robot_that_has_all_parts_stays_as_it_is() -> None:
    robot = load_robot()
    assert fill_places(robot) is robot
    assert describe_absent(robot) == ""
    log = drops.fly_drop(1).log
    assert ignore_absent(log, robot) is log


@pytest.mark.parametrize("bodies", [2, 3])
def test_absent_bodies_change_no_momentum(bodies: int, tmp_path: Path) -> None:
    robot = smaller_robot(tmp_path, bodies=bodies)
    filled = fill_places(robot)
    assert (filled.n_bodies, filled.n_joints, len(filled.imus), len(filled.angle_sensors)) == (4, 3, 4, 6)
    assert bodies_of(filled) == bodies_with_imu(filled) == tuple(range(1, bodies + 1))
    angles = np.random.default_rng(1).uniform(0.0, 1.5, (20, 3)) * (np.arange(3) < bodies - 1)
    few, all_places = Multibody.of(robot), Multibody.of(filled)
    own = angles[:, : robot.n_joints]
    inertia = locked_inertia(few, own)
    assert locked_inertia(all_places, angles) == pytest.approx(inertia, abs=1e-9 * np.abs(inertia).max())
    momentum = joint_momentum(few, own)
    assert joint_momentum(all_places, angles)[..., : robot.n_joints] == pytest.approx(
        momentum, abs=1e-9 * np.abs(momentum).max()
    )


def test_what_the_logger_reads_at_absent_places_does_not_matter(tmp_path: Path) -> None:
    robot = fill_places(smaller_robot(tmp_path, bodies=3, without_imu=[1]))
    log = drops.fly_drop(1).log
    noise = np.random.default_rng(2)
    other = replace(
        log,
        imu_counts=noise.integers(-999, 999, log.imu_counts.shape).astype(np.int16),
        angle_counts=noise.integers(0, 999, log.angle_counts.shape).astype(np.uint16),
    )
    for name in ("imu_counts", "imu_valid", "clipped", "angle_counts", "angle_valid"):
        first, second = (getattr(ignore_absent(some, robot), name) for some in (log, other))
        absent = [4, 5] if name.startswith("angle") else [0, 3]
        assert np.array_equal(first[:, absent], second[:, absent])
        there = [column for column in range(first.shape[1]) if column not in absent]
        assert np.array_equal(first[:, there], getattr(log, name)[:, there])
    assert not ignore_absent(log, robot).imu_valid[:, [0, 3]].any()
    assert ignore_absent(log, robot, missed=False).imu_valid[:, [0, 3]].all()


def test_an_imu_has_the_place_of_its_body() -> None:
    robot = load_robot()
    mixed = fill_places(replace(robot, imus=tuple(robot.imus[k] for k in (2, 0, 3, 1))))
    assert [imu.body for imu in mixed.imus] == [0, 1, 2, 3]
    assert [(imu.bus, imu.address) for imu in mixed.imus] == [(imu.bus, imu.address) for imu in robot.imus]


def test_a_certificate_counts_for_what_the_robot_file_has(tmp_path: Path) -> None:
    """Parts were taken off, or put on, since it was measured."""
    small, whole = fill_places(smaller_robot(tmp_path, bodies=3, without_imu=[1])), load_robot()
    measured = whole_calibration()
    taken_off = measured.of_robot(small)
    assert [gyro.body for gyro in taken_off.present_gyros] == [2, 3]
    assert [sensors.joint for sensors in taken_off.present_joints] == [1, 2]
    assert {row.name for row in quantities(taken_off)} <= {row.name for row in quantities(measured)}
    assert not [row.name for row in quantities(taken_off) if "body 1" in row.name or "joint 3" in row.name]
    put_on = {row.name for row in taken_off.of_robot(whole).shortcomings() if row.state == "missing"}
    assert {"bias of body 1", "bias of body 4", "zero point of joint 3"} <= put_on
    assert not {"bias of body 2", "zero point of joint 1"} & put_on


def test_absent_parts_are_named(tmp_path: Path) -> None:
    robot = fill_places(smaller_robot(tmp_path, bodies=3, without_imu=[1]))
    assert describe_absent(robot) == "Absent by the robot file: body 4, joint 3, IMU of body 1"
    require_joint(robot, 2)
    with pytest.raises(UsageError, match="has no joint 3"):
        require_joint(robot, 3)


def test_corrected_masses_move_no_wire(tmp_path: Path) -> None:
    robot = load_robot()
    corrected = replace(robot, mass_kg=1.01 * robot.mass_kg, com_m=robot.com_m + 0.001, name="corrected")
    assert hash_wired_parts(corrected) == hash_wired_parts(robot)
    turned = replace(robot.angle_sensors[0], direction=-robot.angle_sensors[0].direction)
    others = [
        fill_places(smaller_robot(tmp_path, without_imu=[4])),
        fill_places(smaller_robot(tmp_path, bodies=3)),
        replace(robot, angle_sensors=(turned, *robot.angle_sensors[1:])),
        replace(robot, joint_limits_rad=0.9 * robot.joint_limits_rad),
    ]
    assert len({hash_wired_parts(other) for other in (robot, *others)}) == 5


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"imus": load_robot().imus[:1]}, "it has fewer than two IMUs"),
        (
            {"angle_sensors": tuple(load_robot().angle_sensors[k] for k in (0, 2, 1, 3, 4, 5))},
            "in the order of",
        ),
        ({"angle_sensors": load_robot().angle_sensors[:5]}, "it has not two angle sensors for each joint"),
        ({"joint_inner": np.array([1, 2, 0])}, "its joints do not join body 1 to 2, 2 to 3"),
        ({"imus": (load_robot().imus[0],) * 2}, "a body of it has several IMUs"),
    ],
)
def test_what_the_boards_have_no_place_for_is_refused(change: dict[str, Any], reason: str) -> None:
    with pytest.raises(TfsatError, match=reason):
        fill_places(replace(load_robot(), **change))


def test_no_number_of_an_absent_part_is_fitted(tmp_path: Path) -> None:
    names = model_offsets(fill_places(smaller_robot(tmp_path, bodies=2))).names
    assert {tuple(name.split()[:2]) for name in names} == {("body", "1"), ("body", "2"), ("joint", "1")}
