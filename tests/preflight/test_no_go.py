"""One thing is wrong with the robot, and one check turns red: that one, and no other.

What cannot be looked at for that reason is said to be not made, which is as good as NO-GO.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from typing import Any

import numpy as np
import pytest

from tests.preflight.ready_robot import MANEUVER, ReadyRobot, check, found_wrong, not_made
from tfsat_host.calibration.certificate.certificate import Landing
from tfsat_host.devices.logger_configuration import FACTORY
from tfsat_host.emulated.emulated_robot import BoardIndex, Reset
from tfsat_host.emulated.fault_injection import CardDefect
from tfsat_host.emulated.manual_motion import Leg, Motion, Operator
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.servo_settings import FACTORY as SERVOS

# Without a usable card these cannot be made.
AFTER_CARD = {"card-room", "card-writing"}
OLDER_SLOT = 1
FREE_BLOCKS = 2048 * 100
"""100 MiB, of which one recording takes 32."""

Break = Callable[[ReadyRobot], object]


def stale(ready: ReadyRobot) -> None:
    landed = Landing(ready.calibration.written + timedelta(minutes=30), "recording 1a2b3c4d")
    ready.certify(replace(ready.calibration, landings=(landed,)))


def without_a_servo(ready: ReadyRobot) -> None:
    calibration = ready.calibration
    ready.certify(
        replace(
            calibration,
            servo_maps=tuple(servo_map for servo_map in calibration.servo_maps if servo_map.joint != 2),
        )
    )


def without_a_scale(ready: ReadyRobot) -> None:
    gyros = ready.calibration.gyros
    ready.certify(replace(ready.calibration, gyros=(replace(gyros[0], scaled={}), *gyros[1:])))


def of_another_kind_of_imu(ready: ReadyRobot) -> None:
    subject = replace(ready.calibration.subject, who_am_i="70686868")
    ready.certify(replace(ready.calibration, subject=subject))


def move_joint(joint: int, degrees: float) -> Break:
    def act(ready: ReadyRobot) -> None:
        leg = Leg(np.deg2rad(degrees), 1.0)
        motion = Motion((leg,), Operator.steady(), 1)
        ready.robot.operator.move_joint(joint, motion)
        ready.robot.advance(round(1e6 * motion.duration_s) + 500_000)

    return act


def servo_limit(ready: ReadyRobot) -> None:
    first, *others = SERVOS.servos
    ready.sequencer().write_settings(replace(SERVOS, servos=(replace(first, max_cdeg=5000), *others)))


def fly_unrecorded(ready: ReadyRobot) -> None:
    """Armed and dropped, nothing recorded; back in the releaser with its servos on."""
    ready.sequencer().arm()
    ready.robot.drop()
    while ready.robot.falling:
        ready.robot.advance(10_000)
    ready.robot.advance(1_000_000)
    ready.robot.seat()
    ready.robot.advance(1_000_000)


def latched_fault(ready: ReadyRobot) -> None:
    """It restarted while armed, with a switch open; a press on its button since tells of no bad supply."""
    ready.sequencer().arm()
    ready.robot.set_switch(1, False)
    ready.robot.advance(100_000)
    ready.robot.reset(Reset.BUTTON)
    ready.robot.advance(3_000_000)
    ready.robot.set_switch(1, True)
    ready.robot.advance(100_000)


def damaged_store(ready: ReadyRobot) -> None:
    """Flip a bit of the older of the maneuver's two slots (128 bytes each, from 512) during a power-off."""
    robot = ready.robot
    # The second upload fills the other slot, so the damaged one is the older.
    for maneuver in (four_stroke(40.0, 50.0), MANEUVER):
        ready.sequencer().upload(schedule_maneuver(maneuver))
    robot.set_power(BoardIndex.SEQUENCER, False)
    image = bytearray(robot.eeprom())
    image[512 + OLDER_SLOT * 128 + 30] ^= 1
    robot._library.tfsat_eeprom_set(robot._robot, bytes(image), len(image))
    robot.set_power(BoardIndex.SEQUENCER, True)
    robot.advance(3_000_000)
    # Bit 0: the maneuver's store.
    assert ready.sequencer().status().stores_damaged & 1


def restart_board(cause: Reset) -> Break:
    def act(ready: ReadyRobot) -> None:
        ready.robot.reset(cause)
        ready.robot.advance(3_000_000)

    return act


def imu(*arguments: Any) -> Break:
    return lambda ready: ready.robot.faults.imu(*arguments)


def angle_sensor(*arguments: Any) -> Break:
    return lambda ready: ready.robot.faults.angle_sensor(*arguments)


def settle(act: Break) -> Break:
    """Let the robot run on after `act`: the logger looks at its card every two seconds."""

    def act_and_settle(ready: ReadyRobot) -> None:
        act(ready)
        ready.robot.advance(5_000_000)

    return act_and_settle


