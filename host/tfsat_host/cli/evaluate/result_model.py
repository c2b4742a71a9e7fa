"""What became of the model, as JSON: its correction, and both models beside the measured attitude."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tfsat_host.evaluation.evaluation import Evaluation
    from tfsat_host.evaluation.model_fit.com_swarm import SwarmFit
    from tfsat_host.evaluation.model_fit.comparison import AttitudeError
    from tfsat_host.evaluation.model_fit.fit import ModelFit
    from tfsat_host.evaluation.model_fit.identifiability import Identifiability
    from tfsat_host.evaluation.model_fit.trades import Trade

Json = dict[str, Any]


def model_as_dict(found: Evaluation) -> Json:
    """The keys of an evaluation that speak of the model."""
    import numpy as np

    from tfsat_host.evaluation.model_fit.offsets import COM_BODIES
    from tfsat_host.evaluation.model_fit.trades import trades
    from tfsat_host.report.contents.correction import significance, worth_of

    explained = found.explained
    fit, before, after = explained.fit, explained.before.error, explained.after.error
    centers = [index for index, kind in enumerate(fit.offsets.kinds) if kind == "com"]
    shape = (len(COM_BODIES), 3)
    return {
        "com_offset_mm": fit.values[centers].reshape(shape).tolist(),
        "com_offset_mm_std": fit.std[centers].reshape(shape).tolist(),
        "offsets": offsets_as_rows(fit),
        "attitude_error_deg": {
            "before": float(np.rad2deg(before.final_norm_rad)),
            "after": float(np.rad2deg(after.final_norm_rad)),
        },
        "attitude_error": {"before": _error(before), "after": _error(after)},
        "correction": {
            "worth": worth_of(found),
            "significance": significance(found),
            "offered": explained.offered,
            "withheld": list(explained.withheld),
            "converged": fit.converged,
        },
        "momentum_kg_m2_s": fit.momentum_kg_m2_s.tolist(),
        "excess_variance": fit.excess,
        "identifiability": _identifiability(found.identifiability),
        "trades": [_trade(trade) for trade in trades(fit, explained.driven.flown)],
        "swarm": None if found.swarm is None else _swarm(found.swarm),
    }


def _swarm(swarm: SwarmFit) -> Json:
    return {
        "com_offset_mm": swarm.values.reshape(-1, 3).tolist(),
        "spread_mm": swarm.spread.reshape(-1, 3).tolist(),
        "searches": len(swarm.each),
        "particles": swarm.particles,
        "iterations": swarm.iterations,
        "converged": swarm.converged,
        "sentences": list(swarm.sentences()),
        "objective_kg_m2_s": {
            "before": swarm.objective_before,
            "swarm": swarm.objective,
            "gauss_newton": swarm.objective_gauss_newton,
        },
    }


def offsets_as_rows(fit: ModelFit) -> list[Json]:
    """Each offset that was free, with what was allowed and what was found."""
    offsets = fit.offsets
    return [
        {
            "name": name,
            "unit": unit,
            "value": float(value),
            "std": float(std),
            "prior_std": float(prior),
            "bound": float(bound),
            "at_bound": bool(at_bound),
        }
        for name, unit, value, std, prior, bound, at_bound in zip(
            offsets.names,
            offsets.units,
            fit.values,
            fit.std,
            offsets.prior_std,
            offsets.bounds,
            fit.at_bound,
            strict=True,
        )
    ]


def _error(error: AttitudeError) -> Json:
    import numpy as np

    return {
        "final_zyx_deg": np.rad2deg(error.final_rad).tolist(),
        "final_zyx_deg_std": np.rad2deg(error.std_rad[-1]).tolist(),
        "final_norm_deg": float(np.rad2deg(error.final_norm_rad)),
        "rms_deg": float(np.rad2deg(error.rms_rad)),
        "z_scores": error.z_scores.tolist(),
        "mahalanobis": error.mahalanobis,
    }


def _identifiability(found: Identifiability) -> Json:
    return {
        "unit": found.unit,
        "condition": found.condition,
        "rank": found.rank,
        "directions": [
            {
                "composition": direction.composition,
                "components": direction.components.tolist(),
                "told": direction.told,
                "std": direction.std,
                "std_by_data": direction.std_by_data,
                "prior_std": direction.prior_std,
            }
            for direction in found.directions
        ],
        "sentences": list(found.sentences()),
    }


def _trade(trade: Trade) -> Json:
    return {
        "name": trade.name,
        "unit": trade.unit,
        "std": trade.std,
        "std_alone": trade.std_alone,
        "growth": dict(trade.growth),
        "partners": [{"name": name, "correlation": value} for name, value in trade.partners],
    }
