"""How a rotation spreads: to first order by its derivatives, and by the samples of a Monte Carlo study.

Derivatives are central differences of order 4, all parameters in one batch, of the rotation from the nominal final
attitude to the changed one: that is small, so neither a half turn nor no turn at all troubles them.

    parameters = Parameters.of(robot, Plan.of(robot, [PlannedStroke(0, 1.03, 0.7), ...], rate_rad_s=2.97))
    sources = error_sources(parameters, robot.uncertainty)
    linear = linear_spread(derivatives(parameters), sources)
    outcomes = run_locally(Study(parameters, sources, samples=10_000, seed=1))
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.propagate_within import final_attitudes
from tfsat_host.plan.error_sources import ErrorSources
from tfsat_host.plan.facility import DropTower
from tfsat_host.plan.parameters import Parameters
from tfsat_host.plan.study import Outcomes, Study

# Central difference of order 4: offsets in steps, and weights.
_OFFSETS = np.array([-2.0, -1.0, 1.0, 2.0])
_WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0
# Below this the rotation has no axis, and its angle no gradient.
_NO_TURN_RAD = 1e-9


@dataclass(frozen=True, eq=False)
class Derivatives:
    """At the nominal parameters; degrees per unit of each parameter.

    Attributes:
        reorientation_deg: Nominal rotation angle of the base.
        rotation_vector_deg: (3,) nominal.
        quaternion_xyzw: (4,) nominal final attitude of the base, w >= 0.
        of_reorientation: (p,). Without any rotation the angle has a kink: then its slope away from there.
        of_rotation_vector: (p, 3).
        of_attitude: (p, 3) rotation of the final attitude, base axes: what a star tracker would see.
        error_rad: How wrong an attitude may be by the error of the integration.
    """

    reorientation_deg: float
    rotation_vector_deg: FloatArray
    quaternion_xyzw: FloatArray
    of_reorientation: FloatArray
    of_rotation_vector: FloatArray
    of_attitude: FloatArray
    error_rad: float


@dataclass(frozen=True, eq=False)
class LinearSpread:
    """Standard deviations to first order, deg.

    Attributes:
        reorientation_deg: Of the rotation angle.
        rotation_vector_deg: (3,) of the rotation vector's components.
        attitude_deg: Root mean square angle between the final attitude and the nominal one.
        of_parameters_deg: (p,) |derivative| times standard deviation: what each parameter alone would give the angle.
            Parameters with a common source do not add up in squares.
        of_sources_deg: (d,) what each source alone gives the angle; in squares they add up to the whole.
        shares: (d,) of the angle's variance; 0 if it has none.
    """

    reorientation_deg: float
    rotation_vector_deg: FloatArray
    attitude_deg: float
    of_parameters_deg: FloatArray
    of_sources_deg: FloatArray
    shares: FloatArray


def derivatives(parameters: Parameters, *, step_scale: float = 1.0) -> Derivatives:
    """Compute all derivatives by one batched evaluation of 4 p + 1 robots.

    `step_scale` is a factor on the parameters' steps, to check that the derivatives do not depend on them.
    """
    count, steps = len(parameters.nominal), step_scale * parameters.steps
    # One parameter at a time at four offsets, (4 p, p): the whole stencil is one batch.
    changed = parameters.nominal + (_OFFSETS[:, None, None] * np.diag(steps)).reshape(-1, count)
    vectors = np.vstack([parameters.nominal, changed])
    # All robots share their steps: differences are right to more digits than the attitudes.
    attitude, error_rad = final_attitudes(
        parameters.robots(vectors),
        parameters.history(vectors),
        initial_rate_rad_s=parameters.initial_rate_rad_s,
    )
    # Of the two quaternions of a rotation the one with w >= 0.
    nominal = np.copysign(1.0, attitude[3, 0]) * attitude[:, 0]
    # Small rotations from the nominal attitude, far from the logarithm's cut at half a turn.
    relative = quaternion.product(quaternion.inverse(nominal)[:, None], attitude[:, 1:])
    turns = np.degrees(quaternion.logarithm(relative)).reshape(3, len(_OFFSETS), count)
    # o: offsets of the stencil, c: components, p: parameters.
    of_attitude = np.asarray(np.einsum("o,cop->pc", _WEIGHTS, turns) / steps[:, None])
    vector = quaternion.logarithm(nominal)
    size = float(np.linalg.norm(vector))
    return Derivatives(
        reorientation_deg=float(np.degrees(quaternion.angle(nominal))),
        rotation_vector_deg=np.degrees(vector),
        quaternion_xyzw=nominal,
        # The angle grows by the part of a small turn that lies along the rotation's axis.
        of_reorientation=(
            of_attitude @ (vector / size) if size > _NO_TURN_RAD else np.linalg.norm(of_attitude, axis=1)
        ),
        # The inverse differential of the exponential takes turns in body axes to the rotation vector.
        of_rotation_vector=quaternion.inverse_differential(
            np.repeat(vector[:, None], count, axis=1), of_attitude.T
        ).T,
        of_attitude=of_attitude,
        error_rad=error_rad,
    )


def linear_spread(derivatives: Derivatives, sources: ErrorSources) -> LinearSpread:
    """Compute the rotation's spread by independent normal errors from `sources`, to first order."""
    # Independent unit deviates: their effects add up in squares.
    of_sources = derivatives.of_reorientation @ sources.matrix
    total = float(np.linalg.norm(of_sources))
    shares = (of_sources / total) ** 2 if total > 0.0 else np.zeros_like(of_sources)
    return LinearSpread(
        reorientation_deg=total,
        rotation_vector_deg=np.linalg.norm(derivatives.of_rotation_vector.T @ sources.matrix, axis=1),
        attitude_deg=float(np.linalg.norm(derivatives.of_attitude.T @ sources.matrix)),
        of_parameters_deg=np.abs(derivatives.of_reorientation) * sources.parameter_sigma,
        of_sources_deg=np.abs(of_sources),
        shares=shares,
    )


