"""The servo maps that a careful day on the bench would have left of an emulated robot, without the day."""

from __future__ import annotations

import numpy as np

from tfsat_host.calibration.servos.fit import fit_servo_map
from tfsat_host.calibration.servos.servo_map import ServoMap, ServoPoint, arrivals, board_pulse_us, servo_plan
from tfsat_host.emulated.imperfections import Imperfections
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.robot import PulseMap, RobotModel
from tfsat_host.servo_settings import FACTORY

_SEEN_STD_RAD = np.deg2rad(0.01)
"""Of a rest's mean by both angle sensors."""


def careful_servo_maps(model: RobotModel, truth: Imperfections, seed: int) -> tuple[ServoMap, ...]:
    """What `calibrate servo` fits to its visits, which are drawn from the servos' true errors.

    The board holds the factory's settings meanwhile, as it does in a rehearsal: what a servo is off then is its truth.
    The ends of a joint's range are left out, for there it lies against its stops.

    Args:
        model: The robot by design, with pulses for every servo.
        truth: Its hidden errors.
        seed: For how a servo scatters, and its sensors.
    """
    return tuple(
        fit_servo_map(
            _visits(pulses, truth, index, np.random.default_rng([seed, 7, index])),
            index + 1,
            FACTORY.of(index + 1),
        )
        for index, pulses in enumerate(_pulses(model))
    )


def _pulses(model: RobotModel) -> list[PulseMap]:
    known = [servo.pulses for servo in model.servos[:JOINT_COUNT]]
    return [pulses for pulses in known if pulses is not None]


def _visits(
    pulses: PulseMap, truth: Imperfections, index: int, random: np.random.Generator
) -> list[ServoPoint]:
    setting: ServoSetting = FACTORY.of(index + 1)
    plan = servo_plan(setting)
    scatter = truth.servo_repeat_rad[index] * random.standard_normal(len(plan))
    seen = _SEEN_STD_RAD * random.standard_normal(len(plan))
    points = []
    for number, (angle_cdeg, direction) in enumerate(zip(plan, arrivals(plan), strict=True)):
        if direction and setting.min_cdeg < angle_cdeg < setting.max_cdeg:
            pulse_us = board_pulse_us(setting, angle_cdeg)
            nominal = (
                pulses.reference_angle_rad + (pulse_us - pulses.reference_pulse_us) / pulses.pulse_us_per_rad
            )
            centred = truth.servo_offset_rad[index] + truth.servo_gain[index] * nominal
            reached = centred - direction * truth.servo_backlash_rad[index] / 2.0
            points.append(
                ServoPoint(pulse_us, direction, reached + scatter[number] + seen[number], _SEEN_STD_RAD)
            )
    return points
