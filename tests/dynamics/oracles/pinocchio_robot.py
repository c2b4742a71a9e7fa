"""A robot in Pinocchio: a free-flyer, unaligned revolute joints, the centroidal momentum map."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from tests.dynamics.oracles.simulator import State
from tests.dynamics.oracles.tree_order import branches
from tfsat_host.arrays import FloatArray
from tfsat_host.robot import RobotModel

_ZERO_ATTITUDE = np.array([0.0, 0.0, 0.0, 1.0])


class PinocchioRobot:
    """Answers from the centroidal map (base rate, momentum) and from the joint-space energy."""

    def __init__(self, robot: RobotModel) -> None:
        self._model = pin.Model()
        com = robot.origin_m + robot.com_m
        flyer = self._model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
        self._append(robot, robot.base, flyer, com[robot.base])
        carrier = {robot.base: flyer}
        origin = {robot.base: np.zeros(3)}
        hinge = {}
        for joint, parent, child, sign in branches(robot):
            point = origin[child] = robot.joint_point_m[joint]
            placement = pin.SE3(np.eye(3), point - origin[parent])
            revolute = pin.JointModelRevoluteUnaligned(sign * robot.joint_axis[joint])
            index = self._model.addJoint(carrier[parent], revolute, placement, robot.joint_names[joint])
            self._append(robot, child, index, com[child] - point)
            carrier[child] = hinge[joint] = index
        self._data = self._model.createData()
        self._carriers = [carrier[body] for body in range(robot.n_bodies)]
        hinges = [self._model.joints[hinge[joint]] for joint in range(robot.n_joints)]
        self._q = np.array([joint.idx_q for joint in hinges], dtype=int)
        self._v = np.array([joint.idx_v for joint in hinges], dtype=int)

    def _append(self, robot: RobotModel, body: int, joint: int, com: FloatArray) -> None:
        inertia = pin.Inertia(float(robot.mass_kg[body]), com, robot.inertia_kg_m2[body])
        self._model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())

    def base_rate(self, angles: FloatArray, angle_rates: FloatArray, momentum: FloatArray) -> FloatArray:
        centroidal = pin.computeCentroidalMap(
            self._model, self._data, self._configuration(_ZERO_ATTITUDE, angles)
        )
        total = np.concatenate([np.zeros(3), momentum])
        return np.asarray(
            np.linalg.solve(centroidal[:, :6], total - centroidal[:, self._v] @ angle_rates)[3:]
        )

    def attitudes(self, state: State) -> FloatArray:
        pin.forwardKinematics(self._model, self._data, self._configuration(state.quaternion, state.angles))
        return np.array([self._data.oMi[joint].rotation for joint in self._carriers])

    def momentum(self, state: State) -> FloatArray:
        total = pin.computeCentroidalMomentum(self._model, self._data, *self._motion(state))
        return np.array(total.angular)

    def kinetic_energy_j(self, state: State) -> float:
        # Pinocchio's own energy, from its own mass matrix.
        return float(pin.computeKineticEnergy(self._model, self._data, *self._motion(state)))

    def _configuration(self, quaternion: FloatArray, angles: FloatArray) -> FloatArray:
        q = np.zeros(self._model.nq)
        q[3:7] = quaternion
        q[self._q] = angles
        return q

    def _motion(self, state: State) -> tuple[FloatArray, FloatArray]:
        q = self._configuration(state.quaternion, state.angles)
        v = np.zeros(self._model.nv)
        v[3:6] = state.rate
        v[self._v] = state.angle_rates
        linear = pin.computeCentroidalMap(self._model, self._data, q)[:3]
        v[:3] = np.linalg.solve(linear[:, :3], -linear[:, 3:] @ v[3:])  # the CoM at rest
        return q, v
