"""What a rehearsal needs before it begins: the robot of a seed, the sequencer's image, the strokes as lists."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from tfsat_host.maneuver import Schedule
    from tfsat_host.rehearsal.truth import Truth
    from tfsat_host.robot import RobotModel


def truth_of(args: argparse.Namespace, filed: RobotModel, number: int) -> Truth:
    """The robot of a seed."""
    from tfsat_host.rehearsal.truth import drawn_truth, truth_as_filed

    return truth_as_filed(filed, number) if args.as_filed else drawn_truth(filed, number)


def image_of(args: argparse.Namespace, out: Output) -> Path | None:
    """The sequencer's image; None for its core. Builds what is missing."""
    from tfsat_host.emulated.build import Variant, ensure_built

    hex_path = None
    if args.sequencer == "avr":
        from tfsat_host.emulated.sequencer_image import sequencer_hex

        hex_path = sequencer_hex(out.note)
    ensure_built(Variant(avr=hex_path is not None), out.note)
    return hex_path


def strokes_of(schedule: Schedule) -> tuple[list[float], list[float], list[int]]:
    """Start times in s, angles in deg, joints."""
    strokes = schedule.strokes
    return (
        [stroke.t_s for stroke in strokes],
        [stroke.angle_deg for stroke in strokes],
        [stroke.joint for stroke in strokes],
    )
