"""A maneuver or a measured joint history, flown from the release on.

Inertial axes are those of the base body at the release. Without initial rate the robot has no angular momentum;
then the attitude after each stroke comes from the path of the joints alone (`stroke_rotation`, order 6), with
one from the propagation in time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.history import JointHistory, TimedMove, moved
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.dynamics.propagate import DEFAULT_STEP_S, Flight, propagate
from tfsat_host.dynamics.stroke import stroke_rotation
from tfsat_host.maneuver import Limits, Schedule
from tfsat_host.robot import RobotModel
from tfsat_host.units import cdeg_from_deg, s_from_us

# One maneuver can afford what a search cannot: with 90/90 of the drop tower robot 2e-10 deg remain, not 5e-5.
_STROKE_STEPS = 16
# Joints within 0.01 deg of where they started have closed the loop.
_CLOSED_RAD = math.radians(0.01)
_SPEED_RANGE_CDEG_S = (1, 1_000_000)


@dataclass(frozen=True, eq=False)
class Simulation:
    """What a robot did from the release to the last instant of the flight.

    Attributes:
        flight: The whole motion; its attitudes are those of the propagation in time.
        stroke_quaternions_xyzw: (k, 4) attitude of the base at the end of each stroke; (0, 4) for a sampled
            history.
        quaternion_xyzw: (4,) attitude of the base at the end: from its axes there to those at the release.
    """

    flight: Flight
    stroke_quaternions_xyzw: FloatArray
    quaternion_xyzw: FloatArray

    @property
    def is_closed(self) -> bool:
        """Whether every joint is back where it was at the release; if so, all bodies have turned alike."""
        angles = self.flight.angles_rad
        return bool((np.abs(angles[-1] - angles[0]) < _CLOSED_RAD).all())

    def rotations(self) -> FloatArray:
        """(n, 3, 3): how each body has turned from the release to the end, in inertial axes."""
        pose, _ = poses(self.flight.body, self.flight.angles_rad[[0, -1]])
        return np.asarray(quaternion.to_matrix(self.quaternion_xyzw) @ pose[1] @ pose[0].swapaxes(1, 2))


def robot_limits(robot: RobotModel) -> Limits:
    """What bounds a maneuver of this robot when no sequencer is involved: the range of its own joints."""
    return Limits(
        joint_ranges_cdeg=tuple((_cdeg(low), _cdeg(high)) for low, high in robot.joint_limits_rad),
        start_cdeg=tuple(_cdeg(servo.start_rad) for servo in robot.servos),
        speed_range_cdeg_s=_SPEED_RANGE_CDEG_S,
        strokes_min=0,
        strokes_max=None,
        pause_min_us=0,
        end_max_us=None,
        numbering=f"they are numbered in the order of {robot.path.name}, and --robot names another robot",
    )


def _cdeg(angle_rad: float) -> int:
    return cdeg_from_deg(math.degrees(angle_rad))


def fly_schedule(
    robot: RobotModel,
    schedule: Schedule,
    *,
    until_s: float,
    base: int | None = None,
    initial_rate_rad_s: FloatArray | None = None,
    step_s: float = DEFAULT_STEP_S,
    order: Literal[4, 6] = 6,
) -> Simulation:
    """The strokes of a schedule, from the start pose of the robot's servos.

    Args:
        robot: Who flies.
        schedule: Checked against `robot_limits(robot)` or stricter limits.
        until_s: End of the flight, after the release; at least the end of the last stroke.
        base: Index of the body whose attitude is followed; the robot's base if None.
        initial_rate_rad_s: (3,) rate of the base at the release, base axes. None: no angular momentum.
        step_s, order: Of the propagation in time.
    """
    body = Multibody.of(robot, base)
    start = np.array([servo.start_rad for servo in robot.servos])
    moves = [
        TimedMove(s.joint - 1, math.radians(s.angle_deg), s.t_s, s_from_us(s.end_us))
        for s in schedule.strokes
    ]
    flight = propagate(
        body,
        moved(robot, moves, start_rad=start, end_s=until_s),
        initial_rate_rad_s=initial_rate_rad_s,
        step_s=step_s,
        order=order,
    )
    if initial_rate_rad_s is None:
        attitudes = _after_strokes(body, start, moves)
        final = attitudes[-1] if moves else quaternion.identity()
    else:
        ends = [int(np.abs(flight.t_s - move.end_s).argmin()) for move in moves]
        attitudes, final = flight.quaternion_xyzw[ends], flight.quaternion_xyzw[-1]
    return Simulation(flight, attitudes, final)


def fly_history(
    robot: RobotModel,
    history: JointHistory,
    *,
    until_s: float,
    base: int | None = None,
    initial_rate_rad_s: FloatArray | None = None,
    step_s: float = DEFAULT_STEP_S,
    order: Literal[4, 6] = 6,
) -> Simulation:
    """Any joint history, held still from the release to its beginning and from its end to `until_s`.

    Args:
        robot: Who flies.
        history: Does not begin before the release, t = 0.
        until_s: End of the flight, after the release; at least the end of the history.
        base: Index of the body whose attitude is followed; the robot's base if None.
        initial_rate_rad_s: (3,) rate of the base at the release, base axes. None: no angular momentum.
        step_s, order: Of the propagation in time.
    """
    flight = propagate(
        Multibody.of(robot, base),
        held(history, 0.0, until_s),
        initial_rate_rad_s=initial_rate_rad_s,
        step_s=step_s,
        order=order,
    )
    return Simulation(flight, np.empty((0, 4)), flight.quaternion_xyzw[-1])


def held(history: JointHistory, from_s: float, until_s: float) -> JointHistory:
    """The same history, with the joints at rest from `from_s` to its beginning and from its end to `until_s`."""
    breaks, pieces = history.breaks_s, history.coefficients
    ends = history.angles_rad(breaks[[0, -1]])
    if from_s < breaks[0]:
        breaks, pieces = (
            np.append(from_s, breaks),
            np.concatenate([_at_rest(pieces, ends[0]), pieces], axis=1),
        )
    if until_s > breaks[-1]:
        breaks, pieces = (
            np.append(breaks, until_s),
            np.concatenate([pieces, _at_rest(pieces, ends[1])], axis=1),
        )
    return JointHistory(breaks, pieces)


def _at_rest(like: FloatArray, angles_rad: FloatArray) -> FloatArray:
    """One piece (d, 1, n - 1) that holds `angles_rad` (n - 1,)."""
    piece = np.zeros((len(like), 1, len(angles_rad)))
    piece[-1, 0] = angles_rad
    return piece


def _after_strokes(body: Multibody, start_rad: FloatArray, moves: list[TimedMove]) -> FloatArray:
    """(k, 4) attitude of the base after each of the moves, at zero momentum."""
    angles, attitude = start_rad.copy(), quaternion.identity()
    attitudes = np.empty((len(moves), 4))
    for i, move in enumerate(moves):
        turned = stroke_rotation(body, move.joint, angles, np.array(move.delta_rad), steps=_STROKE_STEPS)
        attitude = quaternion.product(attitude, turned)
        angles[move.joint] += move.delta_rad
        attitudes[i] = attitude
    return attitudes
