"""The model beside the measurement, and its correction, for people."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tfsat_host.cli.evaluate.phrases import number, plus_minus, sentences
from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from tfsat_host.evaluation.evaluation import Evaluation
    from tfsat_host.evaluation.model_fit.com_swarm import SwarmFit
    from tfsat_host.evaluation.model_fit.fit import ModelFit

_AXES = "xyz"
_BODIES = (1, 2, 3)


def show_model(found: Evaluation, out: Output) -> None:
    """Attitude errors before and after, offsets, and what the data cannot tell."""
    from tfsat_host.evaluation.model_fit.trades import trades
    from tfsat_host.report.contents.correction import correction_sentences

    _show_errors(found, out)
    fit = found.explained.fit
    _show_centers(fit, out)
    _show_others(fit, out)
    _show_swarm(found.swarm, out)
    sentences((*correction_sentences(found), *found.identifiability.sentences()), out)
    if set(fit.offsets.kinds) != {"com"}:
        sentences([trade.sentence() for trade in trades(fit, found.explained.driven.flown)], out)
    out.line()


def _show_errors(found: Evaluation, out: Output) -> None:
    import numpy as np

    sides = [side.error for side in (found.explained.before, found.explained.after)]
    finals = [(np.rad2deg(error.final_rad), np.rad2deg(error.std_rad[-1])) for error in sides]
    rows: list[tuple[object, ...]] = [
        (f"{name} at the end / deg", *[plus_minus(final[k], std[k], sign=True) for final, std in finals])
        for k, name in enumerate(("z", "y", "x"))
    ]
    rows += [
        ("norm of the three / deg", *[number(np.rad2deg(error.final_norm_rad), 3) for error in sides]),
        ("rms over the fall / deg", *[number(np.rad2deg(error.rms_rad), 3) for error in sides]),
        ("standard deviations from zero", *[number(error.mahalanobis, 1) for error in sides]),
    ]
    columns = ("Euler angle", "model as it is", "model corrected")
    out.table(columns, rows, title="Attitude of body 1, measured less predicted")


def _show_centers(fit: ModelFit, out: Output) -> None:
    centers = [index for index, kind in enumerate(fit.offsets.kinds) if kind == "com"]
    by_body: dict[int, list[str]] = {}
    for index in centers:
        bound = " (bound)" if fit.at_bound[index] else ""
        by_body.setdefault(fit.offsets.places[index][0], []).append(
            plus_minus(float(fit.values[index]), float(fit.std[index]), sign=True) + bound
        )
    if by_body:
        columns = ("body", *[f"{axis} / mm" for axis in _AXES])
        rows = [(str(body + 1), *cells) for body, cells in by_body.items()]
        out.table(columns, rows, title="Centers of mass, off where the robot file has them")


def _show_swarm(swarm: SwarmFit | None, out: Output) -> None:
    if swarm is None:
        return
    rows = [
        (str(body), *[f"{value:+.2f} ± {std:.2f}" for value, std in zip(values, stds, strict=True)])
        for body, values, stds in zip(
            _BODIES, swarm.values.reshape(-1, 3), swarm.spread.reshape(-1, 3), strict=True
        )
    ]
    out.table(
        ("body", *[f"{axis} / mm" for axis in _AXES]),
        rows,
        title=f"The same by the paper's swarm: the best of {len(swarm.each)}, ± their spread",
    )
    out.line(
        f"Its objective, the sum of |h - h0|: {swarm.objective_before:.3g} kg m^2/s as it is, {swarm.objective:.3g} by "
        f"the swarm, {swarm.objective_gauss_newton:.3g} by Gauss and Newton's offsets above."
    )
    sentences(swarm.sentences(), out)


def _show_others(fit: ModelFit, out: Output) -> None:
    offsets = fit.offsets
    rows = [
        (
            offsets.names[i],
            offsets.units[i],
            plus_minus(float(fit.values[i]), float(fit.std[i]), sign=True),
            f"± {offsets.prior_std[i]:.2g}",
        )
        for i, kind in enumerate(offsets.kinds)
        if kind != "com"
    ]
    if rows:
        out.table(("of the model", "unit", "off by", "allowed"), rows, title="Masses and inertias")
