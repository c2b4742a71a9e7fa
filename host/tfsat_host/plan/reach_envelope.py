"""How far the moving robot reaches in the test space, and how fast it may drift sideways.

In free fall the robot's center of mass (CoM) moves along a straight line while the bodies turn about it, so
the reach is counted from the vertical line through the CoM, in axes that do not turn, with the attitude
that conservation of angular momentum gives.

The paper says 100 mm for its maneuver 59/70; here it is 125 mm, an upper corner of body 1 when both joints are
open. The paper gives neither the robot's outlines nor the line that it measured from, so the difference
cannot be resolved: the outlines here are the robot file's boxes, assumed from the tables of frames and centers
of mass. Its rule then permits 16 mm/s sideways, not 26; taken moment by moment, as the robot is folded
again when it has drifted furthest, 27 mm/s.

Up is z of the base body at the release: inferred, because lying on its side the folded robot alone would need
more than the envelope's radius.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, quaternion
from tfsat_host.dynamics.components import matmul, matvec
from tfsat_host.dynamics.poses import place
from tfsat_host.dynamics.simulation import arrivals_s, fly
from tfsat_host.errors import TfsatError
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.facility import permissible_transversal_velocity_mm_s
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import bodies_of

STEP_S = 0.005  # a joint turns by less than 1 deg in it
_MAX_STEPS = 200_000

_UNKNOWN_REACH = "How far the moving robot reaches is unknown: it may strike the walls of the test space."


class EnvelopeError(TfsatError):
    """The reach of this maneuver of this robot cannot be computed (exit code 1)."""


@dataclass(frozen=True, eq=False)
class Envelope:
    """The reach of n bodies over m moments from release to landing, mm, counted from the system's CoM.

    Attributes:
        body_names: n names.
        t_s: (m,) from release, rising.
        angles_rad: (m, n - 1) joint angles.
        radius_mm: (m, n) greatest distance of each body from the vertical line through the CoM.
        top_mm: (m,) height of the highest point above the CoM.
        bottom_mm: (m,) height of the lowest point, negative below the CoM.
    """

    body_names: tuple[str, ...]
    t_s: FloatArray
    angles_rad: FloatArray
    radius_mm: FloatArray
    top_mm: FloatArray
    bottom_mm: FloatArray

    @property
    def max_radius_mm(self) -> float:
        """Greatest radius over the whole fall."""
        return float(self.radius_mm.max())

    @property
    def max_radius_t_s(self) -> float:
        """When it is reached."""
        return float(self.t_s[self.radius_mm.max(axis=1).argmax()])

    @property
    def max_radius_body(self) -> str:
        """Which body reaches it."""
        return self.body_names[int(self.radius_mm.max(axis=0).argmax())]

    @property
    def folded_radius_mm(self) -> float:
        """Radius at release, before anything moves."""
        return float(self.radius_mm[0].max())

    @property
    def height_mm(self) -> float:
        """From the lowest to the highest point of the whole fall, both counted from the CoM."""
        return float(self.top_mm.max() - self.bottom_mm.min())

    @property
    def rise_mm(self) -> FloatArray:
        """(m,) how much higher above the CoM the robot reaches than at release."""
        return np.asarray(self.top_mm - self.top_mm[0])

    @property
    def sink_mm(self) -> FloatArray:
        """(m,) how much lower below the CoM the robot reaches than at release."""
        return np.asarray(self.bottom_mm[0] - self.bottom_mm)


class TransversalVelocities(NamedTuple):
    """Permissible velocity sideways, mm/s; below zero if the robot touches the walls without any drift.

    Attributes:
        paper: By the paper's rule: as if the greatest radius lasted from release to landing.
        moment_by_moment: With the radius of each moment; never less.
    """

    paper: float
    moment_by_moment: float


def envelope_of(
    robot: RobotModel,
    schedule: Schedule,
    *,
    until_s: float,
    initial_rate_rad_s: FloatArray | None = None,
) -> Envelope:
    """Compute the envelope of `robot` flying `schedule` from its start pose, from release until `until_s`.

    Args:
        robot: With joints, and a shape for every body.
        schedule: Its strokes start from the start pose of the robot's servos. Motion after `until_s` is
            ignored.
        until_s: End of the fall (landing), after release.
        initial_rate_rad_s: (3,) angular rate of the base body after release, body axes; None: no angular
            momentum.

    Raises:
        EnvelopeError: the robot lacks a joint that the schedule moves, a body has no shape, or a
            stroke would outlast the fall by too many steps to compute.
    """
    _check_described(robot, schedule)
    # A stroke that would begin after the landing takes no part.
    begun = tuple(stroke for stroke in schedule.strokes if stroke.t_s < until_s)
    rest_s = max(arrivals_s(robot, replace(schedule, strokes=begun)), default=0.0)
    if rest_s > _MAX_STEPS * STEP_S:
        raise EnvelopeError(
            what=f"The stroke during which the robot lands would go on until {rest_s:g} s after release.",
            meaning=f"{_UNKNOWN_REACH} To follow it that long would take very much time and memory.",
            next_step="Use smaller angles or a higher speed.",
        )
    flight = fly(
        robot,
        replace(schedule, strokes=begun),
        until_s=max(until_s, rest_s),
        initial_rate_rad_s=initial_rate_rad_s,
        step_s=STEP_S,
    ).flight
    # The flight goes on until the joints rest: what follows the landing is cut off.
    falling = flight.t_s <= until_s
    return envelope_of_motion(
        robot,
        flight.body,
        flight.t_s[falling],
        flight.angles_rad[falling],
        flight.quaternion_xyzw[falling],
    )


def _check_described(robot: RobotModel, schedule: Schedule) -> None:
    shapeless = [robot.body_names[body - 1] for body in bodies_of(robot) if len(robot.shape_m[body - 1]) == 0]
    if shapeless:
        raise EnvelopeError(
            what=f"{robot.path}: no shape is given for {', '.join(shapeless)}.",
            meaning=_UNKNOWN_REACH,
            next_step="Add `boxes_mm` to the body; robots/drop_tower.toml shows how.",
        )
    last = max((stroke.joint for stroke in schedule.strokes), default=0)
    if last >= len(bodies_of(robot)):
        raise EnvelopeError(
            what=f"The maneuver moves joint {last}; {robot.path} has {len(bodies_of(robot)) - 1}.",
            meaning="Nothing of this robot would move there, and its reach is unknown.",
            next_step="Name the robot that the maneuver is for (--robot FILE), or a maneuver of its own joints "
            "(--file FILE).",
        )


def envelope_of_motion(
    robot: RobotModel,
    body: Multibody,
    t_s: FloatArray,
    angles_rad: FloatArray,
    quaternion_xyzw: FloatArray,
) -> Envelope:
    """Compute the envelope of a known motion.

    The motion is given by joint angles (m, n - 1) and attitudes (m, 4) of `body`'s base at times `t_s`.
    """
    # A body that is not there has no corners.
    reach_mm = [
        reach for reach in reach_of_bodies_mm(robot, body, angles_rad.T, quaternion_xyzw.T) if len(reach)
    ]
    height_mm = np.concatenate([reach[:, 2] for reach in reach_mm])
    return Envelope(
        body_names=robot.body_names[: len(reach_mm)],
        t_s=t_s,
        angles_rad=angles_rad,
        radius_mm=np.stack([np.hypot(reach[:, 0], reach[:, 1]).max(axis=0) for reach in reach_mm], axis=1),
        top_mm=height_mm.max(axis=0),
        bottom_mm=height_mm.min(axis=0),
    )


def reach_of_bodies_mm(
    robot: RobotModel, body: Multibody, angles_rad: FloatArray, attitude: FloatArray
) -> list[FloatArray]:
    """Return each body's corners (k, 3, ...), counted from the system's CoM in axes that do not turn; z is up.

    The hull of the corners holds the body, and its farthest point is a corner. `angles_rad` (n - 1, ...) and attitudes
    (4, ...) of the base have any number of axes.
    """
    placed = place(body, body.columns(attitude.ndim - 1), angles_rad)
    ones = (1,) * (attitude.ndim - 1)
    # The common center of mass is the origin: in free fall it keeps to a straight line.
    shares = body.mass_kg / body.mass_kg.sum()
    center = sum(
        (
            share * at.at(com.reshape(3, *ones))
            for share, at, com in zip(shares, placed, body.com_m, strict=True)
        ),
        np.zeros((3, *ones)),
    )
    turn = quaternion.to_matrix(attitude)
    reach_mm = []
    for at, origin, corners in zip(placed, robot.origin_m, robot.shape_m, strict=True):
        # Corners are global at zero angles; by the body's pose to base axes, by the attitude to those of the release.
        rotation, shift = matmul(turn, at.rotation + 0.0 * turn), matvec(turn, at.translation - center)
        reach_mm.append(1e3 * (np.tensordot(origin + corners, rotation, axes=(1, 1)) + shift))
    return reach_mm


def permissible_transversal_velocities(
    envelope: Envelope, envelope_radius_mm: float, fall_s: float
) -> TransversalVelocities:
    """Sideways velocities that just take the robot to walls `envelope_radius_mm` away by the landing.

    A point that lies at r on the side that the robot drifts to reaches the wall at r_f when v t = r_f - r(t).
    """
    paper = permissible_transversal_velocity_mm_s(envelope_radius_mm, envelope.max_radius_mm, fall_s)
    # At the release nothing has drifted yet: no division by zero.
    drifting = (envelope.t_s > 0.0) & (envelope.t_s <= fall_s)
    room_mm = envelope_radius_mm - envelope.radius_mm.max(axis=1)[drifting]
    return TransversalVelocities(paper, float(np.min(room_mm / envelope.t_s[drifting])))
