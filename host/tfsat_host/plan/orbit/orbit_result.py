"""A flight of primitives as JSON and for people."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import accumulate
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, quaternion
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.plan.orbit.chain_polish import LeastTime, least_time
from tfsat_host.plan.orbit.orbit_flight import Flight, Step, fly, open_loop_error_rad
from tfsat_host.plan.orbit.orbit_planner import Planner
from tfsat_host.quantity import Column, Columns, Table, columns_of, fields, vector
from tfsat_host.robot import RobotModel

DEFAULT_ROBOT = "cubesat_3u"
_WHY = {
    "within tolerance": "the measured error is within the tolerance, the true one is not: the noise is too great",
    "no progress": "no single loop brings it nearer",
    "given up": "the last plans brought no progress; it ends where it was measured nearest",
    "primitives used up": "the primitives are used up; --max-primitives allows more",
}


@dataclass(frozen=True, eq=False)
class OrbitResult:
    """A plan and its simulated flight.

    Attributes:
        robot: The planner's.
        robot_file: Its file or name, as typed.
        planner: Who planned.
        flight: What came of it.
        least_time: What a chain of such loops takes at least, estimated.
        possible_tolerance_deg: A tolerance that would be met; None: none is known, or this one is met.
        open_loop_error_rad: What would be left without feedback; None: the model itself flew.
        file: The written plan; None: not asked for.
        history: The written joint angles; None: not asked for.
    """

    robot: RobotModel
    robot_file: str
    planner: Planner
    flight: Flight
    least_time: LeastTime
    possible_tolerance_deg: float | None
    open_loop_error_rad: float | None
    file: Path | None = None
    history: Path | None = None

    @classmethod
    def of(
        cls, robot: RobotModel, robot_file: str, planner: Planner, flight: Flight, plant: Multibody | None
    ) -> OrbitResult:
        """Compare a flight with its bounds; `plant` is the robot flown if it differs from the planner's."""
        # With noise, meeting a tolerance is chance: then none is promised.
        is_hopeless = flight.reached or flight.noise_rad > 0.0
        possible = None if is_hopeless else _possible_tolerance_deg(planner, flight, plant)
        least = least_time(
            planner.table, planner.time_to_go.axes[0], flight.target_xyzw, planner.tolerance_rad
        )
        # Joints that move together travel so many times as far a second: the estimate counts their loops by travel.
        at_once = planner.moving_at_once
        least = least._replace(seconds=least.seconds / at_once, rate_rad_s=least.rate_rad_s * at_once)
        open_loop = None if plant is None else open_loop_error_rad(planner, flight.target_xyzw, plant=plant)
        return cls(robot, robot_file, planner, flight, least, possible, open_loop)

    @property
    def overlapping(self) -> bool:
        """Whether strokes of the flight overlap."""
        return any(step.primitive.spans_s is not None for step in self.flight.steps)

    @property
    def axis_rate_rad_s(self) -> float | None:
        """How fast the best loop turns about the axis of this turn; None: no loop turns about it."""
        target = self.flight.target_xyzw
        vector = quaternion.logarithm(target)
        axis = vector / max(float(np.linalg.norm(vector)), 1e-12)
        overlapping = [
            float(axis @ quaternion.logarithm(step.primitive.quaternion_xyzw)) / step.primitive.duration_s
            for step in self.flight.steps
            if step.primitive.spans_s is not None and step.primitive.duration_s > 0.0
        ]
        rate = max([self.planner.table.best_rate_about(target), *overlapping])
        return rate if rate > 0.0 else None

    @property
    def axis_time_s(self) -> float | None:
        """How long the angle alone takes at that rate."""
        return None if self.axis_rate_rad_s is None else self.flight.start_error_rad / self.axis_rate_rad_s

    @property
    def measured_to_deg(self) -> float:
        """Root mean square angle of the measurements' noise."""
        return math.degrees(math.sqrt(3.0) * self.flight.noise_rad)

    @property
    def target_euler_zyx_deg(self) -> FloatArray:
        """(3,) the target, z-y-x Euler angles."""
        return np.degrees(euler_zyx_rad(Rotation.from_quat(self.flight.target_xyzw).as_matrix()))

    @property
    def verdict(self) -> str:
        """Whether the target was reached, in a line."""
        flight = self.flight
        tolerance = f"tolerance {math.degrees(flight.tolerance_rad):g} deg"
        if not flight.steps and flight.reached:
            return f"REACHED: at the start, nothing is flown ({tolerance})"
        word = "REACHED" if flight.reached else "NOT REACHED"
        return (
            f"{word}: {_format_angle(flight.error_rad)} deg left of {math.degrees(flight.start_error_rad):.1f} deg "
            f"({tolerance}) after {flight.duration_s:.1f} s"
        )


