"""What a rehearsal needs before it begins: the robot of a seed, the sequencer's image, the strokes as lists."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.output import Output
from tfsat_host.errors import TfsatError, UsageError

if TYPE_CHECKING:
    from tfsat_host.emulated.imu_part import ImuPart
    from tfsat_host.maneuver import Schedule
    from tfsat_host.rehearsal.preflight import Preflight
    from tfsat_host.rehearsal.truth import Truth
    from tfsat_host.robot import RobotModel


def robot_of(args: argparse.Namespace) -> RobotModel:
    """The robot's file, of a robot that can be dropped.

    Raises:
        TfsatError: it cannot be read, or there are no boards for such a robot.
    """
    from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT
    from tfsat_host.robot import load_robot

    robot = load_robot(args.robot)
    if (robot.n_bodies, robot.n_joints, len(robot.imus)) != (IMU_COUNT, JOINT_COUNT, IMU_COUNT):
        raise TfsatError(
            what=f"{robot.name} cannot be rehearsed: its file has {robot.n_bodies} bodies, {robot.n_joints} joints and "
            f"{len(robot.imus)} IMUs, and the boards drop a robot of {IMU_COUNT} bodies with an IMU each and "
            f"{JOINT_COUNT} joints.",
            meaning="Nothing was flown.",
            next_step="Name a file like robots/drop_tower.toml with --robot, or leave it out. What such a robot would "
            f"do is computed by tfsat-host simulate --robot {args.robot}",
        )
    return robot


def truth_of(args: argparse.Namespace, filed: RobotModel, number: int) -> Truth:
    """The robot of a seed."""
    from tfsat_host.rehearsal.truth import drawn_truth, truth_as_filed

    part = part_of(args)
    return truth_as_filed(filed, number) if args.as_filed else drawn_truth(filed, number, part)


def part_of(args: argparse.Namespace) -> ImuPart | None:
    """The IMU that was asked for; None: the robot's own."""
    if args.imu is None:
        return None
    if args.as_filed:
        raise UsageError(
            what="--imu and --as-filed contradict each other: a robot as its file has it has no part's errors.",
            meaning="Nothing was flown.",
            next_step="Leave one of them out.",
        )
    from tfsat_host.emulated.imu_part import load_imu

    return load_imu(args.imu)


def image_of(args: argparse.Namespace, out: Output) -> Path | None:
    """The sequencer's image; None for its core. Builds what is missing."""
    from tfsat_host.emulated.build import Variant, ensure_built

    hex_path = None
    if args.sequencer == "avr":
        from tfsat_host.emulated.sequencer_image import sequencer_hex

        hex_path = sequencer_hex(out.note)
    ensure_built(Variant(avr=hex_path is not None), out.note)
    return hex_path


def preflight_of(
    args: argparse.Namespace, schedule: Schedule, filed: RobotModel, image: Path | None
) -> Preflight:
    """What every rehearsed drop is checked against."""
    from tfsat_host.facility import load_tower
    from tfsat_host.rehearsal.preflight import Preflight

    return Preflight.of(schedule, filed, load_tower(None), image, despite=args.despite_preflight)


def strokes_of(schedule: Schedule) -> tuple[list[float], list[float], list[int]]:
    """Start times in s, angles in deg, joints."""
    strokes = schedule.strokes
    return (
        [stroke.t_s for stroke in strokes],
        [stroke.angle_deg for stroke in strokes],
        [stroke.joint for stroke in strokes],
    )
