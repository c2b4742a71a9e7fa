"""`tfsat-host upload-sequence`: a maneuver, checked whole, onto the sequencer."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from tfsat_host.cli import maneuver_argument, stroke_errors
from tfsat_host.cli.boards import offering_emulated, open_sequencer
from tfsat_host.cli.usage import device, refuse_existing
from tfsat_host.maneuver import Maneuver, ManeuverError, Schedule, write_maneuver
from tfsat_host.maneuver.schedule import servo_speed_notices
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.run.files import MANEUVER, schedule_in
from tfsat_host.run.held_maneuver import keep_upload
from tfsat_host.servo_settings import ServoSettings, insist_on_fit

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
    notices = [*schedule.notices, *too_fast, *unknown]
    out.warn_each(notices)
    if args.out is not None:
        refuse_existing(args.out, force=args.force)
        write_maneuver(maneuver, args.out)
        out.note(f"Written: {args.out}")
    result: dict[str, object] = {"schedule": schedule.as_rows(), "end_s": schedule.end_s}
    expected = stroke_errors.Expectation()
    if args.dry_run:
        result |= {"verified": False, "device": None, "dry_run": True}
    else:
        uploaded, settings = _upload(maneuver, schedule, args, out)
        _warn_of_other_file(schedule, args, out)
        expected = stroke_errors.expect(schedule, servos, settings)
        out.warn_each(expected.notices)
        result |= {**uploaded, "expected": expected.rows}
    result["notices"] = [*notices, *expected.notices]
    out.result(result, lambda: _show(schedule, expected, result, out, doubtful=bool(too_fast)))
    return 0


def _upload(
    maneuver: Maneuver, schedule: Schedule, args: argparse.Namespace, out: Output
) -> tuple[dict[str, object], ServoSettings]:
    """Sends the schedule, has it read back and compared: what `--json` has of it, and the board's settings."""
    with offering_emulated(), open_sequencer(args, out) as sequencer:
        settings = sequencer.settings().settings
        insist_on_fit([(stroke.joint, stroke.angle_cdeg) for stroke in schedule.strokes], settings)
        with out.progress(f"Uploading to {sequencer.port}"):
            upload = sequencer.upload(schedule)
        keep_upload(maneuver, sequencer.identity.serial, upload.stored.crc, out.note)
        uploaded: dict[str, object] = {
            "verified": True,
            "written": upload.written,
            "identity": sequencer.identity.describe(),
            "device": sequencer.device(),
            "maneuver_crc": f"{upload.stored.crc:04x}",
            "generation": upload.stored.generation,
        }
        return uploaded, settings


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


def _show(
    schedule: Schedule,
    expected: stroke_errors.Expectation,
    result: Mapping[str, object],
    out: Output,
    *,
    doubtful: bool,
) -> None:
    rows = [(f"{s.t_s:.2f}", s.joint, f"{s.angle_deg:+.2f}") for s in schedule.strokes]
    columns = ("start / s", "joint", "turns by / deg")
    if expected.rows is None:
        out.table(columns, rows)
    else:
        cells = [(*row, *expected.cells(number)) for number, row in enumerate(rows, 1)]
        out.table((*columns, *stroke_errors.COLUMNS), cells)
        out.line(
            "A stroke misses by the angle reached minus the angle commanded; std is that of a single drop."
        )
    out.line(f"Ends {schedule.end_s:.2f} s after release, at {schedule.speed_deg_s:g} deg/s.")
    if result.get("dry_run"):
        verdict = "all checks passed, but see the warning" if doubtful else "all checks passed"
        out.line(f"Dry run: {verdict}; nothing was sent.")
    elif result.get("verified"):
        already = " (unchanged)" if result.get("written") is False else ""
        out.line(f"Uploaded, read back and identical{already}: {result['identity']}")
