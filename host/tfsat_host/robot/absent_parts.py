"""A robot of fewer parts than the boards have places for: absent ones are filled in, and marked as such.

The boards have places for four bodies with an IMU each, and three joints with a servo and two angle sensors each. An
absent body weighs a nanogram and is fastened to the last one that is there, by a joint that stays at 0. What the
logger reads at the places of absent sensors counts for nothing.
"""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT, JOINT_COUNT
from tfsat_host.robot.loading import load_robot
from tfsat_host.robot.model import AngleSensor, RobotModel, frozen, frozen_indices

_ABSENT = " (absent)"
_SPECK_KG, _SPECK_KG_M2 = 1e-12, 1e-18
"""Of an absent body: dynamics takes nothing without mass."""
_PER_JOINT = ANGLE_SENSOR_COUNT // JOINT_COUNT


class _Dataclass(Protocol):
    __dataclass_fields__: ClassVar[dict[str, Any]]


SamplesT = TypeVar("SamplesT", bound=_Dataclass)
"""A log, or counts: with `imu_counts`, `angle_counts`, `imu_valid`, `angle_valid` and `clipped`."""


def load_robot_of_boards(name_or_path: Path | str | None) -> RobotModel:
    """Load a robot file as `load_robot` does, for what the boards do: see `fill_places`. Raises TfsatError."""
    return fill_places(load_robot(name_or_path))


def fill_places(robot: RobotModel) -> RobotModel:
    """Return the robot with as many bodies, joints, IMUs and angle sensors as the boards have places for.

    Raises:
        TfsatError: it has more of something, or a part for which the boards have no place.
    """
    chain = [{joint, joint + 1} for joint in range(robot.n_joints)]
    ends = zip(robot.joint_inner.tolist(), robot.joint_outer.tolist(), strict=True)
    pairs = [joint for joint in range(robot.n_joints) for _ in range(_PER_JOINT)]
    problems = {
        f"it has {robot.n_bodies} bodies": not 2 <= robot.n_bodies <= IMU_COUNT,
        "its joints do not join body 1 to 2, 2 to 3 and so on": [{*pair} for pair in ends] != chain,
        "it has fewer than two IMUs, and nothing would check the one": len(robot.imus) < 2,
        "a body of it has several IMUs": len({imu.body for imu in robot.imus}) < len(robot.imus),
        "it has not two angle sensors for each joint, in the order of the joints": pairs
        != [sensor.joint for sensor in robot.angle_sensors],
    }
    problem = next((text for text, is_so in problems.items() if is_so), "")
    if problem:
        raise TfsatError(
            what=f"{robot.path}: {robot.name} does not fit the boards: {problem}.",
            meaning=f"They drive and record a robot of 2 to {IMU_COUNT} bodies with an IMU each at most, and up to "
            f"{JOINT_COUNT} joints with two angle sensors each. Nothing was done.",
            next_step=Advice(
                "Name a file like robots/drop_tower.toml with --robot. What another robot would do is computed by ",
                NextStep("simulate", ("--robot", str(robot.path))),
            ),
        )
    bodies, joints = range(robot.n_bodies, IMU_COUNT), range(robot.n_joints, JOINT_COUNT)
    if [imu.body for imu in robot.imus] == list(range(IMU_COUNT)):
        return robot
    last, count = robot.n_bodies - 1, len(bodies)
    by_body = {imu.body: imu for imu in robot.imus}
    # A servo that is not there has the pulses of another one, for the board's sake, and moves nothing.
    servo = replace(robot.servos[-1], start_rad=0.0, absent=True)
    return replace(
        robot,
        body_names=(*robot.body_names, *(f"body {body + 1}{_ABSENT}" for body in bodies)),
        mass_kg=_append(robot.mass_kg, np.full(count, _SPECK_KG)),
        origin_m=_append(robot.origin_m, np.repeat(robot.origin_m[last:], count, axis=0)),
        com_m=_append(robot.com_m, np.zeros((count, 3))),
        inertia_kg_m2=_append(robot.inertia_kg_m2, np.tile(_SPECK_KG_M2 * np.eye(3), (count, 1, 1))),
        shape_m=(*robot.shape_m, *(frozen([], 0, 3) for _ in bodies)),
        joint_names=(*robot.joint_names, *(f"joint {joint + 1}{_ABSENT}" for joint in joints)),
        joint_inner=frozen_indices([*robot.joint_inner, *joints]),
        joint_outer=frozen_indices([*robot.joint_outer, *bodies]),
        joint_axis=_append(robot.joint_axis, np.tile([1.0, 0.0, 0.0], (count, 1))),
        joint_point_m=_append(robot.joint_point_m, np.repeat(robot.origin_m[last:], count, axis=0)),
        joint_limits_rad=_append(robot.joint_limits_rad, np.zeros((count, 2))),
        servos=(*robot.servos, *(servo for _ in joints)),
        imus=tuple(
            by_body.get(body) or replace(robot.imus[0], body=body, absent=True) for body in range(IMU_COUNT)
        ),
        angle_sensors=(
            *robot.angle_sensors,
            *(AngleSensor(joint, 1, 0.0, absent=True) for joint in joints for _ in range(_PER_JOINT)),
        ),
    )


