"""MuJoCo's own forward dynamics, its joints driven by torques that give them prescribed accelerations."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from tests.dynamics.histories import ClosedForm
from tests.dynamics.oracles.mujoco_robot import MujocoRobot
from tests.dynamics.oracles.simulator import State
from tfsat_host.arrays import FloatArray
from tfsat_host.robot import RobotModel


def actuated_rollout(
    robot: RobotModel, history: ClosedForm, release: State, duration_s: float, steps: int
) -> State:
    """Return the state after `steps` equal Runge-Kutta steps (order 4).

    Nothing acts on the base, and no conservation law is used: the torques are internal, so whatever
    momentum the simulator keeps, it keeps by itself.
    """
    simulator = MujocoRobot(robot)
    model, data = simulator.model, simulator.data
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    # A step that divides the duration: the last state is at the end.
    model.opt.timestep = duration_s / steps
    simulator.place(release)

    def drive(_: Any, data: Any) -> None:
        """Called at every stage of a step."""
        accelerations = history.accelerations(data.time)
        data.qfrc_applied[simulator.joint_dof] = computed_torque(simulator, accelerations)

    mujoco.set_mjcb_control(drive)
    # The callback is global: it must be gone before the next test.
    try:
        mujoco.mj_step(model, data, steps)
    finally:
        mujoco.set_mjcb_control(None)
    return simulator.state()


def computed_torque(simulator: MujocoRobot, accelerations: FloatArray) -> FloatArray:
    """Joint torques (joints,) for `accelerations` (joints,) in the state in which the simulator stands.

    From M a + bias = (0, torque): the first six rows give the base's acceleration.
    """
    data, joints = simulator.data, simulator.joint_dof
    # Of the pose in which the simulator stands, momentum and all.
    mass = mass_matrix(simulator)
    acceleration = np.zeros(len(mass))
    acceleration[joints] = accelerations
    # The base is not driven: its acceleration follows from the first six rows.
    acceleration[:6] = np.linalg.solve(mass[:6, :6], -data.qfrc_bias[:6] - mass[:6, joints] @ accelerations)
    return np.asarray((mass @ acceleration + data.qfrc_bias)[joints])


def mass_matrix(simulator: MujocoRobot) -> FloatArray:
    """(nv, nv), of the pose in which the simulator stands."""
    mass = np.empty((simulator.model.nv, simulator.model.nv))
    for row, unit in zip(mass, np.eye(len(mass)), strict=True):
        mujoco.mj_mulM(simulator.model, simulator.data, row, unit)
    return mass
