"""What a drop was, for tables and JSON: attitudes, strokes, joints, clocks, release, landing, micro-gravity."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.evaluation.clock_fit import ClockFit
from tfsat_host.evaluation.clocks import Clocks
from tfsat_host.evaluation.evaluated_drop import Evaluation, Turn
from tfsat_host.evaluation.micro_gravity import MicroGravity
from tfsat_host.evaluation.motion.joints import SensorDisagreement
from tfsat_host.evaluation.motion.motion import InitialRate
from tfsat_host.evaluation.standing_joints import JointRest
from tfsat_host.quantity import UNKNOWN, Column, Columns, Table, fields, number, plus_minus
from tfsat_host.robot.absent_parts import bodies_of


def _quaternion(turn: Turn) -> Any:
    return Rotation.from_rotvec(turn.rotation_vector_rad).as_quat(canonical=True)


TURN: Columns = (
    Column("reorientation_deg", of="turn.angle_rad", std="turn.std_rad"),
    *fields(
        "rotation_vector_deg=turn.rotation_vector_rad euler_zyx_deg=turn.euler_zyx_rad bridged=turn.bridged"
    ),
    # Twice to degrees: a covariance is in square units.
    Column("attitude_covariance_deg2", of=lambda body: np.rad2deg(np.rad2deg(body.turn.covariance))),
    # Canonical sign: q and -q are one rotation, and a file should show only one of them.
    Column("quaternion_xyzw", of=lambda body: _quaternion(body.turn)),
)
INITIAL_RATE: Columns = (Column("initial_rate_deg_s", of="initial.rate_rad_s", std="initial.std_rad_s"),)
LAG: Columns = (*fields("measured expected_ms"), Column("delay_ms", "late", std="delay_std_s", form=".1f"))

STROKES: Columns = (
    Column("stroke", "stroke", of="number", words=lambda stroke: f"{stroke.number}: joint {stroke.joint}"),
    *fields("joint scheduled_s logged_s moved"),
    Column("commanded_deg", "commanded", form="+.2f"),
    Column("size_deg", "flown", std="size_std_rad", form="+.2f"),
    Column("start_s", "start", std="start_std_s"),
    Column("dead_time_s", "dead time", form=".1f", shown_in="ms"),
    Column("end_s", "end"),
    Column("peak_rate_deg_s", "peak rate", form="+.0f"),
    Column("overshoot_deg", "overshoot", form=".2f"),
    *fields("short_deg mean_rate_deg_s settling_s unfinished remark"),
)


def _farthest(rest: JointRest) -> str:
    return f"{number(float(np.rad2deg(rest.greatest_rad)), '+.3f')} at {number(rest.greatest_at_s, '.2f')} s"


_JOINT = Column("joint", "joint", words=lambda row: f"joint {row.joint}")
STANDING: Columns = (
    _JOINT,
    Column("from_s", "time", words=lambda rest: f"{rest.from_s:.2f} to {rest.until_s:.2f}"),
    Column("drift_deg", "drift", std="drift_std_rad", form="+.2f"),
    Column("greatest_deg", "max. deviation", words=_farthest),
    Column(
        "", "state", words=lambda rest: "moved" if rest.unexpected else "crept" if rest.crept else "steady"
    ),
    *fields("until_s greatest_at_s unexpected crept remark"),
)


class JointEnds(NamedTuple):
    """A joint at the release and at the end; standard deviations; whether and how far its sensors are off."""

    joint: int
    initial_rad: float
    initial_std_rad: float
    final_rad: float
    final_std_rad: float
    sensed: bool
    sensors: tuple[SensorDisagreement, ...]

    def off(self, sensor: int) -> str:
        """Format an angle sensor's difference from the fused angle."""
        disagreement = self.sensors[sensor]
        mean, expected, rms = np.rad2deg(
            [disagreement.mean_rad, disagreement.expected_rad, disagreement.rms_rad]
        )
        if not np.isfinite(mean):
            return "never answered"
        return f"{plus_minus(mean, expected, sign=True, unknown=UNKNOWN)}, rms {number(rms, '.2f')}"


JOINTS: Columns = (
    _JOINT,
    Column("initial_deg", "at the release", std="initial_std_rad", form="+.2f"),
    Column("final_deg", "at the end", std="final_std_rad", form="+.2f"),
    Column("", "sensor 1 (deg)", words=lambda joint: joint.off(0)),
    Column("", "sensor 2 (deg)", words=lambda joint: joint.off(1)),
    *fields("sensed"),
    Column("sensors", columns=fields("sensor mean_deg rms_deg greatest_deg expected_deg")),
)


def joints(evaluation: Evaluation) -> list[JointEnds]:
    """Return the ends of all joints; NaN where the results of their sensors are withheld."""
    # NaN withholds: a check of the sensors behind these angles failed.
    motion, factor = evaluation.motion, 1.0 if evaluation.is_given() else np.nan
    release = int(np.searchsorted(motion.t_s, 0.0))
    return [
        JointEnds(
            joint.joint,
            factor * float(joint.angle_rad[release]),
            factor * float(joint.std_rad()[release]),
            factor * float(joint.angle_rad[-1]),
            factor * float(joint.std_rad()[-1]),
            joint.sensed,
            tuple(joint.sensors) if evaluation.is_given() else (),
        )
        for joint in motion.joints
        if not evaluation.model.servos[joint.joint - 1].absent
    ]


BODIES: Columns = (*fields("body"), *TURN, *INITIAL_RATE)


class BodyResult(NamedTuple):
    """One body: its turn from the release to the end, and its rate before the first stroke."""

    body: int
    turn: Turn
    initial: InitialRate


