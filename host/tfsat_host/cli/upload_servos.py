"""`tfsat-host upload-servos`: how the servos turn pulses into angles, checked, onto the sequencer."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.advice import device_option, offering_emulated
from tfsat_host.cli.options import add_device_options, file_name
from tfsat_host.errors import UsageError
from tfsat_host.present.output import Output
from tfsat_host.whole_file import write_whole

if TYPE_CHECKING:
    from tfsat_host.devices.sequencer import SequencerClient, StoredSettings
    from tfsat_host.servo_settings import ServoSettings

_UNCHANGED = "Nothing was sent; the board keeps its settings."


def configure(parser: argparse.ArgumentParser) -> None:
    """A file, or the factory's; or only a look at what is there; the device."""
    parser.description = (
        "Put servo settings on the sequencer: for each joint the pulse at 0 deg, the change for each degree, "
        "the direction and the limits. Checked, shown beside the old ones, stored, read back and compared. "
        "docs/servos.md describes the file and how to find the numbers."
    )
    group = parser.add_argument_group("settings")
    group.add_argument("file", metavar="FILE", nargs="?", type=file_name, help="settings' file (TOML)")
    group.add_argument("--factory", action="store_true", help="the firmware's own values instead of a file")
    group.add_argument("--show", action="store_true", help="only show what is on the board")
    group.add_argument(
        "--out", metavar="FILE", type=file_name, help="with --show: also write what is on the board to a file"
    )
    group.add_argument("--force", action="store_true", help="let --out overwrite a file")
    group.add_argument(
        "--dry-run", action="store_true", help="check and show the new settings; touch no board"
    )
    add_device_options(parser, "sequencer")


def run(args: argparse.Namespace, out: Output) -> int:
    """Shows, or checks, asks and uploads; a file is checked before a port is opened."""
    _check_usage(args)
    if args.show:
        return _show(args, out)
    settings, notices = _wanted(args)
    for notice in notices:
        out.warn(notice)
    if args.dry_run:
        return _dry_run(settings, notices, out)
    return _upload(settings, notices, args, out)


def _check_usage(args: argparse.Namespace) -> None:
    chosen = sum((args.file is not None, args.factory, args.show))
    if chosen != 1:
        raise UsageError(
            what="One of FILE, --factory and --show is needed, and only one.",
            meaning="Nothing was done.",
            next_step="tfsat-host upload-servos servos.toml   or   tfsat-host upload-servos --show",
        )
    if args.out is not None and not args.show:
        raise UsageError(
            what="--out writes what is on the board: it goes with --show only.",
            meaning="Nothing was done.",
            next_step=f"First tfsat-host upload-servos --show --out {args.out}, then the upload without --out.",
        )
    if args.dry_run and args.show:
        raise UsageError(
            what="--dry-run touches no board, and --show asks one.",
            meaning="Nothing was done.",
            next_step="tfsat-host upload-servos --show   or   tfsat-host upload-servos FILE --dry-run",
        )
    if args.out is not None and args.out.exists() and not args.force:
        raise UsageError(
            what=f"{args.out} exists already.",
            meaning="Nothing was overwritten.",
            next_step="Give another name to --out, or add --force to overwrite it.",
        )


def _wanted(args: argparse.Namespace) -> tuple[ServoSettings, list[str]]:
    from tfsat_host.servo_settings import FACTORY, read_settings_file

    return (FACTORY, []) if args.factory else read_settings_file(args.file)


def _show(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.cli.connection import open_sequencer
    from tfsat_host.cli.servo_words import comparison, origin_words

    with offering_emulated(), open_sequencer(args, out) as sequencer:
        stored = sequencer.settings()
        result = {**_stored_as_dict(stored), "device": _device(sequencer)}
    if args.out is not None:
        _write(stored.settings, args.out)
        out.note(f"Settings written to {args.out}")

    def tell() -> None:
        out.table(*comparison(stored.settings, None))
        out.line(f"On the board: {origin_words(stored.origin)}.")

    out.result(result, tell)
    return 0


def _write(settings: ServoSettings, path: Path) -> None:
    from tfsat_host.servo_settings import format_settings

    write_whole(path, format_settings(settings).encode())


def _dry_run(settings: ServoSettings, notices: list[str], out: Output) -> int:
    from tfsat_host.cli.servo_words import comparison, settings_as_dict

    def tell() -> None:
        out.table(*comparison(settings, None))
        out.line("Dry run: the board would accept these settings; nothing was sent.")

    result = {**settings_as_dict(settings), "verified": False, "device": None, "dry_run": True}
    out.result({**result, "notices": notices}, tell)
    return 0


def _upload(settings: ServoSettings, notices: list[str], args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.cli.connection import open_sequencer
    from tfsat_host.cli.servo_words import comparison, settings_as_dict
    from tfsat_host.servo_settings import find_misfit

    with offering_emulated(), open_sequencer(args, out) as sequencer:
        _insist_on_safe(sequencer)
        before = sequencer.settings()
        if settings != before.settings:
            out.table(*comparison(settings, before.settings))
            out.confirm("Store the new settings on the sequencer?", meaning=_UNCHANGED)
        with out.progress(f"uploading to {sequencer.port}"):
            done = sequencer.write_settings(settings)
        misfit = find_misfit(sequencer.read_back().moves, settings)
        if misfit is not None:
            out.warn(
                f"The maneuver on the board does not fit these settings: {misfit.words}. ARM will refuse it. "
                f"Upload one that fits: tfsat-host upload-sequence A B{device_option(args)}"
            )
        result = {
            **_stored_as_dict(done.stored),
            "before": settings_as_dict(before.settings),
            "verified": True,
            "written": done.written,
            "maneuver_fits": misfit is None,
            "device": _device(sequencer),
            "notices": notices,
        }
        already = "" if done.written else " (they were there already)"
        out.result(result, f"Stored, read back and identical{already}: {sequencer.identity.describe()}.")
    return 0


def _insist_on_safe(sequencer: SequencerClient) -> None:
    """Before anybody is asked: the board takes settings only while no servo is held by them."""
    from tfsat_host.devices.client import board_error
    from tfsat_host.protocol.enums import ErrorCode, SequencerState
    from tfsat_host.protocol.messages import ErrorReply, SettingsWriteRequest

    if sequencer.status().state != SequencerState.SAFE:
        raise board_error(ErrorReply(SettingsWriteRequest.TYPE, ErrorCode.WRONG_STATE, -1))


def _stored_as_dict(stored: StoredSettings) -> dict[str, Any]:
    from tfsat_host.cli.servo_words import settings_as_dict

    return {
        "origin": stored.origin.name.lower(),
        "generation": stored.generation,
        **settings_as_dict(stored.settings),
    }


def _device(sequencer: SequencerClient) -> dict[str, str | None]:
    return {"port": sequencer.port, **sequencer.identity.as_dict()}