PERCENTILES = (2.5, 16.0, 50.0, 84.0, 97.5)
_LEVEL = 1e-9  # a spread below this share of the values is rounding
_BINS = 15  # of the histogram


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure and its standard error."""

    value: float
    standard_error: float


@dataclass(frozen=True, slots=True)
class Spread:
    """Of one output.

    Attributes:
        mean, std: With standard errors; that of `std` follows from the fourth moment, not from a normal distribution.
        percentiles: By percent; standard errors from the ranks within which a percentile lies.
    """

    mean: Estimate
    std: Estimate
    percentiles: dict[float, Estimate]


def spread(values: FloatArray) -> Spread:
    """Compute the spread of samples (s,), s >= 2."""
    count, mean = len(values), float(values.mean())
    squared = (values - mean) ** 2
    std = float(np.sqrt(squared.sum() / (count - 1)))
    fourth = float((squared**2).mean())
    # Delta method: var(s) = (m4 - s^4) / (4 n s^2), without assuming a normal distribution.
    of_std = np.sqrt(max(fourth - std**4, 0.0) / count) / (2.0 * std) if std > 0.0 else 0.0
    ordered = np.sort(values)
    return Spread(
        mean=Estimate(mean, std / np.sqrt(count)),
        std=Estimate(std, float(of_std)),
        percentiles={percent: _percentile(ordered, percent) for percent in PERCENTILES},
    )


def share(hits: BoolArray) -> Estimate:
    """Estimate the share of true samples (s,).

    The standard error follows from all shares that may have led to these samples (Laplace's rule of
    succession): it is not 0 even without a single hit.
    """
    count, hit_count = len(hits), int(hits.sum())
    # Mean and variance of the beta posterior that follows from a uniform prior.
    likely = (hit_count + 1) / (count + 2)
    return Estimate(hit_count / count, float(np.sqrt(likely * (1.0 - likely) / (count + 3))))


def variance_shares(output: FloatArray, deviates: FloatArray) -> FloatArray:
    """(d,) share of the variance of `output` (s,) that each of the independent deviates (s, d) explains linearly.

    0 for an output without spread. Independent deviates correlate by chance, by about 1 / s in the square.
    """
    return np.asarray(_correlation(output, deviates) ** 2)


def rank_correlation(output: FloatArray, deviates: FloatArray) -> FloatArray:
    """(d,) Spearman's correlation of `output` (s,) with each of the deviates (s, d); 0 without spread."""
    if _is_level(output):
        return np.zeros(deviates.shape[1])
    return _correlation(_ranks(output), np.column_stack([_ranks(column) for column in deviates.T]))


