"""Chains of primitives flown: after each the attitude is measured, and the rest is planned again where it must.

The robot that flies need not be the one that the planner knows, and what is measured need not be true. A chain may lead
away from the target before it leads there. Where it is given up on the way, the way back to the attitude that was
measured nearest is known exactly, whatever the robot: the same loops backwards.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, path_rotation, quaternion
from tfsat_host.errors import UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.error_sources import error_sources
from tfsat_host.plan.grid import OrbitError
from tfsat_host.plan.orbit.orbit_planner import Chain, Planner, backwards, remainder
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable
from tfsat_host.plan.orbit.stroke_history import fly_history, stroke_history
from tfsat_host.plan.parameters import Parameters, Plan, PlannedStroke
from tfsat_host.plan.study import Study
from tfsat_host.robot import RobotModel, Uncertainty

Outcome = Literal["within tolerance", "no progress", "given up", "primitives used up"]

_ANGLE = re.compile(r"\s*([xyz])\s*:\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*", re.ASCII | re.IGNORECASE)
# While more primitives are to come, a chain may miss the target by so much: a short one corrects it at the end.
_DRIFT_RAD = math.radians(1.0)
# Plans without progress before the flight gives up: noise may hide it once or twice.
_MAX_STALLED_PLANS = 6
# One measurement in a thousand is farther off than so many standard deviations about each axis.
_BLUR_DEVIATIONS = 4.0


class Pilot:
    """Decides from measured attitudes.

    Args:
        planner: Makes the chains.
        target_xyzw: (4,) where to go.
        noise_rad: Standard deviation of the measurements about each axis. Nearer than four of these no chain
            leads away from the target first: what is left may be noise.

    Attributes:
        outcome: Why nothing more is flown, once that is so.
    """

    def __init__(self, planner: Planner, target_xyzw: FloatArray, noise_rad: float) -> None:
        self.outcome: Outcome = "within tolerance"
        self._planner = planner
        self._target = target_xyzw
        self._blur_rad = _BLUR_DEVIATIONS * noise_rad
        self._chain = Chain((), 0.0)
        self._returning = False
        self._nearest_to_go, self._patience = np.inf, _MAX_STALLED_PLANS
        self._least_rad = np.inf
        self._since_least: tuple[Primitive, ...] = ()

    def next(self, measured_xyzw: FloatArray, primitives_left: int) -> Primitive | None:
        """Return the next primitive to fly from a measured attitude (4,), or None to end the flight.

        At most `primitives_left` primitives may still be flown.
        """
        # The rotation from the measured attitude to the target, in body axes.
        needed = quaternion.product(quaternion.inverse(measured_xyzw), self._target)
        error = float(quaternion.angle(needed))
        # Remember the nearest attitude and the loops since: backwards they lead there on any robot.
        if error < self._least_rad:
            self._least_rad, self._since_least = error, ()
            # A still nearer attitude on the way back ends the return here.
            if self._returning:
                self._chain = Chain((), error)
        if error <= self._planner.tolerance_rad:
            self.outcome = "within tolerance"
            return None
        # Coming back with the very last primitive is given up, not used up.
        if primitives_left == 0 and not self._has_returned:
            self.outcome = "primitives used up"
            return None
        # Keep the chain while it leads where it was planned to; else plan again from what was measured.
        if not self._returning and (not self._chain.primitives or self._misses_target(needed)):
            self._plan(needed, primitives_left)
        if not self._chain.primitives:
            return None
        first, self._chain = self._chain.primitives[0], self._chain.after_first()
        self._since_least = (*self._since_least, first)
        return first

    @property
    def _has_returned(self) -> bool:
        return self._returning and not self._chain.primitives

    def _plan(self, needed: FloatArray, primitives_left: int) -> None:
        # Within the sensor's noise a detour would be flown for measurement errors.
        near = quaternion.angle(needed) <= self._blur_rad
        self._chain, to_go = (
            self._planner.chain(needed, most=primitives_left, detour=not near),
            self._planner.to_go(needed),
        )
        # Judge progress by the planner's estimate: a chain may lead away in angle before it leads there.
        if to_go < self._nearest_to_go:
            self._nearest_to_go, self._patience = to_go, _MAX_STALLED_PLANS
        else:
            self._patience -= 1
        # No chain, and already at the nearest attitude: there is nothing to go back to.
        if not self._chain.primitives and not self._since_least:
            self.outcome = "no progress"
        # Give up without a plan, without patience, or at the last chance to get back.
        elif not self._chain.primitives or self._patience == 0 or self._is_last_chance(primitives_left):
            self.outcome, self._returning = "given up", True
            self._chain = Chain(backwards(self._since_least), self._least_rad)

    def _is_last_chance(self, primitives_left: int) -> bool:
        """Return whether the robot must turn back now.

        It must if undoing the primitives since the smallest error takes all that are left, and the chain leads
        no closer to the target than that error.
        """
        return 0 < primitives_left <= len(self._since_least) and self._chain.remaining_rad >= self._least_rad

    def _misses_target(self, needed: FloatArray) -> bool:
        """Return whether the remaining chain, flown from here, would miss the attitude it was planned for."""
        tolerance = self._planner.tolerance_rad
        has_next = len(self._chain.primitives) > 1
        # Midway a degree may be missed, to be corrected later; the last loop must meet the tolerance.
        allowed = max(tolerance, _DRIFT_RAD, self._blur_rad) if has_next else tolerance
        remaining = float(quaternion.angle(remainder(self._chain.primitives, needed)))
        # A chain that was planned to leave more than that is not astray because of it.
        return remaining > max(allowed, self._chain.remaining_rad * (1.0 + 1e-6) + 1e-9)


class AttitudeSensor:
    """Measures attitudes, with errors of its own.

    Args:
        noise_rad: Standard deviation of the error about each body axis, independent at every measurement.
        seed: Of the errors.
    """

    def __init__(self, noise_rad: float = 0.0, seed: int = 1) -> None:
        self.noise_rad = noise_rad
        self._random = np.random.default_rng(seed)

    def measure(self, attitude: FloatArray) -> FloatArray:
        """Simulate a measurement of an attitude (4,), with normally distributed noise."""
        # The error is a small rotation about the body axes, hence the factor on the right.
        error = self.noise_rad * self._random.standard_normal(3)
        return quaternion.product(attitude, quaternion.exponential(error))


@dataclass(frozen=True, eq=False)
class Step:
    """One primitive flown.

    Attributes:
        primitive: What was flown.
        predicted_xyzw: (4,) attitude after it, by the planner, from what was measured before it.
        attitude_xyzw: (4,) attitude after it.
        measured_xyzw: (4,) the same, as measured.
        error_rad: From `attitude_xyzw` to the target.
        measured_error_rad: From `measured_xyzw` to the target.
    """

    primitive: Primitive
    predicted_xyzw: FloatArray
    attitude_xyzw: FloatArray
    measured_xyzw: FloatArray
    error_rad: float
    measured_error_rad: float


@dataclass(frozen=True, eq=False)
class Flight:
    """How a target attitude was approached.

    Attributes:
        target_xyzw: (4,).
        tolerance_rad: What was asked for.
        noise_rad: Of what was measured, about each axis.
        start_error_rad: At the start.
        steps: The primitives in order.
        outcome: Why it ended, as the robot believes by what it measured: "within tolerance"; "no progress", no
            single loop brings it nearer; "given up", plans came to nothing and it went back to where it
            had been measured nearest; "primitives used up".
    """

    target_xyzw: FloatArray
    tolerance_rad: float
    noise_rad: float
    start_error_rad: float
    steps: tuple[Step, ...]
    outcome: Outcome

    @property
    def error_rad(self) -> float:
        """The true error at the end."""
        return self.steps[-1].error_rad if self.steps else self.start_error_rad

    @property
    def least_error_rad(self) -> float:
        """The smallest true error at the start or after any primitive."""
        return min([self.start_error_rad, *(step.error_rad for step in self.steps)])

    @property
    def duration_s(self) -> float:
        """Time that the joints move."""
        return sum(step.primitive.duration_s for step in self.steps)

    @property
    def reached(self) -> bool:
        """Whether the true error at the end is within the tolerance."""
        return self.error_rad <= self.tolerance_rad


def fly(
    planner: Planner,
    target_xyzw: FloatArray,
    *,
    plant: Multibody | None = None,
    sensing: AttitudeSensor | None = None,
    initial_xyzw: FloatArray | None = None,
) -> Flight:
    """Approach a target with feedback after every primitive.

    Args:
        planner: Chooses the primitives.
        target_xyzw: (4,) attitude from body to inertial axes.
        plant: The robot that flies; the planner's own if None.
        sensing: How the attitude is measured; exactly if None.
        initial_xyzw: (4,) attitude at the start; the inertial axes if None.

    Returns:
        The flight. It ends when the measured error is within the planner's tolerance, when no plan could be made
        or six brought no progress, then back at the attitude that was measured nearest, or after the
        planner's greatest number of primitives.
    """
    target = _unit(target_xyzw)
    attitude = quaternion.identity() if initial_xyzw is None else _unit(initial_xyzw)
    robot = planner.table.body if plant is None else plant
    sensing = sensing or AttitudeSensor()
    pilot = Pilot(planner, target, sensing.noise_rad)
    measured, start_error = sensing.measure(attitude), _error(attitude, target)
    steps = list[Step]()
    while (primitive := pilot.next(measured, planner.most - len(steps))) is not None:
        # Predict from the measurement, as the robot would; the plant turns the true attitude.
        predicted = quaternion.product(measured, primitive.quaternion_xyzw)
        attitude = quaternion.product(attitude, fly_primitive(robot, planner.table, primitive))
        measured = sensing.measure(attitude)
        errors = _error(attitude, target), _error(measured, target)
        steps.append(Step(primitive, predicted, attitude, measured, *errors))
    return Flight(target, planner.tolerance_rad, sensing.noise_rad, start_error, tuple(steps), pilot.outcome)


def open_loop_error_rad(
    planner: Planner,
    target_xyzw: FloatArray,
    *,
    plant: Multibody,
) -> float:
    """Compute the final attitude error of the planner's first chain flown without feedback."""
    target = _unit(target_xyzw)
    attitude = quaternion.identity()
    # The chain as planned at the start, with nothing measured in between.
    for primitive in planner.chain(target).primitives:
        attitude = quaternion.product(attitude, fly_primitive(plant, planner.table, primitive))
    return _error(attitude, target)


