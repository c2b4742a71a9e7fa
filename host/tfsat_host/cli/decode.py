"""`tfsat-host decode`: the card's recording in engineering units, and what is missing from it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.decode_calibration import tell_calibration
from tfsat_host.cli.decode_words import aside_words, footer_rows, recordings_lines, utc, verdict_words
from tfsat_host.cli.decoded_files import FORMATS
from tfsat_host.cli.event_words import event_words
from tfsat_host.cli.options import add_output_options, file_name, session_id
from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError, TfsatError

if TYPE_CHECKING:
    from tfsat_host.cli.decoded_files import Written
    from tfsat_host.sdlog import DropLog


class NotWrittenError(TfsatError):
    """The recording was decoded and its files could not be written (exit code 1).

    Attributes:
        details: For `--json`: the decoded facts, which a full disk need not cost.
    """

    def __init__(self, error: TfsatError, facts: dict[str, Any]) -> None:
        super().__init__(what=error.what, meaning=error.meaning, next_step=error.next_step)
        self.details = {"decoded": facts}


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
        "--session",
        metavar="ID",
        type=session_id,
        help="which recording of the file, 8 hex digits (default: the newest by the time of day in the headers; "
        "where an unbroken one has none, the first in the file)",
    )
    parser.add_argument(
        "--calibration",
        metavar="FILE",
        type=file_name,
        help="certificate to hold against the recording; it learns of the landing (default: calibration.toml beside "
        "FILE or here, of an emulated robot calibration-emulated.toml)",
    )
    parser.add_argument("--force", action="store_true", help="overwrite files that this command did not make")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Decodes, writes the files, shows the summary."""
    from tfsat_host.sdlog.load import load
    from tfsat_host.sdlog.summary import summary

    with out.progress(f"Reading {args.file}", total=1.0) as advance:
        log = load(args.file, session=args.session, progress=advance)
    facts = summary(log)
    for line in recordings_lines(facts, args.file):
        out.note(line)
    for warning in facts["warnings"]:
        out.warn(warning) if not warning.startswith(" ") else out.note(warning)
    facts |= tell_calibration(log, args.calibration, out)
    try:
        written = _write(log, args, out)
    except TfsatError as error:
        _show(facts, out)
        raise NotWrittenError(error, facts) from None
    for path in written.removed:
        out.note(f"{path} was removed: it is older than the recording of this name.")
    facts["files"] = {name: str(path) for name, path in written.files.items()}
    out.result(facts, lambda: _show(facts, out))
    return DataLossError.exit_code if facts["warnings"] else 0


def _write(log: DropLog, args: argparse.Namespace, out: Output) -> Written:
    """Raises TfsatError also where the system refuses: the recording itself was decoded."""
    from tfsat_host.cli.decoded_files import write_decoded
    from tfsat_host.cli.outputs import UnwritableError

    folder = args.out or args.file.parent
    try:
        with out.progress(f"Writing {', '.join(args.format)}"):
            return write_decoded(log, folder / args.file.stem, args.format, force=args.force)
    except BrokenPipeError:
        raise
    except (OSError, UnwritableError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise TfsatError(
            what=f"No file could be written to {folder}: {str(reason).splitlines()[0].rstrip('.')}.",
            meaning=f"The recording {log.session:08x} is decoded ({log.verdict}, {len(log)} samples); "
            "not all of its files are there.",
            next_step="Make room, or name a folder that can be written with --out.",
        ) from None


def _show(facts: dict[str, Any], out: Output) -> None:
    out.line(f"Recording  {facts['session']}")
    out.line(f"Verdict    {verdict_words(facts)}")
    if facts["unix_offset_us"] is not None:
        out.line(f"Started    {utc(facts['header']['wall_clock_us'])}")
    rate = "unknown" if facts["rate_hz"] is None else f"{facts['rate_hz']:.2f} Hz"
    commanded = f"{facts['header']['rate_hz']:g} Hz commanded"
    out.line(f"Samples    {facts['samples']} in {facts['duration_s']:.3f} s, {rate} ({commanded})")
    for label, text in footer_rows(facts["footer"]):
        out.line(f"{label:<11}{text}")
    if aside := aside_words(facts):
        out.line(f"Set aside  {aside} (blocks)")
    out.line()
    columns = ("sensor", "valid", "invalid", "clipped")
    out.table(columns, [[row[name] for name in columns] for row in facts["sensors"]])
    _show_clipping(facts, out)
    _show_events(facts, out)
    for path in facts.get("files", {}).values():
        out.line(f"Written    {path}")


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
