"""`tfsat-host upload-sequence`: a maneuver, checked whole, onto the sequencer."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tfsat_host.cli import maneuver_argument, stroke_errors
from tfsat_host.cli.boards import offering_emulated, open_sequencer
from tfsat_host.cli.usage import device, refuse_existing
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.sequencer import StoredManeuver, Upload
from tfsat_host.exit_code import ExitCode
from tfsat_host.maneuver import Maneuver, ManeuverError, Schedule, write_maneuver
from tfsat_host.maneuver.schedule import STROKES, servo_speed_notices
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import Column, Columns, fields, record
from tfsat_host.run.files import MANEUVER, schedule_in
from tfsat_host.run.held_maneuver import keep_upload
from tfsat_host.servo_settings import ServoSettings, insist_on_fit

if TYPE_CHECKING:
    from tfsat_host.calibration.servos.servo_map import StrokeError


@dataclass(frozen=True, eq=False)
class UploadedSequence:
    """A maneuver that was checked, and uploaded unless this was a dry run.

    Attributes:
        schedule: Its strokes and their times.
        notices: What a person should know of it; sentences.
        doubtful: A stroke is faster than its servo, or the maneuver does not fit the drop tower.
        tower: Whether it does, in a line.
        device: The board that has it; None: a dry run.
        upload: What the board has stored; None: a dry run.
        expected: Errors of the strokes, as far as the joints have servo maps.
    """

    schedule: Schedule
    notices: Sequence[str]
    doubtful: bool
    tower: str
    device: Device | None = None
    upload: Upload[StoredManeuver] | None = None
    expected: tuple[StrokeError, ...] = ()


_CHECKED: Columns = (
    Column("schedule", of="schedule.strokes", columns=STROKES),
    *fields("end_s=schedule.end_s notices"),
    Column("device", columns=DEVICE),
)
_DRY_RUN: Columns = (*_CHECKED, Column("verified", of=lambda _: False), Column("dry_run", of=lambda _: True))
_UPLOADED: Columns = (
    *_CHECKED,
    Column("verified", of=lambda _: True),
    *fields("written=upload.written generation=upload.stored.generation"),
    Column("identity", of=lambda result: result.device.identity.describe()),
    Column("maneuver_crc", of=lambda result: f"{result.upload.stored.crc:04x}"),
    Column("expected", of=lambda result: result.expected or None, columns=stroke_errors.EXPECTED),
)
_USAGE = f"""
Put a maneuver on the sequencer: checked whole, sent, read back and compared. {maneuver_argument.WHAT_A_B_MEANS}

