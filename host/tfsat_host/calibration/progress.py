"""How far a step has come while its sensors are read: who moves, how much, and which rest is next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.gyros.bias import STILL_RATE_RAD_S
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, joint_angles
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.motion_checks import LEAST_RMS_RAD_S, MOST_HELD_FRACTION
from tfsat_host.calibration.steps.patterns import MotionPattern
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.steps.relative import body_to_base
from tfsat_host.calibration.steps.rests import SHORTEST_S, TURN_SHARE, find_rests
from tfsat_host.calibration.steps.step import SWEEP_ROUNDS, SWEEP_STOPS_DEG, TURN_ROUNDS, Step, StepKind
from tfsat_host.calibration.steps.view import MotionView
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

DURATION_S: Final = {StepKind.REST: 20.0, StepKind.ZERO: 5.0, StepKind.SWING: 12.0}
"""Of steps that end by the clock; the others end with their last rest."""
LONGEST_S = 90.0
"""Of those others, whatever came of them."""
_RECENT_S = 2.0
"""A body that was touched a while ago may be still again."""
_NEW_PLACE_RAD = np.deg2rad(10.0)
"""A joint that rests, twitches and rests again has rested once."""


@dataclass(frozen=True, slots=True)
class BodyLevel:
    """How one body moves, and how it should.

    Attributes:
        body: 1 to 4.
        rate_deg_s: Scatter of the gyro's worst axis in a rest or a zero, else its rms over all axes.
        limit_deg_s: What the step asks for; None of a body that only goes along.
        at_least: It must reach the limit; else it must stay below.
    """

    body: int
    rate_deg_s: float
    limit_deg_s: float | None
    at_least: bool

    @property
    def met(self) -> bool:
        """It is as the step asks."""
        if self.limit_deg_s is None:
            return True
        if self.at_least:
            return self.rate_deg_s >= self.limit_deg_s
        return self.rate_deg_s <= self.limit_deg_s


@dataclass(frozen=True, slots=True)
class StepProgress:
    """A step at one moment.

    Attributes:
        elapsed_s: Since its first sample.
        left_s: Until the clock ends it at the latest.
        levels: Of bodies 1 to 4.
        joint_deg: Angles of joints 1 to 3; one whose zero is not known counts from where the step began.
        rests: Rests so far; 0 where the step is none from rest to rest.
        stops_deg: Where it should rest, in order; empty likewise.
        done: It needs no more samples.
    """

    elapsed_s: float
    left_s: float
    levels: tuple[BodyLevel, ...]
    joint_deg: tuple[float, ...]
    rests: int
    stops_deg: tuple[float, ...]
    done: bool

    @property
    def next_stop_deg(self) -> float | None:
        """Where the next rest should be; None after the last, and where there are none."""
        return self.stops_deg[self.rests] if self.rests < len(self.stops_deg) else None


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of a robot's sensors while a step is read.

    Attributes:
        gyros: Of bodies 1 to 4.
        joints: Sensors of joints 1 to 3.
        model: The robot.
    """

    gyros: Sequence[GyroCalibration]
    joints: Sequence[JointSensors]
    model: RobotModel


def stops_deg(step: Step) -> tuple[float, ...]:
    """Where a sweep (the joint's angle) or a turn (the robot's) should rest, in order; empty for other steps."""
    if step.kind == StepKind.SWEEP:
        return SWEEP_STOPS_DEG[:1] + SWEEP_STOPS_DEG[1:] * SWEEP_ROUNDS
    if step.kind == StepKind.TURN:
        return (0.0, *(step.angle_deg, 0.0) * TURN_ROUNDS)
    return ()


