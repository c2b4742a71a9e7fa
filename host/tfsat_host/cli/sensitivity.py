"""`tfsat-host sensitivity`: how sure a maneuver's rotation is, and which error it depends on."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.initial_rate import add_initial_rate_option, initial_rate_rad_s
from tfsat_host.cli.maneuver_argument import (
    WHAT_A_B_MEANS,
    add_maneuver_arguments,
    robots_maneuver,
    schedule_from,
)
from tfsat_host.cli.options import add_output_options, file_name, number, seed
from tfsat_host.errors import UsageError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.maneuver import Schedule
    from tfsat_host.plan.parameters import Plan
    from tfsat_host.plan.statistics import TimeLimit
    from tfsat_host.plan.study import Outcomes, Study
    from tfsat_host.robot import RobotModel, Uncertainty

_SAMPLES = (2, 1_000_000)
_WORTH_PROGRESS = 2_000  # samples; about a second


def configure(parser: argparse.ArgumentParser) -> None:
    """The maneuver, the robot, what is uncertain, and where to compute."""
    parser.description = (
        "Derivatives of a maneuver's rotation by every parameter of the robot model, and a Monte Carlo study over "
        f"the uncertainties that the robot file states. {WHAT_A_B_MEANS} docs/sensitivity.md explains the figures."
    )
    add_maneuver_arguments(parser, default_speed="what the robot file says of its servos")
    robot = parser.add_argument_group("robot, release and facility")
    robot.add_argument(
        "--robot",
        metavar="FILE",
        type=file_name,
        help="a robot file, or the name of a robot that tfsat brings along (default: drop_tower)",
    )
    add_initial_rate_option(robot)
    robot.add_argument(
        "--facility",
        metavar="FILE",
        type=file_name,
        help="a facility file, whose times the maneuver must keep (default: COSMOTORRE's, for a robot that "
        "the sequencer commands)",
    )
    study = parser.add_argument_group("Monte Carlo")
    study.add_argument(
        "--samples", metavar="N", type=_samples, default=10_000, help="robots to draw (default 10000)"
    )
    study.add_argument("--seed", metavar="N", type=seed, default=0, help="seed of the draws (default 0)")
    study.add_argument(
        "--sigma",
        metavar="KEY=VALUE",
        type=_sigma,
        action="append",
        default=[],
        help="another standard deviation than the robot file's, such as com_mm=2 or stroke_relative=0; "
        "once for each",
    )
    where = study.add_mutually_exclusive_group()
    where.add_argument(
        "--workers", metavar="N", type=_workers, help="processes at most (default: one a core)"
    )
    where.add_argument(
        "--dask",
        metavar="ADDRESS",
        help="compute on the Dask cluster whose scheduler is there, such as tcp://127.0.0.1:8786 (extra dask)",
    )
    files = parser.add_argument_group("samples")
    files.add_argument(
        "--out", metavar="FILE", type=file_name, help="write every sample to a CSV file, a row each"
    )
    files.add_argument("--force", action="store_true", help="overwrite a file that this command did not make")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Differentiates, draws, and shows what spreads and why."""
    import time

    from tfsat_host.cli.sensitivity_files import check_samples_file, write_samples
    from tfsat_host.cli.sensitivity_words import result_of, show
    from tfsat_host.cli.simulate_notices import ERROR_DEG
    from tfsat_host.maneuver.servo_speed import servo_speed_notices
    from tfsat_host.plan.parameters import Parameters
    from tfsat_host.plan.sources import error_sources
    from tfsat_host.plan.statistics import summary
    from tfsat_host.plan.study import Study, derivatives, linear_spread
    from tfsat_host.robot import load_robot

    rate = initial_rate_rad_s(args)
    robot = load_robot(args.robot)
    stated = _stated(args, robot)
    schedule = _schedule(args, robot)
    notices = [*schedule.notices, *servo_speed_notices(schedule, robot.path)]
    limits = _time_limits(args, robot)
    parameters = Parameters.of(robot, _plan(robot, schedule), rate)
    if args.out is not None:
        check_samples_file(args.out, force=args.force)
    sources = error_sources(parameters, stated)
    found = derivatives(parameters)
    study = Study(parameters, sources, args.samples, args.seed)
    for notice in notices:
        out.warn(notice)
    begun_s = time.perf_counter()
    outcomes = _outcomes(args, study, out)
    seconds = time.perf_counter() - begun_s
    result = result_of(
        study,
        found,
        linear_spread(found, sources),
        summary(study, outcomes, found.quaternion_xyzw, limits),
    )
    error_deg = math.degrees(max(found.error_rad, outcomes.error_rad))
    if error_deg > ERROR_DEG:
        notices.append(
            f"An attitude may be wrong by {error_deg:.2g} deg by the error of the integration: give a lower "
            "--initial-rate, or a maneuver that ends earlier."
        )
        out.warn(notices[-1])
    result |= _circumstances(args, robot, schedule, stated) | {"notices": notices, "seconds": seconds}
    result["integration_error_deg"] = error_deg
    if args.out is not None:
        write_samples(study, outcomes, found.quaternion_xyzw, args.out, force=args.force)
    result["files"] = {} if args.out is None else {"csv": str(args.out)}
    out.result(result, partial(show, result, out))
    return 0


