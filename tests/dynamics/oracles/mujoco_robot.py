"""A robot in MuJoCo: a free joint on its base, hinges, no gravity, no contacts."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from tests.dynamics.oracles.simulator import State
from tests.dynamics.oracles.tree_order import branches
from tfsat_host.arrays import FloatArray
from tfsat_host.robot import RobotModel


def mujoco_spec(robot: RobotModel) -> Any:
    """Build a `mujoco.MjSpec` with the robot's names for bodies and joints, each body's frame on its hinge.

    The free joint comes first; the base's frame is the global frame at zero angles.
    """
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    # Mass properties in the global frame at zero angles.
    com = robot.origin_m + robot.com_m
    origin = {robot.base: np.zeros(3)}
    bodies = {robot.base: _add_body(spec.worldbody, robot, robot.base, np.zeros(3), com[robot.base])}
    bodies[robot.base].add_freejoint()
    for joint, parent, child, sign in branches(robot):
        point = origin[child] = robot.joint_point_m[joint]
        bodies[child] = _add_body(bodies[parent], robot, child, point - origin[parent], com[child] - point)
        bodies[child].add_joint(
            name=robot.joint_names[joint],
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=sign * robot.joint_axis[joint],
        )
    return spec


def _add_body(parent: Any, robot: RobotModel, body: int, pos: FloatArray, com: FloatArray) -> Any:
    i = robot.inertia_kg_m2[body]
    return parent.add_body(
        name=robot.body_names[body],
        pos=pos,
        mass=robot.mass_kg[body],
        ipos=com,
        # MuJoCo takes the six of the full inertia, not its principal values.
        fullinertia=[i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]],
        explicitinertial=True,
    )


class MujocoRobot:
    """Answers from MuJoCo's mass matrix (base rate) and from its velocity recursion (momentum).

    `spec`: the robot's own, when something was added to it.
    """

    def __init__(self, robot: RobotModel, spec: Any = None) -> None:
        self.model = (mujoco_spec(robot) if spec is None else spec).compile()
        self.data = mujoco.MjData(self.model)
        self.joint_qpos = np.array(
            [self.model.joint(name).qposadr[0] for name in robot.joint_names], dtype=int
        )
        self.joint_dof = np.array([self.model.joint(name).dofadr[0] for name in robot.joint_names], dtype=int)
        self.body_id = np.array([self.model.body(name).id for name in robot.body_names], dtype=int)
        # The base's own subtree is the whole robot.
        self._base_id = self.body_id[robot.base]

    def base_rate(self, angles: FloatArray, angle_rates: FloatArray, momentum: FloatArray) -> FloatArray:
        return self._base_velocity(angles, angle_rates, momentum)[3:]

    def attitudes(self, state: State) -> FloatArray:
        self.place(state)
        return np.array(self.data.xmat[self.body_id].reshape(-1, 3, 3))

    def momentum(self, state: State) -> FloatArray:
        self.place(state)
        mujoco.mj_subtreeVel(self.model, self.data)
        return np.array(self.data.subtree_angmom[self._base_id])

    def kinetic_energy_j(self, state: State) -> float:
        self.place(state)
        mujoco.mj_energyVel(self.model, self.data)
        return float(self.data.energy[1])

    def state(self) -> State:
        """Return the present state of the simulation."""
        qpos, qvel = self.data.qpos, self.data.qvel
        # MuJoCo's quaternion has its scalar first.
        return State(np.roll(qpos[3:7], -1), qvel[3:6].copy(), qpos[self.joint_qpos], qvel[self.joint_dof])

    def _pose(self, quaternion: FloatArray, angles: FloatArray) -> None:
        self.data.qpos[:3] = 0.0
        self.data.qpos[3:7] = np.roll(quaternion, 1)  # MuJoCo's scalar comes first
        self.data.qpos[self.joint_qpos] = angles
        self.data.qvel[:] = 0.0
        mujoco.mj_fwdPosition(self.model, self.data)

    def _momentum_per_velocity(self) -> FloatArray:
        """(6, nv): rows of the mass matrix that belong to the base."""
        rows = np.empty((6, self.model.nv))
        for row, unit in zip(rows, np.eye(6, self.model.nv), strict=True):
            mujoco.mj_mulM(self.model, self.data, row, unit)
        return rows

    def _base_velocity(self, angles: FloatArray, angle_rates: FloatArray, momentum: FloatArray) -> FloatArray:
        """Linear and angular (6,), with the CoM at rest."""
        self._pose(np.array([0.0, 0.0, 0.0, 1.0]), angles)
        rows = self._momentum_per_velocity()
        # With the CoM at rest the momentum about the base's origin is the one about the CoM.
        total = np.concatenate([np.zeros(3), momentum])
        return np.asarray(np.linalg.solve(rows[:, :6], total - rows[:, self.joint_dof] @ angle_rates))

    def rate_of(self, body: int) -> FloatArray:
        """Rate (3,) of a body in its own axes, in the state in which the simulation stands."""
        velocity, kind = np.empty(6), mujoco.mjtObj.mjOBJ_XBODY
        # The local frame: rates in the body's own axes.
        mujoco.mj_objectVelocity(self.model, self.data, kind, self.body_id[body], velocity, 1)
        return velocity[:3]

    def place(self, state: State) -> None:
        """Bring the model to `state`, its CoM at rest."""
        self._pose(state.quaternion, state.angles)
        rows = self._momentum_per_velocity()[:3]
        self.data.qvel[self.joint_dof] = state.angle_rates
        self.data.qvel[3:6] = state.rate
        # The linear velocity that keeps the CoM at rest, from the momentum of the base's rows.
        self.data.qvel[:3] = np.linalg.solve(rows[:, :3], -rows[:, 3:] @ self.data.qvel[3:])
        mujoco.mj_fwdVelocity(self.model, self.data)
