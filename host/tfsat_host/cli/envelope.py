"""`tfsat-host envelope`: whether a maneuver fits the drop tower."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.initial_rate import add_initial_rate_option, initial_rate_rad_s
from tfsat_host.cli.maneuver_argument import add_maneuver_arguments, robots_maneuver, schedule_from
from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.errors import DataLossError
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import Column, Columns

if TYPE_CHECKING:
    from tfsat_host.maneuver import Schedule
    from tfsat_host.plan.envelope import Envelope
    from tfsat_host.plan.facility import DropTower
    from tfsat_host.plan.tower_checks import Check
    from tfsat_host.robot import RobotModel


def configure(parser: argparse.ArgumentParser) -> None:
    """The maneuver, the robot and the facility."""
    parser.description = (
        "Check a maneuver against the drop tower before it is uploaded: the time it takes, how far the moving "
        "robot reaches and may drift, the release and the pause after it. It starts from the robot's start pose. "
        "Exit code 3 if a check fails."
    )
    add_maneuver_arguments(parser, default_speed="what the robot file says of its servos")
    parser.add_argument(
        "--robot",
        metavar="FILE",
        type=file_name,
        help="a robot file, or the name of a robot that tfsat brings along (default: drop_tower)",
    )
    parser.add_argument(
        "--facility", metavar="FILE", type=file_name, help="a facility file (default: COSMOTORRE's)"
    )
    add_initial_rate_option(parser)
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Computes the reach of the maneuver and compares everything with the facility."""
    from tfsat_host.plan.envelope import envelope_of
    from tfsat_host.plan.facility import load_tower
    from tfsat_host.plan.tower_checks import check_maneuver
    from tfsat_host.robot import load_robot

    rate = initial_rate_rad_s(args)
    robot = load_robot(args.robot)
    schedule = _schedule(args, robot)
    for notice in schedule.notices:
        out.warn(notice)
    tower = load_tower(args.facility)
    envelope = envelope_of(robot, schedule, until_s=tower.fall_s, initial_rate_rad_s=rate)
    checks = check_maneuver(schedule, robot, tower, envelope)
    fits = all(check.passed for check in checks)
    result = _result(schedule, robot, tower, envelope, checks)
    result["initial_rate_deg_s"] = args.initial_rate
    out.result(result, lambda: _show(tower, envelope, checks, out))
    return 0 if fits else DataLossError.exit_code


def _schedule(args: argparse.Namespace, robot: RobotModel) -> Schedule:
    """The strokes by the robot's own limits, and the sequencer's for a robot whose servos it commands."""
    from dataclasses import replace

    from tfsat_host.dynamics.flying import robot_limits
    from tfsat_host.maneuver import SEQUENCER

    maneuver = robots_maneuver(args, robot)
    limits = replace(robot_limits(robot), strokes_min=SEQUENCER.strokes_min)
    schedule = schedule_from(args, maneuver, limits)
    if all(servo.pulses is not None for servo in robot.servos):
        schedule_from(args, maneuver)
    return schedule


def _result(
    schedule: Schedule, robot: RobotModel, tower: DropTower, envelope: Envelope, checks: tuple[Check, ...]
) -> dict[str, Any]:
    from dataclasses import asdict

    from tfsat_host.plan.envelope import permissible_transversal_velocities

    permissible = permissible_transversal_velocities(envelope, tower.envelope_radius_mm, tower.fall_s)
    return {
        "fits": all(check.passed for check in checks),
        "checks": [asdict(check) for check in checks],
        "max_radius_mm": envelope.max_radius_mm,
        "max_radius_t_s": envelope.max_radius_t_s,
        "max_radius_body": envelope.max_radius_body,
        "folded_radius_mm": envelope.folded_radius_mm,
        "height_mm": envelope.height_mm,
        "permissible_transversal_velocity_mm_s": permissible.paper,
        "permissible_transversal_velocity_moment_by_moment_mm_s": permissible.moment_by_moment,
        "schedule": schedule.as_rows(),
        "end_s": schedule.end_s,
        "robot": robot.name,
        "facility": tower.name,
        "notices": list(schedule.notices),
    }


def _show(tower: DropTower, envelope: Envelope, checks: tuple[Check, ...], out: Output) -> None:
    show_rows(_CHECKS, checks, out)
    out.line(
        f"The robot reaches {envelope.max_radius_mm:.0f} mm from its line of fall and {envelope.height_mm:.0f} mm "
        "in height, by the boxes of its robot file."
    )
    failed = [check.name for check in checks if not check.passed]
    if failed:
        out.line(f"Doubtful at {tower.name}: {', '.join(failed)}.")
    else:
        out.line(f"The maneuver fits {tower.name}: all {len(checks)} checks passed.")


_CHECKS: Columns = (
    Column("name", "check"),
    Column("value", "found", words=lambda check: _shown(check.value, check.unit)),
    Column("limit", "needed", words=lambda check: f"{check.needed} {_shown(check.limit, check.unit)}"),
    Column("passed", "passed", words=lambda check: "ok" if check.passed else "NO"),
    Column("sentence", "which means"),
)


def _shown(value: float, unit: str) -> str:
    """Times to a millisecond, all else to a tenth."""
    return f"{value:.3f} {unit}" if unit == "s" else f"{value:.1f} {unit}"
