"""The design problem: how far the joints may move, how long it may take, and what a candidate is worth."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import optimize

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.dynamics import Multibody
from tfsat_host.dynamics.history import shortest_s
from tfsat_host.errors import UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.loops import Loops, Sequence, best_sequence, classes, enough_steps
from tfsat_host.plan.swarm import Coefficient, SwarmSettings
from tfsat_host.protocol.limits import SCHEDULE_GRID_US
from tfsat_host.robot import RobotModel
from tfsat_host.units import CDEG_PER_DEG, s_from_us

DEFAULT_TIME_LIMIT_S = 1.5  # 2.5 s of fall less 1.0 s of margin (paper, section "Design of optimal ...")
MAX_JOINTS = 4  # 864 sequences; five joints have 39480
_MIN_STROKE_RAD = math.radians(0.01)  # the sequencer's resolution
_EXACT_CDEG = 1e-6  # what binary digits cost of a hundredth
_EXACT_TIME = 1e-9
GRID_S = s_from_us(SCHEDULE_GRID_US)
"""Starts of strokes are multiples of it."""
# The time of a short stroke goes with the root of its size: below this its slope is held, to be finite.
_STEEPEST_RAD = math.radians(0.01)
# Greatest error of a loop's rotation by the steps of its integration.
_ENOUGH_RAD = math.radians(5e-4)
_COEFFICIENT_MOST = 100.0
DEFAULT_PENALTY = 1e11  # deg/s^2 (paper, likewise)


class DesignError(UsageError):
    """No maneuver can be designed with these settings.

    Attributes:
        setting: Which one is at fault.
    """

    def __init__(self, setting: str, what: str) -> None:
        super().__init__(
            what=what,
            meaning="Nothing was designed.",
            next_step=Advice(f"Correct the {setting}: ", NextStep("design", ("--help",))),
        )
        self.setting = setting


def coefficient(name: str, pair: tuple[float, ...]) -> Coefficient:
    """Check and return the swarm's coefficient `name`, at the first and the last iteration.

    Raises:
        DesignError: the values are not two numbers, or they are too large.
    """
    if len(pair) != 2 or not all(abs(value) <= _COEFFICIENT_MOST for value in pair):
        option, what = f"--{name.replace('_', '-')}", f"needs two numbers up to {_COEFFICIENT_MOST:g}"
        raise DesignError(option, f"{option} {what}: at the first iteration and at the last.")
    return pair[0], pair[1]


@dataclass(frozen=True, slots=True)
class DesignSettings:
    """What is asked for, and how it is searched.

    Attributes:
        joints: Indices of the joints that may move; every joint of the robot if None.
        speed_deg_s: Average joint speed; the slowest of those servos' averages if None.
        time_limit_s: T_max, for all strokes together.
        limit_deg: Greatest displacement of each joint in `joints`; to the end of its range if None.
        penalty: P, deg of reorientation for (1 s)^2 of overtime.
        robust: K of mean less K standard deviations over what the robot file calls uncertain; 0: not asked for.
        alternating: Optimize displacements and sequence in turns, as the paper describes its search,
            instead of taking the best sequence of every candidate, as it writes its objective.
        swarm: The swarm.
        seed: Of the swarm's random numbers.
        steps: Steps of order 6 into which each stroke is divided; as many as the robot needs if None.
    """

    joints: tuple[int, ...] | None = None
    speed_deg_s: float | None = None
    time_limit_s: float = DEFAULT_TIME_LIMIT_S
    limit_deg: tuple[float, ...] | None = None
    penalty: float = DEFAULT_PENALTY
    robust: float = 0.0
    alternating: bool = False
    swarm: SwarmSettings = field(default_factory=SwarmSettings)
    seed: int = 1
    steps: int | None = None


@dataclass(frozen=True, eq=False)
class Problem:
    """The settings made concrete for one robot.

    Attributes:
        body: The robot.
        joints: (d,) indices of the joints that may move.
        start_rad: (n - 1,) pose at the start.
        directions: (d,) 1 where a joint moves out by a positive angle, -1 where by a negative; by `of`, to the side
            where its range has more room.
        limit_rad: (d,) greatest displacements that way.
        sides_rad: (d, 2) greatest displacements by negative and by positive angles.
        speed_rad_s: Average joint speed.
        max_rate_rad_s: (d,) greatest rate of each joint's servo.
        acceleration_rad_s2: (d,) its acceleration.
        time_limit_s: T_max.
        penalty: P in rad/s^2.
        steps: Steps of each stroke.
    """

    body: Multibody
    joints: tuple[int, ...]
    start_rad: FloatArray
    directions: FloatArray
    limit_rad: FloatArray
    sides_rad: FloatArray
    speed_rad_s: float
    max_rate_rad_s: FloatArray
    acceleration_rad_s2: FloatArray
    time_limit_s: float
    penalty: float
    steps: int

    @classmethod
    def of(cls, robot: RobotModel, settings: DesignSettings) -> Problem:
        """Build the problem for `robot`.

        Raises:
            DesignError: the settings do not fit the robot; `setting` names the one at fault.
        """
        joints = tuple(range(robot.n_joints)) if settings.joints is None else settings.joints
        _check_joints(robot, joints)
        start = np.array([servo.start_rad for servo in robot.servos])
        # Room to either side of the start pose; a joint moves out to the wider one.
        below, above = np.abs(robot.joint_limits_rad[list(joints)] - start[list(joints), None]).T
        directions, room = np.where(above >= below, 1.0, -1.0), np.maximum(above, below)
        limit = room if settings.limit_deg is None else np.radians(np.array(settings.limit_deg))
        _check_limits(robot, joints, limit, room)
        speed = settings.speed_deg_s
        # The slowest servo sets the common speed; rounding takes off the noise of radians.
        if speed is None:
            speed = round(math.degrees(min(robot.servos[joint].average_rate_rad_s for joint in joints)), 9)
        for name, value in (
            ("speed", speed),
            ("time limit", settings.time_limit_s),
            ("penalty", settings.penalty),
        ):
            if not (math.isfinite(value) and value > 0.0):
                raise DesignError(name, f"The {name} is {value:g}; it must be above zero.")
        body = Multibody.of(robot)
        sides = np.minimum(np.stack([below, above], axis=1), limit[:, None])
        # The integration must be good at all corners of the box, and half way there.
        far = np.array(list(itertools.product(*(sides * [-1.0, 1.0])))).T
        reach = np.concatenate([far, 0.5 * far], axis=1)
        return cls(
            body,
            joints,
            start,
            directions,
            limit,
            sides,
            math.radians(speed),
            np.array([robot.servos[joint].max_rate_rad_s for joint in joints]),
            np.array([robot.servos[joint].acceleration_rad_s2 for joint in joints]),
            settings.time_limit_s,
            math.radians(settings.penalty),
            settings.steps or enough_steps(body, joints, start, reach, _ENOUGH_RAD),
        )

    def __post_init__(self) -> None:
        """Raises DesignError if the time is too short to move anything."""
        if not self.keeps_time(np.full(len(self.joints), _MIN_STROKE_RAD)):
            raise DesignError(
                "time limit",
                f"In {self.time_limit_s:g} s at {math.degrees(self.speed_rad_s):g} deg/s no joint turns by 0.01 deg.",
            )

    def with_directions(self, directions: FloatArray) -> Problem:
        """Return the problem with its joints' opening directions set to the signs (d,)."""
        limit = np.where(directions > 0.0, self.sides_rad[:, 1], self.sides_rad[:, 0])
        return replace(self, directions=directions, limit_rad=limit)

    def sign_patterns(self) -> Iterator[Problem]:
        """Yield the problem for every combination of the sides on which its joints have room.

        The problem itself comes first.
        """
        yield self
        # A side without room for one hundredth of a degree gives no pattern.
        room = [[s for s in (1.0, -1.0) if side[int(s > 0.0)] >= _MIN_STROKE_RAD] for side in self.sides_rad]
        for pattern in itertools.product(*room):
            if not np.array_equal(pattern, self.directions):
                yield self.with_directions(np.array(pattern))

    def stroke_s(self, displacements_rad: FloatArray) -> FloatArray:
        """(d, ...) how long a stroke takes: at the average speed, and longer where its servo needs to speed up and slow
        down."""
        size = np.asarray(displacements_rad)
        # Append axes of length one, so that figures (d,) go with displacements (d, ...).
        rate, acceleration = (
            per_joint.reshape(-1, *[1] * (size.ndim - 1))
            for per_joint in (self.max_rate_rad_s, self.acceleration_rad_s2)
        )
        return np.asarray(np.maximum(size / self.speed_rad_s, shortest_s(size, rate, acceleration)))

    def stroke_s_per_rad(self, displacements_rad: FloatArray) -> FloatArray:
        """(d,) its derivative; near zero, where that is without bounds, the one at `_STEEPEST_RAD`."""
        size = np.maximum(displacements_rad, _STEEPEST_RAD)
        rate, acceleration = self.max_rate_rad_s, self.acceleration_rad_s2
        # With a cruise the slope is 1 / rate; two ramps take 2 sqrt(size / a), of slope 1 / sqrt(size a).
        short = np.where(size * acceleration > rate * rate, 1.0 / rate, 1.0 / np.sqrt(size * acceleration))
        average = size / self.speed_rad_s >= self.stroke_s(size)
        return np.where(average, 1.0 / self.speed_rad_s, short)

    def farthest_rad(self, stroke_s: float | FloatArray) -> FloatArray:
        """(d,) displacements that take so long, each joint's own time (d,) or one for all."""
        rate, acceleration = self.max_rate_rad_s, self.acceleration_rad_s2
        # Invert the servo's profile: with a cruise if both ramps fit into the time, else two ramps alone.
        ramps = rate / acceleration
        reach = np.where(
            stroke_s > 2.0 * ramps, rate * (stroke_s - ramps), 0.25 * acceleration * stroke_s * stroke_s
        )
        return np.asarray(np.minimum(self.speed_rad_s * stroke_s, reach))

    def keeps_time(self, displacements_rad: FloatArray) -> BoolArray:
        """(...) whether displacements (d, ...) take no longer than the time limit, but for rounding."""
        return np.asarray(self.duration_s(displacements_rad) <= self.time_limit_s * (1.0 + 1e-12))

    def within_time(self, displacements_rad: FloatArray) -> FloatArray:
        """Displacements (d,) shortened in proportion until they keep the time."""
        if self.keeps_time(displacements_rad):
            return displacements_rad
        # The time grows strictly with the common factor: one root between 0 and 1.
        over = optimize.brentq(
            lambda share: float(self.duration_s(share * displacements_rad)) - self.time_limit_s,
            0.0,
            1.0,
            xtol=1e-15,
        )
        # The root may lie above the limit by rounding: stay below it by a hair.
        return np.asarray(over * (1.0 - 1e-13) * displacements_rad)

    def loops(self, sequences: tuple[Sequence, ...] | None = None) -> Loops:
        """Build the loops of the problem's joints; one sequence of each class if None."""
        chosen = classes(len(self.joints)) if sequences is None else sequences
        return Loops(
            self.body,
            self.joints,
            chosen,
            start_rad=self.start_rad,
            directions=self.directions,
            steps=self.steps,
        )

    def commanded_deg(self, displacements_deg: FloatArray) -> FloatArray:
        """Displacements (d,) in whole hundredths of a degree, as the sequencer holds them, that keep time and limits.

        Each is the nearest, unless they would then take too long; then those that gained most lose it again.
        """
        exact = displacements_deg * CDEG_PER_DEG
        # Round down at the limit, which rounding to the nearest could pass.
        most = np.floor(np.degrees(self.limit_rad) * CDEG_PER_DEG + _EXACT_CDEG)
        angles_cdeg = np.minimum(np.rint(exact), most)
        # What overran before rounding may keep its time, but not add to it.
        allowed_s = max(self.time_limit_s, float(self.duration_s(np.radians(displacements_deg))))
        # Take a hundredth back where rounding up has added most.
        for number in np.argsort(exact - angles_cdeg, kind="stable"):
            if self.duration_s(np.radians(angles_cdeg / CDEG_PER_DEG)) <= allowed_s * (1.0 + _EXACT_TIME):
                break
            angles_cdeg[number] = max(angles_cdeg[number] - 1.0, 0.0)
        return np.asarray(angles_cdeg / CDEG_PER_DEG)

    def scheduled_s(self, displacements_rad: FloatArray, sequence: Sequence) -> float:
        """Time from the first stroke's start to the last one's end, with every start on the sequencer's grid.

        `sequence` has numbers of the problem's joints, from 1, in flight order, each with its displacement
        (d,); their signs do not matter.
        """
        strokes_s = self.stroke_s(displacements_rad)[np.abs(np.array(sequence, dtype=int)) - 1]
        # A nanosecond off, as where the schedule is made: rounding must not cost a whole step.
        steps = np.ceil((strokes_s[:-1] - 1e-9) / GRID_S)
        return float(steps.sum() * GRID_S + strokes_s[-1:].sum())

    def schedulable_deg(self, displacements_deg: FloatArray, sequence: Sequence) -> Iterator[FloatArray]:
        """Yield displacements (d,) near these that keep the time limit with every start on the sequencer's grid.

        Each joint as commanded by itself, or as far as it goes in the whole steps of the grid below and above; the
        last stroke, after which none has to wait for the grid, also as far as it goes in the time that is left.
        """
        plain, stroke_s = self.commanded_deg(displacements_deg), self.stroke_s(np.radians(displacements_deg))
        around_s = [GRID_S * rounding((stroke_s - 1e-9) / GRID_S) for rounding in (np.floor, np.ceil)]
        options = np.stack([plain, *map(self._reach_deg, around_s)])
        # A joint that stands goes on standing.
        per_joint = [sorted(set(column)) for column in np.where(plain > 0.0, options, 0.0).T.tolist()]
        # What overran the limit by its strokes alone, such as a swarm's result, may keep its time.
        allowed_s = max(self.time_limit_s, float(self.duration_s(np.radians(displacements_deg))))
        allowed_s *= 1.0 + _EXACT_TIME
        last = abs(sequence[-1]) - 1 if sequence else 0
        for chosen in itertools.product(*per_joint):
            displacements = np.array(chosen)
            late_s = self.scheduled_s(np.radians(displacements), sequence) - allowed_s
            if late_s > 0.0:
                # Its way out stays within the same step of the grid, or the schedule is checked again below.
                shorter_s = self.stroke_s(np.radians(displacements)) - late_s
                displacements[last] = self._reach_deg(np.maximum(shorter_s, 0.0))[last]
            if self.scheduled_s(np.radians(displacements), sequence) <= allowed_s:
                yield displacements

    def _reach_deg(self, stroke_s: FloatArray) -> FloatArray:
        """(d,) displacements in whole hundredths of a degree that each joint reaches in its time (d,)."""
        reach_deg = np.degrees(np.clip(self.farthest_rad(stroke_s), 0.0, self.limit_rad))
        return np.asarray(np.floor(reach_deg * CDEG_PER_DEG + _EXACT_CDEG) / CDEG_PER_DEG)

    def duration_s(self, displacements_rad: FloatArray) -> FloatArray:
        """T (...) of displacements (d, ...): all strokes, one after another, out and back."""
        return np.asarray(2.0 * self.stroke_s(displacements_rad).sum(axis=0))

    def objective(self, loops: Loops, displacements_rad: FloatArray) -> FloatArray:
        """J (b,) in rad of displacements (d, b): the paper's equation of the optimization."""
        reorientation, _ = best_sequence(loops.angles_rad(displacements_rad))
        overtime = np.maximum(self.duration_s(displacements_rad) - self.time_limit_s, 0.0)
        return np.asarray(-reorientation + self.penalty * overtime * overtime)


