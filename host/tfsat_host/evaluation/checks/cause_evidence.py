"""Which cause: hypotheses compared by the evidence of one drop, each kind of cause as likely as another before it.

The whole residual is normal, with what is stated as its covariance. A hypothesis adds columns with unknown numbers of
a typical size; how much larger or smaller they are is unknown, too. The evidence of a hypothesis is the probability of
the residual with all of that integrated out, so that a fault with many numbers must explain as much more (D. MacKay,
Information Theory, Inference, and Learning Algorithms, 2003, chapter 28). A kind of cause has members, such as one for
each gyro and time: its evidence is their mean.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.checks.check import UNKNOWN, Cause, SensorColumn
from tfsat_host.evaluation.checks.whole_residual import WholeResidual
from tfsat_host.next_step import Advice, NextStep

SIZES = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Times the typical size, that a fault's numbers may have."""
_WORSE = (1.5, 2.0, 3.0, 5.0, 10.0, 30.0, 100.0, 300.0)
"""Times as great all errors may be for no reason that is known."""
SOUND = "as filed and certified"
TIE = 3.0
"""Two causes whose probabilities are closer than this cannot be told apart: "barely worth mentioning" (H. Jeffreys,
Theory of Probability, 1961, appendix B)."""
_ENDS_IT = 2.0
"""Chi-square a number that a true cause may leave: healthy drops leave 0.5."""
_CERTAIN, _LISTED = 0.995, 0.001
MIN_CULPRIT_PROBABILITY = 0.95
"""Of a sensor that is left out. One that is accused wrongly is kept: the others would not agree without it."""
_LOOK = Advice("Look at the samples: ", NextStep("decode"))
Words = Callable[[FloatArray], str]


class Hypothesis(NamedTuple):
    """One fault.

    Attributes:
        kind: Of cause.
        columns: (size, q) of the whole residual by the fault's q unknown numbers, each of which is typically 1.
        words: The cause in words, by those numbers (q,) at their best fit.
        next_step: What to do about it.
        left: (size,) the residual with the fault put right, but for those numbers; None: as it is.
        sensor: The one that is wrong then; None: none or several.
    """

    kind: str
    columns: FloatArray
    words: Words
    next_step: str
    left: FloatArray | None = None
    sensor: SensorColumn | None = None


class TestedHypothesis(NamedTuple):
    """A hypothesis with the logarithm of its evidence; `columns` (k, q) are whitened, of their likeliest size."""

    kind: str
    log_evidence: float
    words: Callable[[], str]
    next_step: str
    columns: FloatArray
    sensor: SensorColumn | None = None


def try_hypotheses(residuals: WholeResidual, hypotheses: Iterable[Hypothesis]) -> list[TestedHypothesis]:
    """Compute the evidence of each hypothesis."""
    as_it_is = residuals.whiten(residuals.residual)
    trials: list[TestedHypothesis] = []
    chosen = list(hypotheses)
    widths = np.cumsum([0, *(hypothesis.columns.shape[1] for hypothesis in chosen)])
    columns = residuals.whiten(np.concatenate([hypothesis.columns for hypothesis in chosen], axis=1))
    for first, last, hypothesis in zip(widths, widths[1:], chosen, strict=False):
        whitened_residual = as_it_is if hypothesis.left is None else residuals.whiten(hypothesis.left)
        trials.append(_try_hypothesis(hypothesis, whitened_residual, columns[:, first:last]))
    return trials


def _try_hypothesis(
    hypothesis: Hypothesis, whitened_residual: FloatArray, columns: FloatArray
) -> TestedHypothesis:
    """Compute a hypothesis's evidence in the eigenvectors of its columns' normal matrix.

    There the evidence is equally easy to compute for every size of the fault.
    """
    values, axes = np.linalg.eigh(columns.T @ columns)
    along, values = axes.T @ (columns.T @ whitened_residual), np.maximum(values, 0.0)
    # (sizes, 1), broadcast over the eigenvectors; a fault without numbers has one size.
    squares = np.array(SIZES if len(values) else (1.0,))[:, None] ** 2
    # Posterior variance along each eigenvector, by size.
    shrunk = squares / (1.0 + squares * values)
    # What the fit explains, less the Occam factor: the logarithm of prior over posterior volume.
    logs = 0.5 * (shrunk * along**2).sum(axis=1) - 0.5 * np.log1p(squares * values).sum(axis=1)
    likeliest = int(logs.argmax())
    best = shrunk[likeliest]
    # Mean over the sizes, which are equally likely; then the likelihood without the fault.
    evidence = float(logsumexp(logs) - np.log(len(squares)) - 0.5 * whitened_residual @ whitened_residual)

    def words() -> str:
        # Posterior mean: the numbers whose columns cancel the residual.
        numbers = -axes @ (best * along)
        unexplained = float(((whitened_residual + columns @ numbers) ** 2).mean())
        still = f"; with it the data still contradict each other {unexplained:.3g} times as much as their errors allow"
        return hypothesis.words(numbers) + (still if unexplained > _ENDS_IT else "")

    return TestedHypothesis(
        hypothesis.kind,
        evidence,
        words,
        hypothesis.next_step,
        np.sqrt(squares[likeliest]) * columns,
        hypothesis.sensor,
    )


