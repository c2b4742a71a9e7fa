"""What of the model should be corrected, what the data leave open, and the attitude error of either model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.comparison import AttitudeError
from tfsat_host.evaluation.model_fit.fit import ModelFit
from tfsat_host.evaluation.model_fit.offsets import COM_BODIES
from tfsat_host.evaluation.model_fit.trades import trades
from tfsat_host.evaluation.result.correction import correction_sentences, significance, worth_of
from tfsat_host.quantity import Column, Columns, Table, fields, nested, number, record, records

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
    Column("prior_std", "allowed before", words=lambda one: f"± {number(one.prior_std, '.3g')}"),
    Column("", "of that left", words=lambda one: f"{100.0 * one.std / one.prior_std:.0f} %"),
    *fields("bound at_bound"),
)


def offsets(fit: ModelFit) -> list[Offset]:
    """Of a fit."""
    found = fit.offsets
    numbers = (fit.values, fit.std, found.prior_std, found.bounds, fit.at_bound)
    return [
        Offset(*one)
        for one in zip(found.names, found.units, *(all_.tolist() for all_ in numbers), strict=True)
    ]


ERROR: Columns = (
    Column("final_zyx_deg", of="final_rad", std=lambda error: np.rad2deg(error.std_rad[-1])),
    *fields("final_norm_deg rms_deg z_scores mahalanobis"),
)
_DIRECTION = "composition components told std std_by_data prior_std"
_IDENTIFIABILITY: Columns = (
    *fields("unit condition rank"),
    Column("directions", columns=fields(_DIRECTION)),
    Column("sentences", of=lambda found: found.sentences()),
)
_TRADE: Columns = (
    *fields("name unit std std_alone"),
    Column("growth", of=lambda trade: dict(trade.growth)),
    Column("partners", of=lambda trade: [{"name": n, "correlation": c} for n, c in trade.partners]),
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


def model(found: Evaluation) -> dict[str, Any]:
    """The keys of JSON that speak of the model."""
    explained = found.explained
    fit, before, after = explained.fit, explained.before.error, explained.after.error
    centers = [index for index, kind in enumerate(fit.offsets.kinds) if kind == "com"]
    shape = (len(COM_BODIES), 3)
    errors = {"before": record(ERROR, before), "after": record(ERROR, after)}
    return {
        "com_offset_mm": fit.values[centers].reshape(shape).tolist(),
        "com_offset_mm_std": fit.std[centers].reshape(shape).tolist(),
        "offsets": records((*OFFSETS[:2], *fields("value std prior_std bound at_bound")), offsets(fit)),
        "attitude_error_deg": {side: error["final_norm_deg"] for side, error in errors.items()},
        "attitude_error": errors,
        "correction": {
            "worth": worth_of(found),
            "significance": significance(found),
            "offered": explained.offered,
            "withheld": list(explained.withheld),
            "converged": fit.converged,
        },
        "momentum_kg_m2_s": fit.momentum_kg_m2_s.tolist(),
        "excess_variance": fit.excess,
        "identifiability": record(_IDENTIFIABILITY, found.identifiability),
        "trades": records(_TRADE, trades(fit, explained.driven.flown)),
        "swarm": nested(_SWARM, found.swarm),
    }


def offset_table(found: Evaluation) -> Table:
    """Each offset with its standard deviation, and that of the paper's swarm."""
    fit, swarm = found.explained.fit, found.swarm
    rows, columns = offsets(fit), OFFSETS
    if swarm is not None:
        by_name = dict(zip(fit.offsets.names, zip(swarm.values, swarm.spread, strict=True), strict=True))
        columns = (*OFFSETS, _of_fit("paper's swarm ± its spread", by_name))
    sentences = [*correction_sentences(found), *_stuck(rows), *found.identifiability.sentences()]
    return Table("Correction of the model", columns, rows, " ".join(sentences))


def remarks(found: Evaluation) -> list[str]:
    """What a single offset trades with, and how far the swarm came: sentences, where there is something of it."""
    fit, swarm = found.explained.fit, found.swarm
    sentences = []
    if set(fit.offsets.kinds) != {"com"}:
        sentences += [trade.sentence() for trade in trades(fit, found.explained.driven.flown)]
    if swarm is not None:
        sentences += [
            f"The swarm's objective, the sum of |h - h0|: {swarm.objective_before:.3g} kg m^2/s as filed, "
            f"{swarm.objective:.3g} by the swarm, {swarm.objective_gauss_newton:.3g} by the correction.",
            *swarm.sentences(),
        ]
    return sentences


def combined_columns(
    label: str, values: Sequence[float], std: Sequence[float], fits: dict[str, ModelFit]
) -> Columns:
    """The common correction, and that of each drop under its name.

    Args:
        label: Of the common one.
        values: (n,)
        std: (n,)
        fits: By drop.
    """
    names = next(iter(fits.values())).offsets.names

    def of(label: str, values: Sequence[float], std: Sequence[float]) -> Column:
        return _of_fit(label, dict(zip(names, zip(values, std, strict=True), strict=True)))

    drops = (of(name, fit.values.tolist(), fit.std.tolist()) for name, fit in fits.items())
    return (*OFFSETS[:2], of(label, values, std), *drops)


def _of_fit(label: str, by_name: dict[str, tuple[float, float]]) -> Column:
    """Another correction than the row's own: value and standard deviation by the offset's name."""
    return Column(
        "value", label, of=lambda row: by_name[row.name][0], std=lambda row: by_name[row.name][1], form="+.2f"
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


def _z_scores(side: _Side) -> str:
    return ", ".join(number(score, "+.1f") for score in side.error.z_scores)


def error_table(found: Evaluation) -> Table:
    """Measured less predicted attitude of body 1 at the end."""
    columns = (
        Column("name", "model"),
        *map(_angle, range(3)),
        Column("norm_deg", "norm", of="error.final_norm_rad"),
        Column("rms_deg", "rms over time", of="error.rms_rad"),
        Column("", "z-scores", words=_z_scores),
    )
    return Table(
        "Attitude error of the model",
        columns,
        [_Side("as filed", found.explained.before.error), _Side("corrected", found.explained.after.error)],
        "Measured less predicted z-y-x Euler angles of body 1 at the end. z-scores: in units of the standard "
        "deviation, the same order.",
    )
