"""A servo of known faults, and its measurement by the plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tfsat_host.calibration.servos.servo_map import ServoPoint, arrivals, board_pulse_us, servo_plan
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import FACTORY

FACTORY_SERVO = FACTORY.of(1)


@dataclass
class SimulatedServo:
    """Comes to rest at gain * (what the factory's settings ask for) + offset, and its faults.

    Attributes:
        gain: Reached over commanded.
        offset_deg: At 0 deg.
        backlash_deg: Closing minus opening.
        repeatability_deg: Standard deviation of an arrival.
        bend_deg: Height of a half wave over 90 deg.
        noise_deg: Standard deviation of the sensors, and what each point says of itself.
        seed: Of all that is random.
    """

    gain: float = 1.0
    offset_deg: float = 0.0
    backlash_deg: float = 0.0
    repeatability_deg: float = 0.0
    bend_deg: float = 0.0
    noise_deg: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        self._random = np.random.default_rng(self.seed)

    def mean_deg(self, pulse_us: float, direction: int) -> float:
        """Compute the mean angle at which the servo comes to rest."""
        # What the factory's settings mean by this pulse.
        asked_deg = (pulse_us - FACTORY_SERVO.zero_us) / FACTORY_SERVO.ns_per_deg * 1000.0
        bend_deg = self.bend_deg * float(np.sin(np.pi * asked_deg / 90.0))
        # Half of the backlash on either side of the mean.
        return self.gain * asked_deg + self.offset_deg + bend_deg - direction * self.backlash_deg / 2

    def arrive_deg(self, pulse_us: float, direction: int) -> float:
        """Draw the angle at which the servo comes to rest this time."""
        return self.mean_deg(pulse_us, direction) + self.repeatability_deg * self._random.standard_normal()

    def visit_plan(self, setting: ServoSetting = FACTORY_SERVO) -> list[ServoPoint]:
        """Visit the whole plan; the direction of the first arrival is drawn."""
        plan = servo_plan(setting)
        points = []
        for angle_cdeg, direction in zip(plan, arrivals(plan), strict=True):
            pulse_us = board_pulse_us(setting, angle_cdeg)
            # The first arrival has no direction: the servo comes from wherever it was.
            came = direction or int(self._random.choice([-1, 1]))
            seen_deg = self.arrive_deg(pulse_us, came) + self.noise_deg * self._random.standard_normal()
            points.append(
                ServoPoint(
                    pulse_us, direction, float(np.deg2rad(seen_deg)), float(np.deg2rad(self.noise_deg))
                )
            )
        return points

    def fly_deg(self, angles_cdeg: Sequence[int], setting: ServoSetting) -> list[float]:
        """Return the angle moved by each stroke of a maneuver, from the start pose."""
        rest_deg = self.arrive_deg(board_pulse_us(setting, 0), int(self._random.choice([-1, 1])))
        pose_cdeg, reached = 0, []
        for angle_cdeg in angles_cdeg:
            pose_cdeg += angle_cdeg
            next_deg = self.arrive_deg(board_pulse_us(setting, pose_cdeg), int(np.sign(angle_cdeg)))
            # A stroke's size is the difference of two arrivals, each with its own scatter.
            reached.append(next_deg - rest_deg)
            rest_deg = next_deg
        return reached
