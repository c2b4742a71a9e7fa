"""A simulation as JSON, as facts and tables for people, and where motion or figures are not what one may think."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.dynamics.history import JointHistory, overshoots
from tfsat_host.dynamics.simulation import Simulation
from tfsat_host.maneuver import Maneuver, ManeuverError, Schedule, schedule_maneuver
from tfsat_host.maneuver.schedule import TimedStroke, servo_speed_notices
from tfsat_host.quantity import Column, Columns, Table, columns_of, fields, vector
from tfsat_host.robot import RobotModel
from tfsat_host.units import s_from_us

ERROR_DEG = 1e-3
"""What `simulate` and `sensitivity` promise: a greater error of the integration is a notice."""
_BEYOND_DEG = 0.5  # less is how far sensors and servos are off
_LATE_S = 1e-6  # the schedule's own resolution


@dataclass(frozen=True, eq=False, slots=True)
class Turn:
    """How a body has turned since the release, in the ways that people write it; inertial axes.

    Attributes:
        matrix: (3, 3) the rotation.
    """

    matrix: FloatArray

    @property
    def reorientation_deg(self) -> float:
        """The rotation angle."""
        return float(np.degrees(self._rotation.magnitude()))

    # Adding zero avoids negative zeros.

    @property
    def rotation_vector_deg(self) -> FloatArray:
        """(3,) axis times angle."""
        return np.asarray(np.degrees(self._rotation.as_rotvec()) + 0.0)

    @property
    def euler_zyx_deg(self) -> FloatArray:
        """(3,) about z, the turned y, the twice turned x."""
        return np.asarray(np.degrees(euler_zyx_rad(self.matrix)) + 0.0)

    @property
    def quaternion_xyzw(self) -> FloatArray:
        """(4,) scalar last, not negative."""
        return np.asarray(self._rotation.as_quat(canonical=True) + 0.0)

    @property
    def _rotation(self) -> Rotation:
        return Rotation.from_matrix(self.matrix)


@dataclass(frozen=True, eq=False, slots=True)
class BodyTurn:
    """How one body has turned at the end."""

    body: str
    turn: Turn


@dataclass(frozen=True, eq=False, slots=True)
class StrokeTurn:
    """One stroke, when its joint arrives, and how the base has turned then."""

    stroke: TimedStroke
    end_s: float
    after: Turn


@dataclass(frozen=True, eq=False)
class SimulationResult:
    """A simulation as it is told.

    Attributes:
        simulation: The flight of a schedule or a history.
        initial_rate_deg_s: Of the base at the release, as typed; None: no angular momentum.
        notices: Where the motion or the figures may differ from what is expected, one sentence each.
        path: The written motion; None: not asked for.
        calibration: The certificate whose servos the robot has; None: those of its file.
    """

    simulation: Simulation
    initial_rate_deg_s: Sequence[float] | None
    notices: Sequence[str]
    path: Path | None = None
    calibration: Path | None = None

    @property
    def base_name(self) -> str:
        """The body whose attitude is followed."""
        return self.simulation.robot.body_names[self.simulation.flight.body.base]

    @property
    def bodies(self) -> list[BodyTurn]:
        """Each body's turn from the release to the end."""
        names = self.simulation.robot.body_names
        return [
            BodyTurn(name, Turn(matrix))
            for name, matrix in zip(names, self.simulation.rotations(), strict=True)
        ]

    @property
    def final(self) -> Turn:
        """The base's turn from the release to the end."""
        return self.bodies[self.simulation.flight.body.base].turn

    @property
    def strokes(self) -> list[StrokeTurn]:
        """The schedule's strokes; none of a sampled history."""
        motion, after = (
            self.simulation.motion,
            quaternion.to_matrix(self.simulation.stroke_quaternions_xyzw.T),
        )
        if not isinstance(motion, Schedule):
            return []
        return [
            StrokeTurn(stroke, round(end_s, 6), Turn(after[..., number]))
            for number, (stroke, end_s) in enumerate(
                zip(motion.strokes, self.simulation.arrivals_s, strict=True)
            )
        ]

    @property
    def duration_s(self) -> float:
        """The end of the simulation."""
        return float(self.simulation.flight.t_s[-1])

    @property
    def end_s(self) -> float:
        """When the joints are at rest; of strokes it is rounded to 10 ms, as in the paper's table."""
        if isinstance(self.simulation.motion, Schedule):
            return round(max(self.simulation.arrivals_s, default=0.0), 2)
        flight = self.simulation.flight
        # At a jump the flight shows the rate before it: the last moving instant is the end of the motion.
        return float(flight.t_s[flight.angle_rates_rad_s.any(axis=1)].max(initial=0.0))


