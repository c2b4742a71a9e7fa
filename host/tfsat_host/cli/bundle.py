"""`tfsat-host bundle`: all of one drop in one file, to be kept, sent and computed anew."""

from __future__ import annotations

import argparse
import json
import shlex
import shutil
import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host import __version__
from tfsat_host.cli.evaluate.options import add_run_arguments, check_run_arguments
from tfsat_host.cli.options import add_output_options, output_file_name
from tfsat_host.cli.output import Output
from tfsat_host.cli.outputs import OutputFile, check_may_write, new_folder_of, tell_new_folder, write_all
from tfsat_host.errors import DataLossError, UsageError
from tfsat_host.file_hash import sha256_of

if TYPE_CHECKING:
    from tfsat_host.bundle.manifest import Evaluated, Manifest
    from tfsat_host.cli.bundle_files import Collected

ENDING = ".tfsat.zip"


def configure(parser: argparse.ArgumentParser) -> None:
    """What `evaluate` takes of one drop, and where to write."""
    parser.description = (
        "Put a drop into one archive: raw log, maneuver, certificate with its raw recordings, preflight, record, robot "
        "and facility, its evaluation and report as computed now, and with what. What is missing is named. The same "
        "run gives the same bytes. `tfsat-host reproduce` computes it anew. Ends with 3 if something was lost."
    )
    add_run_arguments(parser)
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=output_file_name,
        help=f"the archive (default: NAME{ENDING} in the current folder)",
    )
    parser.add_argument(
        "--force", action="store_true", help="overwrite a file that this command did not make"
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Collects, evaluates, writes."""
    from tfsat_host.bundle.archive import MARKER
    from tfsat_host.bundle.manifest import NAME_CHARACTERS_MAX
    from tfsat_host.cli.bundle_doubts import verdict_words
    from tfsat_host.cli.bundle_files import collect
    from tfsat_host.cli.report_files import names_of

    if len(args.runs) > 1:
        raise UsageError(
            what=f"{len(args.runs)} drops were named; a bundle holds one.",
            meaning="Nothing was written.",
            next_step="Bundle each by itself.",
        )
    check_run_arguments(
        argparse.Namespace(**{**vars(args), "facility": None})
    )  # it is bundled without --laser, too
    found, used = collect(args.runs[0], args)
    name = names_of([found.recording])[0][:NAME_CHARACTERS_MAX]
    target = args.out or Path(f"{name}{ENDING}")
    check_may_write(target, marker=MARKER, force=args.force)
    new_folder = new_folder_of(target)
    with tempfile.TemporaryDirectory(prefix="tfsat-bundle-") as made:
        folder = Path(made)
        manifest = _staged(folder, found, used, name, out)
        write_all([OutputFile(target, MARKER, partial(_write, folder, manifest))], force=args.force)
        manifest_sha256 = sha256_of(folder / "manifest.json")
    tell_new_folder(new_folder, out)
    recording = verdict_words(found)
    result = {
        "bundle": str(target),
        "recording": recording,
        "bytes": target.stat().st_size,
        "manifest_sha256": manifest_sha256,
        **manifest.as_dict(),
    }
    out.result(result, lambda: _show(target, manifest, manifest_sha256, recording, out))
    lost = bool(manifest.record or manifest.doubts) or any(one.lost for one in manifest.missing)
    return DataLossError.exit_code if lost else 0


def _staged(folder: Path, found: Collected, used: Evaluated, name: str, out: Output) -> Manifest:
    """Lays out the bundle in a folder and evaluates it there, as `reproduce` will."""
    from tfsat_host.bundle.checked import not_as_checked
    from tfsat_host.bundle.environment import environment
    from tfsat_host.bundle.manifest import (
        ENVIRONMENT,
        EVALUATION,
        MANIFEST,
        REPORT,
        BundledFile,
        Manifest,
        Missing,
        format_manifest,
    )
    from tfsat_host.cli.bundle_doubts import doubts_of
    from tfsat_host.cli.bundle_files import images_of
    from tfsat_host.cli.recomputing import recompute
    from tfsat_host.record.run_record import verify

    for inside, path in found.files.items():
        (folder / inside).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / inside)
    with out.progress(f"Evaluating {name}"):
        done = recompute(folder, name, used)
    missing = list(found.missing)
    made = {EVALUATION: _json(done.evaluation), ENVIRONMENT: _json(environment())}
    if done.page is None:
        missing.append(
            Missing(REPORT, f"The drop cannot be evaluated: {done.evaluation['error']['what']}", lost=True)
        )
    else:
        made[REPORT] = done.page
    for inside, text in made.items():
        (folder / inside).write_bytes(text.encode())
    preflight = _preflight(folder)
    images, without = images_of(found.log, preflight)
    files = {
        inside: BundledFile(sha256_of(folder / inside), (folder / inside).stat().st_size)
        for inside in sorted((*found.files, *made))
    }
    record = (
        *(finding.sentence for finding in verify(found.folder)),
        *not_as_checked(preflight, {name: file.sha256 for name, file in files.items()}, used),
    )
    manifest = Manifest(
        f"tfsat-host bundle {__version__}",
        name,
        used,
        images,
        files,
        (*missing, *without),
        record,
        found.left_out,
        doubts_of(found, used, preflight),
    )
    (folder / MANIFEST).write_bytes(format_manifest(manifest).encode())
    return manifest


def _write(folder: Path, manifest: Manifest, path: Path) -> None:
    from tfsat_host.bundle.archive import write_archive
    from tfsat_host.bundle.manifest import MANIFEST

    write_archive(path, {name: folder / name for name in (*manifest.files, MANIFEST)})


def _preflight(folder: Path) -> Any:
    """What it says; nothing if it cannot be read: it is in the bundle as it is."""
    try:
        return json.loads((folder / "run" / "preflight.json").read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def _json(value: Any) -> str:
    return json.dumps(value, indent=1, allow_nan=False) + "\n"


def _show(target: Path, manifest: Manifest, manifest_sha256: str, recording: str, out: Output) -> None:
    from tfsat_host.cli.bundle_files import MADE_AGAIN
    from tfsat_host.cli.evaluate.phrases import printable

    size = sum(file.bytes for file in manifest.files.values())
    out.line(f"Written   {printable(target)}: {len(manifest.files)} files, {size / 1e6:.1f} MB.")
    out.line(f"Manifest  SHA-256 {manifest_sha256}: for the logbook, it vouches for every file.")
    out.line(f"Recording {printable(manifest.evaluated.recording)}, {recording}.")
    for one in manifest.missing:
        out.line(f"{'LOST     ' if one.lost else 'Missing  '} {printable(one.what)}: {printable(one.why)}")
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
    out.line(f"To compute it anew: tfsat-host reproduce {shlex.quote(printable(target))}")
