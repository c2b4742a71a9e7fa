"""Faults of servos, gyros, angle sensors and of their calibration."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.faults import ImuFault, ServoFault
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.rehearsal.day import CALIBRATED, Day
from tfsat_host.rehearsal.faults.fault import Fault, Outcome, at_any_moment, during
from tfsat_host.rehearsal.moment import Moment

ANOTHER_ROBOT = 4711
SLIPPED_DEG = 200.0


def _servo(day: Day, kind: ServoFault) -> None:
    day.robot.faults.servo(1, kind)


def _imu(day: Day, kind: ImuFault, other: int | None = None) -> None:
    day.robot.faults.imu(4, kind, other)


def _glitch(day: Day) -> None:
    day.robot.faults.glitch(4)


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
    part: str,
    moment: Moment = Moment.LIFTED,
) -> Fault:
    outcomes = at_any_moment(Outcome.FLIES)
    return Fault(name, what, moment, strike, outcomes, noticed=noticed, morning=morning, part=part)


def _servo_flies(name: str, what: str, kind: ServoFault, noticed: str) -> Fault:
    """After the landing no servo matters any more."""
    return Fault(
        name,
        what,
        Moment.LIFTED,
        partial(_servo, kind=kind),
        during(Moment.POWERED, Moment.BEFORE_LANDING, Outcome.FLIES),
        noticed=noticed,
        morning=(),
        part="servo of joint 1",
    )


SENSOR_FAULTS = (
    _servo_flies("servo-dead", "The servo of joint 1 does not turn.", "dead", "did not move"),
    _servo_flies(
        "servo-slow", "The servo of joint 1 reaches a quarter of its rate.", "slow", "had not come to rest"
    ),
    _servo_flies("servo-reversed", "The servo of joint 1 turns the other way.", "reversed", "wrong way"),
    _flies(
        "gyro-dead",
        "The IMU of body 4 answers no more.",
        partial(_imu, kind="dead"),
        "body 4",
        ("gyros-present",),
        "IMU of body 4",
    ),
    _flies(
        "gyro-frozen",
        "The IMU of body 4 gives the same numbers for ever.",
        partial(_imu, kind="frozen"),
        "body 4",
        ("gyros-present",),
        "IMU of body 4",
    ),
    _flies(
        "gyro-swapped",
        "The plugs of the IMUs of bodies 3 and 4 were exchanged after the calibration.",
        partial(_imu, kind="swapped", other=3),
        "IMUs of bodies 3 and 4 exchanged",
        ("gyros-agree",),
        "IMU of body 4",
        Moment.POWERED,
    ),
    _flies(
        "gyro-saturated",
        "The gyro of body 4 shows ten times its rate, and clips.",
        partial(_imu, kind="saturated"),
        "body 4",
        ("gyro-biases", "gyros-agree"),
        "IMU of body 4",
    ),
    _flies(
        "bus-glitch",
        "A disturbance spoils one transfer with the IMU of body 4: at most one of its samples is lost.",
        _glitch,
        "",
        (),
        "IMU of body 4",
        Moment.FALLING,
    ),
    _flies(
        "bus-stuck",
        "The bus of the IMUs of bodies 3 and 4 is held low.",
        _bus,
        "body 3",
        ("gyros-present",),
        "bus of the IMUs of bodies 3 and 4",
    ),
    _flies(
        "angle-sensor-slipped",
        f"The magnet of joint 1's first angle sensor slips by {SLIPPED_DEG:g} deg and wraps.",
        _slipped,
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
