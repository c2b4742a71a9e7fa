"""`tfsat-host bundle`: all of one drop in one file, to be kept, sent and computed again."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from tfsat_host.cli.run_options import RUNS, options_of
from tfsat_host.cli.usage import FORCE, OUTPUT, add_options, output_file_name
from tfsat_host.errors import UsageError
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import list_facts, sentences
from tfsat_host.quantity import record
from tfsat_host.run.bundle.manifest import MANIFEST_COLUMNS, Manifest

if TYPE_CHECKING:
    from tfsat_host.run.bundle.making import WrittenBundle


_USAGE = f"""
Put a drop into one archive: raw log, maneuver, certificate with its raw recordings, preflight, record, robot and
facility, its evaluation and report as computed now, and with what. What is missing is named. The same run gives the
same bytes. `tfsat-host reproduce` recomputes it. Ends with 3 if something was lost.

{RUNS}
options:
--full      why something is missing, what was left out, what the recording holds
--out FILE  the archive (default: NAME.tfsat.zip in the current folder)
{FORCE}
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options that `evaluate` takes for one drop, and the output file."""
    add_options(parser, _USAGE, out=output_file_name)


def run(args: argparse.Namespace, out: Output) -> int:
    """Collects, evaluates, writes."""
    from tfsat_host.run.bundle.making import BUNDLE, bundle

    if len(args.runs) > 1:
        raise UsageError(
            what=f"{len(args.runs)} drops were named; a bundle holds one.",
            meaning="Nothing was written.",
            next_step="Bundle each alone.",
        )
    options = options_of(args)
    replace(options, facility=None).check(args.runs)  # it is bundled without --laser, too
    archive = bundle(args.runs[0], options, args.out, force=args.force, notices=out)
    result = record(BUNDLE, archive) | record(MANIFEST_COLUMNS, archive.manifest)
    out.result(result, lambda: _show(archive, out, full=args.full))
    return 0 if archive.is_whole else ExitCode.DATA_LOSS


def _show(archive: WrittenBundle, out: Output, *, full: bool) -> None:
    from tfsat_host.run.bundle.contents import MADE_AGAIN

    manifest, target = archive.manifest, archive.target
    size = sum(file.bytes for file in manifest.files.values())
    sentences(
        [
            f"Bundle: {target} ({len(manifest.files)} files, {size / 1e6:.1f} MB)",
            f"Manifest (for the logbook): SHA-256 {archive.manifest_sha256}",
        ],
        out,
    )
    show_concerns(manifest, out)
    unusual = [name for name, why in manifest.left_out.items() if why != MADE_AGAIN]
    if not full:
        names = {"Missing": [part.what for part in manifest.never_there], "Left out": unusual}
        sentences(
            [f"{label}: {', '.join(names[label])} (why: --full)" for label in names if names[label]], out
        )
        return
    list_facts("Missing", [f"{part.what}: {part.why}" for part in manifest.never_there], out)
    list_facts("Left out", [f"{name} {manifest.left_out[name]}." for name in unusual], out)
    plain = [name for name in manifest.left_out if name not in unusual]
    sentences(
        [
            *([f"Left out, not needed: {', '.join(plain)}"] if plain else []),
            f"Recording: {manifest.evaluated.recording}, {archive.recording}",
            Advice("To reproduce: ", NextStep("reproduce", (str(target),))),
        ],
        out,
    )


def show_concerns(manifest: Manifest, out: Output, changed: Sequence[str] | None = None) -> None:
    """Write what was lost, changed or is doubtful; `changed` instead of what the manifest says was changed."""
    list_facts("Lost", [f"{part.what}: {part.why}" for part in manifest.lost], out)
    list_facts("Changed", manifest.record if changed is None else changed, out)
    list_facts("Doubtful", manifest.doubts, out)
