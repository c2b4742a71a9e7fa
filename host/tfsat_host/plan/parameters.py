"""Everything in the model that may be wrong, as one vector in the units that people read.

    body masses             kg
    centers of mass         mm        in the body frame
    inertia tensors         g m^2     the six entries of the tensor about the center of mass
    points of joint axes    mm        the two coordinates across the axis
    tilts of joint axes     deg       about the two directions across the axis
    ends of strokes         deg       the joint angle at which each stroke ends
    starts                  deg       the angle of each joint at the release
    speeds of servos        deg/s     average of a stroke, for the joints that the maneuver moves; greatest rate each
                                      way where a calibration measured it
    accelerations           deg/s^2   of the same servos
    delays                  ms        from a stroke's time to the joint's first motion, of the same servos

A point's coordinate along its axis changes nothing, so it is no parameter. Across an axis that is parallel to a
coordinate axis, the two directions are the other two coordinate axes, and bear their names.

The maneuver runs open loop: a stroke starts its servo's delay after its time, whatever the joints have done so far. A
joint goes at its servo's average rate, or as fast as it can if the servo was measured, with the servo's acceleration at
both ends, to the angle at which its servo believes that the stroke is done. A slow servo may still move while the next
joint starts: then the path through the joint angles, and with it the rotation, is another one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.history import JointHistory, ServoMotion, history_of
from tfsat_host.dynamics.multibody import Multibody, across, tilt_axes
from tfsat_host.maneuver import Schedule
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import Servo, ServoDynamics
from tfsat_host.units import s_from_us


class PlannedStroke(NamedTuple):
    """One joint is commanded to move once.

    Attributes:
        joint: Index of the joint.
        delta_rad: Change of its angle.
        start_s: After release.
    """

    joint: int
    delta_rad: float
    start_s: float


@dataclass(frozen=True, eq=False)
class Plan:
    """A maneuver as the servos are commanded.

    Attributes:
        servos: Of the robot.
        start_rad: (n - 1,) joint angles at the release: the start pose of the servos.
        joints: (k,) index of the joint of each stroke.
        stop_rad: (k,) angle at which the joint of each stroke ends: the commanded one, less its servo's play.
        start_s: (k,) start of each stroke after release, in order.
        drives: Of each servo whose dynamics count: index of its joint, and 1 or -1 if they were measured each way, else
            0; by joint.
        drive_of: (k,) index of each stroke's drive.
        dynamics: Of each drive.
        rate_rad_s: Average joint rate of a stroke of a servo that was not measured.
        until_s: When the attitude is looked at; later for a robot whose joints still move.
    """

    servos: tuple[Servo, ...]
    start_rad: FloatArray
    joints: tuple[int, ...]
    stop_rad: FloatArray
    start_s: FloatArray
    drives: tuple[tuple[int, int], ...]
    drive_of: tuple[int, ...]
    dynamics: tuple[ServoDynamics, ...]
    rate_rad_s: float
    until_s: float

    @classmethod
    def of(
        cls, robot: RobotModel, strokes: Sequence[PlannedStroke], rate_rad_s: float, *, until_s: float = 0.0
    ) -> Plan:
        """Build the plan of `strokes`, in order of their starts.

        Args:
            robot: Its servos' start pose, greatest rates and accelerations are used.
            strokes: At least one, of joints of the robot.
            rate_rad_s: Average joint rate of a stroke.
            until_s: Time of the final attitude, if the joints are at rest by then. It matters only
                for a robot with angular momentum.
        """
        start = np.array([servo.start_rad for servo in robot.servos])
        # Relative strokes, added up to the absolute angle at which each one ends.
        commanded, reached, stops = start.copy(), start.copy(), []
        for joint, delta, _ in strokes:
            commanded[joint] += delta
            reached[joint] = robot.servos[joint].stop_rad(reached[joint], commanded[joint])
            stops.append(reached[joint])
        by_drive: dict[tuple[int, int], ServoDynamics] = {}
        drives = []
        for stroke in strokes:
            dynamics = robot.servos[stroke.joint].dynamics(stroke.delta_rad)
            way = 0 if dynamics.covariance is None else -1 if stroke.delta_rad < 0.0 else 1
            drives.append((stroke.joint, way))
            by_drive[drives[-1]] = dynamics
        ordered = sorted(by_drive)
        return cls(
            servos=robot.servos,
            start_rad=start,
            joints=tuple(stroke.joint for stroke in strokes),
            stop_rad=np.array(stops),
            start_s=np.array([stroke.start_s for stroke in strokes]),
            drives=tuple(ordered),
            drive_of=tuple(map(ordered.index, drives)),
            dynamics=tuple(by_drive[drive] for drive in ordered),
            rate_rad_s=rate_rad_s,
            until_s=until_s,
        )

    @classmethod
    def of_schedule(cls, robot: RobotModel, schedule: Schedule) -> Plan:
        """Build the plan of a schedule as its servos are commanded.

        The final attitude is taken when `simulate` takes it: at the landing or later.
        """
        strokes = [PlannedStroke(s.joint - 1, math.radians(s.angle_deg), s.t_s) for s in schedule.strokes]
        until_s = s_from_us(max(FALL_US, schedule.end_us))
        return cls.of(robot, strokes, math.radians(schedule.speed_deg_s), until_s=until_s)

    @property
    def moved_joints(self) -> tuple[int, ...]:
        """The joints that the maneuver moves, in order of their index."""
        return tuple(sorted(set(self.joints)))


SERVO_KINDS = {
    "speed": ("deg/s", math.degrees(1.0)),
    "acceleration": ("deg/s^2", math.degrees(1.0)),
    "delay": ("ms", 1e3),
}
"""What is known of a servo's motion, in the order of a covariance: unit, and how many of it make one in SI."""
_ENTRIES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
DEG = float(np.degrees(1.0))
"""In a radian."""