{maneuver_argument.maneuver_usage()}
--out FILE          also write the maneuver to a file
--force             let --out overwrite a file
--dry-run           check and show the schedule; touch no board
--calibration FILE  also show how far each stroke will miss, by this calibration's servo maps (default:
                    calibration.toml, with --emulated calibration-emulated.toml, where it is there)
{device("sequencer")}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the maneuver (two angles or a file), its other options, and the device."""
    maneuver_argument.add_maneuver_options(parser, _USAGE, nothing_done="Nothing was sent to the robot.")


def run(args: argparse.Namespace, out: Output) -> int:
    """Checks, shows and uploads; everything is checked before a port is opened."""
    maneuver = maneuver_argument.maneuver_from(args)
    schedule = maneuver_argument.schedule_from(args, maneuver)
    too_fast = servo_speed_notices(schedule)
    servos, unknown = stroke_errors.find_servo_maps(args)
    tower = _check_in_tower(maneuver)
    notices = [*schedule.notices, *too_fast, *tower.doubts, *unknown]
    out.warn_each(notices)
    if args.out is not None:
        refuse_existing(args.out, force=args.force)
        write_maneuver(maneuver, args.out)
        out.note(f"Written: {args.out}")
    result = UploadedSequence(schedule, notices, doubtful=bool(too_fast or tower.doubts), tower=tower.verdict)
    if not args.dry_run:
        device, upload, settings = _upload(maneuver, schedule, args, out)
        _warn_of_other_file(schedule, args, out)
        expected = stroke_errors.expect(schedule, servos, settings)
        out.warn_each(expected.notices)
        result = replace(
            result,
            notices=[*notices, *expected.notices],
            device=device,
            upload=upload,
            expected=expected.errors,
        )
    out.result(record(_DRY_RUN if args.dry_run else _UPLOADED, result), lambda: _show(result, out))
    return ExitCode.DATA_LOSS if result.doubtful else 0


class _InTower(NamedTuple):
    """A verdict in a line, and a sentence for each check of the drop tower that failed."""

    verdict: str
    doubts: list[str]


def _check_in_tower(maneuver: Maneuver) -> _InTower:
    """Run the checks of `envelope` and `design`; a maneuver that does not pass them may be uploaded all the same."""
    from tfsat_host.plan.checked_maneuver import check_design
    from tfsat_host.robot import load_robot

    checked = check_design(load_robot(), maneuver, Path(MANEUVER))
    doubts = [f"The check {check.name} failed: {check.sentence}" for check in checked.failed]
    if checked.collision:
        doubts.append(checked.collision)
    return _InTower("" if checked.tower is None else checked.tower.verdict, doubts)


def _upload(
    maneuver: Maneuver, schedule: Schedule, args: argparse.Namespace, out: Output
) -> tuple[Device, Upload[StoredManeuver], ServoSettings]:
    """Sends the schedule, has it read back and compared: by which board, and the board's settings."""
    with offering_emulated(), open_sequencer(args, out) as sequencer:
        settings = sequencer.settings().settings
        insist_on_fit(schedule.strokes, settings, args.file)
        with out.progress(f"Uploading to {sequencer.port}"):
            upload = sequencer.upload(schedule)
        keep_upload(maneuver, sequencer.identity.serial, upload.stored.crc, out.note)
        return sequencer.device(), upload, settings


def _warn_of_other_file(schedule: Schedule, args: argparse.Namespace, out: Output) -> None:
    """Warn if `maneuver.toml` in this folder commands another motion than the one uploaded.

    It would be taken for what is on the board now.
    """
    here = Path(MANEUVER)
    try:
        if not here.is_file() or schedule_in(here).is_same_motion(schedule):
            return
    except ManeuverError as error:
        out.warn(f"{error.what} Preflight and evaluate read it in this folder.")
        return
    if args.file is not None:
        maneuver_words = ("--file", str(args.file))
    else:
        speed = () if args.speed is None else ("--speed", f"{args.speed:g}")
        maneuver_words = (f"{args.a_deg:g}", f"{args.b_deg:g}", *speed)
    out.warn(
        Advice(
            f"{here} in this folder is another maneuver: preflight will refuse it, and evaluate will not compare "
            "with it. To replace it: ",
            NextStep("upload-sequence", (*maneuver_words, "--out", str(here), "--force")),
        )
    )


def _show(result: UploadedSequence, out: Output) -> None:
    schedule = result.schedule
    if result.expected:
        errors = {error.stroke: error for error in result.expected}
        rows = [
            stroke_errors.ExpectedStroke(stroke, errors.get(number))
            for number, stroke in enumerate(schedule.strokes, 1)
        ]
        show_rows(stroke_errors.EXPECTED_STROKES, rows, out)
        out.line(
            "A stroke misses by the angle reached minus the angle commanded; std is that of a single drop."
        )
    else:
        show_rows(STROKES, schedule.strokes, out)
    at_once = schedule.moving_at_once
    together = f", up to {at_once} joints at once (servo settings: moving_at_once)" if at_once > 1 else ""
    out.line(f"Ends {schedule.end_s:.2f} s after release, at {schedule.speed_deg_s:g} deg/s{together}.")
    if result.tower:
        out.line(f"{result.tower}.")
    if result.device is None or result.upload is None:
        verdict = "the board would take it, but see the warning" if result.doubtful else "all checks passed"
        out.line(f"Dry run: {verdict}; nothing was sent.")
    else:
        already = "" if result.upload.written else " (unchanged)"
        out.line(f"Uploaded, read back and identical{already}: {result.device.identity.describe()}")
