"""Faults of servos, gyros, angle sensors and their calibration."""

from __future__ import annotations

from tfsat_host.emulated.emulated_certificate import careful_certificate
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.rehearsal.day import CALIBRATED, Day
from tfsat_host.rehearsal.faults.fault import (
    Fault,
    Moment,
    Outcome,
    at_any_moment,
    break_part,
    outcomes_between,
)

_ANOTHER_ROBOT_SEED = 4711


def _take_foreign_calibration(day: Day) -> None:
    day.calibration = careful_certificate(
        day.robot.model, draw_as_built(_ANOTHER_ROBOT_SEED), _ANOTHER_ROBOT_SEED, CALIBRATED
    )


def _servo_fault(how: str, what: str, noticed: str) -> Fault:
    return Fault(
        f"servo-{how}",
        f"The servo of joint 1 {what}.",
        Moment.LIFTED,
        outcomes_between(Moment.POWERED, Moment.BEFORE_LANDING, Outcome.FLIES),
        action=break_part("servo", 1, how),
        noticed=noticed,
        preflight=(),
        part="servo of joint 1",
    )


def _gyro_fault(how: str, what: str, *preflight: str) -> Fault:
    return Fault(
        f"gyro-{how}",
        what,
        Moment.LIFTED,
        at_any_moment(Outcome.FLIES),
        action=break_part("imu", 4, how),
        noticed="body 4",
        preflight=preflight,
        part="IMU of body 4",
    )


FAULTS = (
    _servo_fault("dead", "does not turn", "did not move"),
    _servo_fault("slow", "reaches a quarter of its rate", "had not come to rest"),
    _servo_fault("reversed", "turns the other way", "wrong way"),
    _gyro_fault("dead", "The IMU of body 4 does not respond.", "gyros-present"),
    _gyro_fault("frozen", "The IMU of body 4 repeats one reading.", "gyros-present"),
    Fault(
        "gyro-swapped",
        "The plugs of the IMUs of bodies 3 and 4 were exchanged after the calibration.",
        Moment.POWERED,
        at_any_moment(Outcome.FLIES),
        action=break_part("imu", 4, "swapped", 3),
        noticed="IMUs of bodies 3 and 4 exchanged",
        preflight=("gyros-agree",),
        part="IMU of body 4",
    ),
    _gyro_fault(
        "saturated", "The gyro of body 4 shows ten times its rate, and clips.", "gyro-biases", "gyros-agree"
    ),
    Fault(
        "bus-glitch",
        "A disturbance spoils one transfer with the IMU of body 4: at most one of its samples is lost.",
        Moment.FALLING,
        at_any_moment(Outcome.FLIES),
        action=break_part("glitch", 4),
        noticed="gave no value in 1 of",
        preflight=(),
        part="IMU of body 4",
    ),
    Fault(
        "bus-stuck",
        "The bus of the IMUs of bodies 3 and 4 is held low.",
        Moment.LIFTED,
        at_any_moment(Outcome.FLIES),
        action=break_part("bus", 2, True),
        noticed="body 3",
        preflight=("gyros-present",),
        part="bus of the IMUs of bodies 3 and 4",
    ),
    Fault(
        "angle-sensor-slipped",
        "The magnet of joint 1's first angle sensor slips by 200 deg and wraps.",
        Moment.LIFTED,
        at_any_moment(Outcome.FLIES),
        action=break_part("angle_sensor", 1, "turned", 200.0),
        noticed="joint 1",
        preflight=("joint-sensors",),
        part="first angle sensor of joint 1",
    ),
    Fault(
        "calibration-of-another-robot",
        "The calibration at hand is another robot's.",
        Moment.POWERED,
        at_any_moment(Outcome.FLIES),
        action=_take_foreign_calibration,
        noticed="it is not used",
        preflight=("gyros-agree", "joint-sensors", "start-pose", "calibration"),
        part="calibration",
    ),
)