def progress_of(step: Step, counts: Counts, known: Known) -> StepProgress:
    """Where a step stands by all samples that have come so far, at least one.

    Rests are counted as the fit will find them, but only where the joint (or the robot) has come to another place.
    """
    recording = Recording.from_counts(counts)
    elapsed_s = float(recording.t_s[-1] - recording.t_s[0])
    longest_s = DURATION_S.get(step.kind, LONGEST_S)
    angles = joint_angles(recording.sensor_angle_rad, known.joints, known.model)
    wanted = stops_deg(step)
    rests = 0
    if wanted and elapsed_s > SHORTEST_S:
        rests = min(_rests(step, recording, angles, known), len(wanted))
    return StepProgress(
        elapsed_s,
        max(0.0, longest_s - elapsed_s),
        _levels(step, recording, known.gyros),
        tuple(np.rad2deg(angles[-1]).tolist()),
        rests,
        wanted,
        elapsed_s >= longest_s or (len(wanted) > 0 and rests == len(wanted)),
    )


def joined(parts: Sequence[Counts]) -> Counts:
    """Counts that came one after the other, as one; for a look at them, not for keeping: gaps are not counted."""
    columns: dict[str, Any] = {
        column.name: np.concatenate([getattr(part, column.name) for part in parts])
        for column in fields(Counts)
        if column.name not in ("samples_lost", "scales")
    }
    return replace(parts[0], **columns)


def _levels(step: Step, recording: Recording, gyros: Sequence[GyroCalibration]) -> tuple[BodyLevel, ...]:
    if step.kind in (StepKind.REST, StepKind.ZERO):
        recent = recording.rate_rad_s[recording.t_s >= recording.t_s[-1] - _RECENT_S]
        scatter = np.rad2deg(recent.std(axis=0).max(axis=1))
        still_deg_s = float(np.rad2deg(STILL_RATE_RAD_S))
        return tuple(BodyLevel(body, float(rate), still_deg_s, False) for body, rate in enumerate(scatter, 1))
    rates = recording.rate_rad_s - np.array([gyro.bias_rad_s for gyro in gyros])
    rms = np.rad2deg(np.sqrt((rates**2).sum(axis=2).mean(axis=0)))
    as_in = StepKind.SWEEP if step.kind == StepKind.TURN else step.kind
    least = float(np.rad2deg(LEAST_RMS_RAD_S[as_in]))
    most = MOST_HELD_FRACTION * max(least, min(float(rms[body - 1]) for body in step.moved))
    limits = {**dict.fromkeys(step.held, most), **dict.fromkeys(step.moved, least)}
    return tuple(
        BodyLevel(body, float(rate), limits.get(body), body in step.moved) for body, rate in enumerate(rms, 1)
    )


def _rests(step: Step, recording: Recording, angles: FloatArray, known: Known) -> int:
    """Of the moved body that has the fewest."""
    if step.kind == StepKind.TURN:
        return min(_rests_of_turn(step, recording, known.gyros[body - 1]) for body in step.moved)
    if step.joint is None:
        raise ValueError(f"a {step.kind} moves no joint")
    pattern = MotionPattern(step.joint, step.moved, step.held)
    to_base = body_to_base(known.model, angles)
    view = MotionView(pattern, recording, angles, to_base, known.gyros, known.joints, known.model)
    place = angles[:, step.joint - 1]
    return min(
        _places(find_rests(recording.t_s, _along(view.readings(body))), place, _NEW_PLACE_RAD)
        for body in step.moved
    )


def _rests_of_turn(step: Step, recording: Recording, gyro: GyroCalibration) -> int:
    along = _along(recording.rate_rad_s[:, gyro.body - 1] - gyro.bias_rad_s)
    turned = np.concatenate([[0.0], np.cumsum(along[1:] * np.diff(recording.t_s))])
    return _places(find_rests(recording.t_s, along, TURN_SHARE), turned, abs(np.deg2rad(step.angle_deg)) / 2)


def _along(readings: FloatArray) -> FloatArray:
    """(n,) of readings (n, 3): their component in the direction in which there is most of them."""
    return np.asarray(readings @ np.linalg.eigh(readings.T @ readings)[1][:, -1])


def _places(rests: Sequence[slice], angle_rad: FloatArray, apart_rad: float) -> int:
    """How many of the rests are at another place than the one before."""
    count, last = 0, None
    for rest in rests:
        here = float(angle_rad[rest].mean())
        if last is None or abs(here - last) >= apart_rad:
            count, last = count + 1, here
    return count
