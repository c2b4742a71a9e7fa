"""`tfsat-host decode`: the card's recording in engineering units, and what is missing from it."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.decoded_files import FORMATS
from tfsat_host.cli.event_words import event_words
from tfsat_host.cli.options import add_output_options
from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError

if TYPE_CHECKING:
    pass

_VERDICTS = {
    "complete": "complete: nothing is missing",
    "truncated": "truncated: nothing is missing up to the last sample; the end is",
    "damaged": "damaged: something inside is missing or contradictory",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """The file, the formats, where to write."""
    parser.description = (
        "Decode a recording (DROP0001.BIN off the card, a copy such as SD.bin, or an image of the whole "
        "card) to engineering units, say what was recorded and what is missing. "
        "Ends with 3 if anything was lost or is doubtful."
    )
    parser.add_argument(
        "file", metavar="FILE", type=Path, help="the recording off the card, such as DROP0001.BIN"
    )
    parser.add_argument(
        "--format",
        metavar="LIST",
        type=_formats,
        default=("csv",),
        help=f"what to write, separated by commas: {', '.join(FORMATS)} (default csv)",
    )
    parser.add_argument("--out", metavar="DIR", type=Path, help="folder to write to (default: beside FILE)")
    parser.add_argument(
        "--session", metavar="ID", type=_session, help="which recording, 8 hex digits (default: the newest)"
    )
    parser.add_argument("--force", action="store_true", help="overwrite files that this command did not make")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Decodes, writes the files, shows the summary."""
    from tfsat_host.cli.decoded_files import write_decoded
    from tfsat_host.sdlog.load import load
    from tfsat_host.sdlog.summary import summary

    log = load(args.file, session=args.session)
    folder = args.out or args.file.parent
    with out.progress(f"Writing {', '.join(args.format)}"):
        written = write_decoded(log, folder / args.file.stem, args.format, force=args.force)
    for path in written.removed:
        out.note(f"{path} was removed: it is older than the recording of this name.")
    facts = summary(log) | {"files": {name: str(path) for name, path in written.files.items()}}
    for warning in facts["warnings"]:
        out.warn(warning) if not warning.startswith(" ") else out.note(warning)
    out.result(facts, lambda: _show(facts, out))
    return DataLossError.exit_code if facts["warnings"] else 0


def _show(facts: dict[str, Any], out: Output) -> None:
    others = facts["other_sessions"]
    out.line(
        f"Recording  {facts['session']}" + (f"  (also in the file: {', '.join(others)})" if others else "")
    )
    out.line(f"Verdict    {_VERDICTS[facts['verdict']]}")
    if facts["unix_offset_us"] is not None:
        out.line(f"Started    {_utc(facts['header']['wall_clock_us'])}")
    rate = "unknown" if facts["rate_hz"] is None else f"{facts['rate_hz']:.2f} Hz"
    commanded = f"{facts['header']['rate_hz']:g} Hz commanded"
    out.line(f"Samples    {facts['samples']} in {facts['duration_s']:.3f} s, {rate} ({commanded})")
    aside = {name: count for name, count in facts["set_aside"].items() if count}
    if aside:
        listed = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in aside.items())
        out.line(f"Set aside  {listed} (blocks)")
    out.line()
    columns = ("sensor", "valid", "invalid", "clipped")
    out.table(columns, [[row[name] for name in columns] for row in facts["sensors"]])
    _show_clipping(facts, out)
    _show_events(facts, out)
    for path in facts["files"].values():
        out.line(f"Written    {path}")


def _utc(unix_us: int) -> str:
    try:
        moment = datetime.fromtimestamp(unix_us / 1e6, UTC)
    except (OverflowError, ValueError, OSError):
        return f"at an impossible time of day ({unix_us} µs since 1970)"
    return moment.isoformat(sep=" ", timespec="seconds").replace("+00:00", " UTC")


def _show_clipping(facts: dict[str, Any], out: Output) -> None:
    clipping = facts["clipping"]
    if clipping is None:
        return
    when = f"{clipping['first_s']:.3f} to {clipping['last_s']:.3f} s"
    if clipping["in_fall"]:
        out.line(
            f"Clipped     {when}: {clipping['in_fall']} samples of them IN THE FALL; they are lower bounds."
        )
    else:
        out.line(f"Clipped     {when}: none within {clipping['fall_s']:g} s after the release.")
    out.line()


def _show_events(facts: dict[str, Any], out: Output) -> None:
    if facts["release_us"] is None:
        out.line("No release was recorded: times count from the first sample.")
    else:
        doubtful = "" if facts["t_s_origin"] == "release" else ", which is doubtful"
        out.line(f"Times count from the release{doubtful}.")
    rows = [(f"{event['t_s']:.6f}", event_words(event)) for event in facts["events"][:_EVENTS_SHOWN]]
    if rows:
        out.table(("t / s", "event"), rows)
    if len(facts["events"]) > _EVENTS_SHOWN:
        out.line(f"… and {len(facts['events']) - _EVENTS_SHOWN} more events (all of them with --json).")


_EVENTS_SHOWN = 40


def _formats(text: str) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(part.strip().lower() for part in text.split(",")))
    unknown = [name for name in names if name not in FORMATS]
    if unknown:
        raise argparse.ArgumentTypeError(f"{unknown[0]!r} is no format; there are {', '.join(FORMATS)}")
    return names


def _session(text: str) -> int:
    try:
        number = int(text, 16)
    except ValueError:
        number = -1
    if not 0 <= number <= 0xFFFFFFFF:
        raise argparse.ArgumentTypeError(f"{text!r} is no recording's id (8 hexadecimal digits)")
    return number
