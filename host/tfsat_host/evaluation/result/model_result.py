"""The correction of the model, for tables and JSON: whether it is one to make, and what the drop tells of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import chdtri

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.identifiability import Coupling, couplings
from tfsat_host.evaluation.com_fit.model_comparison import EXPECTED_DISTANCE
from tfsat_host.evaluation.com_fit.offsets import Offsets
from tfsat_host.evaluation.com_fit.prediction import AttitudeError
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.quantity import Column, Columns, Table, fields, number

NOT_CALLED_FOR = 0.05
"""A correction as great as this one comes of noise alone in more than this share of drops: none is called for."""
MISSED = f"95 % lie below {EXPECTED_DISTANCE:g}"

Worth = Literal["to be made", "not called for", "withheld"]


def significance(evaluation: Evaluation) -> float:
    """Distance of the offsets from zero over what 95 % of corrections of a right model stay below."""
    fit = evaluation.explained.fit
    p = len(fit.values)
    # Marginal covariance of the offsets: momentum and sensors' errors are allowed for, not shown.
    squared = fit.values @ np.linalg.solve(fit.covariance[:p, :p], fit.values)
    # Degrees of freedom are what the data determine: along the other directions the prior holds zero.
    return float(np.sqrt(squared / chdtri(max(fit.determined_numbers, 1.0), NOT_CALLED_FOR)))


def worth_of(evaluation: Evaluation) -> Worth:
    """Judge whether the fitted correction is to be made; any failed check withholds it."""
    if evaluation.explained.withheld or evaluation.failed_checks:
        return "withheld"
    before = evaluation.explained.nominal.error.mahalanobis
    # The model as filed predicts within its error, and the correction is within noise: leave the file.
    if before <= EXPECTED_DISTANCE and significance(evaluation) <= 1.0:
        return "not called for"
    return "to be made"


def correction_sentences(evaluation: Evaluation) -> tuple[str, ...]:
    """Format sentences for a person who has to decide what to change in the robot file."""
    worth = worth_of(evaluation)
    if worth == "withheld":
        failed = tuple(f"Failed check: “{check.name}”." for check in evaluation.failed_checks[:1])
        explained = evaluation.explained.withheld if evaluation.is_given() else ()
        return ("Correction: withheld, leave the robot file unchanged.", *failed, *explained)
    if worth == "not called for":
        return (
            "Correction: none needed, the nominal model explains the motion and the fitted correction is within its "
            "uncertainty.",
        )
    # Along a weak direction a single offset is the prior's; only what they do together was measured.
    if evaluation.identifiability.undetermined:
        return (
            "Correction: all offsets or none; along directions that are not observable single ones are the prior's.",
        )
    return ()


def distance_words(error: AttitudeError) -> str:
    """Format the distance of an attitude error from zero in its own standard deviations."""
    return f"{error.mahalanobis:.1f} standard deviations ({MISSED})"


_ANGLES = ("φz", "φy", "φx")


class Offset(NamedTuple):
    """One number of the model that was free: what was allowed, what was found."""

    name: str
    unit: str
    value: float
    std: float
    prior_std: float
    bound: float
    at_bound: bool


OFFSETS: Columns = (
    Column("name", "what"),
    Column("unit", "unit"),
    Column("value", "correction", std="std", form="+.2f"),
    Column("prior_std", "prior σ", words=lambda offset: number(offset.prior_std, ".3g")),
    Column("", "posterior ÷ prior", words=lambda offset: f"{100.0 * offset.std / offset.prior_std:.0f} %"),
    *fields("bound at_bound"),
)


def withholding_factor(evaluation: Evaluation) -> float:
    """1, or NaN where the correction is not given; to multiply its numbers with."""
    return 1.0 if evaluation.is_given("offsets") and evaluation.is_given() else np.nan


def offsets(fit: ModelFit, times: float = 1.0) -> list[Offset]:
    """Return the offsets of a fit; `times` is the factor of `withholding_factor`."""
    return offset_rows(fit.offsets, times * fit.values, times * fit.std, fit.at_bound)


def offset_rows(free: Offsets, values: FloatArray, std: FloatArray, at_bound: BoolArray) -> list[Offset]:
    """Return a row for each of p free numbers with their values (p,) and standard deviations (p,)."""
    numbers = (column.tolist() for column in (values, std, free.prior_std, free.bounds, at_bound))
    return list(map(Offset, free.names, free.units, *numbers))


ERROR_NORM = Column("final_norm_deg")
ERROR: Columns = (
    Column("final_zyx_deg", of="final_rad", std=lambda error: np.rad2deg(error.std_rad[-1])),
    ERROR_NORM,
    *fields("rms_deg z_scores mahalanobis"),
)
_NO_ERROR: dict[str, None] = dict.fromkeys(column.key for column in ERROR)
_DIRECTION = "composition components told=determined std std_by_data prior_std"
_IDENTIFIABILITY: Columns = (
    *fields("unit condition rank"),
    Column("directions", columns=fields(_DIRECTION)),
    Column("sentences", of=lambda identifiability: identifiability.sentences()),
)
TRADE_EXACTLY = (
    "Hinge points and centers of mass trade exactly: the drop determines the sums below, the robot file's "
    "uncertainty holds the single numbers."
)
_TRADE: Columns = (
    *fields("name unit std std_alone"),
    Column("growth", of=lambda trade: dict(trade.growth)),
    Column("partners", of=lambda trade: [{"name": n, "correlation": c} for n, c in trade.partners]),
    Column("determined", columns=fields("name value std")),
)
_SWARM: Columns = (
    Column("com_offset_mm", of=lambda swarm: swarm.values.reshape(-1, 3)),
    Column("spread_mm", of=lambda swarm: swarm.spread.reshape(-1, 3)),
    Column("searches", of=lambda swarm: len(swarm.each)),
    *fields("particles iterations converged"),
    Column("sentences", of=lambda swarm: swarm.sentences()),
    Column(
        "objective_kg_m2_s",
        of=lambda swarm: swarm,
        columns=fields("before=objective_before swarm=objective gauss_newton=objective_gauss_newton"),
    ),
)


def _nominal_error(evaluation: Evaluation) -> AttitudeError | dict[str, None]:
    """Return the nominal model's error; unknown where the sensors are not trusted."""
    return evaluation.explained.nominal.error if evaluation.is_given() else _NO_ERROR


