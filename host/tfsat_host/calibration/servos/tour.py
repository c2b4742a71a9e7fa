"""A joint that its servo moves from stop to stop while the logger's samples come in: its stops and rests."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Final

import numpy as np

from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.servos.fit import check_following
from tfsat_host.calibration.servos.servo_map import arrivals, board_pulse_us
from tfsat_host.calibration.servos.visits import REST_US, points_of
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Visit
from tfsat_host.calibration.steps.step import SWEEP_ROUNDS, SWEEP_STOPS_DEG, Step, bodies, title
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import JOG_IDLE_MS, JOG_SPEED_CDEG_S
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.messages import LiveReply, ServoSetting
from tfsat_host.robot import RobotModel
from tfsat_host.units import CDEG_PER_DEG

SWEEP_HOLD_S: Final = 1.0
LOOK_S: Final = 0.8
"""So much of a rest is judged: more than `REST_US`."""
LAST_SAMPLES_S: Final = 0.02
"""At the end of a rest: what the logger has sent is in by then."""
SILENCE_S: Final = 1.0
START_WITHIN_DEG: Final = 10.0
"""A joint farther from where its first pulse takes it would be thrown there."""
MIN_PULSE_CHANGE_US: Final = 20.0
"""Pulses that differ by less do not show whether the servo follows; 2 deg of most servos."""


def sweep_stops_cdeg(servo: ServoSetting) -> tuple[int, ...]:
    """Return the stops of a sweep by hand (0.01 deg), clamped to the joint's limits."""
    every_deg = SWEEP_STOPS_DEG + SWEEP_STOPS_DEG[1:] * (SWEEP_ROUNDS - 1)
    stops = [min(max(round(deg * CDEG_PER_DEG), servo.min_cdeg), servo.max_cdeg) for deg in every_deg]
    # Stops that the limits clamp onto each other are one stop.
    return tuple(stop for stop, _ in groupby(stops))


def tour_task(step: Step, stops_cdeg: Sequence[int], hold_s: float, duration_s: float) -> tuple[str, ...]:
    """Return the operator's instructions before a servo moves the joint, line by line.

    They also say what then moves.
    """
    joint, start_deg, to_deg = step.joint, stops_cdeg[0] / CDEG_PER_DEG, max(stops_cdeg) / CDEG_PER_DEG
    return (
        title(step),
        f"Take the holding attachment off joint {joint} and leave it on the others. Lay the robot on its side, "
        f"so that gravity does not load joint {joint}.",
        f"Hold {bodies(step.held)} on the bench; {bodies(step.moved)} will move. Keep hands, hair and cables "
        "clear of the joint.",
        f"The joint is limp now, and its first pulse takes it to {start_deg:g} deg at the servo's full speed: "
        f"bring it to {start_deg:g} deg by hand first.",
        f"Its servo then moves it to {to_deg:g} deg and back through {len(stops_cdeg)} stops, {hold_s:g} s each, at "
        f"{JOG_SPEED_CDEG_S / CDEG_PER_DEG:g} deg/s ({duration_s:.0f} s in all), and lets go.",
        "Ctrl-C or Ctrl-Z lets it go at once, and so does the board "
        f"{JOG_IDLE_MS / 1000:g} s after this program's last order.",
    )


def latest(samples: Sequence[LiveSample], scales: LiveReply) -> Counts:
    """Return the counts of the last `LOOK_S` of some samples, at least one."""
    begin_us = samples[-1].time_us - round(LOOK_S * 1e6)
    # Samples are in order of time: bisect instead of searching the whole tour at each rest.
    first = bisect_left(samples, begin_us, key=lambda sample: sample.time_us)
    return Counts.from_live(samples[first:], scales)


