"""Attitudes, strokes and joints."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.evaluation.evaluation import Evaluation, Turn
from tfsat_host.evaluation.motion.joints import SensorDisagreement
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.strokes.standing_joints import Standing
from tfsat_host.quantity import UNKNOWN, Column, Columns, Table, fields, number, plus_minus, record


def _quaternion(turn: Turn) -> Any:
    return Rotation.from_rotvec(turn.rotation_vector_rad).as_quat(canonical=True)


TURN: Columns = (
    Column("reorientation_deg", of="angle_rad", std="std_rad"),
    *fields("rotation_vector_deg euler_zyx_deg bridged"),
    Column("attitude_covariance_deg2", of=lambda turn: np.rad2deg(np.rad2deg(turn.covariance))),
    Column("quaternion_xyzw", of=_quaternion),
)
INITIAL_RATE: Columns = (Column("initial_rate_deg_s", of="rate_rad_s", std="std_rad_s"),)
LAG: Columns = (
    *fields("measured expected_ms"),
    Column("delay_ms", "late", std="delay_std_s", form=".1f"),
)

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


def _joint(one: Standing | JointEnds) -> str:
    return f"joint {one.joint}"


def _state(one: Standing) -> str:
    return "moved" if one.unexpected else "crept" if one.crept else "stood"


def _farthest(one: Standing) -> str:
    return f"{number(float(np.rad2deg(one.greatest_rad)), '+.3f')} at {number(one.greatest_at_s, '.2f')} s"


def _time(one: Standing) -> str:
    return f"{one.from_s:.2f} to {one.until_s:.2f}"


STANDING: Columns = (
    Column("joint", "joint", words=_joint),
    Column("from_s", "time", words=_time),
    Column("drift_deg", "drift", std="drift_std_rad", form="+.2f"),
    Column("greatest_deg", "farthest", words=_farthest),
    Column("", "it", words=_state),
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
        """An angle sensor against the fused angle."""
        one = self.sensors[sensor]
        mean, expected, rms = np.rad2deg([one.mean_rad, one.expected_rad, one.rms_rad])
        if not np.isfinite(mean):
            return "never answered"
        return f"{plus_minus(mean, expected, sign=True, unknown=UNKNOWN)}, rms {number(rms, '.2f')}"


JOINTS: Columns = (
    Column("joint", "joint", words=_joint),
    Column("initial_deg", "at the release", std="initial_std_rad", form="+.2f"),
    Column("final_deg", "at the end", std="final_std_rad", form="+.2f"),
    Column("", "sensor 1 (deg)", words=lambda joint: joint.off(0)),
    Column("", "sensor 2 (deg)", words=lambda joint: joint.off(1)),
    *fields("sensed"),
    Column("sensors", columns=fields("sensor mean_deg rms_deg greatest_deg expected_deg")),
)


def joints(motion: Motion) -> list[JointEnds]:
    """All of them."""
    release = int(np.searchsorted(motion.t_s, 0.0))
    return [
        JointEnds(
            one.joint,
            float(one.angle_rad[release]),
            float(one.std_rad()[release]),
            float(one.angle_rad[-1]),
            float(one.std_rad()[-1]),
            one.sensed,
            tuple(one.sensors),
        )
        for one in motion.joints
    ]


def bodies(found: Evaluation) -> list[dict[str, Any]]:
    """For JSON: how each body turned, and how it was released."""
    return [
        {"body": number, **record(TURN, turn), **record(INITIAL_RATE, rate)}
        for number, (turn, rate) in enumerate(zip(found.turns, found.initial_rates, strict=True), 1)
    ]


def stroke_table(found: Evaluation) -> Table:
    """Commanded and flown; without rows if no maneuver is known."""
    remarks = [f"Stroke {stroke.number}: {stroke.remark}" for stroke in found.strokes if stroke.remark]
    caption = "Dead time: from the rise of the stroke line to the start of the joint."
    return Table("Strokes", STROKES, found.strokes, " ".join([caption, *remarks]))


def joint_table(found: Evaluation) -> Table:
    """Where the joints were at the release and at the end, and whether their sensors agree."""
    return Table(
        "Joints",
        JOINTS,
        joints(found.motion),
        "Sensors: mean difference from the fused angle ± what their calibration allows, and the rms of all "
        "differences, noise included.",
    )


def standing_table(found: Evaluation) -> Table:
    """Joints while nothing commanded them; without rows if no maneuver is known."""
    return Table(
        "Joints between their strokes",
        STANDING,
        found.standing,
        "Drift: from the first samples to the last. Farthest: from the first samples, noise included.",
    )