def _fitted_error(evaluation: Evaluation) -> AttitudeError | dict[str, None]:
    """Return the fitted model's error; unknown where the sensors or the correction are not trusted."""
    return evaluation.explained.fitted.error if np.isfinite(withholding_factor(evaluation)) else _NO_ERROR


def _if_given(value: Callable[[Evaluation], Any]) -> Callable[[Evaluation], Any]:
    """Make a column's value None where the sensors are not trusted."""
    return lambda evaluation: value(evaluation) if evaluation.is_given() else None


def _of_fit(value: Callable[[ModelFit], Any]) -> Callable[[Evaluation], Any]:
    """Make a column's value of the fit, NaN where the correction is withheld."""
    return lambda evaluation: withholding_factor(evaluation) * value(evaluation.explained.fit)


def _centers(values: FloatArray, fit: ModelFit) -> FloatArray:
    # The sought offsets come first: x, y, z of each corrected center of mass.
    return values[: fit.offsets.sought].reshape(-1, 3)


_CORRECTION: Columns = (
    Column("worth", of=worth_of),
    Column("significance", of=lambda evaluation: withholding_factor(evaluation) * significance(evaluation)),
    *fields("offered=explained.offered"),
    Column("withheld", of=lambda evaluation: evaluation.explained.withheld if evaluation.is_given() else []),
    *fields("converged=explained.fit.converged"),
)
MODEL: Columns = (
    Column(
        "com_offset_mm",
        of=_of_fit(lambda fit: _centers(fit.values, fit)),
        std=_of_fit(lambda fit: _centers(fit.std, fit)),
    ),
    Column(
        "offsets",
        of=lambda evaluation: offsets(evaluation.explained.fit, withholding_factor(evaluation)),
        columns=(*OFFSETS[:2], *fields("value std prior_std bound at_bound")),
    ),
    Column(
        "attitude_error_deg",
        of=lambda evaluation: evaluation,
        columns=(
            Column("before", of=lambda evaluation: ERROR_NORM.value(_nominal_error(evaluation))),
            Column("after", of=lambda evaluation: ERROR_NORM.value(_fitted_error(evaluation))),
        ),
    ),
    Column(
        "attitude_error",
        of=lambda evaluation: evaluation,
        columns=(
            Column("before", of=_nominal_error, columns=ERROR),
            Column("after", of=_fitted_error, columns=ERROR),
        ),
    ),
    Column("correction", of=lambda evaluation: evaluation, columns=_CORRECTION),
    Column("momentum_kg_m2_s", of=_of_fit(lambda fit: fit.momentum_kg_m2_s)),
    Column("excess_variance", of=_of_fit(lambda fit: fit.excess)),
    Column(
        "identifiability",
        of=_if_given(lambda evaluation: evaluation.identifiability),
        columns=_IDENTIFIABILITY,
    ),
    Column(
        "trades", of=lambda evaluation: trades(evaluation) if evaluation.is_given() else [], columns=_TRADE
    ),
    Column("swarm", of=_if_given(lambda evaluation: evaluation.swarm), columns=_SWARM),
)
"""Of an evaluation: the fitted model, its errors, and what the drop can tell of it."""


