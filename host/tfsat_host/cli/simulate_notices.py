"""What a simulation has to say beside its result: where the motion or the figures are not what one may think."""

from __future__ import annotations

import argparse
import math

import numpy as np

from tfsat_host.dynamics import JointHistory
from tfsat_host.dynamics.flying import Simulation
from tfsat_host.dynamics.history import overshoots
from tfsat_host.maneuver import Schedule
from tfsat_host.robot import RobotModel
from tfsat_host.units import s_from_us

_BEYOND_DEG = 0.5  # less is how far sensors and servos are off
ERROR_DEG = 1e-3  # a millidegree is what simulate and sensitivity promise
_LATE_S = 1e-6  # the schedule's own resolution


def history_notices(robot: RobotModel, history: JointHistory) -> list[str]:
    """Where a measured history leaves the joints' limits, or its spline the samples."""
    angles_rad = history.angles_rad(history.breaks_s)
    low_rad, high_rad = robot.joint_limits_rad.T
    beyond_deg = np.degrees(np.maximum(low_rad - angles_rad, angles_rad - high_rad).max(axis=0, initial=0.0))
    notices = [
        f"The history takes {name} {excess_deg:.2f} deg beyond the limits of {robot.path.name}."
        for name, excess_deg in zip(robot.joint_names, beyond_deg, strict=True)
        if excess_deg >= _BEYOND_DEG
    ]
    notices += [
        f"Between two samples, at {beyond.t_s:.6g} s, the spline takes {robot.joint_names[beyond.joint]} "
        f"{math.degrees(beyond.excess_rad):.2g} deg beyond both: leave out a sample that was repeated, fill the "
        "gap, or join the samples by straight lines with --between linear."
        for beyond in overshoots(history)
        if math.degrees(beyond.excess_rad) >= _BEYOND_DEG
    ]
    return notices


def late_notices(robot: RobotModel, schedule: Schedule, simulation: Simulation) -> list[str]:
    """What the servos cannot do in the time that the schedule gives them, and what follows."""
    late = {
        number: arrival_s - s_from_us(stroke.end_us)
        for number, (stroke, arrival_s) in enumerate(
            zip(schedule.strokes, simulation.arrivals_s, strict=True), 1
        )
        if arrival_s - s_from_us(stroke.end_us) > _LATE_S
    }
    if not late:
        return []
    words = f"Stroke {min(late)} ends" if len(late) == 1 else f"Strokes {', '.join(map(str, late))} end"
    notices = [
        f"{words} later than the schedule assumes, by {1e3 * max(late.values()):.3g} ms at most: the servos of "
        f"{robot.path.name} speed up and slow down no faster."
    ]
    if simulation.strokes_overlap:
        notices.append(
            "A stroke starts while another joint is still under way, so the joints cut a corner of the path and the "
            "rotation depends on their speed: it is that of the propagation in time. Give a lower --speed, or "
            "later t_s in the maneuver file, to part the strokes."
        )
    return notices


def error_notices(args: argparse.Namespace, simulation: Simulation) -> list[str]:
    """That the result is not to be trusted, and what helps."""
    error_deg = math.degrees(simulation.estimated.error_rad)
    if error_deg <= ERROR_DEG:
        return []
    helps = (
        "follow the robot for a shorter time (--until), or give a --step shorter than "
        f"{simulation.flight.t_s[-1] / len(simulation.flight.t_s):.1g}"
        if args.step is None
        else "give a shorter --step, or leave it out"
    )
    return [f"The attitude may be wrong by {error_deg:.2g} deg by the error of the integration: {helps}."]
