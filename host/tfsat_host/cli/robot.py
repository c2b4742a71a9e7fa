"""`tfsat-host robot`: what a robot file says, checked and in one view."""

from __future__ import annotations

import argparse

from tfsat_host.cli.usage import OUTPUT, add_options
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show

_USAGE = f"""
Check a robot file and show its bodies, joints, servos and sensors, and the mass properties of the whole.
docs/robot-files.md explains the format.

[FILE]  a robot file, or the name of a robot that tfsat brings along (default: drop_tower)
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the robot file and the output options."""
    add_options(parser, _USAGE, file={"dest": "robot"})


def run(args: argparse.Namespace, out: Output) -> int:
    """Reads, checks, shows."""
    from tfsat_host.robot import load_robot
    from tfsat_host.robot.robot_summary import lines, summary

    facts = summary(load_robot(args.robot))
    out.result(facts, lambda: show(lines(facts), out))
    return 0