def trades(evaluation: Evaluation) -> tuple[Coupling, ...]:
    """Return the couplings of the offsets that the fit sought."""
    return couplings(evaluation.explained.fit, evaluation.explained.driven.flown)


def offset_table(evaluation: Evaluation) -> Table:
    """Build the table of offsets with their standard deviations, and those of the paper's swarm."""
    fit, swarm = evaluation.explained.fit, evaluation.swarm
    rows, columns = offsets(fit, withholding_factor(evaluation)), OFFSETS
    if swarm is not None:
        # The swarm seeks the centers of mass only: match by name, the other rows stay unknown.
        by_name = dict(
            zip(fit.offsets.alone.names, zip(swarm.values, swarm.spread, strict=True), strict=True)
        )
        columns = (*OFFSETS, other_correction("paper's swarm ± its spread", by_name))
    if np.isnan(withholding_factor(evaluation)):
        return Table("Correction of the model", OFFSETS, (), fold=" ".join(correction_sentences(evaluation)))
    sentences = [*correction_sentences(evaluation), *_stuck(rows), *evaluation.identifiability.sentences()]
    fixed_count = len(fit.offsets) - fit.offsets.sought
    return Table(
        "Correction of the model",
        columns,
        rows,
        " ".join(sentences),
        folded=fixed_count,
        fold=f"{fixed_count} more fitted parameters: uncertainties of the robot file",
    )


def remarks(evaluation: Evaluation) -> list[str]:
    """Format sentences on the couplings of single offsets and on the swarm's result, where there are any."""
    swarm = evaluation.swarm
    sentences: list[str] = []
    if np.isnan(withholding_factor(evaluation)):
        return sentences
    determined = [trade.sentence() for trade in trades(evaluation) if trade.determined]
    if determined:
        sentences += [TRADE_EXACTLY, *determined]
    if swarm is not None:
        sentences += [
            f"Swarm objective, sum of |h - h0|: {swarm.objective_before:.3g} kg m^2/s (nominal), "
            f"{swarm.objective:.3g} (swarm), {swarm.objective_gauss_newton:.3g} (fitted).",
            *swarm.sentences(),
        ]
    return sentences


def other_correction(label: str, by_name: dict[str, tuple[float, float]]) -> Column:
    """Another correction than the row's own: value and standard deviation by the offset's name."""
    unknown = (float("nan"), float("nan"))
    return Column(
        "value",
        label,
        of=lambda row: by_name.get(row.name, unknown)[0],
        std=lambda row: by_name.get(row.name, unknown)[1],
        form="+.2f",
    )


def _stuck(rows: Sequence[Offset]) -> list[str]:
    names = [row.name for row in rows if row.at_bound]
    return [f"Stopped at its bound: {', '.join(names)}."] if names else []


class _Side(NamedTuple):
    """A model's error at the end."""

    name: str
    error: AttitudeError


def _angle(index: int) -> Column:
    return Column(
        f"{_ANGLES[index]}_deg",
        _ANGLES[index],
        of=lambda side: float(np.rad2deg(side.error.final_rad[index])),
        std=lambda side: float(np.rad2deg(side.error.std_rad[-1, index])),
        form="+.2f",
    )


_ERRORS: Columns = (
    Column("name", "model"),
    *map(_angle, range(3)),
    Column("norm_deg", "norm", of="error.final_norm_rad"),
    Column("rms_deg", "rms over time", of="error.rms_rad"),
    Column("", "z-scores", words=lambda side: ", ".join(number(z, "+.1f") for z in side.error.z_scores)),
)


def error_table(evaluation: Evaluation) -> Table:
    """Measured less predicted attitude of body 1 at the end."""
    models = (("nominal", _nominal_error(evaluation)), ("fitted", _fitted_error(evaluation)))
    return Table(
        "Attitude error of the model",
        _ERRORS,
        [_Side(name, error) for name, error in models if isinstance(error, AttitudeError)],
        "Measured − predicted z-y-x Euler angles of body 1 at the end. z-scores: in units of the standard "
        "deviation, the same order.",
        below=("rms over time", "z-scores"),
    )
