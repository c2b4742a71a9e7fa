"""Chains of primitives flown: after each the attitude is measured, and the rest is planned anew where it must.

The robot that flies need not be the one that the planner knows, and what is measured need not be true.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tfsat_host.dynamics import Multibody, path_rotation, quaternion
from tfsat_host.orbit.grid import OrbitError
from tfsat_host.orbit.pilot import Outcome, Pilot
from tfsat_host.orbit.planner import Planner
from tfsat_host.orbit.primitives import Primitive
from tfsat_host.robot import RobotModel, Uncertainty
from tfsat_host.robot.model import FloatArray
from tfsat_host.sensitivity.parameters import Parameters
from tfsat_host.sensitivity.sources import error_sources
from tfsat_host.sensitivity.strokes import Plan, PlannedStroke
from tfsat_host.sensitivity.study import Study


@dataclass(frozen=True)
class Sensing:
    """How the attitude is measured.

    Attributes:
        noise_rad: Standard deviation of its error about each body axis, independent at every measurement.
        seed: Of the errors.
    """

    noise_rad: float = 0.0
    seed: int = 1


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
        start_error_rad: At the start.
        steps: The primitives in order.
        outcome: Why it ended, as the robot believes by what it measured: "within tolerance"; "no progress", no
            single loop brings it nearer; "given up", plans came to nothing and it went back to where it
            had been measured nearest; "primitives used up".
    """

    target_xyzw: FloatArray
    tolerance_rad: float
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
    sensing: Sensing | None = None,
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
    sensing = sensing or Sensing()
    sensor, pilot = _Sensor(sensing), Pilot(planner, target, sensing.noise_rad)
    measured, start_error = sensor.measure(attitude), _error(attitude, target)
    steps = list[Step]()
    while (primitive := pilot.next(measured, planner.most - len(steps))) is not None:
        predicted = quaternion.product(measured, primitive.quaternion_xyzw)
        attitude = quaternion.product(attitude, flown(robot, planner.table.start_rad, primitive))
        measured = sensor.measure(attitude)
        errors = _error(attitude, target), _error(measured, target)
        steps.append(Step(primitive, predicted, attitude, measured, *errors))
    return Flight(target, planner.tolerance_rad, start_error, tuple(steps), pilot.outcome)


def open_loop_error_rad(
    planner: Planner,
    target_xyzw: FloatArray,
    *,
    plant: Multibody,
    initial_xyzw: FloatArray | None = None,
) -> float:
    """What error is left if the planner's first chain is flown to its end and nothing is measured on the way."""
    target = _unit(target_xyzw)
    attitude = quaternion.identity() if initial_xyzw is None else _unit(initial_xyzw)
    for primitive in planner.chain(quaternion.product(quaternion.inverse(attitude), target)).primitives:
        attitude = quaternion.product(attitude, flown(plant, planner.table.start_rad, primitive))
    return _error(attitude, target)


def flown(robot: Multibody, start_rad: FloatArray, primitive: Primitive) -> FloatArray:
    """Quaternion (4,) of a primitive's strokes, flown by `robot` from joint angles `start_rad` (n,)."""
    joints = [joint for joint, _ in primitive.strokes]
    return path_rotation(
        robot, joints, np.array([angle for _, angle in primitive.strokes]), start_rad=start_rad
    )


class _Sensor:
    """Measures attitudes with errors of its own."""

    def __init__(self, sensing: Sensing) -> None:
        self._noise_rad = sensing.noise_rad
        self._random = np.random.default_rng(sensing.seed)

    def measure(self, attitude: FloatArray) -> FloatArray:
        error = self._noise_rad * self._random.standard_normal(3)
        return quaternion.product(attitude, quaternion.exponential(error))


def _error(attitude: FloatArray, target: FloatArray) -> float:
    return float(quaternion.angle(quaternion.product(quaternion.inverse(attitude), target)))


def _unit(values: FloatArray) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    return np.asarray(array / np.linalg.norm(array))


def drawn_robot(robot: RobotModel, scale: float, seed: int) -> Multibody:
    """A robot drawn from the uncertainties of its file.

    Masses, centers of mass, inertias and hinges are drawn, as in a sensitivity study; strokes stay exact.

    Args:
        robot: The model.
        scale: Times the stated standard deviations.
        seed: Of the draw.

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
    stated = Uncertainty(
        **{name: scale * value for name, value in dataclasses.asdict(robot.uncertainty).items()}
    )
    # Parameters come with a maneuver; what it is does not touch the robot.
    plan = Plan.of(robot, [PlannedStroke(joint=0, delta_rad=0.0, start_s=0.0)], 1.0)
    parameters = Parameters.of(robot, plan)
    study = Study(parameters, error_sources(parameters, stated), samples=1, seed=seed)
    drawn = parameters.robots(study.vectors(study.deviates(0)))
    return drawn.replace(
        mass_kg=drawn.mass_kg[0],
        com_m=drawn.com_m[0],
        inertia_kg_m2=drawn.inertia_kg_m2[0],
        joint_axis=drawn.joint_axis[0],
        joint_point_m=drawn.joint_point_m[0],
    )