def _check_joints(robot: RobotModel, joints: tuple[int, ...]) -> None:
    for joint in joints:
        if not 0 <= joint < robot.n_joints:
            raise DesignError("joints", f"{robot.name} has joints 1 to {robot.n_joints}, not {joint + 1}.")
    if robot.n_joints < 2:
        raise DesignError("robot", f"A loop needs two joints; {robot.name} has {robot.n_joints}.")
    if len(set(joints)) != len(joints) or len(joints) < 2:
        raise DesignError("joints", "A loop that turns the robot needs two or more different joints.")
    if len(joints) > MAX_JOINTS:
        raise DesignError(
            "joints",
            f"{len(joints)} joints are too many for one loop: their sequences would take hours. "
            f"Choose up to {MAX_JOINTS} with --joints.",
        )


def _check_limits(robot: RobotModel, joints: tuple[int, ...], limit: FloatArray, room: FloatArray) -> None:
    if limit.shape != (len(joints),):
        raise DesignError("limit", f"{len(joints)} joints move, and {limit.size} limits were given.")
    for joint, most, free in zip(joints, limit, room, strict=True):
        if not _MIN_STROKE_RAD <= most <= free + 1e-9:
            raise DesignError(
                "limit",
                f"{robot.joint_names[joint]} can open by {math.degrees(free):g} deg from its start pose; "
                f"{math.degrees(most):g} deg is not within that, or below the 0.01 deg that can be commanded.",
            )
