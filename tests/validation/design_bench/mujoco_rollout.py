"""One maneuver by a MuJoCo rollout, as it is commonly done: servos follow references, the simulator steps.

Every hinge has a `position` and a `velocity` actuator, whose references are a stroke's angle and rate. A stroke
swings from rest to rest along half a cosine and takes |angle| / speed on average, so a stiff servo follows to
well below 1e-3 rad (the result says how closely). `implicitfast`, the integrator that MuJoCo's documentation
recommends, and `mujoco.rollout`, which steps without Python, are the kindest choice for MuJoCo's time; what
the integrator's first order costs is seen in the angle (drop tower robot, 58.75/70.29: 0.025 deg at 1 ms,
0.003 deg at 0.1 ms).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import mujoco.rollout
import numpy as np

from tests.dynamics.oracles.actuated_rollout import mass_matrix
from tests.dynamics.oracles.mujoco_robot import MujocoRobot, mujoco_spec
from tfsat_host.arrays import FloatArray
from tfsat_host.robot import RobotModel

_SERVO_RAD_S = 800.0
"""Natural frequency of the critically damped servos: lag is the reference's acceleration over its square."""
_SETTLING_S = 0.1


@dataclass(frozen=True)
class Rollout:
    """What came of it.

    Attributes:
        reorientation_deg: Rotation angle of the base body.
        tracking_error_rad: Largest difference of a joint angle from its reference.
        wall_time_s: For references and steps; building the model is not counted.
        steps: How many.
    """

    reorientation_deg: float
    tracking_error_rad: float
    wall_time_s: float
    steps: int


def reorientation_by_rollout(
    robot: RobotModel, strokes_deg: Sequence[tuple[int, float]], speed_deg_s: float, timestep_s: float
) -> Rollout:
    """Fly strokes (joint index, change of its angle) one after the other from zero angles, at rest at first."""
    # Built outside of the timed part: only references and stepping count.
    simulator = _with_servos(robot, timestep_s)
    model, data = simulator.model, simulator.data
    initial = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, initial, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    started = time.perf_counter()
    angles, rates = _references(robot.n_joints, strokes_deg, speed_deg_s, timestep_s)
    states, _ = mujoco.rollout.rollout(model, data, initial, np.hstack([angles, rates])[None])
    wall_time_s = time.perf_counter() - started
    qpos = states[0, :, 1 : 1 + model.nq]  # time comes first
    # A step begins with its reference and ends with its state: that state is due at the next reference.
    lag = qpos[:-1, simulator.joint_qpos] - angles[1:]
    scalar, vector = qpos[-1, 3], qpos[-1, 4:7]
    return Rollout(
        # Both signs of a quaternion are the same rotation: take the smaller angle.
        reorientation_deg=float(np.degrees(2.0 * np.arctan2(np.linalg.norm(vector), abs(scalar)))),
        tracking_error_rad=float(np.abs(lag).max()),
        wall_time_s=wall_time_s,
        steps=len(angles),
    )


def _with_servos(robot: RobotModel, timestep_s: float) -> MujocoRobot:
    """Folded and at rest; gains for each joint's inertia in free flight, with the other joints locked."""
    bare = MujocoRobot(robot)
    mujoco.mj_fwdPosition(bare.model, bare.data)
    mass = mass_matrix(bare)
    # Schur complement: what a joint's servo must accelerate while the base floats freely.
    felt = mass[6:, 6:] - mass[6:, :6] @ np.linalg.solve(mass[:6, :6], mass[:6, 6:])
    inertia = np.diag(felt)[bare.joint_dof - 6]
    spec = mujoco_spec(robot)
    spec.option.timestep = timestep_s
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # Critical damping: kp = J ω², kv = 2 J ω.
    for name, about in zip(robot.joint_names, inertia, strict=True):
        _actuator(spec, name).set_to_position(kp=about * _SERVO_RAD_S**2)
    for name, about in zip(robot.joint_names, inertia, strict=True):
        _actuator(spec, name).set_to_velocity(kv=2.0 * about * _SERVO_RAD_S)
    return MujocoRobot(robot, spec)


def _actuator(spec: mujoco.MjSpec, joint: str) -> mujoco.MjsActuator:
    return spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)


def _references(
    joints: int, strokes_deg: Sequence[tuple[int, float]], speed_deg_s: float, timestep_s: float
) -> tuple[FloatArray, FloatArray]:
    """Angles and rates (steps, joints), with time to settle at the end."""
    angles, rates = [np.zeros((1, joints))], [np.zeros((1, joints))]
    for joint, stroke_deg in strokes_deg:
        duration_s = abs(stroke_deg) / speed_deg_s
        steps = max(1, round(duration_s / timestep_s))
        phase = np.pi * np.arange(1, steps + 1) / steps
        angle, rate = np.tile(angles[-1][-1], (steps, 1)), np.zeros((steps, joints))
        # Half a cosine: the rate starts and ends at zero, so that a stiff servo follows.
        angle[:, joint] += np.radians(stroke_deg) * 0.5 * (1.0 - np.cos(phase))
        rate[:, joint] = np.radians(stroke_deg) * 0.5 * np.sin(phase) * np.pi / (steps * timestep_s)
        angles.append(angle)
        rates.append(rate)
    # Time to settle: the last state must not contain the servo's lag.
    rest = round(_SETTLING_S / timestep_s)
    angles.append(np.tile(angles[-1][-1], (rest, 1)))
    rates.append(np.zeros((rest, joints)))
    return np.concatenate(angles), np.concatenate(rates)
