"""Attitude over time by conservation of angular momentum, for any joint history and any initial rate.

The base turns at w = I^-1 (R^T H - A q') with the constant momentum H: dR/dt = R [w]. The equation is
solved on the rotation group by Runge-Kutta-Munthe-Kaas methods: an ordinary tableau of order p in the rotation
vector of each step, with the exact inverse of the exponential's differential, keeps the order p and
the quaternion's length (Munthe-Kaas, "High order Runge-Kutta methods on manifolds", Applied Numerical
Mathematics 29, 1999). Steps never cross a break of the history, so that jumping rates cost no order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from tfsat_host.dynamics import momentum as conserved
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.history import JointHistory
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.robot.model import IntArray

DEFAULT_STEP_S = 0.01


class Tableau(NamedTuple):
    """An explicit Runge-Kutta method: nodes (s,), weights (s,), and the stages' lower triangle (s, s)."""

    nodes: FloatArray
    weights: FloatArray
    stages: FloatArray


def _tableau(stages: list[list[float]], weights: list[float]) -> Tableau:
    square = np.zeros((len(weights), len(weights)))
    for i, row in enumerate(stages, start=1):
        square[i, : len(row)] = row
    return Tableau(square.sum(axis=1), np.array(weights), square)


# Order 4: Kutta 1901. Order 6: Butcher, "On Runge-Kutta processes of high order", 1964, seven stages.
TABLEAUS = {
    4: _tableau([[1 / 2], [0, 1 / 2], [0, 0, 1]], [1 / 6, 1 / 3, 1 / 3, 1 / 6]),
    6: _tableau(
        [
            [1 / 3],
            [0, 2 / 3],
            [1 / 12, 1 / 3, -1 / 12],
            [25 / 48, -55 / 24, 35 / 48, 15 / 8],
            [3 / 20, -11 / 24, -1 / 8, 1 / 2, 1 / 10],
            [-261 / 260, 33 / 13, 43 / 156, -118 / 39, 32 / 195, 80 / 39],
        ],
        [13 / 200, 0, 11 / 40, 11 / 40, 4 / 25, 4 / 25, 13 / 200],
    ),
}


@dataclass(frozen=True, eq=False)
class Flight:
    """What the robot did: m instants, the first and the last of the history among them.

    Attributes:
        body: The robot that flew, seen from its base.
        t_s: (m,).
        quaternion_xyzw: (m, 4) attitude of the base: from base axes to inertial axes.
        rate_rad_s: (m, 3) rate of the base, base axes.
        angles_rad: (m, n - 1) joint angles.
        angle_rates_rad_s: (m, n - 1); where the rates jump, those before the jump.
    """

    body: Multibody
    t_s: FloatArray
    quaternion_xyzw: FloatArray
    rate_rad_s: FloatArray
    angles_rad: FloatArray
    angle_rates_rad_s: FloatArray

    def momentum(self) -> FloatArray:
        """Total angular momentum (m, 3) about the center of mass, inertial axes, kg m^2/s.

        The rates of the flight were computed from the conserved momentum, so this is constant however coarse the
        steps: it says that inertia, joints and rates belong together, nothing of the integration's error
        (`propagate_within` estimates that).
        """
        inertia = conserved.locked_inertia(self.body, self.angles_rad)
        joints = conserved.joint_momentum(self.body, self.angles_rad)
        own = np.einsum("mij,mj->mi", inertia, self.rate_rad_s)
        own += np.einsum("mij,mj->mi", joints, self.angle_rates_rad_s)
        return np.asarray(np.einsum("mij,mj->mi", self.attitude(), own))

    def kinetic_energy_j(self) -> FloatArray:
        """Kinetic energy (m,) about the center of mass, J."""
        return conserved.kinetic_energy_j(self.body, self.angles_rad, self.angle_rates_rad_s, self.rate_rad_s)

    def attitude(self, body: int | None = None) -> FloatArray:
        """(m, 3, 3) from the axes of body `body` (the base if None) to inertial axes."""
        base = np.moveaxis(quaternion.to_matrix(self.quaternion_xyzw.T), -1, 0)
        if body is None or body == self.body.base:
            return base
        rotation, _ = poses(self.body, self.angles_rad)
        return base @ rotation[:, body]