@dataclass(frozen=True, eq=False)
class Parameters:
    """The parameters of one robot that flies one plan.

    Attributes:
        joint_names: n - 1 names.
        names: p names for people.
        units: p units.
        steps: (p,) small changes, in those units, that derivatives may be taken with.
        nominal: (p,) values of the model, in those units.
        part: Where each kind stands: mass, com, inertia, joint_point, joint_tilt, stroke_end, start, speed,
            acceleration, delay.
        body: The nominal robot.
        origin_m: (n, 3) origins of the body frames.
        across: (n - 1, 2, 3) the two directions across each joint's axis.
        plan: What the servos are commanded to do.
        initial_rate_rad_s: (3,) rate of the base at release, base axes; None: no angular momentum.
    """

    joint_names: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    steps: FloatArray
    nominal: FloatArray
    part: Mapping[str, slice]
    body: Multibody
    origin_m: FloatArray
    across: FloatArray
    plan: Plan
    initial_rate_rad_s: FloatArray | None

    @classmethod
    def of(cls, robot: RobotModel, plan: Plan, initial_rate_rad_s: FloatArray | None = None) -> Parameters:
        """Build the parameters of `robot` and `plan`, at the model's nominal values."""
        body = Multibody.of(robot)
        sides = np.array([across(axis) for axis in robot.joint_axis]).reshape(-1, 2, 3)
        rows = _rows(robot, plan, sides)
        bodies, joints = robot.n_bodies, robot.n_joints
        kinds = ("mass", "com", "inertia", "joint_point", "joint_tilt", "stroke_end", "start", *SERVO_KINDS)
        # The layout of the parameter vector, in the order of `_rows`.
        sizes = (
            bodies,
            3 * bodies,
            6 * bodies,
            2 * joints,
            2 * joints,
            len(plan.joints),
            joints,
            *[len(plan.drives)] * len(SERVO_KINDS),
        )
        # Running sums of the sizes bound each kind's slice.
        edges = itertools.pairwise(itertools.accumulate(sizes, initial=0))
        return cls(
            joint_names=robot.joint_names,
            names=tuple(name for name, _, _, _ in rows),
            units=tuple(unit for _, unit, _, _ in rows),
            steps=np.array([step for _, _, step, _ in rows]),
            nominal=np.array([value for _, _, _, value in rows]),
            part={kind: slice(*edge) for kind, edge in zip(kinds, edges, strict=True)},
            body=body,
            origin_m=robot.origin_m,
            across=sides,
            plan=plan,
            initial_rate_rad_s=initial_rate_rad_s,
        )

    def robots(self, vectors: FloatArray) -> Multibody:
        """s robots with the parameters `vectors` (s, p)."""
        part, batch = self.part, len(vectors)
        # Six entries a body make a symmetric tensor; g m^2 become kg m^2.
        inertia = np.empty((batch, self.body.n_bodies, 3, 3))
        entries = 1e-3 * vectors[:, part["inertia"]].reshape(batch, -1, 6)
        for index, (i, k) in enumerate(_ENTRIES):
            inertia[..., i, k] = inertia[..., k, i] = entries[..., index]
        # Points move across their axis only, by the difference from nominal.
        shift = 1e-3 * (vectors - self.nominal)[:, part["joint_point"]].reshape(batch, -1, 2)
        tilt = vectors[:, part["joint_tilt"]].reshape(batch, -1, 2) / DEG
        return self.body.replace(
            mass_kg=vectors[:, part["mass"]],
            com_m=self.origin_m + 1e-3 * vectors[:, part["com"]].reshape(batch, -1, 3),
            inertia_kg_m2=inertia,
            joint_axis=tilt_axes(self.body.joint_axis, self._sideways(tilt)),
            joint_point_m=self.body.joint_point_m + self._sideways(shift),
        )

    def motion(self, vectors: FloatArray) -> ServoMotion:
        """Compute the servo motion (k, s) of the plan for robots with parameter vectors (s, p).

        A rate above a servo's greatest is limited to the greatest, which has the relative error of the average
        rate.
        """
        part, plan = self.part, self.plan
        joints = list(plan.joints)
        drive_of = list(plan.drive_of)
        # (k, s) of each stroke's servo.
        speed, acceleration, delay_s = (
            vectors[:, part[kind]].T[drive_of] / unit for kind, (_, unit) in SERVO_KINDS.items()
        )
        # A relative speed scales a servo's average and greatest rate alike; a measured one has the greatest alone.
        measured = np.array([plan.dynamics[drive].covariance is not None for drive in drive_of])[:, None]
        greatest = np.array([plan.dynamics[drive].max_rate_rad_s for drive in drive_of])[:, None]
        max_rate = np.where(measured, speed, speed / plan.rate_rad_s * greatest)
        reached = vectors[:, part["stroke_end"]].T / DEG
        # A stroke begins where its joint really ended before, so the error of an end shifts two strokes.
        angle = dict(enumerate(vectors[:, part["start"]].T / DEG))
        delta = np.empty_like(reached)
        for k, joint in enumerate(joints):
            delta[k] = reached[k] - angle[joint]
            angle[joint] = reached[k]
        return ServoMotion.of(
            joints,
            delta,
            plan.start_s[:, None] + delay_s,
            np.where(measured, 0.0, np.abs(delta) / speed),
            max_rate,
            acceleration,
        )

    def history(self, vectors: FloatArray, motion: ServoMotion | None = None) -> JointHistory:
        """Build the joint history of robots with parameters (s, p) from the release to the time of the final attitude.

        It lasts longer while joints still move. `motion` is that of the same vectors, where it is known already.
        """
        motion = motion or self.motion(vectors)
        begin = np.zeros_like(motion.end_s[:1])
        end = np.maximum(motion.end_s.max(axis=0, keepdims=True), self.plan.until_s)
        # (m, s): each robot has breaks of its own, in equal number; pieces may have no length.
        breaks = np.sort(np.concatenate([begin, motion.changes_s, end]), axis=0)
        return history_of(motion, breaks, vectors[:, self.part["start"]].T / DEG)

    def _sideways(self, amounts: FloatArray) -> FloatArray:
        """(s, n - 1, 3): `amounts` (s, n - 1, 2) along the directions across each axis."""
        return np.asarray(
            amounts[..., :1] * self.across[:, 0] + amounts[..., 1:] * self.across[:, 1], dtype=np.float64
        )