class LoggedTour:
    """Keeps the logger's samples while the sequencer moves the joint: the watch of `JogClient.tour`.

    Attributes:
        samples: So far.
        on_angle: Given the stop's number (from 0) and the commanded angle, 0.01 deg.

    Args:
        read: The logger's samples of the next so many seconds.
        scales: Of the samples.
        show_progress: See `on_angle`.
        rested: Given the last `LOOK_S` at the end of each rest; what it raises ends the tour.
    """

    def __init__(
        self,
        read: Callable[[float], Sequence[LiveSample]],
        scales: LiveReply,
        show_progress: Callable[[int, int], None],
        rested: Callable[[Counts], None],
    ) -> None:
        self.samples: list[LiveSample] = []
        self.on_angle = show_progress
        self._read, self._scales, self._rested = read, scales, rested
        self._silent_s = 0.0

    def pause(self, duration_s: float) -> None:
        """Takes what the logger sends. Raises TfsatError when it has been silent for long."""
        fresh = self._read(duration_s)
        self.samples += fresh
        self._silent_s = 0.0 if fresh else self._silent_s + duration_s
        if self._silent_s > SILENCE_S:
            raise TfsatError(
                what=f"No live sample from the logger for {SILENCE_S:g} s.",
                meaning="It has stopped sampling, or its cable is loose. The joint was let go, nothing was kept.",
                next_step="Check the logger's cable, then type the same command again.",
            )

    def on_rest(self, _stop: int) -> None:
        """Gives the rest to its judge, once what the logger has sent is in."""
        # Wait for at least one more sample, so that the rest's last ones are in, too.
        before = len(self.samples)
        while len(self.samples) == before:
            self.pause(LAST_SAMPLES_S)
        self._rested(latest(self.samples, self._scales))


class Visits:
    """The visits of one tour, and where the joint rested at each.

    Args:
        stops_cdeg: Angles that are commanded, 0.01 deg, in order.
        servo: Setting of the joint on the board.
        sensors: Of the joint, with a measured zero point.
        model: For the sensors' places in the log.
    """

    def __init__(
        self, stops_cdeg: Sequence[int], servo: ServoSetting, sensors: JointSensors, model: RobotModel
    ) -> None:
        self._stops_cdeg = stops_cdeg
        self._servo = servo
        self._sensors = sensors
        self._model = model
        self._rests = 0
        self._visits: list[Visit] = []
        self._reached_rad: list[float] = []

    @property
    def known(self) -> tuple[Visit, ...]:
        """All but those to which it is unknown from which side the joint came."""
        return tuple(visit for visit in self._visits if visit.direction)

    def check_start(self, limp: Counts) -> None:
        """Refuses to throw the joint to its first stop.

        Args:
            limp: At least `REST_US` of the joint as it lies, to the last sample.

        Raises:
            RefusedError: it is elsewhere.
            CalibrationError: it moves, or its sensors do not show where it is.
        """
        there_deg = float(np.rad2deg(self._rest(limp, 0)[1]))
        start_deg = self._stops_cdeg[0] / CDEG_PER_DEG
        if abs(there_deg - start_deg) <= START_WITHIN_DEG:
            return
        joint = self._sensors.joint
        raise RefusedError(
            what=f"Joint {joint} is at {there_deg:.0f} deg, and its first pulse would take it to {start_deg:g} deg at "
            "the servo's full speed.",
            meaning="Nothing was moved.",
            next_step=Advice(
                f"Bring joint {joint} to {start_deg:g} deg by hand, then the same command again. If it is there, "
                "its zero point is wrong: ",
                NextStep("calibrate zero", ("--joint", str(joint))),
            ),
        )

    def add_rest(self, so_far: Counts) -> None:
        """Takes the end of a rest into account; not of the first, in which the servo takes hold of the joint.

        Args:
            so_far: At least the last `REST_US` of it, to the last sample.

        Raises:
            CalibrationError: the joint did not rest, or does not follow its servo.
        """
        self._rests += 1
        if self._rests == 1:
            return
        visit, reached_rad = self._rest(so_far, self._rests - 1)
        self._visits.append(visit)
        self._reached_rad.append(reached_rad)
        # Judge during the tour, so that a servo that runs the wrong way is let go at once.
        pulse_us = np.array([visit.pulse_us for visit in self._visits])
        if np.ptp(pulse_us) > MIN_PULSE_CHANGE_US:
            check_following(self._sensors.joint, pulse_us, np.array(self._reached_rad), self._servo)

    def _rest(self, counts: Counts, stop: int) -> tuple[Visit, float]:
        # By the last part of a hold the servo has caught up and the joint has settled.
        end_us = int(counts.t_us[-1])
        pulse_us = board_pulse_us(self._servo, self._stops_cdeg[stop])
        visit = Visit(pulse_us, arrivals(self._stops_cdeg)[stop], end_us - REST_US, end_us)
        (point,) = points_of((visit,), counts, self._sensors, self._model)
        return visit, point.reached_rad
