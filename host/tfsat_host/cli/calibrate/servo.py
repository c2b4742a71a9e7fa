"""`tfsat-host calibrate servo`: which angle each pulse leads to, and settings that make the board's angles true."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.calibrate.jog import ask_to_move, drive
from tfsat_host.cli.calibrate.jog_bench import JogBench, add_sequencer_port, open_jog_bench
from tfsat_host.cli.calibrate.options import add_campaign_options, add_joint_option, as_typed_here, resuming
from tfsat_host.present.output import NotConfirmed, Output

if TYPE_CHECKING:
    from tfsat_host.calibration.sensors.joint_sensors import JointSensors
    from tfsat_host.calibration.servos.servo_map import ServoMap
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.robot import RobotModel
    from tfsat_host.servo_settings import ServoSettings


def configure(parser: argparse.ArgumentParser) -> None:
    """Which joint, whether the board gets the new settings, the certificate, both boards."""
    add_joint_option(parser, required=True)
    parser.add_argument(
        "--no-upload", action="store_true", help="measure only: the sequencer keeps its servo settings"
    )
    add_sequencer_port(parser)
    add_campaign_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures, keeps the evidence, shows the map, and puts the settings that follow from it on the board."""
    from tfsat_host.calibration.servos.reached import at_stops, require_zero, servo_points
    from tfsat_host.calibration.servos.servo_map import settings_from_map
    from tfsat_host.calibration.steps.step import servo as servo_step
    from tfsat_host.cli.calibrate.campaign import keep, open_campaign
    from tfsat_host.cli.calibrate.flow import RESUME_WITHIN, recent
    from tfsat_host.cli.calibrate.servo_words import map_as_dict, points_as_dicts, show_map
    from tfsat_host.robot import load_robot

    model = load_robot(args.robot)
    with _typed_as_here(args, out), open_jog_bench(args, model, out) as bench:
        campaign = open_campaign(args, bench.origin, model, out)
        before = bench.sequencer.settings().settings
        evidence = recent(campaign, servo_step(args.joint), RESUME_WITHIN) if args.resume else None
        if evidence is None:
            sensors = campaign.solution().joints[args.joint - 1]
            require_zero(sensors)
            evidence = measure(args.joint, before, sensors, bench, model, out)
            keep(campaign, evidence, args)
        calibration = campaign.calibration
        if calibration is None:
            raise ValueError("nothing was accepted")
        servo_map = next(one for one in calibration.servo_maps if one.joint == args.joint)
        points = servo_points(evidence, calibration.joints, model)
        stopped = at_stops(points, args.joint, model)
        show_map(servo_map, points, stopped, out)
        out.line(f"Written to {campaign.certificate}.")
        after = settings_from_map(servo_map, before)
        result = {
            "joint": args.joint,
            "points": points_as_dicts(points, stopped, servo_map.setting),
            "map": map_as_dict(servo_map),
            **_upload(servo_map, before, after, bench, args, out),
            "file": campaign.certificate,
        }
    out.result(result)
    return 0


def measure(
    joint: int,
    settings: ServoSettings,
    sensors: JointSensors,
    bench: JogBench,
    model: RobotModel,
    out: Output,
) -> Evidence:
    """Asks, and has the servo visit each place of the plan; the joint ends limp.

    A joint that does not follow, or goes the wrong way, is let go at the first stop that shows it.

    Args:
        joint: 1 to 3.
        settings: In force on the sequencer.
        sensors: Of the joint, with a measured zero point.
        bench: Both boards.
        model: The robot.
        out: Where questions and progress go.

    Raises:
        RefusedError: it was not confirmed, or the joint is not where it should begin.
        CalibrationError: the servo does not follow.
        BoardRefusal, JogError, TfsatError: see `jog.drive`.
    """
    from datetime import UTC, datetime

    from tfsat_host.calibration.servos.points import HOLD_S, servo_plan
    from tfsat_host.calibration.servos.visits import Visits
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.calibration.steps.step import servo as servo_step
    from tfsat_host.devices.jogging import JogTour

    servo = settings.of(joint)
    plan = servo_plan(servo)
    tour = JogTour(joint, (plan[0], *plan), HOLD_S)  # at first the servo only takes hold of the joint
    step = servo_step(joint)
    ask_to_move(step, tour, bench, out)
    visits = Visits(tour.stops_cdeg, servo, sensors, model)
    taken = datetime.now(UTC)
    driven = drive(tour, step, bench, out, visits.check_start, visits.rested)
    counts = Counts.from_live(driven.samples, driven.scales)
    if counts.samples_lost:
        out.warn(f"{counts.samples_lost} of {len(counts.t_us) + counts.samples_lost} samples never arrived.")
    setting = (servo.zero_us, servo.ns_per_deg, servo.reversed)
    return Evidence(step, counts, taken, bench.origin, visits=visits.known, servo_setting=setting)


def _upload(
    servo_map: ServoMap,
    before: ServoSettings,
    after: ServoSettings,
    bench: JogBench,
    args: argparse.Namespace,
    out: Output,
) -> dict[str, Any]:
    """Puts the new settings on the board unless told otherwise; says what error is left."""
    from dataclasses import asdict

    from tfsat_host.calibration.servos.figures import left_by
    from tfsat_host.cli.calibrate.servo_words import left_words, show_settings
    from tfsat_host.cli.servo_words import servo_words, settings_as_dict
    from tfsat_host.servo_settings import find_misfit

    joint = servo_map.joint
    show_settings(before, after, out)
    words = left_words(servo_map, after.of(joint))
    result = {
        "settings": {"before": settings_as_dict(before), "after": settings_as_dict(after)},
        "left": asdict(left_by(servo_map, after.of(joint))),
        "uploaded": False,
        "verified": False,
    }
    if args.no_upload:
        out.line(f"The sequencer keeps its settings. With the new ones {words}")
        return result
    if after != before:
        try:
            out.confirm(
                "Store the new settings on the sequencer?",
                meaning="The measurement is kept; the sequencer keeps its servo settings. "
                f"By the calibration, joint {joint} needs {servo_words(after.of(joint))}.",
            )
        except NotConfirmed as error:
            error.next_step = f"To go on from the measurement: {resuming(args)}"
            raise
    done = bench.sequencer.write_settings(after)
    misfit = find_misfit(bench.sequencer.read_back().moves, after)
    if misfit is not None:
        at = "" if args.sequencer_port is None else f" --port {args.sequencer_port}"
        out.warn(
            f"The maneuver on the board does not fit these settings: {misfit.words}. ARM will refuse it. "
            f"Upload one that fits: tfsat-host upload-sequence A B{' --emulated' if args.emulated else at}"
        )
    already = "" if done.written else " (they were there already)"
    out.line(f"Settings stored on the sequencer, read back and identical{already}: now {words}")
    return {**result, "uploaded": done.written, "verified": True, "maneuver_fits": misfit is None}


@contextmanager
def _typed_as_here(args: argparse.Namespace, out: Output) -> Iterator[None]:
    """Gives the commands that an error names this command's certificate and devices."""
    from tfsat_host.cli.calibrate.campaign import NotKept
    from tfsat_host.errors import TfsatError

    try:
        yield
    except KeyboardInterrupt:
        if not out.json_mode:
            out.note("")  # behind the prompt, and the terminal's ^C
        raise
    except (NotConfirmed, NotKept):  # what they name is complete
        raise
    except TfsatError as error:
        error.next_step = as_typed_here(error.next_step, args)
        raise