def _rows(robot: RobotModel, plan: Plan, square: FloatArray) -> list[tuple[str, str, float, float]]:
    """Name, unit, step and nominal value of each parameter, in their order."""
    rows: list[tuple[str, str, float, float]] = []
    # The third entry is the step that derivatives are taken with, in the parameter's unit.
    for name, mass in zip(robot.body_names, robot.mass_kg, strict=True):
        rows.append((f"{name} mass", "kg", 0.01 * mass, mass))
    for name, com in zip(robot.body_names, robot.com_m, strict=True):
        rows += [(f"{name} CoM {axis}", "mm", 0.5, 1e3 * x) for axis, x in zip("xyz", com, strict=True)]
    for name, tensor in zip(robot.body_names, robot.inertia_kg_m2, strict=True):
        # Two thousandths of the trace, in g m^2.
        step = 2.0 * np.trace(tensor)
        rows += [
            (f"{name} inertia {'xyz'[i]}{'xyz'[k]}", "g m^2", step, 1e3 * tensor[i, k]) for i, k in _ENTRIES
        ]
    # Directions across an axis are named by the coordinate axes nearest to them.
    letters = [["xyz"[np.argmax(np.abs(side))] for side in sides] for sides in square]
    joints = list(zip(robot.joint_names, letters, strict=True))
    for (name, pair), sides, point in zip(joints, square, robot.joint_point_m, strict=True):
        rows += [(f"{name} point {w}", "mm", 0.5, 1e3 * x) for w, x in zip(pair, sides @ point, strict=True)]
    for name, pair in joints:
        rows += [(f"{name} tilt about {which}", "deg", 0.1, 0.0) for which in pair]
    for k, (joint, stop) in enumerate(zip(plan.joints, plan.stop_rad, strict=True), 1):
        rows.append((f"stroke {k} end ({robot.joint_names[joint]})", "deg", 0.02, stop * DEG))
    rows += [
        (f"{name} start", "deg", 0.02, start * DEG)
        for name, start in zip(robot.joint_names, plan.start_rad, strict=True)
    ]
    ways = {0: "", 1: " opening", -1: " closing"}
    names = [f"{robot.joint_names[joint]}{ways[way]}" for joint, way in plan.drives]
    for name, servo in zip(names, plan.dynamics, strict=True):
        rate = plan.rate_rad_s if servo.covariance is None else servo.max_rate_rad_s
        rows.append((f"{name} speed", "deg/s", 0.02, rate * DEG))
    for name, servo in zip(names, plan.dynamics, strict=True):
        rows.append((f"{name} acceleration", "deg/s^2", 1.0, servo.acceleration_rad_s2 * DEG))
    for name, servo in zip(names, plan.dynamics, strict=True):
        rows.append((f"{name} delay", "ms", 0.1, 1e3 * servo.delay_s))
    return [(name, unit, float(step), float(value)) for name, unit, step, value in rows]
