"""Attitude over time by conservation of angular momentum, for any joint history and any initial rate.

With the constant momentum H the base turns at w = I^-1 (R^T H - A q'), and its attitude follows dR/dt = R [w]. Each
step solves for the rotation vector of the step, by a Runge-Kutta-Munthe-Kaas method: an ordinary tableau of order p
with the exact inverse of the exponential's differential keeps the order p and the quaternion's length (Munthe-Kaas,
"High order Runge-Kutta methods on manifolds", Applied Numerical Mathematics 29, 1999). Without momentum w does not
depend on the attitude; then order 6 takes Magnus' series, with w at three instants of a step, not six. Steps never
cross a break of the history, so that jumping rates cost no order.

Conservation of momentum says nothing of the error, because the rates are computed from it. The step size does: at
order p half the step leaves a 2^p-th of the error, so what changes when it is halved bounds what is still wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import batch_last, matvec, solve_symmetric, transpose, upper
from tfsat_host.dynamics.history import JointHistory
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.dynamics.spatial_momentum import compose_bodies, inertia_and_joint_momentum, kinetic_energy_j
from tfsat_host.dynamics.stroke import GAUSS, magnus6

DEFAULT_STEP_S = 0.01
# Robots times instants that are evaluated at once: few enough for a processor's cache, many enough for numpy.
_BLOCK = 3000


class Tableau(NamedTuple):
    """An explicit Runge-Kutta method of s stages.

    Attributes:
        nodes: The different instants of the stages, as shares of a step.
        node_of_stage: (s,) indices into `nodes`.
        weights: (s,).
        stages: (s, s) lower triangle.
    """

    nodes: FloatArray
    node_of_stage: IntArray
    weights: FloatArray
    stages: FloatArray


def _tableau(stages: list[list[float]], weights: list[float]) -> Tableau:
    square = np.zeros((len(weights), len(weights)))
    for i, row in enumerate(stages, start=1):
        square[i, : len(row)] = row
    # A row's sum is its node; stages at the same instant share one evaluation of the inertia.
    nodes, node_of_stage = np.unique(square.sum(axis=1).round(15), return_inverse=True)
    return Tableau(nodes, node_of_stage, np.array(weights), square)


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
        inertia, joints = inertia_and_joint_momentum(self.body, self.angles_rad)
        own = np.einsum("mij,mj->mi", inertia, self.rate_rad_s)
        own += np.einsum("mij,mj->mi", joints, self.angle_rates_rad_s)
        return np.asarray(np.einsum("mij,mj->mi", self.attitude(), own))

    def kinetic_energy_j(self) -> FloatArray:
        """Kinetic energy (m,) about the center of mass, J."""
        return kinetic_energy_j(self.body, self.angles_rad, self.angle_rates_rad_s, self.rate_rad_s)

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
    course = Propagation(body, history, initial_attitude_xyzw, initial_rate_rad_s, step_s=step_s, order=order)
    return course.flight(1, course.attitudes())


class Propagation:
    """The integration for one robot, or for a batch of robots that each have a history of their own.

    Args:
        body: One robot, or a batch of one axis.
        history: What the joints do; of the same batch.
        attitude_xyzw: (4,) of every base at the start, of any length; none turned if None.
        rate_rad_s: (3,) of every base at the start, base axes; None: no angular momentum.
        step_s: Longest step. Every robot of a batch takes as many steps as the slowest needs.
        order: 4 or 6.

    Raises:
        ValueError: `step_s` is not positive, there is no such order, or the start is no attitude and rate.
    """

    def __init__(
        self,
        body: Multibody,
        history: JointHistory,
        attitude_xyzw: FloatArray | None,
        rate_rad_s: FloatArray | None,
        *,
        step_s: float,
        order: Literal[4, 6],
    ) -> None:
        if not step_s > 0.0:
            raise ValueError(f"a step of {step_s} s leads nowhere")
        if order not in TABLEAUS:
            raise ValueError(f"there is no order {order}: choose from {', '.join(map(str, TABLEAUS))}")
        self._body, self._history, self._tableau = body, history, TABLEAUS[order]
        batch = history.breaks_s.shape[1:]
        # To be broadcast against steps, nodes and the batch.
        self._columns = body.columns(2 + len(batch))
        self._start = np.multiply.outer(_unit(attitude_xyzw), np.ones(batch))
        self._momentum = None if rate_rad_s is None else self._initial_momentum(np.asarray(rate_rad_s))
        # Without momentum the rate does not depend on the attitude: three nodes a step are enough.
        self._by_magnus = self._momentum is None and order == 6
        self._nodes = GAUSS if self._by_magnus else self._tableau.nodes
        self._spans_s = np.diff(history.breaks_s, axis=0)
        # One number of steps for the whole batch in each piece, by the longest of them.
        longest_s = self._spans_s.reshape(len(self._spans_s), -1).max(axis=1)
        # The tolerance keeps rounding from adding a step where the span is a multiple of it.
        self._counts = np.maximum(1, np.ceil(longest_s / step_s - 1e-9).astype(np.int64))

    @property
    def steps(self) -> int:
        """Number of steps."""
        return int(self._counts.sum())

    def attitudes(self, parts: int = 1, keep: int = 1) -> FloatArray:
        """(m, 4, ...) at the start and after every `keep`-th step, with every step divided into `parts`."""
        piece, since, length = self._divide_steps(parts)
        latest, attitudes = self._start, [self._start]
        # Inertia and drive are evaluated for a block of steps at once, as many as fit the cache.
        size = max(1, _BLOCK // (latest[0].size * len(self._nodes)))
        for first in range(0, len(piece), size):
            block = slice(first, first + size)
            after = self._after_steps(latest, piece[block], since[block], length[block])
            attitudes += [attitude for number, attitude in enumerate(after, first + 1) if number % keep == 0]
            latest = after[-1]
        return np.array(attitudes)

    def flight(self, parts: int, attitudes: FloatArray) -> Flight:
        """Build the flight of one robot from attitudes (m, 4) as returned by `attitudes(parts)`."""
        piece, since, length = self._divide_steps(parts)
        # Each instant is the end of a step, and shows the rates there; the first is the start of the first step.
        ends = np.append(piece[:1], piece), np.append(0.0, since + length)[:, None]
        angles, rates = self._history.in_piece(*ends)
        in_base = None
        if self._momentum is not None:
            in_base = _in_base(attitudes.T, self._momentum[:, None])[..., None]
        turning = _base_rate(*self._inertia_and_drive(angles, rates), in_base)
        t_s = np.append(self._history.breaks_s[piece] + since, self._history.breaks_s[-1])
        return Flight(self._body, t_s, attitudes, *(v[..., 0].T for v in (turning, angles, rates)))

    def _initial_momentum(self, rate: FloatArray) -> FloatArray:
        """H (3, 1, 1, ...), inertial axes, of a base that turns at `rate` (3,) when the history begins."""
        if rate.shape != (3,) or not np.isfinite(rate).all():
            raise ValueError(f"{rate} is no angular rate")
        start = np.zeros((1, 1, *self._start.shape[1:]))
        angles, rates = (v[:, 0, 0].T for v in self._history.in_piece(np.zeros(1, dtype=np.int64), start))
        inertia, joints = inertia_and_joint_momentum(self._body, angles)
        # The base's part and the joints' in base axes; in inertial axes their sum is conserved.
        own = inertia @ rate + np.einsum("...ij,...j->...i", joints, rates)
        return matvec(quaternion.to_matrix(self._start), batch_last(own))

    def _divide_steps(self, parts: int) -> tuple[IntArray, FloatArray, FloatArray]:
        """Piece (m,), start within the piece (m, ...) and length (m, ...) of each step."""
        counts = self._counts * parts
        piece: IntArray = np.repeat(np.arange(len(counts), dtype=np.int64), counts)
        # Index of a step within its piece: a running count less that of the piece's first step.
        number = np.arange(len(piece)) - np.repeat(np.cumsum(counts) - counts, counts)
        length = (self._spans_s.T / counts).T[piece]
        return piece, (number * length.T).T, length

    def _after_steps(
        self, attitude: FloatArray, piece: IntArray, since: FloatArray, length: FloatArray
    ) -> list[FloatArray]:
        """(4, ...) after each of m steps, from `since` (m, ...) after the start of pieces (m,) on."""
        at = since[:, None] + self._nodes.reshape(-1, *(1,) * (attitude.ndim - 1)) * length[:, None]
        angles, rates = self._history.in_piece(piece, at)
        # Without momentum and with resting joints nothing turns.
        if self._momentum is None and not rates.any():
            return [attitude] * len(piece)
        inertia, drive = self._inertia_and_drive(angles, rates)
        # With momentum a rate depends on the attitude reached: step by step.
        if self._momentum is not None:
            return self._stepwise(attitude, length, inertia, drive, self._momentum)
        w = _base_rate(inertia, drive)  # no step depends on the one before
        turns = magnus6(w, length) if self._by_magnus else self._turn(length, lambda node, _: w[:, :, node])
        attitudes = []
        for i in range(len(length)):
            attitude = _turn_attitude(attitude, turns[:, i])
            attitudes.append(attitude)
        return attitudes

    def _stepwise(
        self,
        attitude: FloatArray,
        length: FloatArray,
        inertia: FloatArray,
        drive: FloatArray,
        momentum: FloatArray,
    ) -> list[FloatArray]:
        """(4, ...) after each of m steps with momentum (3, ...); I (6, m, nodes, ...), A q' (3, m, nodes, ...)."""
        attitudes = []
        for i, h in enumerate(length):
            # Index and attitude are bound as defaults: the function is of this step alone.
            def rate(node: int, turn: FloatArray, i: int = i, start: FloatArray = attitude) -> FloatArray:
                here = quaternion.product(start, quaternion.exponential(turn))
                return _base_rate(inertia[:, i, node], drive[:, i, node], _in_base(here, momentum))

            attitude = _turn_attitude(attitude, self._turn(h, rate))
            attitudes.append(attitude)
        return attitudes

    def _turn(self, h: FloatArray, rate: Callable[[int, FloatArray], FloatArray]) -> FloatArray:
        """Rotation vector (3, ...) of a step of length h (...); `rate` is of a node and of the turn until then."""
        weights, stages = self._tableau.weights, self._tableau.stages
        slopes = np.empty((len(weights), 3, *np.shape(h)))
        # Stages lie in the Lie algebra: each rate passes the inverse differential of the exponential.
        for stage, node in enumerate(self._tableau.node_of_stage):
            turn = h * np.tensordot(stages[stage, :stage], slopes[:stage], axes=1)
            slopes[stage] = quaternion.inverse_differential(turn, rate(int(node), turn))
        return np.asarray(h * np.tensordot(weights, slopes, axes=1))

    def _inertia_and_drive(self, angles: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """I as xx, xy, xz, yy, yz, zz, (6, m, q, ...), and A q', (3, m, q, ...), of joints (n - 1, m, q, ...)."""
        # A joint that rests throughout the block has no momentum of its own.
        moving = [rate if rate.any() else None for rate in rates]
        # A joint that rests is turned only once.
        posed = [
            angle[:1, :1] if rate is None and (angle == angle[:1, :1]).all() else angle
            for angle, rate in zip(angles, moving, strict=True)
        ]
        composite = compose_bodies(self._columns, self._body.base, self._body.steps, posed, moving)
        inertia = np.stack([np.broadcast_to(entry, rates.shape[1:]) for entry in upper(composite.inertia)])
        drive = np.zeros((3, *rates.shape[1:]))
        return inertia, drive if composite.momentum is None else drive + composite.momentum


def _base_rate(inertia: FloatArray, drive: FloatArray, momentum: FloatArray | None = None) -> FloatArray:
    """w (3, ...) by the inertia (6, ...), the joints' own and the whole momentum (3, ...), all in base axes."""
    return solve_symmetric(inertia, -drive if momentum is None else momentum - drive)


def _turn_attitude(attitude: FloatArray, turn: FloatArray) -> FloatArray:
    """Rotate the attitude (4, ...) by a rotation vector (3, ...) in its own axes, and normalize it."""
    after = quaternion.product(attitude, quaternion.exponential(turn))
    # Rounding would let the length drift over many steps.
    return np.asarray(after / np.sqrt((after * after).sum(axis=0)))


def _in_base(attitude: FloatArray, momentum: FloatArray) -> FloatArray:
    """Transform the momentum (3, ...) from inertial axes to those of a base with attitude (4, ...)."""
    return matvec(transpose(quaternion.to_matrix(attitude)), momentum)


def _unit(attitude_xyzw: FloatArray | None) -> FloatArray:
    """(4,) of unit length. Raises ValueError if it is no attitude."""
    attitude = quaternion.identity() if attitude_xyzw is None else np.array(attitude_xyzw, dtype=np.float64)
    length = float(np.linalg.norm(attitude))
    if attitude.shape != (4,) or not (np.isfinite(length) and length > 0.0):
        raise ValueError(f"{attitude} is no attitude")
    return np.asarray(attitude / length)