def _correlation(output: FloatArray, deviates: FloatArray) -> FloatArray:
    if _is_level(output):
        return np.zeros(deviates.shape[1])
    return np.asarray(np.corrcoef(output, deviates, rowvar=False)[0, 1:])


def _is_level(values: FloatArray) -> bool:
    return bool(np.ptp(values) <= _LEVEL * np.abs(values).max(initial=0.0))


def _ranks(values: FloatArray) -> FloatArray:
    """(s,) ranks from 0; equal values share the middle of theirs. `scipy.stats` would take longer to import."""
    _, group, counts = np.unique(values, return_inverse=True, return_counts=True)
    # Midranks: ties share the mean of the ranks that they take up.
    middle = np.cumsum(counts) - 0.5 * (counts + 1)
    return np.asarray(middle[group])


def _percentile(ordered: FloatArray, percent: float) -> Estimate:
    count, part = len(ordered), percent / 100.0
    # The rank of a percentile scatters binomially: samples one deviation off bound its value.
    away = np.sqrt(count * part * (1.0 - part))
    low, high = (int(np.clip(round(count * part + by), 0, count - 1)) for by in (-away, away))
    value = float(np.interp(part * (count - 1), np.arange(count), ordered))
    return Estimate(value, float(ordered[high] - ordered[low]) / 2.0)


@dataclass(frozen=True, slots=True)
class TimeLimit:
    """What a time must not exceed.

    Attributes:
        name: Which limit.
        of: The output that is limited: `end_s` of the last stroke, or `moving_time_s` in which a joint moves.
        limit_s: Greatest permitted time.
    """

    name: str
    of: Literal["moving_time_s", "end_s"]
    limit_s: float


def time_limits(tower: DropTower) -> tuple[TimeLimit, ...]:
    """Return a drop tower's time limits for the strokes and for the fall."""
    planned_s = tower.maneuver_time_max_s
    longest_s = planned_s + tower.maneuver_time_tolerance_s
    return (
        TimeLimit("time for the strokes", "moving_time_s", planned_s),
        TimeLimit("time for the strokes, with its tolerance", "moving_time_s", longest_s),
        TimeLimit("fall", "end_s", tower.fall_s),
    )


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
    study: Study, outcomes: Outcomes, nominal_xyzw: FloatArray, limits: Sequence[TimeLimit]
) -> Summary:
    """Compute the statistics of a study of two samples or more.

    Its deviates are drawn again, to be compared with the outcomes of all its samples. `nominal_xyzw` (4,) is
    the final attitude without errors; times must not exceed `limits`.
    """
    values = outputs_of(outcomes, nominal_xyzw)
    # Draw the deviates again from the seed: outcomes do not carry them.
    deviates = np.vstack([study.deviates(chunk) for chunk in range(study.chunks)])
    # A source without deviation is drawn, too: its chance correlation must not show.
    has_effect = study.sources.matrix.any(axis=0)
    turned, end_s = values["reorientation_deg"], values["end_s"]
    counts, edges = np.histogram(turned, bins=_BINS)
    return Summary(
        outputs={name: spread(column) for name, column in values.items()},
        exceeded=tuple((limit, share(values[limit.of] > limit.limit_s)) for limit in limits),
        variance_shares=has_effect * variance_shares(turned, deviates),
        rank_correlation=has_effect * rank_correlation(turned, deviates),
        end_rank_correlation=has_effect * rank_correlation(end_s, deviates),
        histogram_edges_deg=edges,
        histogram=counts.astype(np.float64),
    )
