"""`tfsat-host reproduce`: a bundled drop computed again from raw, and what differs."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.usage import OUTPUT, add_options
from tfsat_host.exit_code import ExitCode
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import printable, show_rows
from tfsat_host.quantity import Column, Columns

if TYPE_CHECKING:
    from tfsat_host.run.bundle.reproducing import ComparedPart

_SHOWN = 20


_USAGE = f"""
Unpack a bundle into a new folder, check every file's hash, recompute calibration, evaluation and report from the raw
data, and say what differs, number by number. Ends with 0 if nothing does; with 3 if something does, was lost, was
changed, or could not be computed; with 1 if the archive is damaged or not safe: then nothing is unpacked.

BUNDLE     a file that `tfsat-host bundle` made
--out DIR  a new folder to unpack into (default: NAME-reproduced here, for NAME.tfsat.zip)
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the bundle and the folder to unpack into."""
    add_options(parser, _USAGE)


def run(args: argparse.Namespace, out: Output) -> int:
    """Unpacks, computes, compares."""
    from tfsat_host.run.bundle.reproducing import reproduce

    reproduction = reproduce(args.bundle, args.out, out)
    result = {"bundle": str(args.bundle), **reproduction.as_dict()}
    out.result(result, lambda: _show(result, reproduction.compared, out))
    return 0 if reproduction.same and not reproduction.incomplete else ExitCode.DATA_LOSS


def _show(result: dict[str, Any], compared: Sequence[ComparedPart], out: Output) -> None:
    """Part by part, then what is missing, lost, changed or doubtful, and the verdict last."""
    out.line(f"Unpacked  {printable(result['folder'])}: {result['files']} files, every hash is right.")
    out.line(f"Manifest  SHA-256 {result['manifest_sha256']}: compare it with the logbook's.")
    for part in compared:
        word = "NOT DONE" if part.lacking else "not done" if part.differs is None else "same"
        word = "REFUSED" if part.refused else word
        word = f"{len(part.differs)} DIFFER" if part.differs else word
        out.line(f"{part.what.capitalize()}: {word}. {printable(part.sentence)}")
        if part.differs:
            show_rows(DIFFERENCES, part.differs[:_SHOWN], out)
            if len(part.differs) > _SHOWN:
                out.line(f"… and {len(part.differs) - _SHOWN} more: --json has all.")
    for missing in result["missing"]:
        out.line(
            f"{'LOST' if missing['lost'] else 'Missing'} when bundled: {printable(missing['what'])}: "
            f"{printable(missing['why'])}"
        )
    for sentence in result["record"]:
        out.line(f"CHANGED   {printable(sentence)}")
    for sentence in result["doubts"]:
        out.line(f"DOUBTFUL  {printable(sentence)}")
    if result["environment"]:
        out.line(f"Computed with something else than then: {printable(' '.join(result['environment']))}")
    if result["not_computed"]:
        names = ", ".join(map(printable, result["not_computed"]))
        out.line(f"Kept as it was, not computed: {names}")
    if not result["same"]:
        out.line("NOT THE SAME: see above.")
    elif result["complete"]:
        out.line("SAME: the raw data give what was bundled.")
    else:
        out.line(f"SAME as far as it could be computed, and not whole: {printable(_briefly(result))}.")


def _briefly(result: dict[str, Any]) -> str:
    """Summarize how many results were lost, changed, doubtful or not computed."""
    counts = {
        "LOST": sum(missing["lost"] for missing in result["missing"]),
        "CHANGED": len(result["record"]),
        "DOUBTFUL": len(result["doubts"]),
        "NOT COMPUTED": sum(part["lacking"] for part in result["compared"]),
    }
    return ", ".join(f"{count} {word}" for word, count in counts.items() if count) + " (above)"


def _value(value: object) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)[:80]


DIFFERENCES: Columns = (
    Column("key", "what"),
    Column("bundled", "bundled", words=lambda difference: _value(difference.bundled)),
    Column("recomputed", "recomputed", words=lambda difference: _value(difference.recomputed)),
    Column("relative", "relative", form=".1e"),
)
