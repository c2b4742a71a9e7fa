"""`tfsat-host envelope`: whether a maneuver fits the drop tower."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.maneuver_argument import add_maneuver_arguments, maneuver_from, schedule_from
from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError

if TYPE_CHECKING:
    from tfsat_host.facility import Check, DropTower, Envelope
    from tfsat_host.maneuver import Schedule
    from tfsat_host.robot import RobotModel


def configure(parser: argparse.ArgumentParser) -> None:
    """The maneuver, the robot and the facility."""
    parser.description = (
        "Check a maneuver against the drop tower before it is uploaded: the time it takes, how far the moving "
        "robot reaches and may drift, the release and the pause after it. Exit code 3 if a check fails."
    )
    add_maneuver_arguments(parser)
    parser.add_argument(
        "--robot",
        metavar="FILE",
        type=file_name,
        help="a robot file, or the name of a robot that tfsat brings along (default: drop_tower)",
    )
    parser.add_argument(
        "--facility", metavar="FILE", type=file_name, help="a facility file (default: COSMOTORRE's)"
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Computes the reach of the maneuver and compares everything with the facility."""
    schedule = schedule_from(args, maneuver_from(args))  # refused before anything heavy is imported
    for notice in schedule.notices:
        out.warn(notice)

    from tfsat_host.facility import check_maneuver, envelope_of, load_tower
    from tfsat_host.robot import load_robot

    robot = load_robot(args.robot)
    tower = load_tower(args.facility)
    envelope = envelope_of(robot, schedule, until_s=tower.fall_s)
    checks = check_maneuver(schedule, robot, tower, envelope)
    fits = all(check.passed for check in checks)
    result = _result(schedule, robot, tower, envelope, checks)
    out.result(result, lambda: _show(tower, envelope, checks, out))
    return 0 if fits else DataLossError.exit_code


def _result(
    schedule: Schedule, robot: RobotModel, tower: DropTower, envelope: Envelope, checks: tuple[Check, ...]
) -> dict[str, Any]:
    from dataclasses import asdict

    from tfsat_host.facility import permissible_transversal_velocities

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
    rows = [
        (
            check.name,
            _shown(check.value, check.unit),
            f"{'at most' if check.at_most else 'at least'} {_shown(check.limit, check.unit)}",
            "ok" if check.passed else "NO",
            check.sentence,
        )
        for check in checks
    ]
    out.table(("check", "found", "needed", "", "which means"), rows)
    out.line(
        f"The robot reaches {envelope.max_radius_mm:.0f} mm from its line of fall and {envelope.height_mm:.0f} mm "
        "in height, by the boxes of its robot file."
    )
    failed = [check.name for check in checks if not check.passed]
    if failed:
        out.line(f"Doubtful at {tower.name}: {', '.join(failed)}.")
    else:
        out.line(f"The maneuver fits {tower.name}: all {len(checks)} checks passed.")


def _shown(value: float, unit: str) -> str:
    """Times to a millisecond, all else to a tenth."""
    return f"{value:.3f} {unit}" if unit == "s" else f"{value:.1f} {unit}"
