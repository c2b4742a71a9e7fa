"""`tfsat-host decode`: the card's recording in engineering units, and what is missing from it."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.usage import OUTPUT, add_options
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.exit_code import ExitCode
from tfsat_host.output_files import UnwritableError
from tfsat_host.present.output import Output
from tfsat_host.quantity import Column, Columns, columns_of, fields, record
from tfsat_host.run.exports import FORMATS, Written, held_calibration, write_decoded

if TYPE_CHECKING:
    from tfsat_host.run.certificate_check import CertificateState
    from tfsat_host.sdlog import DropLog


class NotWrittenError(TfsatError):
    """The recording was decoded and its files could not be written (exit code 1).

    Attributes:
        decoded: What was decoded, which a full disk need not cost.
    """

    def __init__(self, error: TfsatError, decoded: DecodedRecording, columns: Columns) -> None:
        super().__init__(what=error.what, meaning=error.meaning, next_step=error.next_step)
        self.decoded = decoded
        self.columns = (Column("decoded", columns=columns),)


@dataclass(frozen=True, eq=False)
class DecodedRecording:
    """A recording, decoded.

    Attributes:
        log: The recording.
        calibration: State of the certificate that applies; None: there is none.
        quiet_s: For how long the gyros rested before the release; None: they did not.
        files: What was written, by name.
    """

    log: DropLog
    calibration: CertificateState | None
    quiet_s: float | None
    files: Mapping[str, Path] = field(default_factory=dict)


_USAGE = f"""
Decode a recording (DROP0001.BIN off the card, a copy such as SD.bin, or an image of the whole card) to engineering
units, say what was recorded and what is missing. Ends with 3 if anything was lost or is doubtful.

FILE                the recording off the card, such as DROP0001.BIN
--format LIST       what to write, separated by commas: {", ".join(FORMATS)} (default csv)
--out DIR           folder to write to, or the name of one file, such as drop.csv (default: next to FILE)
--session ID        which recording of the file, 8 hex digits (default: the newest by the time of day in the headers;
                    where an unbroken one has none, the first in the file)
--calibration FILE  certificate to check for this recording; the landing is entered in it (default: calibration.toml
                    next to FILE or here, of an emulated robot calibration-emulated.toml)
--force             overwrite files that this command did not make
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the file, the formats and the output options."""
    add_options(parser, _USAGE, format={"type": _formats, "default": ("csv",)})


def run(args: argparse.Namespace, out: Output) -> int:
    """Decodes, writes the files, shows the summary."""
    from tfsat_host.present.recording_text import show_recording
    from tfsat_host.run.certificate_check import CERTIFICATE_STATE
    from tfsat_host.sdlog.load import load
    from tfsat_host.sdlog.log_summary import SUMMARY, recordings_lines, warnings

    _require_one_format(args)
    with out.progress(f"Reading {args.file}", total=1.0) as advance:
        log = load(args.file, session=args.session, progress=advance)
    for line in recordings_lines(log, args.file):
        out.note(line)
    doubts = warnings(log)
    out.warn_each(doubts)
    decoded = DecodedRecording(log, *held_calibration(log, args.calibration, out))
    columns: Columns = (
        *columns_of("log", SUMMARY),
        Column("calibration", columns=CERTIFICATE_STATE),
        *fields("quiet_s"),
    )
    try:
        written = _write(log, args, out)
    except TfsatError as error:
        show_recording(log, (), out)
        raise NotWrittenError(error, decoded, columns) from None
    for path in written.of_other_recordings:
        out.warn(
            f"{path} holds another recording than {args.file}, under the same name: move or delete it, or decode "
            "into another folder with --out."
        )
    decoded = replace(decoded, files=written.files)
    out.result(
        record((*columns, *fields("files")), decoded),
        lambda: show_recording(log, written.files.values(), out),
    )
    return ExitCode.DATA_LOSS if doubts else 0


def _write(log: DropLog, args: argparse.Namespace, out: Output) -> Written:
    """Raises TfsatError also where the system refuses: the recording itself was decoded."""
    stem = _stem(args)
    folder = stem.parent
    try:
        with out.progress(f"Writing {', '.join(args.format)}"):
            return write_decoded(log, stem, args.format, force=args.force)
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


def _stem(args: argparse.Namespace) -> Path:
    """Return the path of all files without their endings; `--out` is a folder, or the name of a file of one format."""
    if _named_format(args.out) is None:
        return Path(args.out or args.file.parent, args.file.stem)
    return Path(args.out).with_suffix("")


def _named_format(out: Path | None) -> str | None:
    """Return the format that a file's name has; None: a folder."""
    name = "" if out is None or out.is_dir() else out.suffix[1:].lower()
    return name if name in FORMATS else None


def _require_one_format(args: argparse.Namespace) -> None:
    """Refuse a file's name that is of another format than what is to be written."""
    named = _named_format(args.out)
    if named is not None and args.format != (named,):
        raise UsageError(
            what=f"--out {args.out} names a {named} file, and {', '.join(args.format)} is to be written.",
            meaning="Nothing was decoded.",
            next_step=f"For that file: --format {named}. For a folder, a name without .{named}.",
        )


def _formats(text: str) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(part.strip().lower() for part in text.split(",")))
    unknown = [name for name in names if name not in FORMATS]
    if unknown:
        raise argparse.ArgumentTypeError(f"{unknown[0]!r} is no format; there are {', '.join(FORMATS)}")
    return names