def clock(board: Any, ppm: float) -> Break:
    return lambda ready: ready.robot.faults.clock(board, ppm)


def clock_set(seconds: float | None) -> Break:
    return lambda ready: setattr(ready, "set_clock", seconds)


def logger_settings(**changed: int) -> Break:
    return lambda ready: ready.logger().write_settings(replace(FACTORY, **changed))


def future_certificate(ready: ReadyRobot) -> None:
    ready.certify(replace(ready.calibration, written=ready.calibration.written + timedelta(days=2)))


FAULTS: dict[str, tuple[Break, str, set[str]]] = {
    # Each fault: what breaks, which check finds it, which checks cannot be made then.
    "store damaged": (damaged_store, "sequencer-state", set()),
    "flown": (fly_unrecorded, "sequencer-state", set()),
    "fault latched": (latched_fault, "sequencer-state", set()),
    "brown-out": (restart_board(Reset.BROWN_OUT), "restarts", set()),
    "watchdog": (restart_board(Reset.WATCHDOG), "restarts", set()),
    "other maneuver": (
        lambda ready: ready.sequencer().upload(schedule_maneuver(four_stroke(40.0, 50.0))),
        "maneuver",
        set(),
    ),
    "servo limits": (servo_limit, "servo-limits", set()),
    "switch open": (lambda ready: ready.robot.set_switch(2, False), "switches", set()),
    "switch stuck open": (lambda ready: ready.robot.faults.switch(1, "stuck-open"), "switches", set()),
    "gyro dead": (imu(2, "dead"), "gyros-present", set()),
    "gyro frozen": (imu(3, "frozen"), "gyros-present", set()),
    "bus stuck low": (lambda ready: ready.robot.faults.bus(2, True), "gyros-present", set()),
    "gyros swapped": (imu(1, "swapped", 3), "gyros-agree", set()),
    "angle sensor dead": (angle_sensor(3, "dead"), "joint-sensors", set()),
    "angle sensor frozen": (angle_sensor(1, "frozen"), "joint-sensors", set()),
    "magnet slipped": (angle_sensor(6, "turned", 5.0), "joint-sensors", set()),
    "joint open": (move_joint(2, 15.0), "start-pose", set()),
    "card unreadable": (
        settle(lambda ready: ready.robot.card_slot.spoil(CardDefect.UNREADABLE)),
        "card",
        AFTER_CARD,
    ),
    "landed since": (stale, "calibration", set()),
    "servo not calibrated": (without_a_servo, "calibration", set()),
    "gyro not calibrated": (without_a_scale, "calibration", set()),
    "other IMU": (of_another_kind_of_imu, "calibration", set()),
    "no card": (settle(lambda ready: ready.robot.card_slot.remove()), "card", AFTER_CARD),
    "card write-protected": (
        settle(lambda ready: ready.robot.card_slot.spoil(CardDefect.WRITE_PROTECTED)),
        "card",
        AFTER_CARD,
    ),
    "card full": (settle(lambda ready: ready.robot.card_slot.fill(FREE_BLOCKS)), "card-room", set()),
    "card slow": (
        lambda ready: ready.robot.faults.card_stalls(700_000, 2_000_000),
        "card-writing",
        set(),
    ),
    "gyro range": (logger_settings(gyro_range_deg_s=250), "logger-settings", set()),
    "slow rate": (settle(logger_settings(rate_hz=50)), "logger-settings", set()),
    "clock not set": (clock_set(None), "clock", set()),
    "clock wrong": (clock_set(-3600.0), "clock", set()),
    "certificate of the future": (future_certificate, "clock", set()),
    "sequencer 1 % fast": (clock("sequencer", 10_000.0), "clock-pace", set()),
    "logger 1 % slow": (clock("logger", -10_000.0), "clock-pace", set()),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_turns_its_check_red_and_no_other(ready: ReadyRobot, fault: str) -> None:
    act, red, in_the_dark = FAULTS[fault]
    act(ready)
    result = ready.preflight(expect=4)
    assert result["verdict"] == "no-go"
    assert found_wrong(result) == {red}, [check(result, name)["sentence"] for name in found_wrong(result)]
    assert not_made(result) == in_the_dark
    assert check(result, red)["next_step"]


def test_two_checks_tell_of_a_gyro_that_lost_its_gain(
    ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ten times its bias is more than the data sheet allows, and not what the others say."""
    monkeypatch.setattr(
        "tfsat_host.preflight.logger_queries.WATCH_S", 6.0
    )  # its noise is ten times as much, too
    ready.robot.faults.imu(4, "saturated")
    result = ready.preflight(expect=4)
    assert found_wrong(result) == {"gyro-biases", "gyros-agree"}
    assert "body 4" in check(result, "gyros-agree")["sentence"]
