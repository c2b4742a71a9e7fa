"""`tfsat-host upload-sequence`: a maneuver, checked whole, onto the sequencer."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.options import accept_negative_numbers, add_device_options, file_name, number
from tfsat_host.cli.output import Output
from tfsat_host.errors import UsageError

if TYPE_CHECKING:
    from tfsat_host.maneuver import Maneuver, Schedule

_EXAMPLE = "tfsat-host upload-sequence 59 70"


def configure(parser: argparse.ArgumentParser) -> None:
    """Two angles, or a file; what else concerns the maneuver; the device."""
    parser.description = (
        "Put a maneuver on the sequencer: checked whole, sent, read back and compared. "
        "A B means the closed loop +A joint 1, +B joint 2, -A joint 1, -B joint 2, in degrees."
    )
    accept_negative_numbers(parser)
    maneuver = parser.add_argument_group("maneuver")
    maneuver.add_argument("a_deg", metavar="A", nargs="?", type=number, help="angle of joint 1, deg, to 0.01")
    maneuver.add_argument("b_deg", metavar="B", nargs="?", type=number, help="angle of joint 2, deg, to 0.01")
    maneuver.add_argument(
        "--file", metavar="FILE", type=file_name, help="take the strokes from a maneuver file (TOML)"
    )
    maneuver.add_argument(
        "--speed", metavar="DEG_S", type=number, help="average joint speed of A B, deg/s (default 170)"
    )
    maneuver.add_argument("--out", metavar="FILE", type=file_name, help="also write the maneuver to a file")
    maneuver.add_argument("--force", action="store_true", help="let --out overwrite a file")
    maneuver.add_argument(
        "--dry-run", action="store_true", help="check and show the schedule; touch no board"
    )
    add_device_options(parser, "sequencer")


def run(args: argparse.Namespace, out: Output) -> int:
    """Checks, shows and uploads; everything is checked before a port is opened."""
    from tfsat_host.maneuver.servo_speed import servo_speed_notices

    maneuver = _maneuver(args)
    schedule = _schedule(args, maneuver)
    too_fast = servo_speed_notices(schedule)
    notices = (*schedule.notices, *too_fast)
    for notice in notices:
        out.warn(notice)
    if args.out is not None:
        _write(maneuver, args.out, force=args.force)
        out.note(f"Maneuver written to {args.out}")
    result: dict[str, object] = {"schedule": schedule.as_rows(), "end_s": schedule.end_s}
    if args.dry_run:
        result |= {"verified": False, "device": None, "dry_run": True}
    else:
        from tfsat_host.cli.upload_device import upload

        result |= upload(schedule, args, out)
    result["notices"] = list(notices)
    out.result(result, lambda: _show(schedule, result, out, doubtful=bool(too_fast)))
    return 0


def _schedule(args: argparse.Namespace, maneuver: Maneuver) -> Schedule:
    """The checked schedule; an error of a maneuver from a file names the file."""
    from tfsat_host.maneuver import ManeuverError, schedule_maneuver

    try:
        return schedule_maneuver(maneuver)
    except ManeuverError as error:
        if args.file is None:
            raise
        raise error.in_file(str(args.file)) from error


def _maneuver(args: argparse.Namespace) -> Maneuver:
    """The maneuver that the arguments name: a file or two angles, never both."""
    from tfsat_host.maneuver import four_stroke, read_maneuver
    from tfsat_host.maneuver.maneuver import DEFAULT_SPEED_DEG_S

    if args.file is not None:
        if args.a_deg is not None or args.speed is not None:
            raise UsageError(
                what="--file was given together with angles or --speed: the file says both.",
                meaning="Nothing was done.",
                next_step=f"tfsat-host upload-sequence --file {args.file}",
            )
        return read_maneuver(args.file)
    if args.a_deg is None or args.b_deg is None:
        raise UsageError(
            what="Two angles are needed: A of joint 1 and B of joint 2.",
            meaning="Nothing was done.",
            next_step=f"{_EXAMPLE}   or   tfsat-host upload-sequence --file maneuver.toml",
        )
    return four_stroke(
        args.a_deg, args.b_deg, speed_deg_s=DEFAULT_SPEED_DEG_S if args.speed is None else args.speed
    )


def _write(maneuver: Maneuver, path: Path, *, force: bool) -> None:
    from tfsat_host.maneuver import write_maneuver

    if path.exists() and not force:
        raise UsageError(
            what=f"{path} exists already.",
            meaning="Nothing was overwritten and nothing was sent.",
            next_step="Give another name to --out, or add --force to overwrite it.",
        )
    write_maneuver(maneuver, path)


def _show(schedule: Schedule, result: Mapping[str, object], out: Output, *, doubtful: bool) -> None:
    rows = [(f"{s.t_s:.2f}", s.joint, f"{s.angle_deg:+.2f}") for s in schedule.strokes]
    out.table(("start / s", "joint", "turns by / deg"), rows)
    out.line(f"Ends {schedule.end_s:.2f} s after release, at {schedule.speed_deg_s:g} deg/s.")
    if result.get("dry_run"):
        verdict = "no check refuses the maneuver, but see the warning" if doubtful else "the maneuver may fly"
        out.line(f"Dry run: {verdict}; nothing was sent.")
    elif result.get("verified"):
        already = " (it was there already)" if result.get("written") is False else ""
        out.line(f"Uploaded, read back and identical{already}: {result['identity']}.")
