"""Which cause an evaluation names of drops in which one thing is wrong, all else drawn from what the files state."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

from tests.validation.evaluation_proof.campaign import keep_result
from tests.validation.evaluation_proof.hidden import hidden
from tests.validation.evaluation_proof.mismatches import draw_schedule
from tests.validation.simulation_based_calibration.drops import FILED
from tests.validation.tables import csv_text
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.checks.cause_evidence import SOUND, TIE
from tfsat_host.evaluation.checks.check import Cause
from tfsat_host.evaluation.checks.drop_checks import checks_of
from tfsat_host.evaluation.com_fit.model_comparison import compare_model
from tfsat_host.evaluation.com_fit.offsets import model_offsets
from tfsat_host.evaluation.motion.motion import motion_of
from tfsat_host.evaluation.motion.samples import samples_of
from tfsat_host.evaluation.rest import rest_before_release

DROPS = 30
FIRST_SEED = 8001
"""Of all causes; none of these drops was looked at before the campaign."""
# A cause counts as named if it is first in 80 % of its drops and tied in at most 20 %.
FIRST_MIN, TIED_MAX = 0.8, 0.2
"""Shares of the drops of a cause."""
CAUSES: Mapping[str, Sequence[str]] = {
    "masses": ("wrong-masses=40",),
    "hinge points": ("wrong-hinge-points=10",),
    "joint axis": ("wrong-hinge-axes=5",),
    "gyro scale": ("gyro-scale-changed=1",),
    "g-sensitivity": ("gyro-g-sensitive=0.5",),
    "bias step": ("gyro-bias-step=0.3",),
    "slipped sensor": ("angle-sensor-crept=1",),
    "timing": ("imu-late=2",),
    "saturation": ("gyro-saturated-unflagged=100",),
    "certificate": ("certificate-wrong=3",),
    SOUND: (),
}
"""By kind of cause: the fault that is drawn, on top of all that the robot file calls uncertain. The size of those of
the robot itself is a standard deviation, 10 or 20 times the file's: many smaller ones lie within what the file states,
and what centers of mass explain as well cannot be told from them."""


class Named(NamedTuple):
    """One drop.

    Attributes:
        causes: Ranked; empty if no check failed.
        failed: Names of the checks that did.
    """

    causes: tuple[Cause, ...]
    failed: tuple[str, ...]

    @property
    def first(self) -> str:
        """The likeliest kind."""
        return self.causes[0].kind if self.causes else SOUND

    @property
    def tied(self) -> bool:
        """Two cannot be told apart, and it is said so."""
        return len(self.causes) > 1 and self.causes[0].probability < TIE * self.causes[1].probability


def name_causes(kind: str, number: int) -> Named:
    """Drop `number` of a cause, from 0; without what an evaluation does with it besides."""
    seed = FIRST_SEED + number
    schedule = draw_schedule(seed)
    # One fault on top of all that the robot file calls uncertain.
    drop, calibration = hidden(schedule, FILED, seed, CAUSES[kind])
    samples = samples_of(drop.log, calibration, FILED)
    # Noise densities come from the rest before the release, as in a real evaluation.
    densities = rest_before_release(drop.log).densities_rad_s_rthz
    motion = motion_of(samples, calibration, FILED, densities, LowPass.of(drop.log.header))
    fit = compare_model(motion, model_offsets(FILED), schedule.strokes[0].t_s).fit
    failed = [check for check in checks_of(motion, fit, drop.log, calibration, FILED) if check.failed]
    causes = next((check.causes for check in failed if check.causes), ())
    return Named(causes, tuple(check.name for check in failed))


def one_cause(kind: str, drops: int = DROPS) -> tuple[str, list[Named]]:
    """Simulate the drops of a cause, loading from disk those flown before with the same code."""
    module = "tests.validation.evaluation_proof.causes"
    return kind, [
        keep_result(f"cause-{kind}-{number}", module, partial(name_causes, kind, number))
        for number in range(drops)
    ]


Drops = Mapping[str, Sequence[Named]]
"""By kind of cause."""


def first_share(kind: str, drops: Sequence[Named]) -> float:
    """Return the fraction of the drops in which the true cause is the likeliest."""
    return sum(drop.first == kind for drop in drops) / len(drops)


def tied_share(drops: Sequence[Named]) -> float:
    """Return the fraction of the drops in which two causes cannot be told apart."""
    return sum(drop.tied for drop in drops) / len(drops)


def count_causes(causes: Drops) -> str:
    """Return a table with a row a kind of cause: how often the true one was the likeliest."""
    rows = []
    for kind, drops in causes.items():
        # Confusions: which cause was named in place of the true one.
        others = Counter(drop.first for drop in drops if drop.first not in (kind, SOUND))
        met = first_share(kind, drops) >= FIRST_MIN and tied_share(drops) <= TIED_MAX
        rows.append(
            (
                kind,
                ", ".join(f"`{fault}`" for fault in CAUSES[kind]) or "–",
                ", ".join(f"{other} {count}" for other, count in others.most_common()) or "–",
                met,
                len(drops),
                sum(drop.first == kind for drop in drops),
                sum(drop.tied for drop in drops),
                sum(not drop.causes for drop in drops),
            )
        )
    columns = ("cause", "fault", "named instead", "met", "drops", "true one first", "tied", "nothing named")
    return csv_text(columns, rows)


def causes_csv(causes: Drops) -> str:
    """Drop by drop."""
    columns = ("cause", "drop", "first", "probability", "second", "probability of it", "failed checks")
    rows = []
    for kind, drops in causes.items():
        for number, drop in enumerate(drops):
            cells = [(cause.kind, f"{cause.probability:.3f}") for cause in drop.causes[:2]]
            # Fewer than two causes: empty cells keep the columns.
            cells += [("", "")] * (2 - len(cells))
            rows.append((kind, str(FIRST_SEED + number), *cells[0], *cells[1], "; ".join(drop.failed)))
    return csv_text(columns, rows)