def _format_release(result: SimulationResult) -> str:
    if result.initial_rate_deg_s is None:
        return "no angular momentum"
    return (
        f"{result.base_name} turns at {vector(result.initial_rate_deg_s, form='g')} deg/s about its x, y, z"
    )


def _format_time(result: SimulationResult) -> str:
    joints = f"joints at rest after {result.end_s:.2f} s" if result.end_s else "joints never move"
    return f"{joints}, simulated to {result.duration_s:.2f} s"


_TURN: Columns = (
    Column("reorientation_deg", "Reorientation"),
    Column("rotation_vector_deg", "Rotation vector x, y, z", form="+.3f"),
    Column("euler_zyx_deg", "Euler angles z, y, x", form="+.3f"),
    Column("quaternion_xyzw", "Quaternion x, y, z, w", form="+.6f"),
)
_BODY: Columns = (Column("body", "body"), *columns_of("turn", _TURN))
_COMMAND = columns_of(
    "stroke",
    (
        Column("t_s", "start", form=".2f"),
        Column("joint", "joint"),
        Column("angle_deg", "turns by", form="+.2f"),
    ),
)
_STROKE: Columns = (_COMMAND[0], *fields("end_s"), *_COMMAND[1:], Column("after", columns=_TURN))
RESULT: Columns = (
    *columns_of("final", _TURN),
    Column("robot", "Robot", of="simulation.robot.name"),
    Column(
        "calibration",
        "Servos as measured",
        of=lambda result: result.calibration and str(result.calibration),
        words=lambda result: str(result.calibration or ""),
    ),
    Column("base", "Attitude of", of="base_name"),
    Column("closed", of="simulation.is_closed"),
    *fields("duration_s"),
    Column("end_s", "Time", words=_format_time),
    *fields("integration_error_deg=simulation.estimated.error_rad"),
    Column("initial_rate_deg_s", "Release", words=_format_release),
    Column("angular_momentum_kg_m2_s", of=lambda result: result.simulation.flight.momentum()[0] + 0.0),
    Column("bodies", columns=_BODY),
    Column("strokes", columns=_STROKE),
    *fields("notices"),
)
"""A result as `tfsat-host simulate` shows it: all of it in `--json`, what has a label as facts for people."""
FILES: Columns = (
    Column(
        "files",
        "Written",
        of=lambda result: {} if result.path is None else {result.path.suffix.lower()[1:]: str(result.path)},
        words=lambda result: "" if result.path is None else str(result.path),
    ),
)


def tables(result: SimulationResult) -> list[Table]:
    """Return the strokes, and what each body has turned by if that is not the same of all."""
    after = columns_of("after", (replace(_TURN[0], label="then turned"), _TURN[2]))
    return [
        Table("", (*_STROKE, *after), result.strokes),
        Table("", _BODY[:3], [] if result.simulation.is_closed else result.bodies),
    ]


def notices(
    simulation: Simulation, maneuver: Maneuver | None = None, *, step_s: float | None = None
) -> list[str]:
    """Return notices where the motion or the figures may differ from what is expected, one sentence each.

    `maneuver` is the schedule's, for the sequencer's verdict on it; `step_s` the integration's, if it was
    given.
    """
    robot, motion = simulation.robot, simulation.motion
    if isinstance(motion, Schedule):
        messages = [
            *_schedule_notices(robot, motion, maneuver),
            *_late_notices(simulation, motion),
            *_turned_back_notices(simulation, motion),
        ]
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
    # Where strokes overlap by design nothing is cut short.
    if simulation.strokes_overlap and schedule.moving_at_once == 1:
        messages.append(
            "A stroke starts while another joint is still under way, so the joints cut a corner of the path and the "
            "rotation depends on their speed: it is that of the propagation in time. Give a lower --speed, or "
            "later t_s in the maneuver file, to part the strokes."
        )
    return messages


def _turned_back_notices(simulation: Simulation, schedule: Schedule) -> list[str]:
    """Return notices of strokes that turn their joint back before its servo, slower than scheduled, has arrived."""
    notices, latest_s = [], dict.fromkeys(range(1, simulation.robot.n_joints + 1), 0.0)
    for number, (stroke, arrival_s) in enumerate(
        zip(schedule.strokes, simulation.arrivals_s, strict=True), 1
    ):
        early_s = latest_s[stroke.joint] - stroke.t_s
        if early_s > _LATE_S:
            notices.append(
                f"Stroke {number} starts {1e3 * early_s:.3g} ms before joint {stroke.joint} has arrived. A servo turns "
                "back at once; here it arrives first, so the rotation will be another one. Start the stroke later."
            )
        latest_s[stroke.joint] = arrival_s
    return notices


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
