"""What a rehearsal needs before it begins: the robot of a seed, the sequencer's image, the strokes as lists."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.output import Output
from tfsat_host.errors import UsageError

if TYPE_CHECKING:
    from tfsat_host.emulated.imu_part import ImuPart
    from tfsat_host.maneuver import Schedule
    from tfsat_host.rehearsal.preflight import Preflight
    from tfsat_host.rehearsal.truth import Truth
    from tfsat_host.robot import RobotModel


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
