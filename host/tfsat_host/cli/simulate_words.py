"""A simulation as JSON, and as tables for people."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from tfsat_host.dynamics.flying import Simulation
    from tfsat_host.maneuver import Schedule
    from tfsat_host.robot import RobotModel
    from tfsat_host.robot.model import FloatArray


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
    out.table(
        ("final rotation", ""),
        [
            ("reorientation / deg", f"{result['reorientation_deg']:.3f}"),
            ("rotation vector x, y, z / deg", _numbers(result["rotation_vector_deg"], 3)),
            ("Euler angles z, y, x / deg", _numbers(result["euler_zyx_deg"], 3)),
            ("quaternion x, y, z, w", _numbers(result["quaternion_xyzw"], 6)),
        ],
    )
    if result["strokes"]:
        _show_strokes(result, out)
    if not result["closed"]:
        columns = ("body", "has turned by / deg", "rotation vector x, y, z / deg")
        rows = [
            (b["body"], f"{b['reorientation_deg']:.3f}", _numbers(b["rotation_vector_deg"], 3))
            for b in result["bodies"]
        ]
        out.table(columns, rows)
    for path in result["files"].values():
        out.line(f"Written    {path}")


def _show_strokes(result: Mapping[str, Any], out: Output) -> None:
    columns = ("start / s", "joint", "turns by / deg", "then turned / deg", "Euler angles z, y, x / deg")
    rows = [
        (
            f"{s['t_s']:.2f}",
            s["joint"],
            f"{s['angle_deg']:+.2f}",
            f"{s['after']['reorientation_deg']:.3f}",
            _numbers(s["after"]["euler_zyx_deg"], 3),
        )
        for s in result["strokes"]
    ]
    out.table(columns, rows)


def _release_words(result: Mapping[str, Any]) -> str:
    if result["initial_rate_deg_s"] is None:
        return "without angular momentum"
    rate = ", ".join(f"{value:g}" for value in result["initial_rate_deg_s"])
    return f"{result['base']} turning at {rate} deg/s about its x, y, z"


def _numbers(values: Sequence[float], decimals: int) -> str:
    return "  ".join(f"{round(value, decimals) + 0.0:+.{decimals}f}" for value in values)