def fly_primitive(robot: Multibody, table: PrimitiveTable, primitive: Primitive) -> FloatArray:
    """Quaternion (4,) of a primitive's strokes, flown by `robot` from the start pose of the planner's table."""
    joints = [joint for joint, _ in primitive.strokes]
    if primitive.spans_s is not None:
        angles = np.array([angle for _, angle in primitive.strokes])
        history = stroke_history(table.robot, joints, angles[:, None], primitive.spans_s[:, :1])
        return fly_history(robot, history, 1.0)[-1, :, 0]
    return path_rotation(
        robot, joints, np.array([angle for _, angle in primitive.strokes]), start_rad=table.start_rad
    )


def _error(attitude: FloatArray, target: FloatArray) -> float:
    return float(quaternion.angle(quaternion.product(quaternion.inverse(attitude), target)))


def _unit(values: FloatArray) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    return np.asarray(array / np.linalg.norm(array))


def unit_quaternion(euler_zyx: str | None, xyzw: Sequence[float] | None) -> FloatArray:
    """Parse a target attitude into a unit quaternion (4,).

    The target is given by z-y-x Euler angles, such as "x:30,z:90" in deg, or by a quaternion of any length.

    Raises:
        UsageError: the text gives no angles, or one twice; the quaternion has no direction.
    """
    what = ""
    if euler_zyx is not None:
        parts = [_ANGLE.fullmatch(part) for part in euler_zyx.split(",")]
        # An axis given twice, or a part that is no angle, leaves fewer entries than parts.
        deg = {part[1].lower(): float(part[2]) for part in parts if part}
        if len(deg) == len(parts):
            angles = [deg.get(axis, 0.0) for axis in "zyx"]
            return np.asarray(Rotation.from_euler("ZYX", angles, degrees=True).as_quat())
        what = f"--target {euler_zyx} is no attitude: it takes an angle in deg for each of some axes."
    length = float(np.linalg.norm(np.array(xyzw, dtype=np.float64)))
    if what or not (math.isfinite(length) and length > 0.0):
        raise UsageError(
            what=what or "--target-quaternion is no rotation: its four numbers have no direction.",
            meaning="Nothing was planned.",
            next_step=Advice(
                NextStep("plan", ("--target", "x:30,z:90")),
                "   or   --target-quaternion 0 0 0.7071 0.7071",
            ),
        )
    return np.asarray(np.array(xyzw) / length)


