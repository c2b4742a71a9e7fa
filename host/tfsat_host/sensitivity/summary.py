"""A study in figures: how the outputs spread, which limits are exceeded, and which errors are to blame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tfsat_host.dynamics.components import FloatArray
from tfsat_host.sensitivity.statistics import (
    Estimate,
    Spread,
    rank_correlation,
    share,
    spread,
    variance_shares,
)
from tfsat_host.sensitivity.study import Outcomes, Study


@dataclass(frozen=True, slots=True)
class TimeLimit:
    """What a time must not exceed.

    Attributes:
        name: Which limit.
        of_end: The end of the last stroke is limited; else the time that the strokes take together.
        limit_s: Greatest permitted time.
    """

    name: str
    of_end: bool
    limit_s: float


@dataclass(frozen=True, eq=False)
class Summary:
    """Of all samples.

    Attributes:
        outputs: By name and unit: `reorientation_deg`, `rotation_x_deg`, …, `attitude_error_deg`
            (angle between the final attitude and that of a robot without errors), `moving_time_s`, `end_s`.
        exceeded: The share of samples that exceed each limit.
        variance_shares: (d,) of the reorientation's variance that each source explains linearly.
        rank_correlation: (d,) of the reorientation with each source.
        end_rank_correlation: (d,) of the last stroke's end with each source.
        histogram_edges_deg, histogram: (b + 1,) and (b,) samples by their reorientation; the outermost bins
            begin and end with the samples.
    """

    outputs: dict[str, Spread]
    exceeded: tuple[tuple[TimeLimit, Estimate], ...]
    variance_shares: FloatArray
    rank_correlation: FloatArray
    end_rank_correlation: FloatArray
    histogram_edges_deg: FloatArray
    histogram: FloatArray


def outputs_of(outcomes: Outcomes, nominal_xyzw: FloatArray) -> dict[str, FloatArray]:
    """(s,) values of each output, by the names of `Summary.outputs`."""
    vector = outcomes.rotation_vector_deg
    return {
        "reorientation_deg": outcomes.reorientation_deg,
        "rotation_x_deg": vector[:, 0],
        "rotation_y_deg": vector[:, 1],
        "rotation_z_deg": vector[:, 2],
        "attitude_error_deg": outcomes.attitude_error_deg(nominal_xyzw),
        "moving_time_s": outcomes.moving_time_s,
        "end_s": outcomes.end_s,
    }


def summary(
    study: Study, outcomes: Outcomes, nominal_xyzw: FloatArray, limits: Sequence[TimeLimit], *, bins: int = 15
) -> Summary:
    """The figures of a study of two samples or more.

    Args:
        study: Its deviates are drawn again, to be compared with the outcomes.
        outcomes: Of all its samples.
        nominal_xyzw: (4,) final attitude without errors.
        limits: What times must not exceed.
        bins: Of the histogram.
    """
    values = outputs_of(outcomes, nominal_xyzw)
    deviates = np.vstack([study.deviates(chunk) for chunk in range(study.chunks)])
    has_effect = study.sources.matrix.any(axis=0)
    turned, end_s = values["reorientation_deg"], values["end_s"]
    counts, edges = np.histogram(turned, bins=bins)
    return Summary(
        outputs={name: spread(column) for name, column in values.items()},
        exceeded=tuple(
            (limit, share(values["end_s" if limit.of_end else "moving_time_s"] > limit.limit_s))
            for limit in limits
        ),
        variance_shares=has_effect * variance_shares(turned, deviates),
        rank_correlation=has_effect * rank_correlation(turned, deviates),
        end_rank_correlation=has_effect * rank_correlation(end_s, deviates),
        histogram_edges_deg=edges,
        histogram=counts.astype(np.float64),
    )
