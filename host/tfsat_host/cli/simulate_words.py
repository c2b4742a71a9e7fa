"""A simulation as JSON, and as tables for people."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import Column, Columns, vector

if TYPE_CHECKING:
    from tfsat_host.dynamics.flying import Simulation
    from tfsat_host.maneuver import Schedule
    from tfsat_host.robot import RobotModel
    from tfsat_host.robot.model import FloatArray

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


def result_of(
    robot: RobotModel,
    simulation: Simulation,
    schedule: Schedule | None,
    initial_rate_deg_s: Sequence[float] | None,
) -> dict[str, Any]:
    """The object of `--json`; `strokes` is empty for a sampled history."""
    from tfsat_host.dynamics import quaternion

    flight = simulation.flight
    rotations = simulation.rotations()
    after = [quaternion.to_matrix(q) for q in simulation.stroke_quaternions_xyzw]
    timed = schedule.strokes if schedule is not None else ()
    return {
        **rotation_as_dict(rotations[flight.body.base]),
        "robot": robot.name,
        "base": robot.body_names[flight.body.base],
        "closed": simulation.is_closed,
        "duration_s": float(flight.t_s[-1]),
        "end_s": _end_s(simulation, schedule),
        "integration_error_deg": math.degrees(simulation.estimated.error_rad),
        "initial_rate_deg_s": None if initial_rate_deg_s is None else list(initial_rate_deg_s),
        "angular_momentum_kg_m2_s": (flight.momentum()[0] + 0.0).tolist(),
        "bodies": [
            {"body": name, **rotation_as_dict(rotation)}
            for name, rotation in zip(robot.body_names, rotations, strict=True)
        ],
        "strokes": [
            {"t_s": s.t_s, "end_s": round(end_s, 6), "joint": s.joint, "angle_deg": s.angle_deg}
            | {"after": rotation_as_dict(rotation)}
            for s, end_s, rotation in zip(timed, simulation.arrivals_s, after, strict=True)
        ],
    }


def _end_s(simulation: Simulation, schedule: Schedule | None) -> float:
    """When the joints are at rest; for strokes to the nearest 10 ms, as in the paper's table."""
    if schedule is not None:
        return round(max(simulation.arrivals_s, default=0.0), 2)
    flight = simulation.flight
    moving = flight.t_s[flight.angle_rates_rad_s.any(axis=1)]
    return float(moving[-1]) if len(moving) else 0.0


def rotation_as_dict(matrix: FloatArray) -> dict[str, Any]:
    """One rotation (3, 3) in the four ways that people write it, degrees."""
    import numpy as np
    from scipy.spatial.transform import Rotation

    from tfsat_host.dynamics.euler import euler_zyx_rad

    rotation = Rotation.from_matrix(matrix)
    # Adding zero turns a minus zero into a zero.
    return {
        "reorientation_deg": float(np.degrees(rotation.magnitude())),
        "rotation_vector_deg": (np.degrees(rotation.as_rotvec()) + 0.0).tolist(),
        "euler_zyx_deg": (np.degrees(euler_zyx_rad(matrix)) + 0.0).tolist(),
        "quaternion_xyzw": (rotation.as_quat(canonical=True) + 0.0).tolist(),
    }


def show(result: Mapping[str, Any], out: Output) -> None:
    """What a person wants to know, in the order of how much."""
    out.line(f"Robot      {result['robot']}, followed by its {result['base']}")
    out.line(f"Release    {_release_words(result)}")
    joints = f"joints at rest after {result['end_s']:.2f} s" if result["end_s"] else "joints never move"
    out.line(f"Time       {joints}, followed to {result['duration_s']:.2f} s")
    out.line()
    rotation = {
        "reorientation / deg": f"{result['reorientation_deg']:.3f}",
        "rotation vector x, y, z / deg": vector(result["rotation_vector_deg"], form="+.3f"),
        "Euler angles z, y, x / deg": vector(result["euler_zyx_deg"], form="+.3f"),
        "quaternion x, y, z, w": vector(result["quaternion_xyzw"], form="+.6f"),
    }
    out.table(("final rotation", ""), rotation.items())
    if result["strokes"]:
        show_rows(_STROKES, [{**stroke, **stroke["after"]} for stroke in result["strokes"]], out)
    if not result["closed"]:
        show_rows(_BODIES, result["bodies"], out)
    for path in result["files"].values():
        out.line(f"Written    {path}")


def _release_words(result: Mapping[str, Any]) -> str:
    if result["initial_rate_deg_s"] is None:
        return "without angular momentum"
    rate = ", ".join(f"{value:g}" for value in result["initial_rate_deg_s"])
    return f"{result['base']} turning at {rate} deg/s about its x, y, z"
