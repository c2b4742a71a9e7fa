"""`tfsat-host bundle`: all of one drop in one file, to be kept, sent and computed again."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from tfsat_host.cli.run_options import RUNS, options_of
from tfsat_host.cli.usage import FORCE, OUTPUT, add_options, output_file_name
from tfsat_host.errors import UsageError
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import NextStep
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.run.bundle.making import WrittenBundle


_USAGE = f"""
Put a drop into one archive: raw log, maneuver, certificate with its raw recordings, preflight, record, robot and
facility, its evaluation and report as computed now, and with what. What is missing is named. The same run gives the
same bytes. `tfsat-host reproduce` recomputes it. Ends with 3 if something was lost.

{RUNS}
options:
--out FILE  the archive (default: NAME.tfsat.zip in the current folder)
{FORCE}
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options that `evaluate` takes for one drop, and the output file."""
    add_options(parser, _USAGE, out=output_file_name)


def run(args: argparse.Namespace, out: Output) -> int:
    """Collects, evaluates, writes."""
    from tfsat_host.run.bundle.making import bundle

    if len(args.runs) > 1:
        raise UsageError(
            what=f"{len(args.runs)} drops were named; a bundle holds one.",
            meaning="Nothing was written.",
            next_step="Bundle each alone.",
        )
    options = options_of(args)
    replace(options, facility=None).check(args.runs)  # it is bundled without --laser, too
    archive = bundle(args.runs[0], options, args.out, force=args.force, notices=out)
    result = {
        "bundle": str(archive.target),
        "recording": archive.recording,
        "bytes": archive.target.stat().st_size,
        "manifest_sha256": archive.manifest_sha256,
        **archive.manifest.as_dict(),
    }
    out.result(result, lambda: _show(archive, out))
    return ExitCode.DATA_LOSS if archive.lost else 0


def _show(archive: WrittenBundle, out: Output) -> None:
    from tfsat_host.notices import printable
    from tfsat_host.run.bundle.contents import MADE_AGAIN

    manifest, target = archive.manifest, archive.target
    size = sum(file.bytes for file in manifest.files.values())
    out.line(f"Written   {printable(target)}: {len(manifest.files)} files, {size / 1e6:.1f} MB.")
    out.line(f"Manifest  SHA-256 {archive.manifest_sha256}: for the logbook, it vouches for every file.")
    out.line(f"Recording {printable(manifest.evaluated.recording)}, {archive.recording}.")
    for missing_part in manifest.missing:
        out.line(
            f"{'LOST     ' if missing_part.lost else 'Missing  '} {printable(missing_part.what)}: "
            f"{printable(missing_part.why)}"
        )
    for sentence in manifest.record:
        out.line(f"CHANGED   {printable(sentence)}")
    for sentence in manifest.doubts:
        out.line(f"DOUBTFUL  {printable(sentence)}")
    plain = [name for name, why in manifest.left_out.items() if why == MADE_AGAIN]
    for name, why in manifest.left_out.items():
        if name not in plain:
            out.line(f"Left out  {printable(name)} {printable(why)}.")
    if plain:
        out.line(f"Left out  {', '.join(map(printable, plain))}.")
    out.line(f"To recompute it: {NextStep('reproduce', (printable(target),))}")