def _possible_tolerance_deg(planner: Planner, flight: Flight, plant: Multibody | None) -> float | None:
    """Return a tolerance slightly above the smallest error if a simulated flight reaches it, else None."""
    # Two percent more than the smallest error, so that rounding to three digits cannot miss it.
    possible = float(f"{1.02 * math.degrees(flight.least_error_rad):.3g}")
    easier = replace(planner, tolerance_rad=math.radians(possible))
    return possible if fly(easier, flight.target_xyzw, plant=plant).reached else None


def _format_angle(angle_rad: float) -> str:
    """Format an angle in deg with three digits; angles below 1e-9 deg are rounding and become 0."""
    angle_deg = math.degrees(angle_rad)
    return f"{angle_deg if angle_deg >= 1e-9 else 0.0:.3g}"


def _format_robot(result: OrbitResult) -> str:
    is_default = result.robot_file == DEFAULT_ROBOT
    others = ", the default on orbit; of other commands: drop_tower" if is_default else ""
    return f"{result.robot.name} ({result.robot_file}{others})"


def _format_at_once(result: OrbitResult) -> str:
    """Format how many joints move at once; nothing where one at a time is all that was asked for."""
    most = result.planner.moving_at_once
    if most == 1:
        return ""
    return (
        f"up to {most}"
        if result.overlapping
        else f"one (no faster loop of {most} joints that overlap was found)"
    )


def _format_rate(result: OrbitResult) -> str:
    if result.axis_rate_rad_s is None:
        return ""
    return (
        f"{math.degrees(result.axis_rate_rad_s):.2f} deg/s about the axis of this turn; the angle alone takes "
        f"{result.axis_time_s:.1f} s"
    )


def _format_least_time(result: OrbitResult) -> str:
    """Format the estimate of the least flight time, and the turn or tilt that sets it."""
    least = result.least_time
    if not least.seconds > 0.0:
        return ""
    angle, rate = f"{math.degrees(least.angle_rad):.1f} deg", f"{math.degrees(least.rate_rad_s):.3g} deg/s"
    if least.of == "turn":
        why = f"turn of {angle}, by any loop at most {rate}"
    else:
        why = f"tilt of body direction ({vector(least.direction, form='.2f')}) by {angle}, by any loop at most {rate}"
    return f"{least.seconds:.1f} s ({why})"


def _format_outcome(result: OrbitResult) -> str:
    """Format why the target was not reached, and the tolerance that would be met if one is known."""
    flight = result.flight
    if flight.reached:
        return ""
    why = _WHY[flight.outcome]
    if flight.outcome == "within tolerance":
        return why
    possible = result.possible_tolerance_deg
    met = "" if possible is None else f", --tolerance {possible:g} is met"
    return f"{why} (smallest error on the way: {_format_angle(flight.least_error_rad)} deg{met})"


def _format_noise(result: OrbitResult) -> str:
    if not result.measured_to_deg > math.degrees(result.flight.tolerance_rad):
        return ""
    return f"{result.measured_to_deg:.2g} deg, above the tolerance: a measured error within it is chance"


def _format_strokes(step: Step) -> str:
    """Format the strokes; those that a joint held aside lets repeat stand once, in brackets."""
    shape, displacement_rad = step.primitive.shape, step.primitive.displacement_rad
    if step.primitive.spans_s is not None:
        timed = zip(step.primitive.strokes, step.primitive.spans_s[:, 0], strict=True)
        return " ".join(
            f"{joint + 1}:{math.degrees(angle):+.1f}@{start:.2f}" for (joint, angle), start in timed
        )
    words = [
        f"{joint + 1}:{math.degrees(angle):+.1f}" for joint, angle in shape.once.strokes(displacement_rad)
    ]
    if shape.repeats > 1 and shape.held is not None:
        # A joint of which the optimum is not to move at all has no strokes.
        first = int(displacement_rad[shape.held] != 0.0)
        inner = " ".join(words[first : len(words) - first])
        words = [*words[:first], f"{shape.repeats}x({inner})", *words[len(words) - first :]]
    return " ".join(words)


