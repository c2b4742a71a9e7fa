"""Every sample of a study as a CSV file: what it did, and with which parameters."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from tfsat_host.output_files import OutputFile, check_may_write, write_all

if TYPE_CHECKING:
    from tfsat_host.plan.study import Outcomes, Study
    from tfsat_host.robot.model import FloatArray

_MARKER = b"sample,reorientation_deg,rotation_x_deg,rotation_y_deg,rotation_z_deg,attitude_error_deg"


def check_samples_file(path: Path, *, force: bool) -> None:
    """Refuses, before anything is computed, a file that this command did not make.

    Raises:
        TfsatError: the file exists, or something is in the way.
    """
    check_may_write(path, marker=_MARKER, force=force)


def write_samples(
    study: Study, outcomes: Outcomes, nominal_xyzw: FloatArray, path: Path, *, force: bool
) -> None:
    """A row a sample: its number from 1, its outputs, its parameters with their units.

    Raises:
        TfsatError: the file exists and was not made by this command, or something is in the way.
    """

    def write(target: Path) -> None:
        with target.open("w", encoding="utf-8", newline="\n") as file:
            _write(study, outcomes, nominal_xyzw, file)

    write_all([OutputFile(path, _MARKER, write)], force=force)


def _write(study: Study, outcomes: Outcomes, nominal_xyzw: FloatArray, file: TextIO) -> None:
    import numpy as np

    from tfsat_host.plan.statistics import outputs_of

    outputs = outputs_of(outcomes, nominal_xyzw)
    named = zip(study.parameters.names, study.parameters.units, strict=True)
    file.write(",".join(["sample", *outputs, *(_column(f"{name} {unit}") for name, unit in named)]) + "\n")
    results, first = np.column_stack(list(outputs.values())), 0
    for chunk in range(study.chunks):
        vectors = study.vectors(study.deviates(chunk))
        rows = np.hstack([results[first : first + len(vectors)], vectors])
        for sample, row in enumerate(rows.tolist(), first + 1):
            file.write(f"{sample},{','.join(map(repr, row))}\n")
        first += len(vectors)


def _column(text: str) -> str:
    """A name that needs no quotes anywhere: `body_1_com_x_mm`."""
    return re.sub(r"[^a-z0-9]+", "_", text.lower().replace("^", "")).strip("_")
