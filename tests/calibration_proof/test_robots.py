"""A calibration finds what is wrong with a robot that nobody has calibrated, and how sure it is.

The full campaign is `make calibration-report`; these are some of them again.
"""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from tests.calibration_proof.page import TARGETS
from tests.calibration_proof.robots import QUANTITIES, calibrated, errors_of, recorded_day

ROBOTS = Path(__file__).parents[2] / "docs" / "calibration-proof" / "robots.csv"
MOST_DEVIATIONS = 5.0


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.prove) for seed in (2, 3, 4))])
def test_a_robot_of_the_proof(seed: int) -> None:
    day = recorded_day(seed)
    errors = errors_of(day, calibrated(day))
    for name, target in TARGETS.items():
        assert errors[name].rms <= target, name
        assert (abs(errors[name].error) / errors[name].std).max() < MOST_DEVIATIONS, name
    assert [errors[name].rms for name in QUANTITIES] == pytest.approx(_on_the_page(seed), abs=2e-5)


def _on_the_page(seed: int) -> list[float]:
    rows = csv.reader(ROBOTS.read_text(encoding="utf-8").splitlines())
    return next([float(cell) for cell in row[1:]] for row in rows if row[0] == str(seed))
