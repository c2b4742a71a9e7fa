"""Our flights against MuJoCo's and Pinocchio's: attitude of every body, momentum, energy, work."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from tests.dynamics.cases import RANDOM_CASES, Case, make_cases
from tests.dynamics.oracles.actuated_rollout import actuated_rollout, computed_torque
from tests.dynamics.oracles.mujoco_robot import MujocoRobot
from tests.dynamics.oracles.simulator import Simulator, State, fly
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Flight
from tfsat_host.robot import RobotModel

TOLERANCE_DEG = 1e-3
FINE_TOLERANCE_DEG = 1e-6  # where neither steps nor samples limit us, but the equations alone
MOMENTUM_TOLERANCE = 1e-6  # N m s; the bodies' momenta are some 0.1
ENERGY_TOLERANCE = 2e-5  # of the energy; 1e-3 deg are as much of a radian
LOOKS = 6  # instants of a flight that are compared, first and last among them
ROLLOUT_STEPS = 500

MakeSimulator = Callable[[RobotModel], Simulator]
FlyTheirs = Callable[[MakeSimulator, int], tuple[Simulator, list[State]]]

simulators: list[MakeSimulator] = [MujocoRobot]
if sys.platform != "win32":  # for which Pinocchio has no wheels
    from tests.dynamics.oracles.pinocchio_robot import PinocchioRobot

    simulators.append(PinocchioRobot)

every_simulator = pytest.mark.parametrize("simulator", simulators)
# Chains and a tree, in closed form and sampled, with momentum and without, the drop tower robot; `make prove`: all.
QUICK = (4, 9, 17, RANDOM_CASES)


def of_cases(numbers: range) -> pytest.MarkDecorator:
    marked = [pytest.param(n, marks=() if n in QUICK else pytest.mark.prove) for n in numbers]
    return pytest.mark.parametrize("number", marked)


every_case_in_closed_form = of_cases(range(0, RANDOM_CASES + 1, 2))
every_case = of_cases(range(RANDOM_CASES + 1))


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> list[Case]:
    return make_cases(tmp_path_factory.mktemp("robots"))


@pytest.fixture(scope="module")
def fly_theirs(cases: list[Case]) -> FlyTheirs:
    """Flies case `number` in a simulator; gives it and the states at the instants at which we look."""

    @functools.cache
    def fly_once(simulator: MakeSimulator, number: int) -> tuple[Simulator, list[State]]:
        case, flight_simulator = cases[number], simulator(cases[number].robot)
        return flight_simulator, fly(
            flight_simulator, case.history, case.release(), case.flight.t_s[looks(case.flight)]
        )

    return fly_once


def state_at(flight: Flight, index: int) -> State:
    return State(
        flight.quaternion_xyzw[index],
        flight.rate_rad_s[index],
        flight.angles_rad[index],
        flight.angle_rates_rad_s[index],
    )


def looks(flight: Flight) -> list[int]:
    return [round(i) for i in np.linspace(0, len(flight.t_s) - 1, LOOKS)]


def attitudes_at(flight: Flight, index: int, robot: RobotModel) -> Rotation:
    return Rotation.from_matrix([flight.attitude(body)[index] for body in range(robot.n_bodies)])


def error_deg(ours: Rotation, theirs: FloatArray) -> float:
    return float(np.degrees((ours * Rotation.from_matrix(theirs).inv()).magnitude().max()))


@every_case
@every_simulator
def test_every_body_turns_as_in_the_simulator(
    cases: list[Case], fly_theirs: FlyTheirs, simulator: MakeSimulator, number: int
) -> None:
    case = cases[number]
    flight, (other, states) = case.flight, fly_theirs(simulator, number)
    for index, state in zip(looks(flight), states, strict=True):
        ours = attitudes_at(flight, index, case.robot)
        assert error_deg(ours, other.attitudes(state)) < TOLERANCE_DEG
        assert flight.momentum()[index] == pytest.approx(other.momentum(state), abs=MOMENTUM_TOLERANCE)
        assert flight.kinetic_energy_j()[index] == pytest.approx(
            other.kinetic_energy_j(state), rel=ENERGY_TOLERANCE
        )


@every_case_in_closed_form
@every_simulator
def test_our_equations_are_the_simulators_far_beyond_the_default_step(
    cases: list[Case], fly_theirs: FlyTheirs, simulator: MakeSimulator, number: int
) -> None:
    case = cases[number]
    flight, (other, states) = case.fine_flight, fly_theirs(simulator, number)
    assert error_deg(attitudes_at(flight, -1, case.robot), other.attitudes(states[-1])) < FINE_TOLERANCE_DEG


@every_case
@every_simulator
def test_momentum_and_energy_are_what_the_simulator_finds_in_our_motion(
    cases: list[Case], fly_theirs: FlyTheirs, simulator: MakeSimulator, number: int
) -> None:
    case = cases[number]
    flight, other = case.flight, simulator(case.robot)
    for index in looks(flight):
        state = state_at(flight, index)
        assert flight.momentum()[index] == pytest.approx(other.momentum(state), abs=1e-13)
        assert flight.kinetic_energy_j()[index] == pytest.approx(other.kinetic_energy_j(state), rel=1e-12)


@every_case
def test_torques_alone_make_the_simulated_robot_turn_likewise(cases: list[Case], number: int) -> None:
    case = cases[number]
    flight = case.flight
    end = actuated_rollout(case.robot, case.history, case.release(), case.duration_s, ROLLOUT_STEPS)
    assert end.angles == pytest.approx(flight.angles_rad[-1], abs=1e-7)
    simulator = MujocoRobot(case.robot)
    ours = attitudes_at(flight, -1, case.robot)
    assert error_deg(ours, simulator.attitudes(end)) < TOLERANCE_DEG
    assert flight.momentum()[-1] == pytest.approx(simulator.momentum(end), abs=MOMENTUM_TOLERANCE)


@every_case_in_closed_form
def test_momentum_is_constant_and_the_joints_work_is_the_gain_of_energy(
    cases: list[Case], number: int
) -> None:
    case = cases[number]
    flight, simulator = case.fine_flight, MujocoRobot(case.robot)
    power_w, momentum = [], []
    for index, t_s in enumerate(flight.t_s):
        state = state_at(flight, index)
        momentum.append(simulator.momentum(state))  # which also brings the simulator to that state
        torques = computed_torque(simulator, case.history.accelerations(t_s))
        power_w.append(torques @ state.angle_rates)
    at_release = np.zeros(3) if case.rate is None else momentum[0]
    assert np.array(momentum) == pytest.approx(np.tile(at_release, (len(momentum), 1)), abs=1e-12)
    energy_j = flight.kinetic_energy_j()
    work_j = CubicSpline(flight.t_s, power_w).integrate(flight.t_s[0], flight.t_s[-1])
    assert energy_j[-1] - energy_j[0] == pytest.approx(work_j, abs=ENERGY_TOLERANCE * energy_j.max())
