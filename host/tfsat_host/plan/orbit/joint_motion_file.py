"""The motion of the joints in a chain of primitives, as a file for `simulate --history`."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, pairwise
from pathlib import Path

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import TimedMove, history_from_moves
from tfsat_host.plan.orbit.primitives import Primitive
from tfsat_host.plan.orbit.stroke_history import stroke_s
from tfsat_host.robot import RobotModel

_SAMPLE_S = 0.05
_MIN_SAMPLE_S = 0.001
_MIN_SAMPLES = 8  # a spline through fewer of a stroke would cut its corners


def moves_of(robot: RobotModel, primitives: Sequence[Primitive]) -> list[list[TimedMove]]:
    """Return the moves of each primitive: strokes at their times, or one after another if it has none.

    Each goes at its joint's average rate or as fast as the servo can.
    """
    moves, now_s = list[list[TimedMove]](), 0.0
    for primitive in primitives:
        joints, angles_rad = zip(*primitive.strokes, strict=True)
        durations_s = stroke_s(robot, joints, np.array(angles_rad))
        after_s = np.cumsum(durations_s) - durations_s
        starts_s = now_s + (after_s if primitive.spans_s is None else primitive.spans_s[:, 0])
        columns = (starts_s.tolist(), (starts_s + durations_s).tolist())
        moves.append([TimedMove(*move) for move in zip(joints, angles_rad, *columns, strict=True)])
        now_s = float((starts_s + durations_s).max())
    return moves


def write_joint_motion(robot: RobotModel, primitives: Sequence[Primitive], path: Path) -> None:
    """Writes t_s, the angle of every joint in deg and the number of the primitive, from 1.

    Without primitives the joints rest for a second.
    """
    times, numbers = [np.zeros(1)], [np.zeros(1)]
    moves = moves_of(robot, primitives)
    for number, strokes in enumerate(moves, start=1):
        samples_s = _samples_s(strokes)
        times.append(samples_s)
        numbers.append(np.full(len(samples_s), number))
    # Two samples at rest: a history with fewer cannot be read back.
    if not moves:
        times.append(np.ones(1))
        numbers.append(np.zeros(1))
    # Round the times as the file has them, so that the angles are those of the written instants.
    t_s = np.concatenate(times).round(6)
    history = history_from_moves(
        robot, [*chain(*moves)], start_rad=np.array([servo.start_rad for servo in robot.servos])
    )
    joints = ",".join(f"theta{joint + 1}_deg" for joint in range(robot.n_joints))
    np.savetxt(
        path,
        np.column_stack([t_s, np.degrees(history.angles_rad(t_s)), np.concatenate(numbers)]),
        fmt=["%.6f", *["%.8f"] * robot.n_joints, "%d"],
        delimiter=",",
        header=f"t_s,{joints},primitive",
        comments="",
    )


def _samples_s(moves: Sequence[TimedMove]) -> FloatArray:
    """Return instants (m,) after the first start: all starts and ends, and others between them."""
    edges_s = np.unique(np.round([(move.start_s, move.end_s) for move in moves], 6))
    pieces = []
    for begin_s, end_s in pairwise(edges_s):
        # A short piece has few samples, or they could not be told apart.
        least = min(_MIN_SAMPLES, int((end_s - begin_s) / _MIN_SAMPLE_S) + 1)
        count = max(int((end_s - begin_s) / _SAMPLE_S) + 1, least)
        # Leave out the first instant: it is the end of the piece before.
        pieces.append(np.linspace(begin_s, end_s, count + 1)[1:])
    return np.concatenate(pieces)
