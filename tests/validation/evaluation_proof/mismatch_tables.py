"""Robots and sensors that are not as filed: what was said of each row of drops, and what held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom, norm

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.errors import join_errors
from tests.validation.evaluation_proof.figures import COVERED, covered_share, percent
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
        hold: Of all quantities together, of drops with one joint at a time and with joints together.
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
    hold: tuple[float, float]
    by_quantity: Mapping[str, float]
    off: tuple[str, ...]

    @property
    def met(self) -> bool:
        """All that is wanted of it."""
        # NaN, no value given, is neither below nor above.
        is_covered = not any(share < COVERED[0] or share > COVERED[1] for share in self.hold)
        has_required_results = not (self.row.of_model and set(ALWAYS_GIVEN) & set(self.withheld))
        # Of a right robot at most 5 % of the drops may lose a result.
        within_limit = (
            not self.row.right or max(self.withheld.values(), default=0) <= WITHHELD_MAX * self.drops
        )
        return is_covered and has_required_results and within_limit and not self.wrong and not self.off


def summary(row: Row, drops: Sequence[Judged]) -> Summary:
    """Summarize all drops of a row."""
    errors_by_name = {
        name: [drop.errors[name] for drop in drops if name in drop.errors] for name in PROTECTED
    }
    shares = {name: _covered_share(ones) for name, ones in errors_by_name.items()}
    one_at_a_time, together = (
        _covered_share([errors for drop in drops if drop.together == kind for errors in drop.errors.values()])
        for kind in (False, True)
    )
    off = tuple(name for name, share in shares.items() if _beyond_chance(share, len(errors_by_name[name])))
    return Summary(
        row,
        len(drops),
        sum(drop.good for drop in drops),
        sum(drop.worth == "to be made" for drop in drops),
        {name: n for name in PROTECTED.values() if (n := sum(name in drop.withheld for drop in drops))},
        max(drop.worst for drop in drops),
        sum(drop.good and drop.worst > STDS_MAX for drop in drops),
        (one_at_a_time, together),
        shares,
        off,
    )


def _covered_share(errors: Sequence[Errors]) -> float:
    return covered_share(join_errors(errors)) if errors else float("nan")


def _beyond_chance(share: float, drops: int) -> bool:
    """Values of one drop hang together: chance is judged by the drops."""
    # A 95 % interval holds in a binomial number of drops; outside the 99.9 % band chance is no excuse.
    low, high = np.array(binom.interval(1.0 - CHANCE, drops, 0.95)) / max(drops, 1)
    return bool(share < low or share > high)


Drops = Mapping[str, Sequence[Judged]]
"""By the row's name."""


def summaries(drops: Drops) -> list[Summary]:
    """Summarize all rows, in their order."""
    return [summary(row, drops[row.name]) for row in ROWS]


def expect_by_chance(drops: Drops) -> float:
    """Return how many GOOD drops would have a number beyond `STDS_MAX`, were all ± right."""
    error_counts = [
        sum(errors.error.size for errors in drop.errors.values())
        for of_row in drops.values()
        for drop in of_row
        if drop.good
    ]
    # Two-sided: probability that at least one of `count` normal values lies beyond STDS_MAX.
    return float(sum(1.0 - norm.cdf(STDS_MAX) ** (2 * count) for count in error_counts))


def _verdict_cells(row_summary: Summary) -> tuple[object, ...]:
    return (
        row_summary.row.name,
        str(row_summary.good),
        str(row_summary.to_be_made),
        ", ".join(f"{name} {count}" for name, count in row_summary.withheld.items()) or "none",
        f"{row_summary.worst:.1f}" if row_summary.worst else "–",
        str(row_summary.wrong),
        ", ".join("–" if np.isnan(share) else percent(share) for share in row_summary.hold),
        ", ".join(row_summary.off) or "none",
        row_summary.met,
    )


def make_mismatch_tables(drops: Drops) -> dict[str, str]:
    """Return the text of each table by its name."""
    shares = [
        (row_summary.row.name, *(percent(row_summary.by_quantity[name]) for name in PROTECTED))
        for row_summary in summaries(drops)
    ]
    each = [
        (row.name, str(seed), "together" if drop.together else "one at a time", *row_of(drop))
        for row in ROWS
        for seed, drop in zip(seeds_of(row, len(drops[row.name])), drops[row.name], strict=True)
    ]
    columns = ("wrong is", "GOOD", "to be made", "withheld", "worst", "beyond 4, GOOD", "hold", "off", "met")
    return {
        "mismatch-verdicts": csv_text(columns, map(_verdict_cells, summaries(drops))),
        "mismatches": csv_text(("wrong is", *PROTECTED), shares),
        "mismatch-drops": csv_text(("wrong is", "seed", "joints move", *ROW_COLUMNS), each),
    }


ROW_COLUMNS = ("verdict", "correction", "withheld", "times", *PROTECTED, "checks failed")


def row_of(drop: Judged) -> tuple[str, ...]:
    """Format one drop as a table row.

    For each quantity it has the worst error in the quantity's own standard deviations, empty where it is
    withheld.
    """
    worst = (
        f"{np.abs(drop.errors[name].error / drop.errors[name].std).max():.2f}" if name in drop.errors else ""
        for name in PROTECTED
    )
    return (
        "good" if drop.good else "doubtful",
        drop.worth,
        " ".join(drop.withheld),
        f"{drop.widening:.1f}",
        *worst,
        "; ".join(drop.failed),
    )
