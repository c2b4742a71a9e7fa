"""`tfsat-host envelope`: whether a maneuver fits the drop tower."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tfsat_host.cli import maneuver_argument as given
from tfsat_host.cli.usage import INITIAL_RATE, OUTPUT, ROBOT
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.facility import load_tower
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import bullets, sentences, show_facts, show_rows
from tfsat_host.quantity import record

if TYPE_CHECKING:
    from tfsat_host.plan.tower_checks import TowerReport

_USAGE = f"""
Check a maneuver against the drop tower before it is uploaded: the time it takes, how far the moving robot reaches and
may drift, the release and the pause after it. It starts from the robot's start pose. Exit code 3 if a check fails.

{ROBOT}
--facility FILE  a facility file (default: COSMOTORRE's)
{INITIAL_RATE}
--full           what every check means, not only failed ones
{given.maneuver_usage(given.SERVOS_SPEED)}
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for maneuver, robot and facility."""
    given.add_maneuver_options(parser, _USAGE)


def run(args: argparse.Namespace, out: Output) -> int:
    """Computes the reach of the maneuver and compares everything with the facility."""
    from tfsat_host.dynamics.simulation import robot_limits
    from tfsat_host.plan.reach_envelope import envelope_of
    from tfsat_host.plan.tower_checks import REPORT, TowerReport, check_maneuver
    from tfsat_host.robot import load_robot

    rate = given.initial_rate_rad_s(args)
    robot = load_robot(args.robot)
    maneuver = given.maneuver_from(args, robot)
    schedule = given.schedule_from(args, maneuver, robot_limits(robot, strokes_min=1))
    if robot.has_sequencer:
        given.schedule_from(args, maneuver)  # by the sequencer's limits, too
    out.warn_each(schedule.notices)
    tower = load_tower(args.facility)
    envelope = envelope_of(robot, schedule, until_s=tower.fall_s, initial_rate_rad_s=rate)
    checks = check_maneuver(schedule, robot, tower, envelope)
    report = TowerReport(schedule, robot, tower, envelope, checks, args.initial_rate)
    out.result(record(REPORT, report), lambda: _show(report, out, full=args.full))
    return ExitCode.DATA_LOSS if report.failed else 0


def _show(report: TowerReport, out: Output, *, full: bool) -> None:
    from tfsat_host.plan.tower_checks import CHECK, REPORT

    sentences([report.verdict], out)
    show_rows(CHECK, report.checks, out)
    show_facts(REPORT, report, out)
    bullets([f"{check.name}: {check.sentence}" for check in (report.checks if full else report.failed)], out)
    if report.failed:
        sentences([Advice("Design a maneuver that fits: ", NextStep("design"))], out)
    sentences([report.verdict], out)
