"""A flight of primitives as a document, for people, and its joints' motion as a file for `simulate --history`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import Multibody, TimedMove, history_from_moves, servo_moves
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.orbit.chain_polish import least_time
from tfsat_host.plan.orbit.orbit_flight import Flight, Step, fly, open_loop_error_rad
from tfsat_host.plan.orbit.orbit_planner import Planner
from tfsat_host.plan.orbit.primitives import Primitive
from tfsat_host.quantity import Column, Columns, Table, fields, record, records
from tfsat_host.robot import RobotModel

_SAMPLE_S = 0.05
_MIN_SAMPLES = 8  # a spline through fewer of a stroke would cut its corners
_WHY = {
    "within tolerance": "The measured error is within the tolerance, the true one is not: the noise is too great "
    "for it.",
    "no progress": "No single loop brings it nearer any more.",
    "given up": "The last plans brought no progress; it ends where it was measured nearest.",
    "primitives used up": "The primitives were used up; --most allows more.",
}
_FLIGHT = fields("reached outcome tolerance_deg error_deg least_error_deg duration_s start_error_deg")
_STEPS: Columns = (
    Column("number", "number"),
    Column("strokes", "joint:angle / deg"),
    Column("t_s", "t", form=".1f"),
    Column("measured_error_deg", "measured"),
    Column("error_deg", "error"),
)


def _strokes(step: Step) -> list[dict[str, Any]]:
    return [{"joint": joint + 1, "angle_deg": math.degrees(angle)} for joint, angle in step.primitive.strokes]


_STEP: Columns = (
    Column("strokes", of=_strokes),
    *fields("duration_s=primitive.duration_s predicted_xyzw attitude_xyzw measured_xyzw"),
    *fields("error_deg measured_error_deg"),
)


def document(robot: RobotModel, planner: Planner, flight: Flight, plant: Multibody | None) -> dict[str, Any]:
    """Build the `--json` document of the plan and its simulated flight, without the command's own entries.

    `plant` is the robot flown if it differs from the planner's, else None.
    """
    start_deg = math.degrees(flight.start_error_rad)
    rate = math.degrees(planner.table.best_rate_about(flight.target_xyzw))
    # With noise, meeting a tolerance is chance: then none is promised.
    possible = (
        None if flight.reached or flight.noise_rad > 0.0 else _possible_tolerance_deg(planner, flight, plant)
    )
    least = least_time(planner.table, planner.time_to_go.axes[0], flight.target_xyzw, planner.tolerance_rad)
    open_loop = None if plant is None else open_loop_error_rad(planner, flight.target_xyzw, plant=plant)
    return {
        "robot": robot.name,
        "method": planner.method,
        **record(_FLIGHT, flight),
        "measured_to_deg": math.degrees(math.sqrt(3.0) * flight.noise_rad),
        "possible_tolerance_deg": possible,
        "primitives": len(flight.steps),
        "table_size": len(planner.table),
        "axis_rate_deg_s": rate if rate > 0.0 else None,
        "axis_time_s": start_deg / rate if rate > 0.0 else None,
        "least_time_s": least.seconds,
        "least_time_of": least.of,
        "least_time_angle_deg": math.degrees(least.angle_rad),
        "least_time_rate_deg_s": math.degrees(least.rate_rad_s) if least.seconds > 0.0 else None,
        "least_time_direction": least.direction.tolist(),
        "open_loop_error_deg": None if open_loop is None else math.degrees(open_loop),
        "target_quaternion_xyzw": flight.target_xyzw.tolist(),
        "target_euler_zyx_deg": np.degrees(
            euler_zyx_rad(Rotation.from_quat(flight.target_xyzw).as_matrix())
        ).tolist(),
        "steps": records(_STEP, flight.steps),
    }


def _possible_tolerance_deg(planner: Planner, flight: Flight, plant: Multibody | None) -> float | None:
    """Return a tolerance slightly above the smallest error if a simulated flight reaches it, else None."""
    # Two percent more than the smallest error, so that rounding to three digits cannot miss it.
    possible = float(f"{1.02 * math.degrees(flight.least_error_rad):.3g}")
    easier = replace(planner, tolerance_rad=math.radians(possible))
    return possible if fly(easier, flight.target_xyzw, plant=plant).reached else None


def lines(result: Mapping[str, Any]) -> Iterator[str | Table]:
    """Yield the report for people: the primitives, the attitude reached and the possible tolerance."""
    steps, tolerance = result["steps"], f"{result['tolerance_deg']:g} deg"
    ends_s = accumulate(step["duration_s"] for step in steps)
    yield Table(
        "",
        _STEPS,
        [
            {**step, "number": count, "strokes": _strokes_words(step), "t_s": end_s}
            for count, (step, end_s) in enumerate(zip(steps, ends_s, strict=True), 1)
        ],
    )
    if not steps and result["reached"]:
        yield f"Reached: it is there at the start, within {tolerance}. Nothing is flown."
    else:
        yield (
            f"{'Reached' if result['reached'] else 'NOT REACHED'}: {_format_angle(result['error_deg'])} deg left of "
            f"{result['start_error_deg']:.1f} deg, tolerance {tolerance}, in {result['duration_s']:.1f} s by "
            f"{result['primitives']} of {result['table_size']} primitives."
        )
    if result["axis_rate_deg_s"] is not None:
        yield (
            f"About the axis of this turn the best loop turns by {result['axis_rate_deg_s']:.2f} deg/s: the angle "
            f"alone takes {result['axis_time_s']:.1f} s by it."
        )
    if result["least_time_s"] > 0.0:
        yield _least_time_words(result)
    if result["open_loop_error_deg"] is not None:
        yield f"Without feedback {_format_angle(result['open_loop_error_deg'])} deg would be left."
    if not result["reached"]:
        yield _advice(result)
    if result["measured_to_deg"] > result["tolerance_deg"]:
        yield (
            f"The tolerance is below the noise: the attitude is measured to {result['measured_to_deg']:.2g} deg, "
            "and what is measured within the tolerance is so by chance."
        )
    if result["file"] is not None:
        yield f"Written to {result['file']}."
    if result["history"] is not None:
        yield Advice(
            f"Joint angles written to {result['history']}: ",
            NextStep("simulate", ("--robot", result["robot_file"], "--history", str(result["history"]))),
        )


def _least_time_words(result: Mapping[str, Any]) -> str:
    """Format the lower bound of the flight time, and the turn or tilt that sets it."""
    rate, angle = result["least_time_rate_deg_s"], result["least_time_angle_deg"]
    if result["least_time_of"] == "turn":
        why = f"{angle:.1f} deg are to be turned, and no loop turns by more than {rate:.3g} deg/s"
    else:
        axis = ", ".join(f"{component:.2f}" for component in result["least_time_direction"])
        why = (
            f"the body's direction ({axis}) is to be tilted by {angle:.1f} deg, and no loop tilts it by more than "
            f"{rate:.3g} deg/s"
        )
    return f"No chain of such loops takes less than {result['least_time_s']:.1f} s: {why}."


def _strokes_words(step: Mapping[str, Any]) -> str:
    return " ".join(f"{stroke['joint']}:{stroke['angle_deg']:+.1f}" for stroke in step["strokes"])


def _advice(result: Mapping[str, Any]) -> str:
    """Format the outcome of the flight, and the tolerance that would be met if one is known."""
    why, possible = _WHY[result["outcome"]], result["possible_tolerance_deg"]
    if result["outcome"] == "within tolerance":
        return why
    met = "." if possible is None else f": --tolerance {possible:g} is met."
    return f"{why} The smallest error on the way was {_format_angle(result['least_error_deg'])} deg{met}"


def _format_angle(angle_deg: float) -> str:
    """Format an angle with three digits; angles below 1e-9 deg are rounding and become 0."""
    return f"{angle_deg if angle_deg >= 1e-9 else 0.0:.3g}"


def write_joint_motion(robot: RobotModel, primitives: Sequence[Primitive], path: Path) -> None:
    """Writes t_s, the angle of every joint in deg and the number of the primitive, from 1.

    Strokes follow one another as the servos carry them out, each at its joint's average rate or as fast as it can.
    Without primitives the joints rest for a second.
    """
    moves, times, numbers, now_s = list[TimedMove](), [np.zeros(1)], [np.zeros(1)], 0.0
    for number, primitive in enumerate(primitives, start=1):
        for joint, angle_rad in primitive.strokes:
            # A primitive has no times of its own: its strokes go at each joint's average rate.
            duration_s = abs(angle_rad) / robot.servos[joint].average_rate_rad_s
            moves.append(TimedMove(joint, angle_rad, now_s, now_s + duration_s))
            # The servo's acceleration may take longer: the next stroke waits for the joint to arrive.
            (carried,) = servo_moves(robot, moves[-1:])
            count = max(int((carried.end_s - now_s) / _SAMPLE_S) + 1, _MIN_SAMPLES)
            # Leave out the first instant: it is the end of the stroke before.
            times.append(np.linspace(now_s, carried.end_s, count + 1)[1:])
            numbers.append(np.full(count, number))
            now_s = carried.end_s
    # Two samples at rest: a history with fewer cannot be read back.
    if not moves:
        times.append(np.ones(1))
        numbers.append(np.zeros(1))
    # Round the times as the file has them, so that the angles are those of the written instants.
    t_s = np.concatenate(times).round(6)
    history = history_from_moves(
        robot, moves, start_rad=np.array([servo.start_rad for servo in robot.servos])
    )
    joints = ",".join(f"theta{joint + 1}_deg" for joint in range(robot.n_joints))
    np.savetxt(
        path,
        np.column_stack([t_s, np.degrees(history.angles_rad(t_s)), np.concatenate(numbers)]),
        fmt=["%.6f", *["%.8f"] * robot.n_joints, "%d"],
        delimiter=",",
        header=f"t_s,{joints},primitive",
        comments="",
    )
