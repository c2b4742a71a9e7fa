"""`tfsat-host reproduce`: a bundled drop computed anew from raw, and what differs."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from tfsat_host.bundle.comparing import Compared
from tfsat_host.cli.bundle_files import RUN
from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError

if TYPE_CHECKING:
    from tfsat_host.bundle.comparing import Difference
    from tfsat_host.bundle.manifest import Manifest
    from tfsat_host.cli.recomputing import Recomputed

_RESULTS = ("truth.*", "summary.json", "report.html", "evaluation.json")
"""Of a run's folder: what a rehearsal or an earlier evaluation said."""
_UNREADABLE = object()
_OF_ITS_TIME = ("made_by", "made_at")
"""Of a result: who made it and when differs rightly."""


def configure(parser: argparse.ArgumentParser) -> None:
    """The bundle, and where to unpack."""
    parser.description = (
        "Unpack a bundle into a new folder, check every file's hash, compute calibration, evaluation and report anew "
        "from the raw data, and say what differs, number by number. Ends with 0 if nothing does; with 3 if something "
        "does, was lost, was changed, or could not be computed; with 1 if the archive is damaged or not safe: then "
        "nothing is unpacked."
    )
    parser.add_argument(
        "bundle", metavar="BUNDLE", type=file_name, help="a file that `tfsat-host bundle` made"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=file_name,
        help="a new folder to unpack into (default: NAME-reproduced here, for NAME.tfsat.zip)",
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Unpacks, computes, compares."""
    from tfsat_host.bundle.environment import changed_since
    from tfsat_host.bundle.manifest import ENVIRONMENT
    from tfsat_host.bundle.unpacking import unpack
    from tfsat_host.cli.evaluate.phrases import printable
    from tfsat_host.cli.recomputing import recompute
    from tfsat_host.cli.reproduce_words import show

    _require_file(args.bundle)
    folder = args.out or Path(args.bundle.name.removesuffix(".zip").removesuffix(".tfsat") + "-reproduced")
    with out.progress("Unpacking and checking"):
        manifest, manifest_sha256 = unpack(args.bundle, folder)
    with out.progress(f"Computing {printable(manifest.name)} anew"):
        done = recompute(folder, manifest.name, manifest.evaluated)
        compared = [
            _evaluation(folder, done),
            _report(folder, done),
            *_calibrations(folder, manifest, done),
        ]
    record = _changed(folder, manifest) or list(manifest.record)
    environment = changed_since(_load(folder / ENVIRONMENT))
    same = not any(one.differs for one in compared)
    incomplete = _incomplete(manifest, compared, record)
    result = {
        "same": same,
        "complete": not incomplete,
        "incomplete": incomplete,
        "bundle": str(args.bundle),
        "manifest_sha256": manifest_sha256,
        "folder": str(folder),
        "name": manifest.name,
        "files": len(manifest.files),
        "compared": [_as_dict(one) for one in compared],
        "not_computed": not_computed(manifest),
        "record": record,
        "doubts": list(manifest.doubts),
        "missing": manifest.as_dict()["missing"],
        "environment": environment,
    }
    out.result(result, lambda: show(result, compared, out))
    return 0 if same and not incomplete else DataLossError.exit_code


def _require_file(bundle: Path) -> None:
    """Raises BundleError: there is none."""
    from tfsat_host.bundle.errors import BundleError

    if bundle.is_file():
        return
    what = f"{bundle} is a folder" if bundle.is_dir() else f"There is no file {bundle}"
    raise BundleError(
        what=f"{what}; BUNDLE is a file that tfsat-host bundle makes, such as run.tfsat.zip.",
        meaning="Nothing was unpacked.",
        next_step=f"To make one of a run: tfsat-host bundle {shlex.quote(str(bundle))}"
        if bundle.is_dir()
        else "Name the file; to make one of a run: tfsat-host bundle RUN",
    )


def not_computed(manifest: Manifest) -> list[str]:
    """Results of earlier commands in the run's folder: they are kept by their hashes, and not made again."""
    return [
        name for name in sorted(manifest.files) if PurePosixPath(name).match(f"{RUN}/*") and _is_result(name)
    ]


def _is_result(name: str) -> bool:
    return any(PurePosixPath(name).match(pattern) for pattern in _RESULTS)


def _changed(folder: Path, manifest: Manifest) -> list[str]:
    """What is not as the run's record and its preflight say; sentences."""
    from tfsat_host.bundle.checked import not_as_checked
    from tfsat_host.record.run_record import verify

    run = folder / RUN
    if not run.is_dir():
        return []
    at_hand = {name: file.sha256 for name, file in manifest.files.items()}
    checked = not_as_checked(_load(run / "preflight.json"), at_hand, manifest.evaluated)
    return [*(finding.sentence for finding in verify(run)), *checked]


def _incomplete(manifest: Manifest, compared: Sequence[Compared], record: Sequence[str]) -> list[str]:
    """Why sameness says less than it seems to: what could not be computed, is lost, or was changed."""
    return [
        *(f"NOT COMPUTED: {one.sentence}" for one in compared if one.lacking),
        *(f"LOST: {one.what}: {one.why}" for one in manifest.missing if one.lost),
        *(f"CHANGED: {sentence}" for sentence in record),
        *(f"DOUBTFUL: {sentence}" for sentence in manifest.doubts),
    ]


def _evaluation(folder: Path, done: Recomputed) -> Compared:
    from tfsat_host.bundle.comparing import EVALUATION_TOLERANCE, NOT_THERE, Difference
    from tfsat_host.bundle.manifest import EVALUATION

    bundled = _load(folder / EVALUATION)
    if bundled is _UNREADABLE:
        there = (folder / EVALUATION).is_file()
        differs = [Difference(EVALUATION, "unreadable" if there else NOT_THERE, "an evaluation", None)]
        sentence = "The bundled evaluation cannot be read." if there else "The bundle has no evaluation."
        return Compared(
            "evaluation", differs, f"{sentence} What the raw data give is not held against anything."
        )
    differs = _differences(bundled, done.evaluation, EVALUATION_TOLERANCE)
    if "error" in done.evaluation:
        then = "now, and was not then" if differs else "now as then"
        why = done.evaluation["error"]["what"]
        return Compared("evaluation", differs, f"The drop cannot be evaluated, {then}: {why}", refused=True)
    count = _numbers(done.evaluation)
    return Compared("evaluation", differs, f"{count} numbers were decoded and evaluated anew.")


def _report(folder: Path, done: Recomputed) -> Compared:
    from tfsat_host.bundle.comparing import NOT_THERE, REPORT_TOLERANCE, Difference
    from tfsat_host.bundle.manifest import REPORT
    from tfsat_host.cli.recomputing import document_in

    try:
        bundled = document_in((folder / REPORT).read_text(encoding="utf-8"))
    except FileNotFoundError:
        if done.page is None:
            return Compared("report", None, "There is none, now as then.")
        return Compared(
            "report", [Difference("report", NOT_THERE, "a page", None)], "The bundle has no report."
        )
    except ValueError as error:
        sentence = f"The bundled page cannot be read: {error}."
        return Compared("report", [Difference("report", "unreadable", "a page", None)], sentence)
    if done.page is None:
        sentence = "The bundle has a report, and none can be made."
        return Compared("report", [Difference("report", "a page", NOT_THERE, None)], sentence)
    document = document_in(done.page)
    differs = _differences(bundled, document, REPORT_TOLERANCE)
    return Compared("report", differs, f"{_numbers(document)} numbers of the page were made anew.")


def _calibrations(folder: Path, manifest: Manifest, done: Recomputed) -> list[Compared]:
    """The certificate that lay there, and the one before it if that held at the release."""
    from tfsat_host.bundle.recalibrating import recalibrate, recordings_of
    from tfsat_host.errors import TfsatError
    from tfsat_host.robot import load_robot

    used = manifest.evaluated
    if used.calibration is None:
        return [Compared("calibration", None, "The bundle has no certificate.")]
    found = []
    names = dict.fromkeys([used.calibration, *([done.certificate] if done.certificate else [])])
    for name in (name for name in names if name in manifest.files):
        try:
            robot = load_robot(None if used.robot is None else folder / used.robot)
            again = recalibrate(folder / name, recordings_of(folder / name), robot)
        except TfsatError as error:
            found.append(Compared("calibration", None, error.what, lacking=True))
            continue
        found.append(Compared("calibration", again.differs, f"{name}: {again.sentence}", again.lacking))
    return found


def _differences(bundled: Any, recomputed: Any, tolerance: Any) -> list[Difference]:
    from tfsat_host.bundle.comparing import differences

    return [one for one in differences(bundled, recomputed, tolerance) if one.key not in _OF_ITS_TIME]


def _load(path: Path) -> Any:
    """A JSON file of the bundle, whose hash is right; `_UNREADABLE` if it is none."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError, RecursionError):
        return _UNREADABLE


def _numbers(value: Any) -> int:
    if isinstance(value, dict):
        return sum(map(_numbers, value.values()))
    if isinstance(value, list):
        return sum(map(_numbers, value))
    return isinstance(value, int | float) and not isinstance(value, bool)


def _as_dict(one: Compared) -> dict[str, Any]:
    differs = None if one.differs is None else [vars_of(difference) for difference in one.differs]
    return {"what": one.what, "sentence": one.sentence, "lacking": one.lacking, "differences": differs}


def vars_of(difference: Difference) -> dict[str, Any]:
    """For JSON."""
    return {
        "key": difference.key,
        "bundled": difference.bundled,
        "recomputed": difference.recomputed,
        "relative": difference.relative,
    }
