"""`tfsat-host calibrate servo`: which angle each pulse leads to, and settings that make the board's angles true."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from tfsat_host.calibration.review import CERTIFICATE
from tfsat_host.calibration.servos.servo_findings import (
    MAP,
    MAP_FACTS,
    PLACES,
    RESIDUALS,
    VISITS,
    ServoVisit,
    average_places,
    commanded_deg,
    predict_residuals,
)
from tfsat_host.calibration.servos.servo_map import ServoMap, settings_from_map
from tfsat_host.calibration.servos.visits import at_stops, require_zero, servo_points
from tfsat_host.calibration.session import RESUME_WITHIN, recent
from tfsat_host.calibration.steps.step import servo as servo_step
from tfsat_host.cli.boards import warn_of_misfit
from tfsat_host.cli.calibrate.arguments import commands_as_typed, resume_command
from tfsat_host.cli.calibrate.bench import Bench, open_bench
from tfsat_host.cli.calibrate.flow import open_campaign
from tfsat_host.cli.calibrate.jogged_joint import measure_servo
from tfsat_host.next_step import Advice
from tfsat_host.present.output import NotConfirmed, Output
from tfsat_host.present.stored_settings import comparison, servo_words, settings_as_dict
from tfsat_host.present.terminal import sentences, show_facts, show_table
from tfsat_host.quantity import Table, record, records
from tfsat_host.robot import load_robot
from tfsat_host.servo_settings import ServoSettings


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures, keeps the evidence, shows the map, and puts the settings that follow from it on the board."""
    model = load_robot(args.robot)
    with commands_as_typed(args, out), open_bench(args, model, out, jog=True) as bench:
        campaign = open_campaign(args, bench.origin, model, out)
        before = bench.jog.settings().settings
        evidence = recent(campaign, servo_step(args.joint), RESUME_WITHIN) if args.resume else None
        if evidence is None:
            sensors = campaign.solution().joints[args.joint - 1]
            require_zero(sensors)
            evidence = measure_servo(args.joint, before, sensors, bench, model, out)
            campaign.accept(evidence)
        calibration = campaign.calibration
        if calibration is None:
            raise ValueError("nothing was accepted")
        servo_map = next(candidate for candidate in calibration.servo_maps if candidate.joint == args.joint)
        points = servo_points(evidence, calibration.joints, model)
        visits = [
            ServoVisit(point, commanded_deg(point.pulse_us, servo_map.setting), stopped)
            for point, stopped in zip(points, at_stops(points, args.joint, model), strict=True)
        ]
        _show_map(servo_map, visits, out)
        after = settings_from_map(servo_map, before)
        result = {
            "joint": args.joint,
            "points": records(VISITS, visits),
            "map": record(MAP, servo_map),
            **_upload(servo_map, before, after, bench, args, out),
            "file": campaign.certificate,
        }
        show_facts(CERTIFICATE, campaign, out)
    out.result(result)
    return 0


def _show_map(servo_map: ServoMap, visits: Sequence[ServoVisit], out: Output) -> None:
    places = average_places([visit.point for visit in visits], servo_map.setting)
    show_table(Table(f"Servo of joint {servo_map.joint}", PLACES, places), out)
    left_out = sum(visit.at_stop for visit in visits)
    if left_out:
        sentences([f"{left_out} visits left out: within 0.5 deg of the ends of the joint's range"], out)
    show_facts(MAP_FACTS, servo_map, out)


def _upload(
    servo_map: ServoMap,
    before: ServoSettings,
    after: ServoSettings,
    bench: Bench,
    args: argparse.Namespace,
    out: Output,
) -> dict[str, Any]:
    """Puts the new settings on the board unless `--no-upload`; says what error is left."""
    joint = servo_map.joint
    out.table(*comparison(after, before), title="Servo settings")
    residuals = predict_residuals(servo_map, after.of(joint))
    result = {
        "settings": {"before": settings_as_dict(before), "after": settings_as_dict(after)},
        "left": record(RESIDUALS, residuals),
        "uploaded": False,
        "verified": False,
    }
    if args.no_upload:
        out.line("Sequencer: settings unchanged. With the new ones:")
        show_facts(RESIDUALS, residuals, out)
        return result
    if after != before:
        try:
            out.confirm(
                "Store the new settings on the sequencer?",
                meaning="The measurement is kept; the sequencer keeps its servo settings. "
                f"By the calibration, joint {joint} needs {servo_words(after.of(joint))}.",
            )
        except NotConfirmed as error:
            next_step = Advice("To resume from the measurement: ", resume_command(args))
            raise error.with_words(next_step=next_step) from None
    upload = bench.jog.write_settings(after)
    fits = warn_of_misfit(bench.jog, after, out)
    already = " (there already)" if not upload.written else ""
    out.line(f"Sequencer: settings stored, read back identical{already}")
    show_facts(RESIDUALS, residuals, out)
    return {**result, "uploaded": upload.written, "verified": True, "maneuver_fits": fits}
