"""`tfsat-host upload-servos`: how the servos turn pulses into angles, checked, onto the sequencer."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

from tfsat_host import servo_settings
from tfsat_host.cli.boards import offering_emulated, open_sequencer, warn_of_misfit
from tfsat_host.cli.usage import add_options, device, refuse_existing
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.sequencer import StoredSettings, Upload
from tfsat_host.errors import UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.stored_settings import SERVO_SETTINGS, STORED_SETTINGS, comparison, origin_words
from tfsat_host.quantity import Column, Columns, columns_of, fields, record
from tfsat_host.whole_file import write_whole

_USAGE = f"""
Put servo settings on the sequencer: for each joint the pulse at 0 deg, the change for each degree, the direction and
the limits. Checked, shown with the old ones, stored, read back and compared. docs/servos.md describes the file and how
to find the numbers.

settings:
[FILE]      settings' file (TOML)
--factory   the firmware's own values instead of a file
--show      only show what is on the board
--out FILE  with --show: also write what is on the board to a file
--force     let --out overwrite a file
--dry-run   check and show the new settings; touch no board
{device("sequencer")}"""


@dataclass(frozen=True, slots=True)
class CheckedSettings:
    """Settings that the board would take, and what a person should know of them."""

    settings: servo_settings.ServoSettings
    notices: Sequence[str]


@dataclass(frozen=True, slots=True)
class ReadSettings:
    """What a board has stored."""

    stored: StoredSettings
    device: Device


@dataclass(frozen=True, slots=True)
class UploadedSettings:
    """Settings that a board has stored now.

    Attributes:
        upload: What it has stored.
        before: What it had before.
        maneuver_fits: The maneuver on the board fits them.
        device: The board.
        notices: What a person should know; sentences.
    """

    upload: Upload[StoredSettings]
    before: servo_settings.ServoSettings
    maneuver_fits: bool
    device: Device
    notices: Sequence[str]


_DRY_RUN: Columns = (
    *columns_of("settings", SERVO_SETTINGS),
    Column("verified", of=lambda _: False),
    Column("device", of=lambda _: None),
    Column("dry_run", of=lambda _: True),
    *fields("notices"),
)
_READ: Columns = (*columns_of("stored", STORED_SETTINGS), Column("device", columns=DEVICE))
_UPLOADED: Columns = (
    *columns_of("upload", columns_of("stored", STORED_SETTINGS)),
    Column("before", columns=SERVO_SETTINGS),
    Column("verified", of=lambda _: True),
    *fields("written=upload.written maneuver_fits notices"),
    Column("device", columns=DEVICE),
)
_SHOW = NextStep("upload-servos", ("--show",))


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for settings (a file, the factory's, or only to show them) and the device."""
    add_options(parser, _USAGE)


def run(args: argparse.Namespace, out: Output) -> int:
    """Shows, or checks, asks and uploads; a file is checked before a port is opened."""
    _check_usage(args)
    if args.show:
        return _show(args, out)
    settings, notices = servo_settings.FACTORY, list[str]()
    if args.file is not None:
        settings, notices = servo_settings.read_settings_file(args.file)
    out.warn_each(notices)
    if not args.dry_run:
        return _upload(settings, notices, args, out)

    dry = "Dry run: the board would accept these settings; nothing was sent."
    result = CheckedSettings(settings, notices)
    out.result(record(_DRY_RUN, result), lambda: _show_table(settings, dry, out))
    return 0


def _show_table(settings: servo_settings.ServoSettings, line: str, out: Output) -> None:
    out.table(*comparison(settings, None))
    out.line(line)


def _check_usage(args: argparse.Namespace) -> None:
    if sum((args.file is not None, args.factory, args.show)) != 1:
        what = "One of FILE, --factory and --show is needed, and only one."
        next_step = Advice(NextStep("upload-servos", ("servos.toml",)), ", or ", _SHOW)
    elif args.out is not None and not args.show:
        what = "--out writes what is on the board: it goes with --show only."
        show = NextStep("upload-servos", ("--show", "--out", str(args.out)))
        next_step = Advice("First ", show, ", then the upload without --out.")
    elif args.dry_run and args.show:
        what = "--dry-run touches no board, and --show asks one."
        next_step = Advice(_SHOW, ", or ", NextStep("upload-servos", ("FILE", "--dry-run")))
    else:
        if args.out is not None:
            refuse_existing(args.out, force=args.force)
        return
    raise UsageError(what=what, meaning="Nothing was done.", next_step=next_step)


def _show(args: argparse.Namespace, out: Output) -> int:
    with offering_emulated(), open_sequencer(args, out) as sequencer:
        stored = sequencer.settings()
        result = ReadSettings(stored, sequencer.device())
    if args.out is not None:
        write_whole(args.out, servo_settings.format_settings(stored.settings).encode())
        out.note(f"Written: {args.out}")
    out.result(
        record(_READ, result),
        lambda: _show_table(stored.settings, f"On the board: {origin_words(stored.origin)}.", out),
    )
    return 0


def _upload(
    settings: servo_settings.ServoSettings, notices: list[str], args: argparse.Namespace, out: Output
) -> int:
    with offering_emulated(), open_sequencer(args, out) as sequencer:
        sequencer.insist_on_safe()  # before the question
        before = sequencer.settings()
        if settings != before.settings:
            out.table(*comparison(settings, before.settings))
            unchanged = "Nothing was sent; the board keeps its settings."
            out.confirm("Store the new settings on the sequencer?", meaning=unchanged)
        with out.progress(f"Uploading to {sequencer.port}"):
            upload = sequencer.write_settings(settings)
        fits = warn_of_misfit(sequencer, settings, out)
        result = UploadedSettings(upload, before.settings, fits, sequencer.device(), notices)
        already = "" if upload.written else " (they were there already)"
        out.result(
            record(_UPLOADED, result),
            f"Stored, read back and identical{already}: {sequencer.identity.describe()}.",
        )
    return 0
