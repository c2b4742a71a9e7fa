"""Every sample of a study of sensitivity as a row of a CSV file."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.plan.spread import outputs_of
from tfsat_host.plan.study import Outcomes, Study

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
    """Write one row per sample: its number from 1, its outputs, its parameters with their units.

    Raises:
        TfsatError: the file exists and was not made by this command, or something is in the way.
    """

    def write(target: Path) -> None:
        outputs = outputs_of(outcomes, nominal_xyzw)
        named = zip(study.parameters.names, study.parameters.units, strict=True)
        # Draw the parameters again from the seed, as the chunks did.
        vectors = np.vstack([study.vectors(study.deviates(chunk)) for chunk in range(study.chunks)])
        rows = np.column_stack([*outputs.values(), vectors]).tolist()
        with target.open("w", encoding="utf-8", newline="\n") as file:
            file.write(
                ",".join(["sample", *outputs, *(_column(f"{name} {unit}") for name, unit in named)]) + "\n"
            )
            # `repr` is the shortest decimal that reads back to the same bits.
            file.writelines(f"{sample},{','.join(map(repr, row))}\n" for sample, row in enumerate(rows, 1))

    write_all([OutputFile(path, _MARKER, write)], force=force)


def _column(text: str) -> str:
    """Format a column name that needs no quotes anywhere: `body_1_com_x_mm`."""
    return re.sub(r"[^a-z0-9]+", "_", text.lower().replace("^", "")).strip("_")
