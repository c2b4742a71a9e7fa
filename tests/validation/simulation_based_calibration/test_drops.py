"""A drop with everything drawn is judged by its truth; the campaign of a thousand is `make sbc-report`."""

from __future__ import annotations

import numpy as np
import pytest

from tests.paths import DOCS
from tests.validation.calibration_proof.robots import Errors
from tests.validation.simulation_based_calibration.drops import (
    FILED,
    MANEUVERS,
    QUANTITIES,
    Judged,
    judge_drop,
    true_offsets,
)
from tests.validation.simulation_based_calibration.results import (
    describe_campaign,
    histograms_csv,
    list_z,
    make_tables,
    picture,
    rows,
)
from tests.validation.tables import read_rows
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.com_fit.offsets import model_offsets
from tfsat_host.rehearsal.hidden import draw_hidden

FIRST = DOCS / "simulation-based-calibration" / "first-drops.csv"
PRINTED = 5e-3
"""Of a standard deviation: other processors end their searches a little elsewhere."""


def test_the_true_parameters_make_the_true_robot() -> None:
    true_model = draw_hidden(FILED, 3).model
    offsets = model_offsets(FILED)
    corrected_multibody, true = offsets.correct(true_offsets(offsets, true_model)), Multibody.of(true_model)
    for name in ("mass_kg", "com_m", "inertia_kg_m2", "joint_point_m"):
        np.testing.assert_allclose(
            getattr(corrected_multibody, name), getattr(true, name), rtol=1e-9, atol=1e-12, err_msg=name
        )


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.prove)])
@pytest.mark.parametrize("kind", MANEUVERS)
def test_no_number_of_a_drop_is_far_from_its_truth(kind: str, seed: int) -> None:
    outcome = judge_drop(kind, seed)
    assert tuple(outcome.errors) == QUANTITIES and not outcome.withheld and not outcome.widened
    z_scores = np.concatenate([errors.error / errors.std for errors in outcome.errors.values()])
    assert len(z_scores) > 70 and np.abs(z_scores).max() < 4.5
    assert 0.5 < np.sqrt(np.mean(z_scores**2)) < 1.4
    assert list_z(outcome) == pytest.approx(read_row(kind, seed), abs=PRINTED)


def read_row(kind: str, seed: int) -> list[float]:
    """Return what the page's table has of a drop."""
    _, *rows = read_rows(FIRST, kind)
    (row,) = (row for row in rows if row[0] == str(seed))
    return [float(cell) for cell in row[1:]]


def test_strokes_of_drawn_maneuvers_overlap() -> None:
    maneuvers = [MANEUVERS["joints together"](seed) for seed in range(1, 40)]
    assert len({maneuver.strokes for maneuver in maneuvers}) == len(maneuvers)
    assert all(maneuver.moving_at_once > 1 and maneuver.end_s < 2.4 for maneuver in maneuvers)


def make_judged(drops: int, times: float, off: float = 0.0) -> list[Judged]:
    """Errors so many times as wide as stated."""
    random = np.random.default_rng(1)
    return [
        Judged(
            {name: Errors(times * random.standard_normal(2) + off, np.ones(2)) for name in QUANTITIES},
            (),
            False,
        )
        for _ in range(drops)
    ]


def test_right_intervals_are_told_from_wrong_ones() -> None:
    right = rows(make_judged(400, 1.0))
    assert all(row.met for row in right)
    for wrong in (make_judged(400, 0.8), make_judged(400, 1.25), make_judged(400, 1.0, off=0.4)):
        assert not any(row.met for row in rows(wrong))
    assert ",no\n" in make_tables({"of a kind": make_judged(400, 0.8)})["quantities.csv"]
    assert ",no\n" not in make_tables({"of a kind": make_judged(400, 1.0)})["quantities.csv"]
    assert describe_campaign({"of a kind": make_judged(400, 1.0)})["rank tests"] == 2 * len(QUANTITIES)
    assert histograms_csv({"of a kind": make_judged(40, 1.0)}).count("\n") == 1 + 2 * len(QUANTITIES)
    assert picture(make_judged(40, 1.0)).lstrip().startswith("<?xml")
