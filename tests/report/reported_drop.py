"""A real drop of the emulated robot, evaluated once a run of the tests, as a report has it; parts of its document."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tests.evaluation.run_folder import CERTIFICATE, made_drop, made_folder
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.evaluation.evaluation import Evaluation, evaluate
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
def evaluated() -> Evaluation:
    """Centers of mass are up to 8 mm off, so that before and after differ."""
    log = load(folder() / "SD.bin")
    return evaluate(log, load_robot(), read_calibration(folder() / CERTIFICATE), made_drop().schedule)


def reported(found: Evaluation | None = None, name: str = "drop 1") -> ReportedDrop:
    """Return the reported drop, or another evaluation of its recording."""
    found = found or evaluated()
    path = folder() / "SD.bin"
    return ReportedDrop(name, found, verdict_of(found), sha256_of(path), folder() / CERTIFICATE)


def drop_of(found: Evaluation | None = None) -> Any:
    return document_of([reported(found)], MADE)["drops"][0]


def numbers(drop: Any) -> dict[str, Any]:
    return {one["label"]: one for one in drop["key_numbers"]}


def plots(drop: Any) -> dict[str, Any]:
    return {plot["id"]: plot for plot in drop["plots"]}


def series(plot: Any) -> dict[str, Any]:
    return {one["label"]: np.array(one["values"], dtype=np.float64) for one in plot["series"]}


def table(drop: Any, title: str) -> Any:
    return next(one for one in drop["tables"] if one["title"] == title)
