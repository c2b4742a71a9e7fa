"""Faults of servos, IMUs, angle sensors and their calibration."""

from __future__ import annotations

from collections.abc import Callable

from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.rehearsal.day import CALIBRATED, Day
from tfsat_host.rehearsal.fault import Fault, Moment, Outcome, broken, during

ANOTHER_ROBOT = 4711
SLIPPED_DEG = 200.0


def _foreign_calibration(day: Day) -> None:
    day.calibration = careful_certificate(
        day.robot.model, draw_as_built(ANOTHER_ROBOT), ANOTHER_ROBOT, CALIBRATED
    )


_IMU_4, _SERVO_1 = "IMU of body 4", "servo of joint 1"
_LAST = Moment.BEFORE_LANDING
"""After the landing no servo matters any more."""


def _flies(
    name: str,
    what: str,
    strike: Callable[[Day], object],
    noticed: str,
    preflight: tuple[str, ...],
    part: str,
    moment: Moment = Moment.LIFTED,
    last: Moment = Moment.LANDED,
) -> Fault:
    """A fault of a part that keeps no robot from flying, whenever it strikes until `last`."""
    outcomes = during(Moment.POWERED, last, Outcome.FLIES)
    return Fault(name, what, moment, strike, outcomes, noticed=noticed, preflight=preflight, part=part)


SENSOR_FAULTS = (
    _flies(
        "servo-dead",
        "The servo of joint 1 does not turn.",
        broken("servo", 1, "dead"),
        "did not move",
        (),
        _SERVO_1,
        last=_LAST,
    ),
    _flies(
        "servo-slow",
        "The servo of joint 1 reaches a quarter of its rate.",
        broken("servo", 1, "slow"),
        "had not come to rest",
        (),
        _SERVO_1,
        last=_LAST,
    ),
    _flies(
        "servo-reversed",
        "The servo of joint 1 turns the other way.",
        broken("servo", 1, "reversed"),
        "wrong way",
        (),
        _SERVO_1,
        last=_LAST,
    ),
    _flies(
        "gyro-dead",
        "The IMU of body 4 answers no more.",
        broken("imu", 4, "dead"),
        "body 4",
        ("gyros-present",),
        _IMU_4,
    ),
    _flies(
        "gyro-frozen",
        "The IMU of body 4 repeats one reading.",
        broken("imu", 4, "frozen"),
        "body 4",
        ("gyros-present",),
        _IMU_4,
    ),
    _flies(
        "gyro-swapped",
        "The plugs of the IMUs of bodies 3 and 4 were exchanged after the calibration.",
        broken("imu", 4, "swapped", 3),
        "IMUs of bodies 3 and 4 exchanged",
        ("gyros-agree",),
        _IMU_4,
        Moment.POWERED,
    ),
    _flies(
        "gyro-saturated",
        "The gyro of body 4 shows ten times its rate, and clips.",
        broken("imu", 4, "saturated"),
        "body 4",
        ("gyro-biases", "gyros-agree"),
        _IMU_4,
    ),
    _flies(
        "bus-glitch",
        "A disturbance spoils one transfer with the IMU of body 4: at most one of its samples is lost.",
        broken("glitch", 4),
        "",
        (),
        _IMU_4,
        Moment.FALLING,
    ),
    _flies(
        "bus-stuck",
        "The bus of the IMUs of bodies 3 and 4 is held low.",
        broken("bus", 2, True),
        "body 3",
        ("gyros-present",),
        "bus of the IMUs of bodies 3 and 4",
    ),
    _flies(
        "angle-sensor-slipped",
        f"The magnet of joint 1's first angle sensor slips by {SLIPPED_DEG:g} deg and wraps.",
        broken("angle_sensor", 1, "turned", SLIPPED_DEG),
        "joint 1",
        ("joint-sensors",),
        "first angle sensor of joint 1",
    ),
    _flies(
        "calibration-of-another-robot",
        "The calibration at hand is another robot's.",
        _foreign_calibration,
        "it is not used",
        ("gyros-agree", "joint-sensors", "start-pose", "calibration"),
        "calibration",
        Moment.POWERED,
    ),
)
