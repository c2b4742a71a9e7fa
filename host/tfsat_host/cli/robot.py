"""`tfsat-host robot`: what a robot file says, checked and in one view."""

from __future__ import annotations

import argparse

from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.present.output import Output


def configure(parser: argparse.ArgumentParser) -> None:
    """The robot, and how to print it."""
    parser.description = (
        "Check a robot file and show its bodies, joints, servos and sensors, and the mass properties of the whole. "
        "docs/robot-files.md explains the format."
    )
    parser.add_argument(
        "robot",
        metavar="FILE",
        nargs="?",
        type=file_name,
        help="a robot file, or the name of a robot that tfsat brings along (default: drop_tower)",
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Reads, checks, shows."""
    from tfsat_host.robot import load_robot
    from tfsat_host.robot.summary import Json, summary
    from tfsat_host.robot.summary_text import summary_lines, summary_tables

    def show(facts: Json) -> None:
        for line in summary_lines(facts):
            out.line(line)
        out.line()
        for table in summary_tables(facts):
            out.table(table.columns, table.rows, title=table.title)

    facts = summary(load_robot(args.robot))
    out.result(facts, lambda: show(facts))
    return 0
