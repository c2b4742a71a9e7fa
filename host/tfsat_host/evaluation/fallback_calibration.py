"""Fallbacks for a calibration that is missing or that a landing has ended, and what they cost in certainty."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

from tfsat_host.angles import wrap_angle
from tfsat_host.calibration.certificate.certificate import Calibration, Quantity, Subject
from tfsat_host.calibration.misalignment import LANDING_TILT_STD_RAD
from tfsat_host.calibration.sensors.gyro import MOUNTING, GyroCalibration, by_design
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensor_columns, sensors_by_design
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.evaluation.motion.samples import EvaluationError
from tfsat_host.evaluation.rest import GUARD_S, Rest
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

HUNG_STD_RAD = np.deg2rad(6.0)
"""Of a joint that is taken to hang where its servo holds it: the paper's joint 1 sagged by 6 deg."""
_HANGING_S = 3.0


class Fallback(NamedTuple):
    """A calibration without gaps: what replaces a missing number has the uncertainty of such a replacement.

    Attributes:
        calibration: To evaluate with.
        notes: What was replaced by what; a sentence each.
    """

    calibration: Calibration
    notes: tuple[str, ...]


def with_fallbacks(
    calibration: Calibration | None, log: DropLog, model: RobotModel, rest: Rest, recorded: datetime | None
) -> Fallback:
    """Fills what a drop needs and the calibration lacks, by the model and the rest before the release.

    Landings later than `recorded`, when the drop was, end nothing; None: unknown.

    Raises:
        EvaluationError: a gyro's bias can be had from nowhere.
    """
    initial_calibration = calibration or _design_calibration(log, model)
    lacking = {gap.name: gap for gap in initial_calibration.shortcomings(recorded)}
    notes = []
    if not calibration:
        notes.append("There is no calibration: misalignments, scale factors and bends are by design.")
    gyros, rested = [], np.zeros(len(initial_calibration.gyros), bool)
    for index, gyro in enumerate(initial_calibration.gyros):
        why = lacking.get(f"bias of body {gyro.body}")
        # Only a bias that is missing or stale is replaced, and only if this gyro rested on all axes.
        rested[index] = why is not None and bool(np.isfinite(rest.rate_rad_s[index]).all())
        # A gyro without any sample in the fall needs no bias: it is bridged anyhow.
        if why is not None and not rested[index] and log.imu_valid[log.t_s >= 0.0, index].any():
            notes.append(_require_some_bias(gyro, why))
        # Widen what a landing may have changed first: a bias from the rest then replaces the widened one.
        since = gyro_since(gyro, lacking)
        gyros.append(_with_bias(since, rest, index) if rested[index] else since)
    if rested.any():
        bodies = ", ".join(str(body + 1) for body in np.flatnonzero(rested))
        notes.append(
            f"The bias of body {bodies} is that of the {rest.duration_s:.1f} s before the release, "
            "when the robot is taken to have hung still."
        )
    joints = []
    for sensors in initial_calibration.joints:
        if not sensors.has_zero:
            sensors = _hung(sensors, log, model)
            notes += _of_hung(sensors)
        joints.append(sensors_since(sensors, lacking))
    notes += _rest_of(tuple(lacking.values()), calibration is not None)
    return Fallback(replace(initial_calibration, gyros=tuple(gyros), joints=tuple(joints)), tuple(notes))


def _design_calibration(log: DropLog, model: RobotModel) -> Calibration:
    gyros = tuple(
        by_design(body, imu.sensor_to_body, absent=imu.absent) for body, imu in enumerate(model.imus, 1)
    )
    joints = tuple(sensors_by_design(model, joint + 1) for joint in range(model.n_joints))
    subject = Subject(model.name, log.header.board_serial.hex(), log.header.who_am_i.hex(), False)
    return Calibration(subject, gyros, joints, (), (), (), datetime.now(UTC))


def _with_bias(gyro: GyroCalibration, rest: Rest, index: int) -> GyroCalibration:
    covariance = gyro.covariance.copy()
    # A bias from this rest shares no error with the certificate's mounting and scale.
    covariance[:3, :] = covariance[:, :3] = 0.0
    covariance[:3, :3] = np.diag(rest.rate_std_rad_s[index] ** 2)
    # It was taken at the temperature of the fall.
    return replace(gyro, bias_rad_s=rest.rate_rad_s[index], covariance=covariance, temperature_c=float("nan"))


def _require_some_bias(gyro: GyroCalibration, why: Quantity) -> str:
    # An old bias, with what a landing may have done to it, is better than none.
    if why.state == "stale":
        return (
            f"The bias of body {gyro.body} was measured before a landing that may have changed it, and the robot did "
            "not hang still before this release: the old one is used."
        )
    raise EvaluationError(
        what=f"The bias of body {gyro.body} was never measured, and the robot did not hang still before the release.",
        meaning="Its gyro may show 20 deg/s of nothing: no attitude follows from it.",
        next_step=Advice(
            "Evaluate with a calibration (--calibration FILE); measure the bias before the next drop: ",
            NextStep("calibrate bias"),
        ),
    )


