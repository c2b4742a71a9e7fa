"""A maneuver or a measured joint history, flown from the release on.

Inertial axes are those of the base body at the release.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.history import JointHistory, TimedMove, history_from_moves, overlap, servo_moves
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.dynamics.propagate import Flight
from tfsat_host.dynamics.propagate_within import EstimatedFlight, propagate_within
from tfsat_host.errors import UsageError
from tfsat_host.maneuver import Limits, Schedule
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.robot import RobotModel
from tfsat_host.units import cdeg_from_deg, s_from_us

# Joints within 0.01 deg of where they started have closed the loop.
_CLOSED_RAD = math.radians(0.01)
_SPEED_RANGE_CDEG_S = (1, 1_000_000)
_STEPS_MAX = 200_000


@dataclass(frozen=True, eq=False)
class Simulation:
    """What a robot did from the release to the last instant of the flight.

    Attributes:
        robot: Who flew.
        motion: The schedule that it flew, or the joint history.
        estimated: The whole motion, with an estimate of its error.
        arrivals_s: (k,) when the joint of each stroke has arrived.
        stroke_quaternions_xyzw: (k, 4) attitude of the base then; (0, 4) for a sampled history.
        strokes_overlap: Whether a stroke starts while another joint is still under way.
    """

    robot: RobotModel
    motion: Schedule | JointHistory
    estimated: EstimatedFlight
    arrivals_s: tuple[float, ...]
    stroke_quaternions_xyzw: FloatArray
    strokes_overlap: bool

    @property
    def flight(self) -> Flight:
        """The whole motion."""
        return self.estimated.flight

    @property
    def quaternion_xyzw(self) -> FloatArray:
        """(4,) attitude of the base at the end: from its axes there to those at the release."""
        return np.asarray(self.flight.quaternion_xyzw[-1])

    @property
    def is_closed(self) -> bool:
        """Whether every joint is back where it was at the release; if so, all bodies have turned alike."""
        angles = self.flight.angles_rad
        return bool((np.abs(angles[-1] - angles[0]) < _CLOSED_RAD).all())

    def rotations(self) -> FloatArray:
        """(n, 3, 3): how each body has turned from the release to the end, in inertial axes."""
        # A body's attitude is the base's times its pose; the turn is that at the end against the start's.
        pose, _ = poses(self.flight.body, self.flight.angles_rad[[0, -1]])
        return np.asarray(quaternion.to_matrix(self.quaternion_xyzw) @ pose[1] @ pose[0].swapaxes(1, 2))


def fly(
    robot: RobotModel,
    motion: Schedule | JointHistory,
    *,
    until_s: float,
    base: int | None = None,
    initial_rate_rad_s: FloatArray | None = None,
    step_s: float | None = None,
    order: Literal[4, 6] = 6,
) -> Simulation:
    """Simulate the flight of a robot by a schedule or a joint history.

    The servos carry out the schedule's strokes from their start pose.

    Args:
        robot: The robot that flies.
        motion: A schedule, checked against `robot_limits(robot)` or stricter limits; or a history that does
            not begin before the release, t = 0, held still before it begins and after it ends.
        until_s: End of the flight, after the release; for a schedule at least the last of `arrivals_s`.
            Later parts of a history are ignored.
        base: Index of the body whose attitude is followed; the robot's base if None.
        initial_rate_rad_s: (3,) rate of the base at the release, base axes. None: no angular momentum.
        step_s, order: Step and order of the propagation in time; None: steps as short as 1e-4 deg needs.
    """
    carried: list[TimedMove] = []
    if isinstance(motion, Schedule):
        moves, start = timed_moves(robot, motion), np.array([servo.start_rad for servo in robot.servos])
        carried, history = (
            servo_moves(robot, moves),
            history_from_moves(robot, moves, start_rad=start, end_s=until_s),
        )
    else:
        history = clip_history(motion, 0.0, until_s)
    body = Multibody.of(robot, base)
    estimated = propagate_within(
        body, history, initial_rate_rad_s=initial_rate_rad_s, order=order, step_s=step_s
    )
    # Strokes end at breaks of the history, which steps never cross: the flight has these instants.
    ends = [int(np.abs(estimated.flight.t_s - move.end_s).argmin()) for move in carried]
    arrivals = tuple(move.end_s for move in carried)
    attitudes = estimated.flight.quaternion_xyzw[ends]
    return Simulation(robot, motion, estimated, arrivals, attitudes, overlap(carried))


MAX_STROKES = 100
"""Of a study: it takes seconds with them, and a sequencer holds 16."""


def robot_limits(robot: RobotModel, *, strokes_min: int = 0) -> Limits:
    """Return the limits of a maneuver of this robot without a sequencer: the range of its joints."""
    return Limits(
        joint_ranges_cdeg=tuple((_cdeg(low), _cdeg(high)) for low, high in robot.joint_limits_rad),
        start_cdeg=tuple(_cdeg(servo.start_rad) for servo in robot.servos),
        speed_range_cdeg_s=_SPEED_RANGE_CDEG_S,
        strokes_min=strokes_min,
        strokes_max=MAX_STROKES,
        pause_min_us=0,
        end_max_us=None,
        numbering=f"they are numbered in the order of {robot.path.name}, and --robot names another robot",
    )


def _cdeg(angle_rad: float) -> int:
    return cdeg_from_deg(math.degrees(angle_rad))


def arrivals_s(robot: RobotModel, schedule: Schedule) -> tuple[float, ...]:
    """Compute the arrival time of each stroke's joint.

    It is later than scheduled if the servo needs longer.
    """
    return tuple(move.end_s for move in servo_moves(robot, timed_moves(robot, schedule)))


def end_of_flight_s(asked_s: float | None, joints_end_s: float, step_s: float | None) -> float:
    """Return the end of the flight: as asked, else the end of the fall or of the joints' motion if later.

    Raises:
        UsageError: the joints still move then, or steps of this length would be too many.
    """
    until_s = float(max(s_from_us(FALL_US), joints_end_s) if asked_s is None else asked_s)
    what = cure = ""
    # An end before the joints rest would cut a stroke off.
    if not (math.isfinite(until_s) and until_s > 0.0 and until_s >= joints_end_s):
        what = (
            f"--until {until_s:g} ends before the joints have come to rest, {joints_end_s:g} s after release."
        )
        cure = "Give a later time, or leave --until out."
    elif step_s is not None and until_s / step_s > _STEPS_MAX:
        what = f"{until_s:g} s in steps of {step_s:g} s are more than {_STEPS_MAX} steps."
        cure = "Give a longer --step, or leave it out."
    if what:
        raise UsageError(what=what, meaning="Nothing was done.", next_step=cure)
    return until_s


def timed_moves(robot: RobotModel, schedule: Schedule) -> list[TimedMove]:
    """Convert the schedule's strokes to moves of the robot's joints, for `history_from_moves` and `servo_moves`."""
    commanded_rad = [servo.start_rad for servo in robot.servos]
    reached_rad, moves = commanded_rad.copy(), []
    for stroke in schedule.strokes:
        joint = stroke.joint - 1
        commanded_rad[joint] += math.radians(stroke.angle_deg)
        # A joint goes from where it really is, and no farther than its servo's play.
        stop_rad = robot.servos[joint].stop_rad(reached_rad[joint], commanded_rad[joint])
        moves.append(TimedMove(joint, stop_rad - reached_rad[joint], stroke.t_s, s_from_us(stroke.end_us)))
        reached_rad[joint] = stop_rad
    return moves


def clip_history(history: JointHistory, from_s: float, until_s: float) -> JointHistory:
    """Cut or extend the history to the interval from `from_s` to `until_s`.

    The joints rest before it begins and after it ends. `from_s` is no later than its beginning.
    """
    # Pieces that begin before the end; the last of them is cut there.
    before_end = int(np.searchsorted(history.breaks_s[:-1], until_s))
    breaks = np.append(history.breaks_s[:before_end], min(until_s, history.breaks_s[before_end]))
    pieces = history.coefficients[:, : len(breaks) - 1]
    rest = np.zeros((len(pieces), 2, pieces.shape[2]))  # a piece before and one after
    rest[-1] = history.angles_rad(history.breaks_s[[0, -1]])
    # Constant pieces hold the joints outside of what was measured.
    if from_s < breaks[0]:
        breaks, pieces = np.append(from_s, breaks), np.concatenate([rest[:, :1], pieces], axis=1)
    if until_s > breaks[-1]:
        breaks, pieces = np.append(breaks, until_s), np.concatenate([pieces, rest[:, 1:]], axis=1)
    return JointHistory(breaks, pieces)