def _outcomes(args: argparse.Namespace, study: Study, out: Output) -> Outcomes:
    from contextlib import nullcontext

    where = f"on {args.dask}" if args.dask is not None else "on this computer"
    showing = (
        nullcontext(lambda _amount: None)
        if study.samples < _WORTH_PROGRESS
        else out.progress(f"Flying {study.samples} robots {where}", study.samples)
    )
    with showing as advance:
        if args.dask is not None:
            from tfsat_host.plan.cluster import run_on_cluster

            return run_on_cluster(study, args.dask, progress=advance)
        from tfsat_host.plan.study import run_locally

        return run_locally(study, workers=args.workers, progress=advance)


def _schedule(args: argparse.Namespace, robot: RobotModel) -> Schedule:
    """The strokes by the robot's own limits, as `simulate` takes them, but one at least: at rest nothing is unsure.

    Raises:
        ManeuverError: there is none, or the robot cannot fly them.
    """
    from tfsat_host.dynamics.flying import robot_limits

    limits = replace(robot_limits(robot), strokes_min=1)
    return schedule_from(args, robots_maneuver(args, robot), limits)


def _plan(robot: RobotModel, schedule: Schedule) -> Plan:
    """The schedule as its servos are told it; looked at when `simulate` looks: at the landing or later."""
    from tfsat_host.plan.parameters import Plan, PlannedStroke
    from tfsat_host.protocol.limits import FALL_US
    from tfsat_host.units import s_from_us

    strokes = [PlannedStroke(s.joint - 1, math.radians(s.angle_deg), s.t_s) for s in schedule.strokes]
    until_s = s_from_us(max(FALL_US, schedule.end_us))
    return Plan.of(robot, strokes, math.radians(schedule.speed_deg_s), until_s=until_s)


def _stated(args: argparse.Namespace, robot: RobotModel) -> Uncertainty:
    from tfsat_host.plan.sources import overridden

    if robot.uncertainty is None and not args.sigma:
        raise UsageError(
            what=f"{robot.path} states no uncertainty.",
            meaning="Nothing was computed: without standard deviations there is nothing to draw.",
            next_step="Add a table [uncertainty] to the file, or state some: --sigma com_mm=3 --sigma stroke_deg=1",
        )
    return overridden(robot.uncertainty, dict(args.sigma))


def _time_limits(args: argparse.Namespace, robot: RobotModel) -> tuple[TimeLimit, ...]:
    """The facility's; none for a robot that no sequencer commands, unless a facility is named."""
    from tfsat_host.plan.facility import load_tower
    from tfsat_host.plan.statistics import TimeLimit

    if args.facility is None and any(servo.pulses is None for servo in robot.servos):
        return ()
    tower = load_tower(args.facility)
    planned_s = tower.maneuver_time_max_s
    return (
        TimeLimit("time for the strokes", False, planned_s),
        TimeLimit(
            "time for the strokes, with its tolerance", False, planned_s + tower.maneuver_time_tolerance_s
        ),
        TimeLimit("fall", True, tower.fall_s),
    )


def _circumstances(
    args: argparse.Namespace, robot: RobotModel, schedule: Schedule, stated: Uncertainty
) -> dict[str, Any]:
    from tfsat_host.plan.sources import as_stated

    return {
        "robot": robot.name,
        "base": robot.body_names[robot.base],
        "schedule": schedule.as_rows(),
        "speed_deg_s": schedule.speed_deg_s,
        "initial_rate_deg_s": args.initial_rate,
        "uncertainty": as_stated(stated),
    }


def _sigma(text: str) -> tuple[str, float]:
    """An argparse type: a key and a number. Raises ArgumentTypeError for anything else."""
    key, equals, value = text.partition("=")
    if not (equals and key):
        raise argparse.ArgumentTypeError(f"{text!r} is not KEY=VALUE, such as com_mm=2")
    return key.strip(), number(value.strip())


def _samples(text: str) -> int:
    """An argparse type: a number of samples. Raises ArgumentTypeError for none that is sensible."""
    low, high = _SAMPLES
    if not (text.isascii() and text.isdigit() and len(text) < 20 and low <= int(text) <= high):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no number of samples: write a whole number from {low} to {high}"
        )
    return int(text)


def _workers(text: str) -> int:
    """An argparse type: a number of processes. Raises ArgumentTypeError for none that is sensible."""
    if not (text.isascii() and text.isdigit() and 1 <= int(text) <= 256):
        raise argparse.ArgumentTypeError(f"{text!r} is no number of processes: write a whole number from 1")
    return int(text)
