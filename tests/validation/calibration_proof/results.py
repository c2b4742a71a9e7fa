"""How far calibrations were from the truth, and whether they knew it: the tables of docs/calibration-proof.md."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tests.validation.calibration_proof.robots import QUANTITIES, Errors
from tests.validation.tables import csv_text
from tests.validation.targets import Target, targets_csv

UNITS = {"bias": "deg/s", "misalignment": "deg", "scale": "%", "skew": "%", "zero": "deg"}
RMS_MAX = {"bias": 0.02, "misalignment": 0.1, "scale": 0.2, "skew": 0.2, "zero": 0.1}
# The upper bound counts too: intervals that always hold are stated too wide.
COVERED_PERCENT = (90.0, 99.0)
"""So often must a 95 % interval hold the truth."""
_NORMAL_95 = 1.959964

Results = Mapping[int, Mapping[str, Errors]]
"""By the robot's number and the quantity."""


def make_tables(results: Results) -> dict[str, str]:
    """Return the text of each CSV file by its name."""
    return {
        "targets.csv": targets_csv(find_targets(results)),
        "errors.csv": csv_text(
            ("quantity", "values", "largest error", "stated std, median", "unit"),
            [_describe_errors(results, name) for name in QUANTITIES],
        ),
        "robots.csv": csv_text(
            ("robot", *(f"{name} ({UNITS[name]})" for name in QUANTITIES)),
            [
                (seed, *(f"{errors[name].rms:.5f}" for name in QUANTITIES))
                for seed, errors in sorted(results.items())
            ],
        ),
    }


def find_targets(results: Results) -> list[Target]:
    """Return the rms error and the coverage of each quantity, with their bounds."""
    targets = [
        Target(f"rms error of {name}", calculate_rms(results, name), high=RMS_MAX[name], unit=UNITS[name])
        for name in QUANTITIES
    ]
    shares = {name: round(100.0 * calculate_coverage(results, name), 1) for name in QUANTITIES}
    return targets + [
        Target(f"95 % intervals of {name} that hold", share, *COVERED_PERCENT, "%")
        for name, share in shares.items()
    ]


def calculate_rms(results: Results, name: str) -> float:
    """Return the root mean square of a quantity's errors over all robots."""
    return float(np.sqrt(np.mean(np.concatenate([errors[name].error for errors in results.values()]) ** 2)))


def calculate_coverage(results: Results, name: str) -> float:
    """Return the share of the values whose 95 % interval holds the truth."""
    # z-scores: an error in its own standard deviations.
    off = [np.abs(errors[name].error) / errors[name].std for errors in results.values()]
    return float((np.concatenate(off) < _NORMAL_95).mean())


def _describe_errors(results: Results, name: str) -> tuple[object, ...]:
    error = np.concatenate([errors[name].error for errors in results.values()])
    std = np.concatenate([errors[name].std for errors in results.values()])
    return name, len(error), float(np.abs(error).max()), float(np.median(std)), UNITS[name]