def _timed_strokes(step: Step) -> list[tuple[int, float, float | None]]:
    """Return joint, angle and start of each stroke; no start where one follows another."""
    strokes, spans_s = step.primitive.strokes, step.primitive.spans_s
    starts = [None] * len(strokes) if spans_s is None else spans_s[:, 0].tolist()
    return [(*stroke, start) for stroke, start in zip(strokes, starts, strict=True)]


_STROKE: Columns = (
    Column("joint", of=lambda stroke: stroke[0] + 1),
    Column("angle_deg", of=lambda stroke: math.degrees(stroke[1])),
    Column("start_s", of=lambda stroke: stroke[2]),
)
_STEP: Columns = (
    Column("strokes", "joint:angle / deg", of=_timed_strokes, words=_format_strokes, columns=_STROKE),
    *fields("duration_s=primitive.duration_s predicted_xyzw attitude_xyzw measured_xyzw"),
    Column("error_deg", "error"),
    Column("measured_error_deg", "measured"),
)
PLAN: Columns = (
    Column("made_by", of=lambda _result: "tfsat-host plan"),
    *fields("robot_file"),
    Column(
        "robot",
        "Robot",
        of="robot.name",
        words=_format_robot,
    ),
    Column(
        "",
        "Target",
        words=lambda result: f"{vector(result.target_euler_zyx_deg, form='.2f')} deg (Euler angles z, y, x)",
    ),
    *fields("method=planner.method"),
    *columns_of(
        "flight", fields("reached outcome tolerance_deg error_deg least_error_deg duration_s start_error_deg")
    ),
    Column("measured_to_deg", "Attitude noise", words=_format_noise),
    *fields("possible_tolerance_deg"),
    Column(
        "primitives",
        "Primitives",
        of=lambda result: len(result.flight.steps),
        words=lambda result: f"{len(result.flight.steps)}, of {len(result.planner.table)} in the table",
    ),
    Column("table_size", of=lambda result: len(result.planner.table)),
    *fields("moving_at_once=planner.moving_at_once"),
    Column("overlapping", "Joints at once", words=_format_at_once),
    Column("axis_rate_deg_s", "Best loop", words=_format_rate),
    *fields("axis_time_s"),
    Column("least_time_s", "Estimated least time", of="least_time.seconds", words=_format_least_time),
    *fields("least_time_of=least_time.of least_time_angle_deg=least_time.angle_rad"),
    Column(
        "least_time_rate_deg_s",
        of=lambda result: (
            math.degrees(result.least_time.rate_rad_s) if result.least_time.seconds > 0.0 else None
        ),
    ),
    *fields("least_time_direction=least_time.direction"),
    Column(
        "open_loop_error_deg",
        "Error without feedback",
        words=lambda result: (
            "" if result.open_loop_error_rad is None else f"{_format_angle(result.open_loop_error_rad)} deg"
        ),
    ),
    Column("", "Why", words=_format_outcome),
    *fields("target_quaternion_xyzw=flight.target_xyzw target_euler_zyx_deg"),
    Column("steps", of="flight.steps", columns=_STEP),
)
"""A result as `tfsat-host plan` shows and writes it: all of it in JSON, what has a label as facts for people."""
FILES: Columns = (
    Column("file", "Written", words=lambda result: str(result.file or "")),
    Column("history", "Joint angles", words=lambda result: str(result.history or "")),
)


@dataclass(frozen=True, slots=True)
class _NumberedStep:
    number: int
    t_s: float
    step: Step


_NUMBERED_STEP: Columns = (
    Column("number", "number"),
    Column("t_s", "t", form=".1f"),
    *columns_of("step", _STEP),
)


def step_table(result: OrbitResult) -> Table:
    """Return the primitives that were flown, with the time when each has ended."""
    steps = result.flight.steps
    ends_s = accumulate(step.primitive.duration_s for step in steps)
    rows = [_NumberedStep(*row) for row in zip(range(1, len(steps) + 1), ends_s, steps, strict=True)]
    return Table("", _NUMBERED_STEP, rows)