def propagate(
    body: Multibody,
    history: JointHistory,
    *,
    initial_attitude_xyzw: FloatArray | None = None,
    initial_rate_rad_s: FloatArray | None = None,
    step_s: float = DEFAULT_STEP_S,
    order: Literal[4, 6] = 4,
) -> Flight:
    """Flies a joint history without external torque.

    Args:
        body: One robot (no batch); its base's attitude is integrated.
        history: What the joints do.
        initial_attitude_xyzw: (4,) attitude of the base at the start, of any length; none turned if None.
        initial_rate_rad_s: (3,) rate of the base at the start, base axes. None: no angular momentum, whatever
            the joints do at the start.
        step_s: Longest step.
        order: Order of the integration, 4 or 6.

    Raises:
        ValueError: `step_s` is not positive, there is no such order, or the start is no attitude and rate.
    """
    return propagate_divided(
        body,
        history,
        Release.of(initial_attitude_xyzw, initial_rate_rad_s),
        step_s=step_s,
        order=order,
        parts=1,
    )


class Release(NamedTuple):
    """How the base starts: attitude (4,), and rate (3,) in base axes or None for no angular momentum."""

    attitude: FloatArray
    rate: FloatArray | None

    @classmethod
    def of(cls, attitude_xyzw: FloatArray | None, rate_rad_s: FloatArray | None) -> Release:
        """Checked and of unit length.

        Raises:
            ValueError: these are no attitude and no rate.
        """
        attitude = (
            quaternion.identity() if attitude_xyzw is None else np.array(attitude_xyzw, dtype=np.float64)
        )
        length = float(np.linalg.norm(attitude))
        if attitude.shape != (4,) or not (np.isfinite(length) and length > 0.0):
            raise ValueError(f"{attitude} is no attitude")
        rate = None if rate_rad_s is None else np.asarray(rate_rad_s, dtype=np.float64)
        if rate is not None and not (rate.shape == (3,) and np.isfinite(rate).all()):
            raise ValueError(f"{rate} is no angular rate")
        return cls(attitude / length, rate)


def propagate_divided(
    body: Multibody,
    history: JointHistory,
    release: Release,
    *,
    step_s: float,
    order: Literal[4, 6],
    parts: int,
) -> Flight:
    """As `propagate`, with each of its steps divided into `parts`: every `parts`-th instant is one of its own."""
    if not step_s > 0.0:
        raise ValueError(f"a step of {step_s} s leads nowhere")
    if order not in TABLEAUS:
        raise ValueError(f"there is no order {order}: choose from {', '.join(map(str, TABLEAUS))}")
    tableau = TABLEAUS[order]
    piece, since, length = _steps(history.breaks_s, step_s, parts)
    angles, rates = history.in_piece(
        piece[:, None], since[:, None] + length[:, None] * np.append(tableau.nodes, 1.0)
    )
    spin = _Spin.of(body, angles, rates)
    attitude = release.attitude
    momentum = spin.momentum(attitude, release.rate)
    attitudes = np.empty((len(length) + 1, 4))
    attitudes[0] = attitude
    # Without angular momentum no step asks for the attitude that it begins at: all of them at once.
    turns = _turn_of(length, tableau, lambda stage, _: -spin.driven[:, stage].T) if momentum is None else None
    for i, h in enumerate(length):
        turn = _step(spin, i, h, attitude, momentum, tableau) if turns is None else turns[:, i]
        attitude = quaternion.product(attitude, quaternion.exponential(turn))
        attitude /= np.sqrt(attitude @ attitude)
        attitudes[i + 1] = attitude
    t_s = np.append(history.breaks_s[piece] + since, history.breaks_s[-1])
    # Each instant is the end of a step, and shows the rates there; the first is the start of the first step.
    instants = [np.concatenate([values[:1, 0], values[:, -1]]) for values in (angles, rates)]
    turning = np.array(
        [spin.rate(i - 1 if i else 0, -1 if i else 0, q, momentum) for i, q in enumerate(attitudes)]
    )
    return Flight(body, t_s, attitudes, turning, *instants)


