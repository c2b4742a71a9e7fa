"""How the rotation changes with each parameter, and what the stated errors make of it to first order.

Central differences of order 4, all parameters in one batch. They are taken of the rotation that leads from the
nominal final attitude to the changed one: that is small, so neither a half turn nor no turn at all troubles them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.accuracy import final_attitudes
from tfsat_host.robot.model import FloatArray
from tfsat_host.sensitivity.parameters import Parameters
from tfsat_host.sensitivity.sources import ErrorSources

_OFFSETS = np.array([-2.0, -1.0, 1.0, 2.0])
_WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0
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
    """All derivatives, by one batched evaluation of 4 p + 1 robots.

    Args:
        parameters: Where.
        step_scale: Factor on the parameters' steps, to check that the derivatives do not depend on them.
    """
    count, steps = len(parameters.nominal), step_scale * parameters.steps
    changed = parameters.nominal + (_OFFSETS[:, None, None] * np.diag(steps)).reshape(-1, count)
    vectors = np.vstack([parameters.nominal, changed])
    attitude, error_rad = final_attitudes(
        parameters.robots(vectors),
        parameters.history(parameters.motion(vectors)),
        initial_rate_rad_s=parameters.initial_rate_rad_s,
    )
    nominal = np.copysign(1.0, attitude[3, 0]) * attitude[:, 0]
    relative = quaternion.product(quaternion.inverse(nominal)[:, None], attitude[:, 1:])
    turns = np.degrees(quaternion.logarithm(relative)).reshape(3, len(_OFFSETS), count)
    of_attitude = np.asarray(np.einsum("o,cop->pc", _WEIGHTS, turns) / steps[:, None])
    vector = quaternion.logarithm(nominal)
    size = float(np.linalg.norm(vector))
    return Derivatives(
        reorientation_deg=float(np.degrees(quaternion.angle(nominal))),
        rotation_vector_deg=np.degrees(vector),
        quaternion_xyzw=nominal,
        of_reorientation=(
            of_attitude @ (vector / size) if size > _NO_TURN_RAD else np.linalg.norm(of_attitude, axis=1)
        ),
        of_rotation_vector=quaternion.inverse_differential(
            np.repeat(vector[:, None], count, axis=1), of_attitude.T
        ).T,
        of_attitude=of_attitude,
        error_rad=error_rad,
    )


def linear_spread(found: Derivatives, sources: ErrorSources) -> LinearSpread:
    """What independent normal errors from `sources` make of the rotation, to first order."""
    of_sources = found.of_reorientation @ sources.matrix
    total = float(np.linalg.norm(of_sources))
    shares = (of_sources / total) ** 2 if total > 0.0 else np.zeros_like(of_sources)
    return LinearSpread(
        reorientation_deg=total,
        rotation_vector_deg=np.linalg.norm(found.of_rotation_vector.T @ sources.matrix, axis=1),
        attitude_deg=float(np.linalg.norm(found.of_attitude.T @ sources.matrix)),
        of_parameters_deg=np.abs(found.of_reorientation) * sources.parameter_sigma,
        of_sources_deg=np.abs(of_sources),
        shares=shares,
    )