def _append(values: FloatArray, more: FloatArray) -> FloatArray:
    return frozen(np.concatenate([values, more]), len(values) + len(more), *values.shape[1:])


def ignore_absent(samples: SamplesT, robot: RobotModel, *, missed: bool = True) -> SamplesT:
    """Return samples in which absent IMUs show nothing and absent angle sensors show 0, whatever the logger read.

    Readings of an absent IMU are invalid; unless `missed`, where missing ones are counted, they are not.
    """
    imus = [place for place, imu in enumerate(robot.imus) if imu.absent]
    angles = [place for place, sensor in enumerate(robot.angle_sensors) if sensor.absent]
    if not imus:
        return samples
    fills: dict[str, tuple[list[int], int]] = {
        "imu_counts": (imus, 0),
        "imu_valid": (imus, not missed),
        "clipped": (imus, False),
        "angle_counts": (angles, 0),
        "angle_valid": (angles, True),
    }
    filled = {}
    for name, (columns, value) in fills.items():
        filled[name] = getattr(samples, name).copy()
        filled[name][:, columns] = value
    return replace(samples, **filled)


def bodies_of(robot: RobotModel) -> tuple[int, ...]:
    """Return the numbers of the bodies that are there, from 1."""
    return tuple(range(1, 2 + sum(not servo.absent for servo in robot.servos)))


def bodies_with_imu(robot: RobotModel) -> tuple[int, ...]:
    """Return the numbers of the bodies whose IMU is there, from 1, in the log's order."""
    return tuple(place for place, imu in enumerate(robot.imus, 1) if not imu.absent)


def hash_wired_parts(robot: RobotModel) -> str:
    """SHA-256 of what is wired and moved: which parts are there, how sensors are mounted, how far joints go.

    Masses are not in it: they are corrected after a drop, and no wire moves with them.
    """
    described = (
        [(imu.body, imu.absent, _rounded(imu.sensor_to_body)) for imu in robot.imus],
        [(sensor.joint, sensor.direction, sensor.absent) for sensor in robot.angle_sensors],
        [servo.absent for servo in robot.servos],
        _rounded(robot.joint_limits_rad),
    )
    return sha256(repr(described).encode()).hexdigest()


def _rounded(values: FloatArray) -> list[Any]:
    # Adding 0 makes -0.0 one with 0.0.
    return list((np.round(values, 6) + 0.0).tolist())


def describe_absent(robot: RobotModel) -> str:
    """Name the absent parts, a sentence without its stop; empty if all are there."""
    return f"Absent by the robot file: {', '.join(parts)}" if (parts := list_absent(robot)) else ""


def describe_imus(robot: RobotModel, state: str) -> str:
    """Say that all IMUs that are there are in a state, and name the absent parts."""
    count, absent = len(bodies_with_imu(robot)), describe_absent(robot)
    return f"IMUs: {count} of {count} {state}.{absent and f' {absent}.'}"


def list_absent(robot: RobotModel) -> list[str]:
    """Name the absent parts."""
    there = bodies_of(robot)
    names = [name for body, name in enumerate(robot.body_names, 1) if body not in there]
    names += [name for name, servo in zip(robot.joint_names, robot.servos, strict=True) if servo.absent]
    imus = [robot.body_names[imu.body] for imu in robot.imus if imu.absent and imu.body + 1 in there]
    return [name.removesuffix(_ABSENT) for name in names] + [f"IMU of {name}" for name in imus]


def require_joint(robot: RobotModel, joint: int) -> None:
    """Raises UsageError if the robot has no such joint (from 1)."""
    if robot.servos[joint - 1].absent:
        count = sum(not servo.absent for servo in robot.servos)
        raise UsageError(
            what=f"{robot.name} has no joint {joint}: {robot.path} describes {count}.",
            meaning="Nothing was done.",
            next_step="Name a joint that it has, or the right robot file with --robot.",
        )


def require_all_parts(robot: RobotModel) -> None:
    """Raises UsageError if a part is absent: a fault may concern it."""
    if absent := describe_absent(robot):
        raise UsageError(
            what=f"Faults are emulated on a robot that has all parts. {absent}.",
            meaning="Nothing was done: a fault may concern a part that is not there.",
            next_step="Leave --fault out, or leave --robot out.",
        )
