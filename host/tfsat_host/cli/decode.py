"""`tfsat-host decode`: the card's recording in engineering units, and what is missing from it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.options import add_output_options
from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError

if TYPE_CHECKING:
    from tfsat_host.cli.outputs import OutputFile
    from tfsat_host.sdlog import DropLog

FORMATS = ("csv", "npz", "mat")
_VERDICTS = {
    "complete": "complete: nothing is missing",
    "truncated": "truncated: nothing is missing up to the last sample; the end is",
    "damaged": "damaged: something inside is missing or contradictory",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """The file, the formats, where to write."""
    parser.description = (
        "Decode a recording (SD.bin, or an image of the whole card) to engineering units, say what was "
        "recorded and what is missing. Ends with 3 if anything was lost or is doubtful."
    )
    parser.add_argument("file", metavar="FILE", type=Path, help="the log off the card, such as SD.bin")
    parser.add_argument(
        "--format",
        metavar="LIST",
        type=_formats,
        default=("csv",),
        help="what to write, separated by commas: csv, npz, mat (default csv)",
    )
    parser.add_argument("--out", metavar="DIR", type=Path, help="folder to write to (default: beside FILE)")
    parser.add_argument(
        "--session", metavar="ID", type=_session, help="which recording, 8 hex digits (default: the newest)"
    )
    parser.add_argument("--force", action="store_true", help="overwrite files that this command did not make")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Decodes, writes the files, shows the summary."""
    from tfsat_host.cli.outputs import write_all
    from tfsat_host.sdlog.load import load
    from tfsat_host.sdlog.summary import summary

    log = load(args.file, session=args.session)
    files = _files(log, args.file, args.out or args.file.parent, args.format)
    with out.progress(f"Writing {', '.join(file.path.name for file in files.values())}"):
        write_all(list(files.values()), force=args.force)
    facts = summary(log) | {"files": {name: str(file.path) for name, file in files.items()}}
    for warning in facts["warnings"]:
        out.warn(warning) if not warning.startswith(" ") else out.note(warning)
    out.result(facts, lambda: _show(facts, out))
    return DataLossError.exit_code if facts["warnings"] else 0


def _files(log: DropLog, source: Path, folder: Path, formats: tuple[str, ...]) -> dict[str, OutputFile]:
    """What to write, by the name it has in the JSON result."""
    from tfsat_host.cli.outputs import OutputFile

    files = {}
    if "csv" in formats:
        from tfsat_host.sdlog import export_csv as to_csv

        files["csv"] = OutputFile(
            folder / f"{source.stem}.csv", to_csv.header_line(log), lambda path: to_csv.write_csv(log, path)
        )
        files["events_csv"] = OutputFile(
            folder / f"{source.stem}.events.csv",
            to_csv.events_header_line(),
            lambda path: to_csv.write_events_csv(log, path),
        )
    if "npz" in formats:
        from tfsat_host.sdlog.export_npz import NPZ_MARKER, write_npz

        files["npz"] = OutputFile(
            folder / f"{source.stem}.npz", NPZ_MARKER, lambda path: write_npz(log, path)
        )
    if "mat" in formats:
        from tfsat_host.sdlog.export_mat import MAT_MARKER, write_mat

        files["mat"] = OutputFile(
            folder / f"{source.stem}.mat", MAT_MARKER, lambda path: write_mat(log, path)
        )
    return files


def _show(facts: dict[str, Any], out: Output) -> None:
    others = facts["other_sessions"]
    out.line(
        f"Recording  {facts['session']}" + (f"  (also in the file: {', '.join(others)})" if others else "")
    )
    out.line(f"Verdict    {_VERDICTS[facts['verdict']]}")
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
    _show_events(facts, out)
    for path in facts["files"].values():
        out.line(f"Written    {path}")


def _show_events(facts: dict[str, Any], out: Output) -> None:
    if facts["release_us"] is None:
        out.line("No release was recorded: times count from the first sample.")
    else:
        out.line("Times count from the release.")
    rows = [
        (f"{event['t_s']:.6f}", _EVENT_TEXTS.get(event["name"], event["name"]).format(**_counted(event)))
        for event in facts["events"][:_EVENTS_SHOWN]
    ]
    if rows:
        out.table(("t / s", "event"), rows)
    if len(facts["events"]) > _EVENTS_SHOWN:
        out.line(f"… and {len(facts['events']) - _EVENTS_SHOWN} more events (all of them with --json).")


_EVENTS_SHOWN = 40
_EVENT_TEXTS = {
    "switch_edge": "release switch {number} {state}",
    "stroke": "stroke {number}",
    "sensor_fault": "IMU of body {number} stopped answering (error {arg})",
    "sensor_recovered": "IMU of body {number} answers again",
    "card_stall": "the card took {value} ms for a write",
    "samples_dropped": "{value} samples dropped: the ring was full",
}


def _counted(event: dict[str, Any]) -> dict[str, Any]:
    return event | {"number": event["index"] + 1, "state": "opened" if event["arg"] else "closed"}


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
