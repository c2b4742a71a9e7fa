"""Stages of an evaluation that combine several sources: first stroke, micro-gravity, release velocity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.apply import CalibratedSamples
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.camera import LaserFileError, LaserTracks, Mark
from tfsat_host.evaluation.clocks import Clocks
from tfsat_host.evaluation.laser_spots import BodyRotation
from tfsat_host.evaluation.laser_velocity import (
    LaserError,
    ReleaseVelocity,
    VelocityWindows,
    release_velocity,
)
from tfsat_host.evaluation.micro_gravity import SETTLE_S, MicroGravity, micro_gravity, quiet_windows
from tfsat_host.evaluation.motion.motion import Motion, initial_rates
from tfsat_host.evaluation.motion.samples import end_of_fall_s
from tfsat_host.evaluation.strokes import FlownStroke
from tfsat_host.maneuver import Schedule
from tfsat_host.next_step import Advice
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import bodies_with_imu
from tfsat_host.sdlog import DropLog

LEFT_TO_SETTLE_S = 0.3
"""Without a schedule the last stroke is taken to have ended so long before the end of the fall."""
BODY_2 = 1
"""The lasers' (paper, section "Design of the transformable robot")."""


@dataclass(frozen=True, slots=True)
class ExternalObservations:
    """What others than the logger saw of a drop.

    Attributes:
        video: Events by a video's clock.
        video_rate: Seconds of that clock in a real one; None: nobody knows.
        laser: Places of the laser spots.
        windows: What release velocities are permitted; needed with `laser`.
    """

    video: Sequence[Mark] = ()
    video_rate: float | None = None
    laser: LaserTracks | None = None
    windows: VelocityWindows | None = None


def find_first_stroke_s(
    log: DropLog, schedule: Schedule | None, clocks: Clocks | None, until_s: float
) -> float:
    """Return the time of the first stroke: as logged, else as commanded, else the end of the fall.

    A command counts by the sequencer's clock.
    """
    if schedule is not None and clocks is not None and schedule.strokes:
        fit = clocks.sequencer
        planned = [float(fit.to_logger_s(stroke.t_s)) if fit else stroke.t_s for stroke in schedule.strokes]
        return min(
            logged if np.isfinite(logged) else plan
            for logged, plan in zip(clocks.stroke_s, planned, strict=True)
        )
    # Without a schedule the line's first rise in the fall ends the time before the strokes.
    edges = [log.seconds(event.t_us) for event in log.events if event.name == "stroke"]
    return min((t_s for t_s in edges if t_s > 0.0), default=until_s)


def measure_micro_gravity(
    log: DropLog,
    samples: CalibratedSamples,
    motion: Motion,
    model: RobotModel,
    first_stroke_s: float,
    strokes: Sequence[FlownStroke],
) -> MicroGravity:
    """Measure the forces in the quiet windows before the first stroke and after the last."""
    landing_s = end_of_fall_s(log)
    ends = [stroke.end_s for stroke in strokes if np.isfinite(stroke.end_s)]
    last_end_s = max(ends) if ends else landing_s - LEFT_TO_SETTLE_S
    if any(stroke.unfinished or stroke.scheduled_s > landing_s - SETTLE_S for stroke in strokes):
        last_end_s = landing_s  # the recording ends among the strokes: nothing came after the last
    # The CoM shifts with the joints: the arms at the release hold before, the last ones after the strokes.
    at_release = motion.angles_rad[int(np.searchsorted(motion.t_s, 0.0))]
    windows = quiet_windows(
        first_stroke_s,
        last_end_s,
        landing_s,
        sensor_arms_m(model, at_release),
        sensor_arms_m(model, motion.angles_rad[-1]),
    )
    return micro_gravity(samples, log.t_s, windows, bodies_with_imu(model))


def find_release_velocity(
    witnesses: ExternalObservations,
    motion: Motion,
    model: RobotModel,
    first_stroke_s: float,
    clocks: Clocks | None,
) -> tuple[ReleaseVelocity | None, tuple[str, ...]]:
    """Compute the release velocity, or the reasons why the laser spots give none.

    A failure here does not affect the rest of the drop's results.
    """
    if witnesses.laser is None or witnesses.windows is None:
        return None, ()
    body = motion.bodies[BODY_2]
    rate_std = initial_rates(motion, first_stroke_s)[BODY_2].std_rad_s
    angles_rad = np.column_stack(
        [np.interp(body.t_s, motion.t_s, angle_rad) for angle_rad in motion.angles_rad.T]
    )
    # (n, 3) posture by posture: the robot's CoM wanders through body 2 as the joints move.
    com_m = np.array([com_in_bodies_m(model, angles)[BODY_2] for angles in angles_rad])
    turning = BodyRotation(body.t_s, body.attitude.as_matrix(), rate_std, com_m)
    try:
        velocity = release_velocity(
            witnesses.laser.after_release(clocks.video if clocks else None),
            witnesses.windows,
            first_stroke_s=first_stroke_s,
            turning=turning,
        )
    # The spots are optional: report why they give no velocity, and keep the drop.
    except (LaserError, LaserFileError) as error:
        return None, (Advice(f"No release velocity. {error.what} {error.meaning} ", error.next_step),)
    return velocity, ()


def com_in_bodies_m(model: RobotModel, joint_angles_rad: FloatArray) -> FloatArray:
    """(n, 3) the whole robot's CoM in the frame of each of its n bodies, at joint angles (n - 1,)."""
    tree = Multibody.of(model)
    rotation, translation = poses(tree, np.asarray(joint_angles_rad, dtype=np.float64))
    com = np.einsum("nij,nj->ni", rotation, tree.com_m) + translation
    center = tree.mass_kg @ com / tree.mass_kg.sum()
    # A body's point x, global at zero angles, lies at rotation x + translation; its own frame starts at origin_m.
    at_zero_angles = np.einsum("nji,nj->ni", rotation, center - translation)
    return np.asarray(at_zero_angles - model.origin_m)


def sensor_arms_m(model: RobotModel, joint_angles_rad: FloatArray) -> FloatArray:
    """(4, 3) from the robot's CoM to the IMU of bodies 1 to 4, axes of the IMU's body; arguments as above."""
    center = com_in_bodies_m(model, joint_angles_rad)
    arms = np.full((len(model.imus), 3), np.nan)
    for imu in model.imus:
        arms[imu.body] = imu.position_m - center[imu.body]
    return arms
