"""`tfsat-host robot`: what a robot file says, checked and in one view."""

from __future__ import annotations

import argparse

from tfsat_host.cli.usage import FULL, OUTPUT, add_options
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import sentences, show, show_facts
from tfsat_host.quantity import record

_USAGE = f"""
Check a robot file and show its bodies, joints, servos and sensors, and the mass properties of the whole.
docs/robot-files.md explains the format. The low-pass is the paper's (5 Hz); a recording has the logger's, by default
42 Hz (`logger-settings show`).

[FILE]  a robot file, or the name of a robot that tfsat brings along (default: drop_tower)
{FULL}
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the robot file and the output options."""
    add_options(parser, _USAGE, file={"dest": "robot"})


def run(args: argparse.Namespace, out: Output) -> int:
    """Reads, checks, shows."""
    from tfsat_host.robot import load_robot
    from tfsat_host.robot.robot_summary import SUMMARY, RobotSummary, detail_tables, overview_tables

    summary = RobotSummary.of(load_robot(args.robot))

    def show_summary() -> None:
        show_facts(SUMMARY, summary, out)
        show(overview_tables(summary), out)
        if args.full:
            show(detail_tables(summary), out)
        else:
            more = NextStep("robot", (*([] if args.robot is None else [str(args.robot)]), "--full"))
            sentences([Advice("Inertia tensors, pulses, sensors: ", more)], out)

    out.result(record(SUMMARY, summary), show_summary)
    return 0
