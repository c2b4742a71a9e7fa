"""`tfsat-host reproduce`: a bundled drop computed again from raw, and what differs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tfsat_host.cli.bundle import show_concerns
from tfsat_host.cli.usage import OUTPUT, add_options
from tfsat_host.exit_code import ExitCode
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import list_facts, sentences, show_rows, write_verdict
from tfsat_host.quantity import record
from tfsat_host.run.bundle.json_comparison import DIFFERENCES, ComparedPart

if TYPE_CHECKING:
    from tfsat_host.run.bundle.reproducing import Reproduction

_MAX_ROWS, _MAX_ROWS_FULL = 8, 100
_GREEN, _YELLOW, _RED = "1;32", "1;33", "1;31"


_USAGE = f"""
Unpack a bundle into a new folder, check every file's hash, recompute calibration, evaluation and report from the raw
data, and list the differences, number by number. Ends with 0 if nothing does; with 3 if something does, was lost, was
changed, or could not be computed; with 1 if the archive is damaged or not safe: then nothing is unpacked.

BUNDLE     a file that `tfsat-host bundle` made
--full     what was compared, what is missing, and more of what differs
--out DIR  a new folder to unpack into (default: NAME-reproduced here, for NAME.tfsat.zip)
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the bundle and the folder to unpack into."""
    add_options(parser, _USAGE)


def run(args: argparse.Namespace, out: Output) -> int:
    """Unpacks, computes, compares."""
    from tfsat_host.run.bundle.reproducing import REPRODUCTION, reproduce

    reproduction = reproduce(args.bundle, args.out, out)
    out.result(record(REPRODUCTION, reproduction), lambda: _show(reproduction, out, full=args.full))
    return 0 if reproduction.same and not reproduction.incomplete else ExitCode.DATA_LOSS


def _show(reproduction: Reproduction, out: Output, *, full: bool) -> None:
    """Show the verdict, what differs or is not whole, and below these the verdict again."""
    manifest = reproduction.manifest
    whole = reproduction.same and not reproduction.incomplete
    _show_verdict(reproduction, out)
    sentences(
        [
            f"Unpacked: {reproduction.folder} ({len(manifest.files)} files, SHA-256 of all files verified)",
            f"Manifest (compare with the logbook): SHA-256 {reproduction.manifest_sha256}",
        ],
        out,
    )
    if reproduction.program_changed and not reproduction.same:
        sentences(
            [
                f"Program: changed since the bundle was made (by {manifest.made_by}). Differences may come from the "
                "program, not from the data: reproduce it with that version to tell."
            ],
            out,
        )
    # The page is drawn from the evaluation: where that differs, the page's numbers say nothing more.
    evaluation_differs = False
    for part in reproduction.compared:
        if part.differs:
            limit = 0 if evaluation_differs and part.what == "report" and not full else _MAX_ROWS
            _show_differences(part, out, _MAX_ROWS_FULL if full else limit)
            evaluation_differs |= part.what == "evaluation"
        elif full or part.lacking or part.refused:
            label = "Not computed" if part.lacking else part.what.capitalize()
            list_facts(label, [part.sentence], out)
    show_concerns(manifest, out, reproduction.record)
    if full or not reproduction.same:
        list_facts("Computed with other software", reproduction.environment, out)
    if full:
        list_facts("Missing", [f"{part.what}: {part.why}" for part in manifest.never_there], out)
        if reproduction.not_computed:
            sentences([f"Verified by SHA-256 only: {', '.join(reproduction.not_computed)}"], out)
    if full or not whole:
        _show_verdict(reproduction, out)


def _show_verdict(reproduction: Reproduction, out: Output) -> None:
    compared, manifest = reproduction.compared, reproduction.manifest
    verdict, color = "Reproduced identically", _GREEN
    if reproduction.incomplete:
        verdict, color = "REPRODUCED IN PART", _YELLOW
    if not reproduction.same:
        verdict, color = "NOT REPRODUCED", _RED
    wrong = [f"{len(part.differs):,} differences in {part.what}" for part in compared if part.differs]
    wrong += [f"{part.what} refused" for part in compared if part.refused]
    counts = {
        "not computed": sum(part.lacking for part in compared),
        "lost": len(manifest.lost),
        "changed": len(reproduction.record),
        "doubtful": len(manifest.doubts),
    }
    wrong += [f"{count} {word}" for word, count in counts.items() if count]
    identical = ", ".join(
        f"{part.what} ({part.extent})" if part.extent else part.what for part in compared if part.identical
    )
    if wrong:
        identical = "; ".join([", ".join(wrong), *([f"identical: {identical}"] if identical else [])])
    write_verdict(f"{verdict}: {identical}", color, out)


def _show_differences(part: ComparedPart, out: Output, limit: int) -> None:
    """Write how many numbers, names and keys differ, with the limit, and the first `limit` of them."""
    differs = part.differs or ()
    of = f" ({part.extent} compared)" if part.extent else ""
    tolerance = part.tolerance
    allowed = f", allowed: {tolerance.relative:g} relative or {tolerance.absolute:g}" if tolerance else ""
    sentences([f"{part.what.capitalize()}: {len(differs):,} differences{of}{allowed}"], out)
    if part.tolerance is None:
        sentences([part.sentence], out)
    if limit:
        show_rows(DIFFERENCES, differs[:limit], out)
    if len(differs) > limit:
        sentences([f"{len(differs) - limit:,} more: --full (up to {_MAX_ROWS_FULL}), --json (all)"], out)