def bodies(evaluation: Evaluation) -> list[BodyResult]:
    """Return the results of the bodies that are there."""
    there = bodies_of(evaluation.model)
    return list(map(BodyResult, there, evaluation.turns, evaluation.initial_rates))


def stroke_table(evaluation: Evaluation) -> Table:
    """Commanded and flown; without rows if no maneuver is known."""
    remarks = [f"Stroke {stroke.number}: {stroke.remark}" for stroke in evaluation.strokes if stroke.remark]
    caption = "Dead time: from the rise of the stroke line to the start of the joint."
    return Table(
        "Strokes",
        STROKES,
        evaluation.strokes,
        " ".join([caption, *remarks]),
        below=("dead time", "peak rate", "overshoot"),
    )


def joint_table(evaluation: Evaluation) -> Table:
    """Build the table of joint angles at the release and at the end, and of their sensors' agreement."""
    if not evaluation.is_given():
        return Table("Joints", JOINTS, (), fold="Joint angles: withheld.")
    return Table(
        "Joints",
        JOINTS,
        joints(evaluation),
        "Sensors: mean difference from the fused angle ± what their calibration allows, and the rms of all "
        "differences, noise included.",
        below=("sensor 1 (deg)", "sensor 2 (deg)"),
    )


def standing_table(evaluation: Evaluation) -> Table:
    """Joints while nothing commanded them; without rows if no maneuver is known."""
    return Table(
        "Joints between their strokes",
        STANDING,
        evaluation.standing,
        "Drift: first to last samples. Maximum deviation: from the first samples, noise included.",
    )


_INSTANT: Columns = (Column("t_s", std="std_s"),)
_EVENT: Columns = (
    *fields("event=pair.event clock_s=pair.clock_s logger_s=pair.logger_s used"),
    Column("residual_s", std="std_s"),
)


def _used(fit: ClockFit) -> str:
    return f"{sum(residual.used for residual in fit.residuals)} of {len(fit.residuals)}"


def _greatest_residual_s(fit: ClockFit) -> float:
    return max(
        # Events that were left out are findings of their own and would hide how well the others fit.
        (abs(residual.residual_s) for residual in fit.residuals if residual.used),
        default=float("nan"),
    )


CLOCK: Columns = (
    Column("", "clock", words=lambda fit: fit.name),
    Column("offset_s", "offset", std="offset_std_s", form="+.3f", shown_in="ms"),
    Column("rate_ppm", "drift", std="rate_ppm_std", form="+.1f"),
    Column("", "events used", words=_used),
    Column("events", of="residuals", columns=_EVENT),
    *fields("findings"),
)
_SHOWN_CLOCK: Columns = (
    *CLOCK,
    Column("greatest_residual_s", "max. residual", of=_greatest_residual_s, shown_in="ms"),
)

_MICRO_GRAVITY: Columns = (
    Column(
        "windows",
        columns=(
            *fields("name=window.name from_s=window.from_s until_s=window.until_s"),
            Column(
                "bodies",
                columns=(*fields("body samples motion_rms_g"), Column("residual_g", std="residual_std_g")),
            ),
        ),
    ),
    Column("changes_g", std="changes_std_g"),
    Column(
        "gravity_before_release",
        of="gravity",
        columns=(
            *fields("body"),
            Column("felt_g", of="norm_g", std="norm_std_g"),
            Column("less_fall_g", of="less_fall_norm_g", std="less_fall_std_g"),
            Column("passes", of=lambda row: bool(row.passes)),
        ),
    ),
)


_VELOCITY: Columns = (
    Column("mm_s", of="value_mm_s"),
    Column("mm_s_std", of="std_mm_s"),
    Column("interval_mm_s", of=lambda velocity: [velocity.low_mm_s, velocity.high_mm_s]),
)
_RELEASE_VELOCITY: Columns = (
    *(
        Column(name, columns=_VELOCITY)
        for name in ("downward", "transversal_x", "transversal_y", "transversal_speed")
    ),
    *fields("downward_judged transversal_judged samples samples_left_out scatter_mm from_s until_s"),
)


def _given_micro_gravity(evaluation: Evaluation) -> MicroGravity | None:
    return evaluation.micro_gravity if evaluation.is_given("micro-gravity") else None


FALL: Columns = (
    Column(
        "clocks",
        of=lambda evaluation: evaluation.clocks or Clocks(None, None, (), ()),
        columns=(Column("sequencer", columns=CLOCK), Column("video", columns=CLOCK)),
    ),
    Column("rest", columns=fields("duration_s")),
    Column(
        "release",
        of="instants",
        columns=(*fields("std_s=release_std_s"), Column("felt", of="release", columns=_INSTANT)),
    ),
    Column(
        "landing",
        of="instants",
        columns=(*fields("logged_s=landing_logged_s"), Column("felt", of="landing", columns=_INSTANT)),
    ),
    Column("micro_gravity", of=_given_micro_gravity, columns=_MICRO_GRAVITY),
    Column("release_velocity", columns=_RELEASE_VELOCITY),
    Column("fall_findings", of=lambda drop: [*drop.instants.findings, *drop.micro_gravity.findings]),
)
"""Of an evaluation: clocks, release, landing, micro-gravity."""


def clock_table(evaluation: Evaluation) -> Table:
    """Build the table of the clocks other than the logger's."""
    fits = (evaluation.clocks.sequencer, evaluation.clocks.video) if evaluation.clocks else ()
    return Table(
        "Clocks",
        _SHOWN_CLOCK,
        [fit for fit in fits if fit is not None],
        "Against the logger's clock, by which all times are given.",
    )
