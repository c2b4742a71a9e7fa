"""The flights that are compared: twenty random robots and joint histories, and the drop tower robot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.dynamics.chain_driver import Robot
from tests.dynamics.histories import ClosedForm, PolynomialHistory, SineHistory
from tests.dynamics.oracles.simulator import State
from tests.dynamics.random_robots import random_tree, write_robot_file
from tests.dynamics.reference import rate_without_momentum
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Flight, JointHistory, Multibody, history_from_samples, propagate
from tfsat_host.robot import RobotModel, load_robot

RANDOM_CASES = 20
_SAMPLES_PER_S = 400.0


@dataclass(frozen=True)
class Case:
    """A robot released while its joints are already in motion.

    Attributes:
        robot: From a robot file, as a user's is.
        history: What its joints do, in closed form.
        flown: The same, as our propagation takes it.
        attitude: (4,) of the base at the release.
        rate: (3,) of the base at the release, base axes; None: such that there is no angular momentum.
        duration_s: Of the flight.
    """

    robot: RobotModel
    history: ClosedForm
    flown: JointHistory
    attitude: FloatArray
    rate: FloatArray | None
    duration_s: float

    @cached_property
    def flight(self) -> Flight:
        """Our flight at the default step and order."""
        return propagate(
            Multibody.of(self.robot),
            self.flown,
            initial_attitude_xyzw=self.attitude,
            initial_rate_rad_s=self.rate,
        )

    @cached_property
    def fine_flight(self) -> Flight:
        """Our flight with an integration that adds nothing to the model's own error."""
        return propagate(
            Multibody.of(self.robot),
            self.flown,
            initial_attitude_xyzw=self.attitude,
            initial_rate_rad_s=self.rate,
            step_s=0.0025,
            order=6,
        )

    def release(self) -> State:
        """Return the state at the release; with zero momentum, its rate is the independent reference's."""
        angles, rates = self.history.angles(0.0), self.history.rates(0.0)
        rate = self.rate
        if rate is None:
            rate = rate_without_momentum(Robot.of(self.robot), angles, rates)
        return State(self.attitude, rate, angles, rates)


def make_cases(folder: Path) -> list[Case]:
    """Build cases of two to six bodies: chains and trees, polynomials and sampled sines.

    The drop tower robot comes last. The second half of the cases, it included, has angular momentum. Robot
    files go to `folder`.
    """
    return [_case(number, folder / f"random_{number}.toml") for number in range(RANDOM_CASES + 1)]


def _case(number: int, file: Path) -> Case:
    rng = np.random.default_rng(number)
    if number == RANDOM_CASES:
        robot = load_robot()
    else:
        # Chains and trees by turns, of two to six bodies.
        tree = random_tree(rng, 2 + number % 5, chain=number // 5 % 2 == 0)
        robot = load_robot(write_robot_file(tree, file))
    duration_s = float(rng.uniform(1.0, 2.0))
    history, joint_history = _history(rng, robot.n_joints, duration_s, from_samples=number % 2 == 1)
    attitude = Rotation.random(random_state=rng).as_quat()
    # The second half turns already at the release.
    rate = rng.normal(size=3) if number >= RANDOM_CASES // 2 else None
    return Case(robot, history, joint_history, attitude, rate, duration_s)


def _history(
    rng: np.random.Generator, joints: int, duration_s: float, *, from_samples: bool
) -> tuple[ClosedForm, JointHistory]:
    if from_samples:
        sines = SineHistory(rng, joints, terms=3, reach_rad=np.pi / 2)
        # Sampled finely enough that the interpolation adds nothing to the comparison.
        t_s = np.linspace(0.0, duration_s, round(duration_s * _SAMPLES_PER_S) + 1)
        return sines, history_from_samples(t_s, sines.angles(t_s))
    polynomials = PolynomialHistory(rng, joints, duration_s=duration_s)
    return polynomials, polynomials.joint_history()
