"""The attitude of a batch of robots after a maneuver: each sample has masses, joints and strokes of its own.

As `tfsat_host.dynamics.propagate`, with the batch in place of its one robot. Steps end wherever the acceleration
of a joint of the sample changes. Without angular momentum the base's rate does not depend on its attitude, and
Magnus' series of order 6 needs it at three instants of a step; with angular momentum a Runge-Kutta-Munthe-Kaas
method of order 6 follows both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import (
    FloatArray,
    SymmetricTensor,
    matvec,
    solve_symmetric,
    transpose,
    upper,
)
from tfsat_host.dynamics.momentum import coefficients
from tfsat_host.dynamics.multibody import Columns, Multibody
from tfsat_host.dynamics.propagate import TABLEAUS
from tfsat_host.dynamics.stroke import magnus6
from tfsat_host.sensitivity.strokes import Moves

_STEPS = 2  # between two changes of an acceleration; leave 1e-5 deg on 59/70 without angular momentum
_STEPS_PER_RATE_S = 4.0  # with it, one and this many for each rad/s of the base: the pause is one long step
_GAUSS = 0.5 + 0.5 * np.polynomial.legendre.leggauss(3)[0]
_TABLEAU = TABLEAUS[6]
_NODES, _NODE_OF_STAGE = np.unique(_TABLEAU.nodes, return_inverse=True)


def steps_needed(initial_rate_rad_s: FloatArray | None) -> int:
    """Steps between two changes of an acceleration that leave less than a millidegree."""
    if initial_rate_rad_s is None:
        return _STEPS
    return 1 + int(np.ceil(_STEPS_PER_RATE_S * np.linalg.norm(initial_rate_rad_s)))


def final_attitude(
    body: Multibody, moves: Moves, initial_rate_rad_s: FloatArray | None = None, *, steps: int | None = None
) -> FloatArray:
    """Attitude of the base at the end of `moves`, released at zero attitude.

    Args:
        body: s robots, as a batch of one axis.
        moves: What their joints do.
        initial_rate_rad_s: (3,) rate of the base at release, base axes; None: no angular momentum.
        steps: Steps between two changes of an acceleration; `steps_needed` if None.

    Returns:
        Quaternions (4, s), components first, scalar last: from base axes to inertial axes.
    """
    steps = steps_needed(initial_rate_rad_s) if steps is None else steps
    columns = Columns(*(np.ascontiguousarray(values)[..., None, :] for values in body.columns(1)))
    breaks = moves.breaks_s()
    attitude = quaternion.identity(breaks.shape[1:])
    begins, lengths = breaks[:-1], np.diff(breaks, axis=0) / steps
    if initial_rate_rad_s is None:
        # Before the first stroke and after the last one nothing happens.
        for begin, length in zip(begins[1:-1], lengths[1:-1], strict=True):
            attitude = _without_momentum(body, columns, moves, attitude, begin, length, steps)
    else:
        inertia = coefficients(body, columns, moves.at(breaks[:1])[0]).inertia[:, :, 0]
        momentum = matvec(inertia, np.asarray(initial_rate_rad_s, dtype=np.float64)[:, None])
        for begin, length in zip(begins, lengths, strict=True):
            for step in range(steps):
                spin = _Spin.of(body, columns, moves, begin + (step + _NODES[:, None]) * length)
                turn = _turn(spin, length, attitude, momentum)
                attitude = quaternion.product(attitude, quaternion.exponential(turn))
    return np.asarray(attitude / np.sqrt((attitude * attitude).sum(axis=0)))


def _without_momentum(
    body: Multibody,
    columns: Columns,
    moves: Moves,
    attitude: FloatArray,
    begin: FloatArray,
    length: FloatArray,
    steps: int,
) -> FloatArray:
    """Attitudes (4, s) after `steps` steps of `length` (s,) from attitudes (4, s) at the instants `begin` (s,)."""
    nodes = (np.arange(steps)[:, None] + _GAUSS).reshape(-1, 1)
    spin = _Spin.of(body, columns, moves, begin + nodes * length)
    rates = solve_symmetric(spin.inertia, -spin.joints).reshape(3, steps, len(_GAUSS), -1)
    turns = magnus6(rates, length)
    for step in range(steps):
        attitude = quaternion.product(attitude, quaternion.exponential(turns[:, step]))
    return attitude


class _Spin(NamedTuple):
    """I and A q' at every node: six arrays (nodes, s), and (3, nodes, s)."""

    inertia: SymmetricTensor
    joints: FloatArray

    @classmethod
    def of(cls, body: Multibody, columns: Columns, moves: Moves, t_s: FloatArray) -> _Spin:
        angles, rates = moves.at(t_s)
        found = coefficients(body, columns, angles)
        return cls(upper(found.inertia), np.asarray((found.joints * rates).sum(axis=1)))

    def rate(self, node: int, attitude: FloatArray, momentum: FloatArray) -> FloatArray:
        """Base rate (3, s), base axes, at attitude (4, s) and momentum (3, s) in inertial axes."""
        own = matvec(transpose(quaternion.to_matrix(attitude)), momentum) - self.joints[:, node]
        xx, xy, xz, yy, yz, zz = (entry[node] for entry in self.inertia)
        return solve_symmetric((xx, xy, xz, yy, yz, zz), own)


def _turn(spin: _Spin, length: FloatArray, attitude: FloatArray, momentum: FloatArray) -> FloatArray:
    """Rotation vectors (3, s) of one step."""
    slopes: list[FloatArray] = []
    for row, node in zip(_TABLEAU.stages, _NODE_OF_STAGE, strict=True):
        turn = length * _weighted(row, slopes, length.shape)
        here = quaternion.product(attitude, quaternion.exponential(turn))
        slopes.append(quaternion.inverse_differential(turn, spin.rate(node, here, momentum)))
    return np.asarray(length * _weighted(_TABLEAU.weights, slopes, length.shape))


def _weighted(weights: FloatArray, slopes: list[FloatArray], shape: tuple[int, ...]) -> FloatArray:
    total = np.zeros((3, *shape))
    for weight, slope in zip(weights, slopes, strict=False):
        total += weight * slope
    return total