def of_no_kind(residuals: WholeResidual) -> list[TestedHypothesis]:
    """Compute the evidence of two special hypotheses: nothing is wrong, and everything is."""
    whitened_residual = residuals.whiten(residuals.residual)
    k, chi_square = len(whitened_residual), float(whitened_residual @ whitened_residual)
    factors = np.array(_WORSE)
    # All errors greater by one factor: each row costs its logarithm, and chi-square falls by its square.
    logs = -k * np.log(factors) - 0.5 * chi_square / factors**2
    misfit, no_columns = f"{chi_square / k:.3g}", np.zeros((k, 0))
    agree = f"{UNKNOWN}; gyros, angle sensors and model agree to {misfit} times what their errors allow"
    apart = f"{UNKNOWN}; the data contradict each other {misfit} times as much as their errors allow"
    return [
        TestedHypothesis(SOUND, -0.5 * chi_square, lambda: agree, _LOOK, no_columns),
        TestedHypothesis(
            UNKNOWN, float(logsumexp(logs) - np.log(len(factors))), lambda: apart, _LOOK, no_columns
        ),
    ]


def rank_causes(trials: Sequence[TestedHypothesis]) -> tuple[Cause, ...]:
    """Kinds of causes, the likeliest first."""
    kinds: dict[str, list[TestedHypothesis]] = {}
    for trial in trials:
        kinds.setdefault(trial.kind, []).append(trial)
    # The members of a kind share its prior: their mean, so that many members are no advantage.
    logs = {
        kind: float(logsumexp([trial.log_evidence for trial in of_kind]) - np.log(len(of_kind)))
        for kind, of_kind in kinds.items()
    }
    total = float(logsumexp([*logs.values()]))
    causes: list[Cause] = []
    for kind in sorted(logs, key=lambda kind: -logs[kind]):
        best = max(kinds[kind], key=lambda trial: trial.log_evidence)
        probability = float(np.exp(logs[kind] - total))
        if probability >= _LISTED or not causes:
            accusing = logsumexp([trial.log_evidence for trial in kinds[kind] if trial.sensor == best.sensor])
            share = float(np.exp(accusing - np.log(len(kinds[kind])) - logs[kind]))
            causes.append(Cause(kind, best.words(), probability, best.next_step, best.sensor, share))
    return tuple(causes)


def find_culprit(causes: Sequence[Cause]) -> SensorColumn | None:
    """Return the sensor that is wrong with `MIN_CULPRIT_PROBABILITY`, whatever is wrong with it; else None."""
    accused = causes[0].sensor if causes else None
    if accused is None:
        return None
    # Kinds of cause may be tied, such as a bias that stepped and one that was wrong all along, in one sensor.
    probability = sum(cause.probability * cause.sensor_share for cause in causes if cause.sensor == accused)
    return accused if probability >= MIN_CULPRIT_PROBABILITY else None


def in_words(causes: Sequence[Cause]) -> tuple[str, str]:
    """Format the likely cause, or the two that cannot be told apart, and the next step.

    The probability is stated unless it is one.
    """
    first, *others = causes
    if others and first.probability < TIE * others[0].probability:
        pair = " from ".join(
            f"{cause.cause} (probability {cause.probability:.2f})" for cause in (first, others[0])
        )
        # Of a tie, the next step is that of the cause that can be acted on.
        named = first if first.kind not in (SOUND, UNKNOWN) else others[0]
        return f"cannot tell {pair}", named.next_step
    certain = "" if first.probability >= _CERTAIN else f" (probability {first.probability:.2f})"
    return f"{first.cause}{certain}", first.next_step