def _hung(sensors: JointSensors, log: DropLog, model: RobotModel) -> JointSensors:
    """Zero points that let the joint hang where its servo holds it at the start; NaN for a sensor that showed nothing
    then, so that it counts as silent from there on."""
    columns = sensor_columns(model, sensors.joint)
    before = (log.t_s < -GUARD_S) & (log.t_s >= -GUARD_S - _HANGING_S)
    readings_rad = SensorSamples.from_counts(Counts.from_log(log)).sensor_angle_rad[:, columns]
    zeros = np.full_like(sensors.zero_rad, np.nan)
    for k, column in enumerate(columns):
        rows = before & log.angle_valid[:, column]
        if rows.any():
            # Average on the unit circle: about the wrap, a mean of angles may be half a turn off.
            mean = float(np.angle(np.exp(1j * readings_rad[rows, k]).mean()))
            zeros[k] = mean - sensors.direction[k] * model.servos[sensors.joint - 1].start_rad
    # Both sensors sit on one joint: what it sags, both are off by, each in its own direction.
    shared = HUNG_STD_RAD * sensors.direction
    # A share of each sensor's own; the shared part alone has rank one.
    own = np.deg2rad(0.05) ** 2 * np.eye(2)
    return replace(sensors, zero_rad=wrap_angle(zeros), zero_covariance=np.outer(shared, shared) + own)


def _of_hung(sensors: JointSensors) -> list[str]:
    """Format the sentences on the joint's zero points taken from the rest, and on those it could not give."""
    silent = np.isnan(sensors.zero_rad)
    notes = []
    if not silent.all():
        notes.append(
            f"Joint {sensors.joint}: zero point not measured, start pose assumed at the release (± "
            f"{np.rad2deg(HUNG_STD_RAD):.0f} deg)."
        )
    notes += [
        f"Angle sensor {k + 1} of joint {sensors.joint} has no zero point and did not answer before the release: what "
        "it shows later is not used."
        for k in np.flatnonzero(silent)
    ]
    return notes


def _rest_of(lacking: Iterable[Quantity], certified: bool) -> list[str]:
    """Format the sentences on quantities without a fallback.

    Such a quantity keeps its design or its last value, with that value's uncertainty.
    """
    if not certified:
        return []
    notes = []
    for reason, without, words in (
        ("stale", ("bias", "servo", "scale"), "Measured before a landing that may have changed it"),
        ("missing", ("bias", "zero", "servo"), "Never measured"),
    ):
        names = [gap.name for gap in lacking if gap.state == reason and not gap.name.startswith(without)]
        if names:
            names_text = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
            notes.append(f"{words}: {names_text}; what it may be off is counted in.")
    return notes


LANDING_BIAS_STD_RAD_S = np.deg2rad(0.5)
"""Of a bias: shocks of 10,000 g are survived, not unnoticed; assumed, as no data sheet states it."""
LANDING_ZERO_STD_RAD = np.deg2rad(1.0)
"""Of an angle sensor's zero point: as far as a sensor may turn in its mount, assumed like the gyros' tilt."""

Lacking = Mapping[str, Quantity]


def gyro_since(gyro: GyroCalibration, lacking: Lacking) -> GyroCalibration:
    """Return the gyro with the covariance of its stale part widened by the possible effect of a landing."""
    # Parameters 0 to 2 are the bias, 3 to 5 the mounting's rotation vector, 6 to 8 the scales.
    covariance = gyro.covariance.copy()
    if _is_stale(lacking, f"bias of body {gyro.body}"):
        covariance[:3, :3] += LANDING_BIAS_STD_RAD_S**2 * np.eye(3)
    # A shock tilts a sensor about any axis: one stale angle widens all three.
    if any(_is_stale(lacking, f"misalignment of body {gyro.body} about {axis}") for axis in "xyz"):
        covariance[MOUNTING, MOUNTING] += LANDING_TILT_STD_RAD**2 * np.eye(3)
    return replace(gyro, covariance=covariance)


def sensors_since(sensors: JointSensors, lacking: Lacking) -> JointSensors:
    """Return a joint's angle sensors with a stale zero covariance widened by the effect of a landing.

    Each of the two sensors may have turned alone.
    """
    if not _is_stale(lacking, f"zero point of joint {sensors.joint}"):
        return sensors
    return replace(sensors, zero_covariance=sensors.zero_covariance + LANDING_ZERO_STD_RAD**2 * np.eye(2))


def _is_stale(lacking: Lacking, name: str) -> bool:
    return name in lacking and lacking[name].state == "stale"
