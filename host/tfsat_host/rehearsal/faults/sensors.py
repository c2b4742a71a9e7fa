"""Faults of servos, gyros, angle sensors and of their calibration."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.faults import ImuFault, ServoFault
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.rehearsal.day import CALIBRATED, Day
from tfsat_host.rehearsal.faults.fault import Fault, Outcome, at_any_moment
from tfsat_host.rehearsal.moment import Moment

ANOTHER_ROBOT = 4711
SLIPPED_DEG = 200.0


def _servo(day: Day, kind: ServoFault) -> None:
    day.robot.faults.servo(1, kind)


def _imu(day: Day, kind: ImuFault, other: int | None = None) -> None:
    day.robot.faults.imu(4, kind, other)


def _bus(day: Day) -> None:
    day.robot.faults.bus(2, stuck=True)


def _slipped(day: Day) -> None:
    day.robot.faults.angle_sensor(1, "turned", SLIPPED_DEG)


def _foreign_calibration(day: Day) -> None:
    day.calibration = careful_certificate(
        day.robot.model, draw_as_built(ANOTHER_ROBOT), ANOTHER_ROBOT, CALIBRATED
    )


def _flies(
    name: str,
    what: str,
    strike: Callable[[Day], None],
    noticed: str,
    morning: tuple[str, ...],
    moment: Moment = Moment.LIFTED,
) -> Fault:
    return Fault(name, what, moment, strike, at_any_moment(Outcome.FLIES), noticed=noticed, morning=morning)


SENSOR_FAULTS = (
    _flies(
        "servo-dead", "The servo of joint 1 does not turn.", partial(_servo, kind="dead"), "did not move", ()
    ),
    _flies(
        "servo-slow",
        "The servo of joint 1 reaches a quarter of its rate.",
        partial(_servo, kind="slow"),
        "had not come to rest",
        (),
    ),
    _flies(
        "servo-reversed",
        "The servo of joint 1 turns the other way.",
        partial(_servo, kind="reversed"),
        "wrong way",
        (),
    ),
    _flies(
        "gyro-dead",
        "The IMU of body 4 answers no more.",
        partial(_imu, kind="dead"),
        "body 4",
        ("gyros-present",),
    ),
    _flies(
        "gyro-frozen",
        "The IMU of body 4 gives the same numbers for ever.",
        partial(_imu, kind="frozen"),
        "body 4",
        ("gyros-present",),
    ),
    _flies(
        "gyro-swapped",
        "The plugs of the IMUs of bodies 3 and 4 were exchanged after the calibration.",
        partial(_imu, kind="swapped", other=3),
        "IMUs of bodies 3 and 4 exchanged",
        ("gyros-agree",),
        Moment.POWERED,
    ),
    _flies(
        "gyro-saturated",
        "The gyro of body 4 shows ten times its rate, and clips.",
        partial(_imu, kind="saturated"),
        "body 4",
        ("gyro-biases", "gyros-agree"),
    ),
    _flies(
        "bus-stuck",
        "The bus of the IMUs of bodies 3 and 4 is held low.",
        _bus,
        "body 3",
        ("gyros-present",),
    ),
    _flies(
        "angle-sensor-slipped",
        f"The magnet of joint 1's first angle sensor slips by {SLIPPED_DEG:g} deg and wraps.",
        _slipped,
        "joint 1",
        ("joint-sensors",),
    ),
    _flies(
        "calibration-of-another-robot",
        "The calibration at hand is another robot's.",
        _foreign_calibration,
        "it is not used",
        ("gyros-agree", "joint-sensors", "start-pose", "calibration"),
        Moment.POWERED,
    ),
)
