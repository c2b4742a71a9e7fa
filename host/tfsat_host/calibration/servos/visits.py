"""A servo's visits while they happen: a joint that does not follow must not be driven on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.servos.checks import check_following
from tfsat_host.calibration.servos.points import arrivals
from tfsat_host.calibration.servos.reached import REST_US, points_of
from tfsat_host.calibration.servos.stroke_error import board_pulse_us
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Visit
from tfsat_host.errors import RefusedError
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.robot import RobotModel
from tfsat_host.units import CDEG_PER_DEG

START_WITHIN_DEG: Final = 10.0
"""A joint farther from where its first pulse takes it would be thrown there."""
LEAST_TELLING_US: Final = 20.0
"""Pulses that differ by less do not tell whether the servo follows; 2 deg of most servos."""


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
        """All but those that nobody knows from which side the joint came to."""
        return tuple(visit for visit in self._visits if visit.direction)

    def check_start(self, limp: Counts) -> None:
        """Refuses to throw the joint to its first stop.

        Args:
            limp: At least `REST_US` of the joint as it lies, to the last sample.

        Raises:
            RefusedError: it is elsewhere.
            CalibrationError: it moves, or its sensors do not tell where it is.
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
            next_step=f"Bring joint {joint} to {start_deg:g} deg by hand, then the same command again. If it is there, "
            f"its zero point is wrong: tfsat-host calibrate zero --joint {joint}",
        )

    def rested(self, so_far: Counts) -> None:
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
        pulse_us = np.array([one.pulse_us for one in self._visits])
        if np.ptp(pulse_us) > LEAST_TELLING_US:
            check_following(self._sensors.joint, pulse_us, np.array(self._reached_rad), self._servo)

    def _rest(self, counts: Counts, stop: int) -> tuple[Visit, float]:
        end_us = int(counts.t_us[-1])
        pulse_us = board_pulse_us(self._servo, self._stops_cdeg[stop])
        visit = Visit(pulse_us, arrivals(self._stops_cdeg)[stop], end_us - REST_US, end_us)
        (point,) = points_of((visit,), counts, self._sensors, self._model)
        return visit, point.reached_rad