class _Spin(NamedTuple):
    """w = `inverse` R^T H - `driven` at every stage: (m, s + 1, 3, 3) and (m, s + 1, 3)."""

    inverse: FloatArray
    driven: FloatArray

    @classmethod
    def of(cls, body: Multibody, angles: FloatArray, rates: FloatArray) -> _Spin:
        inverse = np.asarray(np.linalg.inv(conserved.locked_inertia(body, angles)), dtype=np.float64)
        joints = np.einsum("...ij,...j->...i", conserved.joint_momentum(body, angles), rates)
        return cls(inverse, np.einsum("...ij,...j->...i", inverse, joints))

    def momentum(self, attitude: FloatArray, rate: FloatArray | None) -> FloatArray | None:
        """H (3,), inertial axes, of base rate `rate` (3,) at the start."""
        if rate is None:
            return None
        local = np.linalg.solve(self.inverse[0, 0], rate + self.driven[0, 0])
        return np.asarray(quaternion.to_matrix(attitude) @ local)

    def rate(self, step: int, stage: int, attitude: FloatArray, momentum: FloatArray | None) -> FloatArray:
        """Base rate (3,), base axes."""
        if momentum is None:
            return np.asarray(-self.driven[step, stage])
        return np.asarray(
            self.inverse[step, stage] @ (quaternion.to_matrix(attitude).T @ momentum)
            - self.driven[step, stage]
        )


def step_count(breaks_s: FloatArray, step_s: float) -> int:
    """Number of steps of at most `step_s`, none of them across a break."""
    return int(_counts(breaks_s, step_s).sum())


def _counts(breaks_s: FloatArray, step_s: float) -> IntArray:
    return np.maximum(1, np.ceil(np.diff(breaks_s) / step_s - 1e-9).astype(np.int64))


def _steps(breaks_s: FloatArray, step_s: float, parts: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Piece (m,), start within the piece (m,) and length (m,) of each step."""
    spans = np.diff(breaks_s)
    counts = _counts(breaks_s, step_s) * parts
    piece: IntArray = np.repeat(np.arange(len(spans), dtype=np.int64), counts)
    length = (spans / counts)[piece]
    number = np.arange(len(piece)) - np.repeat(np.cumsum(counts) - counts, counts)
    return piece, np.asarray(number * length), length


def _step(
    spin: _Spin, i: int, h: float, attitude: FloatArray, momentum: FloatArray | None, tableau: Tableau
) -> FloatArray:
    """Rotation vector (3,) of step i."""

    def rate(stage: int, turn: FloatArray) -> FloatArray:
        here = quaternion.product(attitude, quaternion.exponential(turn))
        return spin.rate(i, stage, here, momentum)

    return _turn_of(h, tableau, rate)


def _turn_of(
    h: float | FloatArray, tableau: Tableau, rate: Callable[[int, FloatArray], FloatArray]
) -> FloatArray:
    """Rotation vector (3, ...) of a step of length h (...); `rate` is of a stage and the turn (3, ...) until then."""
    slopes = np.empty((len(tableau.weights), 3, *np.shape(h)))
    for stage, row in enumerate(tableau.stages):
        turn = h * np.tensordot(row[:stage], slopes[:stage], axes=1)
        slopes[stage] = quaternion.inverse_differential(turn, rate(stage, turn))
    return np.asarray(h * np.tensordot(tableau.weights, slopes, axes=1))
