"""What the joints do over time while primitives are flown: a file for `simulate --history`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TextIO

import numpy as np

from tfsat_host.dynamics import TimedMove, moved, servo_moves
from tfsat_host.orbit.primitives import Primitive
from tfsat_host.robot import RobotModel

_SAMPLE_S = 0.05
# A spline through fewer samples of a stroke would cut its corners.
_LEAST_SAMPLES = 8


def write_joint_motion(robot: RobotModel, primitives: Sequence[Primitive], file: TextIO) -> None:
    """Writes t_s, the angle of every joint in deg and the number of the primitive, from 1.

    Strokes follow one another as the servos carry them out, each at its joint's average rate or as fast as it can.
    Without primitives the joints rest for a second.
    """
    moves, times, numbers, now_s = list[TimedMove](), [np.zeros(1)], [np.zeros(1)], 0.0
    for number, primitive in enumerate(primitives, start=1):
        for joint, angle_rad in primitive.strokes:
            duration_s = abs(angle_rad) / robot.servos[joint].average_rate_rad_s
            moves.append(TimedMove(joint, angle_rad, now_s, now_s + duration_s))
            (carried,) = servo_moves(robot, moves[-1:])
            count = max(int((carried.end_s - now_s) / _SAMPLE_S) + 1, _LEAST_SAMPLES)
            times.append(np.linspace(now_s, carried.end_s, count + 1)[1:])
            numbers.append(np.full(count, number))
            now_s = carried.end_s
    if not moves:
        times.append(np.ones(1))
        numbers.append(np.zeros(1))
    t_s = np.concatenate(times).round(6)
    history = moved(robot, moves, start_rad=np.array([servo.start_rad for servo in robot.servos]))
    angles_deg = np.degrees(history.angles_rad(t_s))
    joints = ",".join(f"theta{joint + 1}_deg" for joint in range(robot.n_joints))
    np.savetxt(
        file,
        np.column_stack([t_s, angles_deg, np.concatenate(numbers)]),
        fmt=["%.6f", *["%.8f"] * robot.n_joints, "%d"],
        delimiter=",",
        header=f"t_s,{joints},primitive",
        comments="",
    )
