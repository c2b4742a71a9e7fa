"""Robots and sensors that are not as filed: what was said of each row of drops, and what held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom, norm

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.errors import joined
from tests.validation.evaluation_proof.figures import COVERED, covered, percent
from tests.validation.evaluation_proof.mismatches import PROTECTED, ROWS, Judged, Row, seeds_of
from tests.validation.tables import csv_text

STDS_MAX = 4.0
CHANCE = 1e-3
"""Of a quantity outside of its bounds, were its intervals right."""
WITHHELD_MAX = 0.05
"""Share of the drops of robots that are as filed."""
ALWAYS_GIVEN = ("attitudes", "strokes")
"""Of robots whose file alone is wrong."""


@dataclass(frozen=True, slots=True)
class Summary:
    """One row; shares are NaN where nothing was given.

    Attributes:
        row: What was wrong.
        drops: How many.
        good: So many verdicts.
        to_be_made: So many corrections.
        withheld: Drops by what is not given.
        worst: In its own standard deviations.
        wrong: GOOD drops with an error beyond `STDS_MAX`.
        hold: Of all quantities together.
        by_quantity: Of each.
        off: Names of those that chance does not explain.
    """

    row: Row
    drops: int
    good: int
    to_be_made: int
    withheld: Mapping[str, int]
    worst: float
    wrong: int
    hold: float
    by_quantity: Mapping[str, float]
    off: tuple[str, ...]

    @property
    def met(self) -> bool:
        """All that is wanted of it."""
        held = not self.hold < COVERED[0] and not self.hold > COVERED[1]
        given = not (self.row.of_model and set(ALWAYS_GIVEN) & set(self.withheld))
        kept = not self.row.right or max(self.withheld.values(), default=0) <= WITHHELD_MAX * self.drops
        return held and given and kept and not self.wrong and not self.off


def summary(row: Row, drops: Sequence[Judged]) -> Summary:
    """Of all drops of a row."""
    given = {name: [one.errors[name] for one in drops if name in one.errors] for name in PROTECTED}
    shares = {name: _held(ones) for name, ones in given.items()}
    off = tuple(name for name, share in shares.items() if _beyond_chance(share, len(given[name])))
    return Summary(
        row,
        len(drops),
        sum(one.good for one in drops),
        sum(one.worth == "to be made" for one in drops),
        {name: n for name in PROTECTED.values() if (n := sum(name in one.withheld for one in drops))},
        max(one.worst for one in drops),
        sum(one.good and one.worst > STDS_MAX for one in drops),
        _held([error for ones in given.values() for error in ones]),
        shares,
        off,
    )


def _held(errors: Sequence[Errors]) -> float:
    return covered(joined(errors)) if errors else float("nan")


def _beyond_chance(share: float, drops: int) -> bool:
    """Values of one drop hang together: chance is judged by the drops."""
    low, high = np.array(binom.interval(1.0 - CHANCE, drops, 0.95)) / max(drops, 1)
    return bool(share < low or share > high)


Drops = Mapping[str, Sequence[Judged]]
"""By the row's name."""


def summaries(drops: Drops) -> list[Summary]:
    """Of all rows, in their order."""
    return [summary(row, drops[row.name]) for row in ROWS]


def expect_by_chance(drops: Drops) -> float:
    """Return how many GOOD drops would have a number beyond `STDS_MAX`, were all ± right."""
    given = [
        sum(errors.error.size for errors in one.errors.values())
        for of_row in drops.values()
        for one in of_row
        if one.good
    ]
    return float(sum(1.0 - norm.cdf(STDS_MAX) ** (2 * count) for count in given))


def _verdict_cells(one: Summary) -> tuple[object, ...]:
    return (
        one.row.name,
        str(one.good),
        str(one.to_be_made),
        ", ".join(f"{name} {count}" for name, count in one.withheld.items()) or "none",
        "–" if np.isnan(one.hold) else f"{one.worst:.1f}",
        str(one.wrong),
        "–" if np.isnan(one.hold) else percent(one.hold),
        ", ".join(one.off) or "none",
        one.met,
    )


def make_mismatch_tables(drops: Drops) -> dict[str, str]:
    """Return the text of each table by its name."""
    shares = [
        (one.row.name, *(percent(one.by_quantity[name]) for name in PROTECTED)) for one in summaries(drops)
    ]
    each = [
        (row.name, str(seed), *row_of(one))
        for row in ROWS
        for seed, one in zip(seeds_of(row, len(drops[row.name])), drops[row.name], strict=True)
    ]
    columns = ("wrong is", "GOOD", "to be made", "withheld", "worst", "beyond 4, GOOD", "hold", "off", "met")
    return {
        "mismatch-verdicts": csv_text(columns, map(_verdict_cells, summaries(drops))),
        "mismatches": csv_text(("wrong is", *PROTECTED), shares),
        "mismatch-drops": csv_text(("wrong is", "seed", *ROW_COLUMNS), each),
    }


ROW_COLUMNS = ("verdict", "correction", "withheld", "times", *PROTECTED, "checks failed")


def row_of(one: Judged) -> tuple[str, ...]:
    """One drop: of each quantity the worst error in its own standard deviations; empty where it is withheld."""
    worst = (
        f"{np.abs(one.errors[name].error / one.errors[name].std).max():.2f}" if name in one.errors else ""
        for name in PROTECTED
    )
    return (
        "good" if one.good else "doubtful",
        one.worth,
        " ".join(one.withheld),
        f"{one.widening:.1f}",
        *worst,
        "; ".join(one.failed),
    )
