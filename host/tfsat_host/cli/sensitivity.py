"""`tfsat-host sensitivity`: the uncertainty of a maneuver's rotation, by parameter."""

from __future__ import annotations

import argparse
import time

from tfsat_host.cli import maneuver_argument as given
from tfsat_host.cli.usage import FORCE, FULL, INITIAL_RATE, OUTPUT, ROBOT, number, seed, whole_number
from tfsat_host.maneuver.schedule import servo_speed_notices
from tfsat_host.plan.facility import load_tower
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show, show_facts
from tfsat_host.quantity import record

_USAGE = f"""
Derivatives of a maneuver's rotation by every parameter of the robot model, and a Monte Carlo study over the
uncertainties that the robot file states. {given.WHAT_A_B_MEANS} docs/sensitivity.md explains it.

{given.maneuver_usage(given.SERVOS_SPEED)}
robot, release and facility:
{ROBOT}
{given.CALIBRATION}
{INITIAL_RATE}
--facility FILE    a facility file, whose times the maneuver must keep (default: COSMOTORRE's, for a robot that the
                   sequencer commands)
Monte Carlo:
--samples N        robots to draw (default 10000)
--seed N           seed of the draws (default 0)
--sigma KEY=VALUE  another standard deviation than the robot file's, such as com_mm=2 or stroke_relative=0; once for
                   each
| --workers N      processes at most (default: one a core)
| --dask ADDRESS   compute on the Dask cluster whose scheduler is there, such as tcp://127.0.0.1:8786 (extra dask)
samples:
--out FILE         write every sample to a CSV file, a row each
{FORCE}
{OUTPUT}
{FULL}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for maneuver, robot, uncertainties and computation."""
    samples, workers = whole_number("samples", 2, 1_000_000), whole_number("processes", 1, 256)
    sigma = {"type": _sigma, "action": "append", "default": []}
    given.add_maneuver_options(parser, _USAGE, samples=samples, seed=seed, sigma=sigma, workers=workers)
    parser.set_defaults(samples=10_000, seed=0)


def run(args: argparse.Namespace, out: Output) -> int:
    """Differentiates, draws, and shows what spreads and why."""
    from tfsat_host.dynamics.simulation import robot_limits
    from tfsat_host.plan.cluster import run_study
    from tfsat_host.plan.error_sources import error_sources, uncertainty_of
    from tfsat_host.plan.parameters import Parameters, Plan
    from tfsat_host.plan.samples_file import check_samples_file, write_samples
    from tfsat_host.plan.spread import derivatives, linear_spread, summary, time_limits
    from tfsat_host.plan.study import Study
    from tfsat_host.plan.study_result import StudyResult
    from tfsat_host.plan.study_tables import FACTS, STUDY, detail_tables, overview_tables

    rate = given.initial_rate_rad_s(args)
    robot = given.robot_from(args, out)
    stated = uncertainty_of(robot, dict(args.sigma))
    schedule = given.schedule_from(args, given.maneuver_from(args, robot), robot_limits(robot, strokes_min=1))
    notices = (*schedule.notices, *servo_speed_notices(schedule, robot.path))
    in_a_tower = args.facility is not None or robot.has_sequencer
    limits = time_limits(load_tower(args.facility)) if in_a_tower else ()
    parameters = Parameters.of(robot, Plan.of_schedule(robot, schedule), rate)
    if args.out is not None:
        check_samples_file(args.out, force=args.force)
    linearization = derivatives(parameters)
    study = Study(parameters, error_sources(parameters, stated), args.samples, args.seed)
    out.warn_each(notices)
    begun_s = time.perf_counter()
    outcomes = run_study(study, out, workers=args.workers, address=args.dask)
    result = StudyResult(
        robot,
        schedule,
        args.initial_rate,
        stated,
        study,
        linearization,
        linear_spread(linearization, study.sources),
        summary(study, outcomes, linearization.quaternion_xyzw, limits),
        outcomes,
        time.perf_counter() - begun_s,
        notices,
        args.out,
        args.calibration,
    )
    out.warn_each(result.doubts)
    if args.out is not None:
        write_samples(study, outcomes, linearization.quaternion_xyzw, args.out, force=args.force)

    def show_result() -> None:
        show_facts(FACTS, result, out)
        show(overview_tables(result), out)
        if args.full:
            show(detail_tables(result), out)
        else:
            out.line("Kinds of errors, quantiles, histogram: the same command with --full")

    out.result(record(STUDY, result), show_result)
    return 0


def _sigma(text: str) -> tuple[str, float]:
    """Parse KEY=VALUE into a key and a number (argparse type). Raises ArgumentTypeError otherwise."""
    key, equals, value = text.partition("=")
    if not (equals and key):
        raise argparse.ArgumentTypeError(f"{text!r} is not KEY=VALUE, such as com_mm=2")
    return key.strip(), number(value.strip())
