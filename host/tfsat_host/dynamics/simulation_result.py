"""A simulation as a document, as tables for people, and where motion or figures are not what one may think."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.dynamics.history import JointHistory, overshoots
from tfsat_host.dynamics.simulation import Simulation
from tfsat_host.maneuver import Maneuver, ManeuverError, Schedule, schedule_maneuver
from tfsat_host.maneuver.schedule import servo_speed_notices
from tfsat_host.quantity import Column, Columns, Table, vector
from tfsat_host.robot import RobotModel
from tfsat_host.units import s_from_us

ERROR_DEG = 1e-3
"""What `simulate` and `sensitivity` promise: a greater error of the integration is a notice."""
_BEYOND_DEG = 0.5  # less is how far sensors and servos are off
_LATE_S = 1e-6  # the schedule's own resolution

_FINAL: Columns = (Column("what", "final rotation"), Column("value", " "))
_STROKES: Columns = (
    Column("t_s", "start", form=".2f"),
    Column("joint", "joint"),
    Column("angle_deg", "turns by", form="+.2f"),
    Column("reorientation_deg", "then turned"),
    Column("euler_zyx_deg", "Euler angles z, y, x", form="+.3f"),
)
_BODIES: Columns = (
    Column("body", "body"),
    Column("reorientation_deg", "has turned by"),
    Column("rotation_vector_deg", "rotation vector x, y, z", form="+.3f"),
)


def document(simulation: Simulation, initial_rate_deg_s: Sequence[float] | None) -> dict[str, Any]:
    """Build the `--json` document, without notices and files; `strokes` is empty for a sampled history."""
    robot, flight, rotations = simulation.robot, simulation.flight, simulation.rotations()
    strokes = simulation.motion.strokes if isinstance(simulation.motion, Schedule) else ()
    after = quaternion.to_matrix(simulation.stroke_quaternions_xyzw.T)
    return {
        **_rotation(rotations[flight.body.base]),
        "robot": robot.name,
        "base": robot.body_names[flight.body.base],
        "closed": simulation.is_closed,
        "duration_s": float(flight.t_s[-1]),
        "end_s": _end_s(simulation),
        "integration_error_deg": math.degrees(simulation.estimated.error_rad),
        "initial_rate_deg_s": initial_rate_deg_s,
        "angular_momentum_kg_m2_s": (flight.momentum()[0] + 0.0).tolist(),
        "bodies": [
            {"body": name, **_rotation(matrix)}
            for name, matrix in zip(robot.body_names, rotations, strict=True)
        ],
        "strokes": [
            {"t_s": s.t_s, "end_s": round(end_s, 6), "joint": s.joint, "angle_deg": s.angle_deg}
            | {"after": _rotation(after[..., number])}
            for number, (s, end_s) in enumerate(zip(strokes, simulation.arrivals_s, strict=True))
        ],
    }


def _end_s(simulation: Simulation) -> float:
    """Return the time at which the joints are at rest.

    For strokes it is rounded to 10 ms, as in the paper's table.
    """
    if isinstance(simulation.motion, Schedule):
        return round(max(simulation.arrivals_s, default=0.0), 2)
    flight = simulation.flight
    # At a jump the flight shows the rate before it: the last moving instant is the end of the motion.
    return float(flight.t_s[flight.angle_rates_rad_s.any(axis=1)].max(initial=0.0))


def _rotation(matrix: FloatArray) -> dict[str, Any]:
    """Return a rotation (3, 3) as angle, rotation vector, Euler angles (degrees) and quaternion.

    Adding zero avoids negative zeros.
    """
    rotation = Rotation.from_matrix(matrix)
    return {
        "reorientation_deg": float(np.degrees(rotation.magnitude())),
        "rotation_vector_deg": (np.degrees(rotation.as_rotvec()) + 0.0).tolist(),
        "euler_zyx_deg": (np.degrees(euler_zyx_rad(matrix)) + 0.0).tolist(),
        "quaternion_xyzw": (rotation.as_quat(canonical=True) + 0.0).tolist(),
    }


def lines(result: Mapping[str, Any]) -> Iterator[str | Table]:
    """Yield the report for people from a `document`, the most wanted figures first."""
    rate = result["initial_rate_deg_s"]
    turning = (
        "without angular momentum"
        if rate is None
        else f"{result['base']} turning at {vector(rate, form='g')} deg/s about its x, y, z"
    )
    joints = f"joints at rest after {result['end_s']:.2f} s" if result["end_s"] else "joints never move"
    yield f"Robot      {result['robot']}, followed by its {result['base']}"
    yield f"Release    {turning}"
    yield f"Time       {joints}, followed to {result['duration_s']:.2f} s"
    yield ""
    rotation = {
        "reorientation / deg": f"{result['reorientation_deg']:.3f}",
        "rotation vector x, y, z / deg": vector(result["rotation_vector_deg"], form="+.3f"),
        "Euler angles z, y, x / deg": vector(result["euler_zyx_deg"], form="+.3f"),
        "quaternion x, y, z, w": vector(result["quaternion_xyzw"], form="+.6f"),
    }
    yield Table("", _FINAL, [{"what": what, "value": value} for what, value in rotation.items()])
    yield Table("", _STROKES, [{**stroke, **stroke["after"]} for stroke in result["strokes"]])
    if not result["closed"]:
        yield Table("", _BODIES, result["bodies"])
    yield from (f"Written    {path}" for path in result["files"].values())


def notices(
    simulation: Simulation, maneuver: Maneuver | None = None, *, step_s: float | None = None
) -> list[str]:
    """Return notices where the motion or the figures may differ from what is expected, one sentence each.

    Args:
        simulation: The flight of a schedule or a history.
        maneuver: The maneuver of the schedule, for the sequencer's verdict on it.
        step_s: Step of the integration, if it was given.
    """
    robot, motion = simulation.robot, simulation.motion
    if isinstance(motion, Schedule):
        messages = [*_schedule_notices(robot, motion, maneuver), *_late_notices(simulation, motion)]
    else:
        messages = _history_notices(robot, motion)
    if not simulation.is_closed:
        base = robot.body_names[simulation.flight.body.base]
        messages.append(
            "The joints do not end where they started, so the final rotation depends on the base body: this is that "
            f"of {base}."
        )
    error_deg, t_s = math.degrees(simulation.estimated.error_rad), simulation.flight.t_s
    if error_deg > ERROR_DEG:
        helps = (
            f"follow the robot for a shorter time (--until), or give a --step shorter than {t_s[-1] / len(t_s):.1g}"
            if step_s is None
            else "give a shorter --step, or leave it out"
        )
        messages.append(
            f"The attitude may be wrong by {error_deg:.2g} deg by the error of the integration: {helps}."
        )
    return messages


def _schedule_notices(robot: RobotModel, schedule: Schedule, maneuver: Maneuver | None) -> list[str]:
    """Return the schedule's notices, servo speed warnings and the sequencer's refusal if there is one.

    A refusal is only a notice here; it is checked for robots that a sequencer commands.
    """
    messages = list(schedule.notices)
    if schedule.strokes:
        messages += servo_speed_notices(schedule, robot.path)
    if schedule.strokes and maneuver is not None and robot.has_sequencer:
        try:
            schedule_maneuver(maneuver)
        except ManeuverError as error:
            messages.append(f"The sequencer would refuse this maneuver: {error.what}")
    return messages


def _late_notices(simulation: Simulation, schedule: Schedule) -> list[str]:
    """Return notices of strokes that end later than scheduled because of their servos, and the effect."""
    late_s = [
        arrival_s - s_from_us(stroke.end_us)
        for stroke, arrival_s in zip(schedule.strokes, simulation.arrivals_s, strict=True)
    ]
    late = [str(number) for number, by_s in enumerate(late_s, 1) if by_s > _LATE_S]
    if not late:
        return []
    messages = [
        f"{'Strokes' if late[1:] else 'Stroke'} {', '.join(late)} {'end' if late[1:] else 'ends'} later than the "
        f"schedule assumes, by {1e3 * max(late_s):.3g} ms at most: the servos of {simulation.robot.path.name} speed up "
        "and slow down no faster."
    ]
    if simulation.strokes_overlap:
        messages.append(
            "A stroke starts while another joint is still under way, so the joints cut a corner of the path and the "
            "rotation depends on their speed: it is that of the propagation in time. Give a lower --speed, or "
            "later t_s in the maneuver file, to part the strokes."
        )
    return messages


def _history_notices(robot: RobotModel, history: JointHistory) -> list[str]:
    """Return notices where a history exceeds the joint limits, or its spline the samples."""
    angles_rad = history.angles_rad(history.breaks_s)
    low_rad, high_rad = robot.joint_limits_rad.T
    # Greatest excursion of each joint beyond its range at the samples; 0 inside.
    beyond_deg = np.degrees(np.maximum(low_rad - angles_rad, angles_rad - high_rad).max(axis=0, initial=0.0))
    messages = [
        f"The history takes {name} {excess_deg:.2f} deg beyond the limits of {robot.path.name}."
        for name, excess_deg in zip(robot.joint_names, beyond_deg, strict=True)
        if excess_deg >= _BEYOND_DEG
    ]
    return messages + [
        f"Between two samples, at {beyond.t_s:.6g} s, the spline takes {robot.joint_names[beyond.joint]} "
        f"{math.degrees(beyond.excess_rad):.2g} deg beyond both: leave out a sample that was repeated, fill the "
        "gap, or join the samples by straight lines with --between linear."
        for beyond in overshoots(history)
        if math.degrees(beyond.excess_rad) >= _BEYOND_DEG
    ]