def drawn_robot(robot: RobotModel, scale: float, seed: int) -> Multibody:
    """Draw a robot from the uncertainties of its robot file, `scale` times the stated standard deviations.

    Masses, centers of mass, inertias and hinges are drawn, as in a sensitivity study; strokes stay exact.

    Raises:
        OrbitError: the file states no uncertainties.
    """
    if robot.uncertainty is None:
        raise OrbitError(
            what=f"{robot.path.name} states no uncertainties, so there is nothing to draw a true robot from.",
            meaning="Nothing was planned.",
            next_step="Add a table [uncertainty] to the robot file (see robots/cubesat_3u.toml), or leave "
            "--model-error out.",
        )
    # Scale the deviations, then draw the first sample of such a study: the same errors as `sensitivity`.
    stated = Uncertainty.of({key: scale * value for key, value in robot.uncertainty.figures().items()})
    # Parameters come with a maneuver; what it is does not touch the robot.
    plan = Plan.of(robot, [PlannedStroke(joint=0, delta_rad=0.0, start_s=0.0)], 1.0)
    parameters = Parameters.of(robot, plan)
    study = Study(parameters, error_sources(parameters, stated), samples=1, seed=seed)
    true_robot = parameters.robots(study.vectors(study.deviates(0)))
    # Take the only sample out of its batch axis.
    names = ("mass_kg", "com_m", "inertia_kg_m2", "joint_axis", "joint_point_m")
    return true_robot.replace(**{name: getattr(true_robot, name)[0] for name in names})
