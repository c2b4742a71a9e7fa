"""Closed loops of strokes: in which order joints may move, and the reorientation of every sequence at once.

Every joint opens once and closes once. A closing stroke is never flown at once after its own opening stroke, because
that induces nothing (paper, section "Design of optimal reorientation maneuver"). Three joints have 30 such sequences.
Flown backwards, a sequence gives the inverse rotation, so 15 rotation angles are all there are.

For given displacements the joints' angles walk along edges of one box in the space of joint angles. Three joints
have 12 edges, and every stroke of all 30 sequences is one of them: 12 integrals serve 180 strokes.
"""

from __future__ import annotations

from collections.abc import Sequence as SequenceOf
from functools import cache

import numpy as np

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.dynamics import Multibody, quaternion
from tfsat_host.dynamics.stroke import STEPS, Hinge, rotate_base

Sequence = tuple[int, ...]
"""Signed joint numbers from 1, in the order they move: +1 opens joint 1, -1 closes it."""


@cache
def sequences(n_joints: int) -> tuple[Sequence, ...]:
    """Return all closed sequences of joints 1 to `n_joints`, in lexical order of opening first."""
    closed_sequences: list[Sequence] = []

    def extend(prefix: Sequence) -> None:
        if len(prefix) == 2 * n_joints:
            closed_sequences.append(prefix)
            return
        # A joint opens once, then closes once, but not right after its own opening stroke.
        for joint in range(1, n_joints + 1):
            if joint not in prefix:
                extend((*prefix, joint))
            elif -joint not in prefix and prefix[-1] != joint:
                extend((*prefix, -joint))

    extend(())
    return tuple(closed_sequences)


def backwards(sequence: Sequence) -> Sequence:
    """Return the sequence that undoes this one."""
    return tuple(-stroke for stroke in reversed(sequence))


@cache
def classes(n_joints: int) -> tuple[Sequence, ...]:
    """Return one sequence, the lexically first, of each pair that undo one another."""
    return tuple(s for s in sequences(n_joints) if s <= backwards(s))


def format_sequence(sequence: Sequence) -> str:
    """Format the sequence for people: "+1 +2 -1 -2"."""
    return " ".join(f"{stroke:+d}" for stroke in sequence)


# Numbers of steps that are tried, each about half as many again.
_STEPS = (2, 3, 4, 6, 9, 14, 21, 32)


class Loops:
    """The loops of some joints of a robot, from its start pose.

    Args:
        body: One robot (no batch).
        joints: (d,) indices of the joints that move; stroke +1 of a sequence opens the first of them.
        sequences: The sequences to be walked.
        start_rad: (n - 1,) joint angles at the start; zero if None.
        directions: (d,) 1 where a joint moves out by a positive angle, -1 where by a negative; all 1 if None.
        steps: Steps of order 6 into which each edge is divided.
    """

    def __init__(
        self,
        body: Multibody,
        joints: SequenceOf[int],
        sequences: SequenceOf[Sequence],
        *,
        start_rad: FloatArray | None = None,
        directions: FloatArray | None = None,
        steps: int = STEPS,
    ) -> None:
        self.sequences = tuple(sequences)
        self._joints = tuple(joints)
        self._start = (
            np.zeros(body.n_joints) if start_rad is None else np.asarray(start_rad, dtype=np.float64)
        )
        self._directions = np.ones(len(self._joints)) if directions is None else directions
        self._steps = steps
        self._hinges = [Hinge.of(body, joint, 1) for joint in self._joints]
        # Edges of the box along one joint: one for every open or closed state of the d - 1 others.
        corners = 2 ** (len(self._joints) - 1)
        self._opened = np.array(
            [[corner >> bit & 1 for corner in range(corners)] for bit in range(len(self._joints) - 1)]
        )
        # (strokes, s) edge numbers: one gather a stroke serves all sequences.
        self._walks = np.array([self._walk(sequence) for sequence in self.sequences]).T

    def rotations(self, displacements_rad: FloatArray) -> FloatArray:
        """Quaternions (4, s, b) of s sequences for displacements (d, b), components first."""
        edges = self._edges(displacements_rad)
        # Multiply in flight order, all sequences and displacements at once.
        rotation = edges[:, self._walks[0]]
        for stroke in self._walks[1:]:
            rotation = quaternion.product(rotation, edges[:, stroke])
        return rotation

    def angles_rad(self, displacements_rad: FloatArray) -> FloatArray:
        """Rotation angles (s, b) of s sequences for displacements (d, b)."""
        return quaternion.angle(self.rotations(displacements_rad))

    def _edges(self, displacements: FloatArray) -> FloatArray:
        """Quaternions (4, 2 e, b) of the box's e edges, walked outwards and then, behind them, back."""
        displacements = displacements * self._directions[:, None]
        d, batch = displacements.shape
        corners = 2 ** (d - 1)
        outwards = []
        for moving, hinge in enumerate(self._hinges):
            angles = np.empty((len(self._start), corners, batch))
            angles[:] = self._start[:, None, None]
            # Pose the other joints at the corner at which the edge begins.
            for bit, other in enumerate(other for other in range(d) if other != moving):
                angles[self._joints[other]] += self._opened[bit][:, None] * displacements[other]
            delta = np.broadcast_to(displacements[moving], (corners, batch)).reshape(-1)
            rotation = rotate_base(hinge, angles.reshape(len(self._start), -1), delta, self._steps)
            outwards.append(rotation.reshape(4, corners, batch))
        # Walked back, an edge gives the inverse rotation: no second integral.
        there = np.concatenate(outwards, axis=1)
        return np.concatenate([there, quaternion.inverse(there)], axis=1)

    def _walk(self, sequence: Sequence) -> list[int]:
        """Return the index, in the result of `_edges`, of the edge of each stroke."""
        d = len(self._joints)
        corners = 2 ** (d - 1)
        opened, walk = [0] * d, list[int]()
        for stroke in sequence:
            moving = abs(stroke) - 1
            others = [opened[other] for other in range(d) if other != moving]
            # The others' states as a binary number, in the order in which `_edges` counts corners.
            edge = moving * corners + sum(bit << place for place, bit in enumerate(others))
            # Closing strokes take their edge from the second half, which holds the inverses.
            walk.append(edge if stroke > 0 else d * corners + edge)
            opened[moving] = int(stroke > 0)
        return walk


def best_sequence(angles_rad: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the greatest angle (b,) of angles (s, b), and the index (b,) of its sequence."""
    best = np.argmax(angles_rad, axis=0)
    return np.take_along_axis(angles_rad, best[None], axis=0)[0], best


def enough_steps(
    body: Multibody,
    joints: SequenceOf[int],
    start_rad: FloatArray,
    displacements_rad: FloatArray,
    tolerance_rad: float,
) -> int:
    """Return the fewest integration steps per edge that keep every loop of the joints within a tolerance.

    Args:
        body: One robot (no batch).
        joints: (d,) indices of the joints that move.
        start_rad: (n - 1,) joint angles at the start.
        displacements_rad: (d, b) greatest displacements; their loops are compared with those of four times the
            steps.
        tolerance_rad: Greatest error of a rotation.
    """
    for steps in _STEPS[:-1]:
        rough, fine = (
            Loops(body, joints, classes(len(joints)), start_rad=start_rad, steps=n).rotations(
                displacements_rad
            )
            for n in (steps, 4 * steps)
        )
        # A quaternion's components change by half the angle; four times the steps stand for the exact loop.
        if 2.0 * np.abs(rough - fine).max() < tolerance_rad:
            return steps
    return _STEPS[-1]
