"""The motion of the joints in a chain of primitives, as a file for `simulate --history`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tfsat_host.dynamics import TimedMove, history_from_moves, servo_moves
from tfsat_host.plan.orbit.primitives import Primitive
from tfsat_host.robot import RobotModel

_SAMPLE_S = 0.05
_FINE_SAMPLE_S = 0.01  # where strokes overlap, a sample may lie on either side of a start
_MIN_SAMPLES = 8  # a spline through fewer of a stroke would cut its corners


def write_joint_motion(robot: RobotModel, primitives: Sequence[Primitive], path: Path) -> None:
    """Writes t_s, the angle of every joint in deg and the number of the primitive, from 1.

    Strokes follow one another as the servos carry them out, each at its joint's average rate or as fast as it can.
    Without primitives the joints rest for a second.
    """
    moves, times, numbers, now_s = list[TimedMove](), [np.zeros(1)], [np.zeros(1)], 0.0
    for number, primitive in enumerate(primitives, start=1):
        if primitive.spans_s is not None:
            # Overlapping strokes keep their times.
            starts_s = (now_s + primitive.spans_s[:, 0]).tolist()
            for (joint, angle_rad), start_s in zip(primitive.strokes, starts_s, strict=True):
                duration_s = abs(angle_rad) / robot.servos[joint].average_rate_rad_s
                moves.append(TimedMove(joint, angle_rad, start_s, start_s + duration_s))
            count = max(int(primitive.duration_s / _FINE_SAMPLE_S) + 1, _MIN_SAMPLES)
            times.append(now_s + np.linspace(0.0, primitive.duration_s, count + 1)[1:])
            numbers.append(np.full(count, number))
            now_s += primitive.duration_s
            continue
        for joint, angle_rad in primitive.strokes:
            # A primitive has no times of its own: its strokes go at each joint's average rate.
            duration_s = abs(angle_rad) / robot.servos[joint].average_rate_rad_s
            moves.append(TimedMove(joint, angle_rad, now_s, now_s + duration_s))
            # The servo's acceleration may take longer: the next stroke waits for the joint to arrive.
            (carried,) = servo_moves(robot, moves[-1:])
            count = max(int((carried.end_s - now_s) / _SAMPLE_S) + 1, _MIN_SAMPLES)
            # Leave out the first instant: it is the end of the stroke before.
            times.append(np.linspace(now_s, carried.end_s, count + 1)[1:])
            numbers.append(np.full(count, number))
            now_s = carried.end_s
    # Two samples at rest: a history with fewer cannot be read back.
    if not moves:
        times.append(np.ones(1))
        numbers.append(np.zeros(1))
    # Round the times as the file has them, so that the angles are those of the written instants.
    t_s = np.concatenate(times).round(6)
    history = history_from_moves(
        robot, moves, start_rad=np.array([servo.start_rad for servo in robot.servos])
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
