"""A real drop of the emulated robot, evaluated once a run of the tests, as a report has it; parts of its document."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tests.evaluation.run_folder import CERTIFICATE, made_drop, made_folder
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.file_hash import sha256_of
from tfsat_host.report.contents.document_builder import ReportedDrop, document_of
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import load

MADE = datetime(2026, 1, 5, 12, 0, tzinfo=UTC)


def folder() -> Path:
    """Return the run's folder, which must not be changed."""
    return made_folder()


@cache
def evaluate_run() -> Evaluation:
    """Centers of mass are up to 8 mm off, so that before and after differ."""
    log = load(folder() / "SD.bin")
    return evaluate(log, load_robot(), read_calibration(folder() / CERTIFICATE), made_drop().schedule)


def report_drop(evaluation: Evaluation | None = None, name: str = "drop 1") -> ReportedDrop:
    """Return the reported drop, or another evaluation of its recording."""
    evaluation = evaluation or evaluate_run()
    path = folder() / "SD.bin"
    return ReportedDrop(name, evaluation, verdict_of(evaluation), sha256_of(path), folder() / CERTIFICATE)


def drop_of(evaluation: Evaluation | None = None) -> Any:
    return document_of([report_drop(evaluation)], MADE)["drops"][0]


def numbers(drop: Any) -> dict[str, Any]:
    return {key_number["label"]: key_number for key_number in drop["key_numbers"]}


def plots(drop: Any) -> dict[str, Any]:
    return {plot["id"]: plot for plot in drop["plots"]}


def series(plot: Any) -> dict[str, Any]:
    return {curve["label"]: np.array(curve["values"], dtype=np.float64) for curve in plot["series"]}


def table(drop: Any, title: str) -> Any:
    return next(entry for entry in drop["tables"] if entry["title"] == title)
