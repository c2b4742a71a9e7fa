"""How far a step has come while its sensors are read: who moves, how much, and which rest is next."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.integrate import cumulative_trapezoid

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.acceptance import MAX_HELD_FRACTION, MIN_RMS_RAD_S
from tfsat_host.calibration.bias import STILL_RATE_RAD_S
from tfsat_host.calibration.response import main_line
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import joint_angles
from tfsat_host.calibration.solution import SensorKnowledge
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import (
    MIN_DURATION_S,
    SWEEP_SHARE,
    TURN_SHARE,
    SensorSamples,
    find_rests,
)
from tfsat_host.calibration.steps.step import (
    DURATION_S,
    SWEEP_ROUNDS,
    SWEEP_STOPS_DEG,
    TURN_ROUNDS,
    Step,
    StepKind,
)
from tfsat_host.calibration.steps.step_motion import Motion
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.messages import LiveReply
from tfsat_host.robot import RobotModel

MAX_DURATION_S = 90.0
"""Of steps that end with their last rest, whatever came of them."""
LOOK_S = 0.5
"""From one look at a step to the next, on the logger's clock."""
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


def stops_deg(step: Step) -> tuple[float, ...]:
    """Return the stops of a sweep (the joint's angle) or a turn (the robot's), in order, deg.

    Empty for other steps.
    """
    if step.kind == StepKind.SWEEP:
        return SWEEP_STOPS_DEG[:1] + SWEEP_STOPS_DEG[1:] * SWEEP_ROUNDS
    if step.kind == StepKind.TURN:
        return (0.0, *(step.angle_deg, 0.0) * TURN_ROUNDS)
    return ()


def progress_of(step: Step, counts: Counts, calibration: SensorKnowledge, model: RobotModel) -> StepProgress:
    """Compute a step's progress from all samples so far, at least one.

    Rests are counted as the fit will find them, but only where the joint (or the robot) has come to another
    place.
    """
    recording = SensorSamples.from_counts(counts)
    elapsed_s = float(recording.t_s[-1] - recording.t_s[0])
    longest_s = DURATION_S.get(step.kind, MAX_DURATION_S)
    angles = joint_angles(recording.sensor_angle_rad, calibration.joints, model)
    targets_deg = stops_deg(step)
    rests = 0
    if targets_deg and elapsed_s > MIN_DURATION_S:
        rests = min(_rests(step, recording, calibration, model), len(targets_deg))
    return StepProgress(
        elapsed_s,
        max(0.0, longest_s - elapsed_s),
        _levels(step, recording, calibration.gyros),
        tuple(np.rad2deg(angles[-1]).tolist()),
        rests,
        targets_deg,
        elapsed_s >= longest_s or (len(targets_deg) > 0 and rests == len(targets_deg)),
    )


class Watch:
    """Looks at a step while it is read, and says when it has come to its end.

    Args:
        step: What is done.
        scales: Of the samples.
        known: Of the sensors.
        model: The robot.
        show: Given each look.
    """

    def __init__(
        self,
        step: Step,
        scales: LiveReply,
        calibration: SensorKnowledge,
        model: RobotModel,
        show: Callable[[StepProgress], None],
    ) -> None:
        self._scales = scales
        self._look = partial(progress_of, step, calibration=calibration, model=model)
        self._show = show
        self._fresh: list[LiveSample] = []
        self._parts: list[Counts] = []
        self._due_us = 0

    def __call__(self, fresh: Sequence[LiveSample]) -> bool:
        """Add new samples, show the progress if due, and return whether the step needs no more of them."""
        self._fresh += fresh
        # Each look evaluates all samples so far: do it at intervals only.
        if fresh[-1].time_us < self._due_us:
            return False
        # Decode only what is new and append it, so that no sample is decoded twice.
        self._parts = [Counts.join([*self._parts, Counts.from_live(self._fresh, self._scales)])]
        self._fresh = []
        progress = self._look(self._parts[0])
        self._show(progress)
        # Look no later than the end by the clock, or the step would overrun it.
        self._due_us = fresh[-1].time_us + round(min(LOOK_S, progress.left_s) * 1e6)
        return progress.done


def _levels(step: Step, recording: SensorSamples, gyros: Sequence[GyroCalibration]) -> tuple[BodyLevel, ...]:
    if step.kind in (StepKind.REST, StepKind.ZERO):
        recent = recording.rate_rad_s[recording.t_s >= recording.t_s[-1] - _RECENT_S]
        scatter = np.rad2deg(recent.std(axis=0).max(axis=1))
        still_deg_s = float(np.rad2deg(STILL_RATE_RAD_S))
        return tuple(BodyLevel(body, float(rate), still_deg_s, False) for body, rate in enumerate(scatter, 1))
    rates = recording.rate_rad_s - np.array([gyro.bias_rad_s for gyro in gyros])
    rms = np.rad2deg(np.sqrt((rates**2).sum(axis=2).mean(axis=0)))
    # A turn has no rate limit of its own: that of a sweep stands for it.
    as_in = StepKind.SWEEP if step.kind == StepKind.TURN else step.kind
    least = float(np.rad2deg(MIN_RMS_RAD_S[as_in]))
    # As in `acceptance`: what held bodies may do scales with the slowest of the moved ones.
    most = MAX_HELD_FRACTION * max(least, min(float(rms[body - 1]) for body in step.moved))
    limits = {**dict.fromkeys(step.held, most), **dict.fromkeys(step.moved, least)}
    return tuple(
        BodyLevel(body, float(rate), limits.get(body), body in step.moved) for body, rate in enumerate(rms, 1)
    )


def _rests(step: Step, recording: SensorSamples, calibration: SensorKnowledge, model: RobotModel) -> int:
    """Count the rests so far of the moved body that has the fewest."""
    t_s, place, share, apart_rad = recording.t_s, None, SWEEP_SHARE, _NEW_PLACE_RAD
    # In a turn the gyro's own integral tells the place; in a sweep the angle sensors do.
    if step.kind == StepKind.TURN:
        biases = np.array([gyro.bias_rad_s for gyro in calibration.gyros])
        readings = list((recording.rate_rad_s - biases).swapaxes(0, 1))
        share, apart_rad = TURN_SHARE, abs(np.deg2rad(step.angle_deg)) / 2
    else:
        motion = Motion(step, recording, calibration.gyros, calibration.joints, model)
        readings = [motion.readings(body) for body in step.moved]
        place = motion.angle_rad[:, step.moving_joint - 1]
    counts = []
    for reading in readings:
        # Along the line of most motion, which needs no mounting.
        along = reading @ main_line(reading)
        rests = find_rests(t_s, along, share)
        turned = cumulative_trapezoid(along, t_s, initial=0) if place is None else place
        counts.append(_places(rests, turned, apart_rad))
    return min(counts)


def _places(rests: Sequence[slice], angle_rad: FloatArray, apart_rad: float) -> int:
    """Count the rests that lie at least `apart_rad` from the one counted before."""
    count, last = 0, None
    for rest in rests:
        here = float(angle_rad[rest].mean())
        if last is None or abs(here - last) >= apart_rad:
            count, last = count + 1, here
    return count
