"""`tfsat-host calibrate servo`: which angle each pulse leads to, and settings that make the board's angles true."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tfsat_host.calibration.review import CERTIFICATE
from tfsat_host.calibration.servos.servo_findings import (
    MAP,
    MAP_FACTS,
    PLACES,
    RESIDUALS,
    VISITS,
    ServoResiduals,
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
from tfsat_host.present.stored_settings import SERVO_SETTINGS, comparison, servo_words
from tfsat_host.present.terminal import sentences, show_facts, show_table
from tfsat_host.quantity import Column, Columns, Table, fields, record
from tfsat_host.robot.absent_parts import load_robot_of_boards, require_joint
from tfsat_host.servo_settings import ServoSettings


@dataclass(frozen=True, eq=False)
class UploadedSettings:
    """Settings that the board has stored now: whether they are others than before, and fit its maneuver."""

    written: bool
    maneuver_fits: bool


@dataclass(frozen=True, eq=False)
class ServoResult:
    """A servo that was measured.

    Attributes:
        joint: 1 to 3.
        visits: Where it was.
        servo_map: From pulses to angles.
        before: Settings that the board had.
        after: Settings that follow from the map.
        file: The certificate.
        uploaded: None: the board keeps its settings.
    """

    joint: int
    visits: Sequence[ServoVisit]
    servo_map: ServoMap
    before: ServoSettings
    after: ServoSettings
    file: Path
    uploaded: UploadedSettings | None = None

    @property
    def residuals(self) -> ServoResiduals:
        """What deviations the new settings leave."""
        return predict_residuals(self.servo_map, self.after.of(self.joint))


_SETTINGS: Columns = (Column("before", columns=SERVO_SETTINGS), Column("after", columns=SERVO_SETTINGS))
_MEASURED: Columns = (
    *fields("joint"),
    Column("points", of="visits", columns=VISITS),
    Column("map", of="servo_map", columns=MAP),
    Column("settings", of=lambda result: result, columns=_SETTINGS),
    Column("left", of="residuals", columns=RESIDUALS),
    Column("uploaded", of=lambda result: result.uploaded is not None and result.uploaded.written),
    Column("verified", of=lambda result: result.uploaded is not None),
    *fields("file"),
)
_UPLOADED: Columns = (*_MEASURED, *fields("maneuver_fits=uploaded.maneuver_fits"))


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures, keeps the evidence, shows the map, and puts the settings that follow from it on the board."""
    model = load_robot_of_boards(args.robot)
    require_joint(model, args.joint)
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
        result = ServoResult(args.joint, visits, servo_map, before, after, campaign.certificate)
        result = replace(result, uploaded=_upload(result, bench, args, out))
        show_facts(CERTIFICATE, campaign, out)
    out.result(record(_UPLOADED if result.uploaded else _MEASURED, result))
    return 0


def _show_map(servo_map: ServoMap, visits: Sequence[ServoVisit], out: Output) -> None:
    places = average_places([visit.point for visit in visits], servo_map.setting)
    show_table(Table(f"Servo of joint {servo_map.joint}", PLACES, places), out)
    left_out = sum(visit.at_stop for visit in visits)
    if left_out:
        sentences([f"{left_out} visits left out: within 0.5 deg of the ends of the joint's range"], out)
    show_facts(MAP_FACTS, servo_map, out)


def _upload(
    result: ServoResult, bench: Bench, args: argparse.Namespace, out: Output
) -> UploadedSettings | None:
    """Puts the new settings on the board unless `--no-upload`; says what error is left."""
    before, after = result.before, result.after
    out.table(*comparison(after, before), title="Servo settings")
    if args.no_upload:
        out.line("Sequencer: settings unchanged. With the new ones:")
        show_facts(RESIDUALS, result.residuals, out)
        return None
    if after != before:
        try:
            out.confirm(
                "Store the new settings on the sequencer?",
                meaning="The measurement is kept; the sequencer keeps its servo settings. "
                f"By the calibration, joint {result.joint} needs {servo_words(after.of(result.joint))}.",
            )
        except NotConfirmed as error:
            next_step = Advice("To resume from the measurement: ", resume_command(args))
            raise error.with_words(next_step=next_step) from None
    upload = bench.jog.write_settings(after)
    fits = warn_of_misfit(bench.jog, after, out)
    already = "" if upload.written else " (there already)"
    out.line(f"Sequencer: settings stored, read back identical{already}")
    show_facts(RESIDUALS, result.residuals, out)
    return UploadedSettings(upload.written, fits)
