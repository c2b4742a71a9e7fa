"""Sensors that break while the logger records, as the decoded log and the logger's status tell it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.emulator.fault_bench import SEED, do_nothing, record
from tests.fixtures.emulated_drop import read_card, releaser
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.fault_injection import Faults
from tfsat_host.emulated.library import EmulationError
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.robot import load_robot

SWING_US = 1_000_000
BODIES = (1, 2, 3, 4)


def swing_joint(robot: EmulatedRobot) -> None:
    robot.hold([2, 3, 4])
    robot.swing(1, 60.0, 1.0, 1)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(
    ("kind", "error"), [("dead", ErrorCode.SENSOR_MISSING), ("frozen", ErrorCode.SENSOR_FROZEN)]
)
def test_an_imu_that_is_dead_or_frozen_is_invalid_and_the_others_are_not(
    body: int, kind: str, error: ErrorCode
) -> None:
    log, before, after = record(lambda robot: robot.faults.imu(body, kind))  # type: ignore[arg-type]
    assert log.imu_valid[before][50:].all()
    assert not log.imu_valid[after, body - 1].any()
    assert np.delete(log.imu_valid, body - 1, axis=1)[after].all()
    (event,) = [event for event in log.events if event.name == "sensor_fault" and event.index == body - 1]
    assert event.arg == error


def test_a_healed_imu_is_configured_anew_and_valid() -> None:
    for kind in ("dead", "frozen"):
        with releaser(seed=SEED) as (robot, _, logger):
            robot.faults.imu(2, kind)
            robot.advance(500_000)
            assert logger.status().imu_present == 0b1101
            robot.faults.imu(2, None)
            robot.advance(500_000)
            assert logger.status().imu_present == 0b1111


@pytest.mark.parametrize("kind", ["saturated", None])
def test_a_saturated_gyro_stands_at_its_end_in_a_motion_that_a_good_one_takes(kind: str | None) -> None:
    log, _, after = record(
        lambda robot: robot.faults.imu(1, kind),  # type: ignore[arg-type]
        swing_joint,
        then_us=SWING_US,
    )
    clipped = log.clipped[after]
    assert clipped[:, 0].any() == (kind == "saturated")
    assert not clipped[:, 1:].any()
    # In this swing the body turns at 100 deg/s and more: a fifth of the range.
    assert np.abs(log.imu_counts[after, 0, 4:7].astype(int)).max() > 6000
    assert log.imu_valid[after, 0].all()


def test_a_saturated_gyro_at_rest_shows_ten_times_its_bias() -> None:
    log, before, after = record(lambda robot: robot.faults.imu(3, "saturated"))
    bias = log.imu_counts[before, 2, 4:7][50:].mean(axis=0)
    assert log.imu_counts[after, 2, 4:7].mean(axis=0) == pytest.approx(10 * bias, abs=10)  # of rounded counts


@pytest.mark.parametrize("other", [2, 3, 4])
def test_swapped_imus_answer_in_each_others_place(other: int) -> None:
    swapped, _, after = record(
        lambda robot: robot.faults.imu(1, "swapped", other), swing_joint, then_us=SWING_US
    )
    straight, _, _ = record(do_nothing, swing_joint, then_us=SWING_US)
    moved = [
        np.ptp(log.imu_counts[after, :, 4:7].astype(int), axis=0).max(axis=1) for log in (swapped, straight)
    ]
    assert int(np.argmax(moved[0])) == other - 1
    assert int(np.argmax(moved[1])) == 0
    assert moved[0][0] < 0.1 * moved[0][other - 1]


def test_a_swap_is_undone_whichever_body_is_named() -> None:
    for healed in (1, 3):

        def there_and_back(robot: EmulatedRobot, healed: int = healed) -> None:
            robot.faults.imu(1, "swapped", 3)
            robot.faults.imu(healed, None)

        back, _, after = record(there_and_back, swing_joint, then_us=SWING_US)
        straight, _, _ = record(do_nothing, swing_joint, then_us=SWING_US)
        assert np.array_equal(back.imu_counts[after], straight.imu_counts[after])


@pytest.mark.parametrize("bus", [1, 2])
def test_a_stuck_bus_silences_its_two_imus_until_the_logger_loses_its_supply(bus: int) -> None:
    log, _, after = record(lambda robot: robot.faults.bus(bus, True))
    silent = slice(2 * bus - 2, 2 * bus)
    assert not log.imu_valid[after, silent].any()
    assert np.delete(log.imu_valid[after], [2 * bus - 2, 2 * bus - 1], axis=1).all()
    causes = {event.arg for event in log.events if event.name == "sensor_fault"}
    assert causes == {ErrorCode.BUS_STUCK}
    assert log.samples_lost == 0
    with releaser(seed=SEED) as (robot, _, logger):
        robot.faults.bus(bus, True)
        robot.advance(500_000)
        assert logger.status().imu_present == (0b1100 if bus == 1 else 0b0011)
        robot.set_power(BoardIndex.LOGGER, False)
        robot.set_power(BoardIndex.LOGGER, True)
        robot.advance(SETTLE_US)
        assert logger.status().imu_present == 0b1111


def test_a_stuck_bus_is_healed_without_a_power_cycle() -> None:
    with releaser(seed=SEED) as (robot, _, logger):
        robot.faults.bus(2, True)
        robot.advance(500_000)
        assert logger.status().imu_present == 0b0011
        robot.faults.bus(2, False)
        robot.advance(500_000)
        assert logger.status().imu_present == 0b1111


@pytest.mark.parametrize("sensor", [1, 2])
@pytest.mark.parametrize("kind", ["dead", "frozen", None])
def test_a_dead_angle_sensor_reads_zero_and_a_frozen_one_stands_still(sensor: int, kind: str | None) -> None:
    column, partner = sensor - 1, 2 - sensor
    log, _, after = record(
        lambda robot: robot.faults.angle_sensor(sensor, kind),  # type: ignore[arg-type]
        swing_joint,
        then_us=SWING_US,
    )
    counts = log.angle_counts[after].astype(int)
    assert np.ptp(counts[:, partner]) > 500
    assert (np.ptp(counts[:, column]) > 500) == (kind is None)
    assert (counts[:, column] == 0).all() == (kind == "dead")


@pytest.mark.parametrize("turned_deg", [-170.0, -8.0, 30.0, 120.0])
def test_a_slipped_magnet_shifts_its_sensor_round_the_turn_and_no_other(turned_deg: float) -> None:
    slipped, _, after = record(lambda robot: robot.faults.angle_sensor(4, "turned", turned_deg))
    straight, _, _ = record(do_nothing)
    shift = slipped.angle_counts[after].astype(int) - straight.angle_counts[after].astype(int)
    turned = np.rad2deg(np.unwrap(shift[:, 3] * 2 * np.pi / 4096)).mean() % 360
    assert turned == pytest.approx(turned_deg % 360, abs=0.1)
    assert not np.delete(shift, 3, axis=1).any()
    assert (slipped.angle_counts < 4096).all()


def test_a_slipped_magnet_can_make_the_sensor_wrap_within_its_joints_range() -> None:
    """Wrap a slipped sensor within its joint's range.

    Its zero is 10 deg before the end of the turn, or 10 deg after its beginning if it counts against the joint.
    """
    straight, before, _ = record(do_nothing)
    at_rest_deg = straight.angle_counts[before, 0].mean() * 360 / 4096
    near_end_deg = -10.0 * load_robot().angle_sensors[0].direction

    def slip(robot: EmulatedRobot) -> None:
        robot.faults.angle_sensor(1, "turned", near_end_deg - at_rest_deg)

    slipped, _, after = record(slip, swing_joint, then_us=SWING_US)
    healthy_log, _, _ = record(do_nothing, swing_joint, then_us=SWING_US)
    jumps = [np.abs(np.diff(log.angle_counts[after, 0].astype(int))).max() for log in (slipped, healthy_log)]
    assert jumps[0] > 4000 and jumps[1] < 100


@pytest.mark.parametrize(
    ("break_it", "reason"),
    [
        (lambda faults: faults.imu(5, "dead"), "no body 5: 1 to 4"),
        (
            lambda faults: faults.imu(1, "tired"),
            "no such fault of IMUs as 'tired': dead, frozen, saturated, swapped",
        ),
        (lambda faults: faults.imu(1, "swapped"), "swapped with that of another body"),
        (lambda faults: faults.imu(1, "swapped", 1), "swapped with that of another body"),
        (lambda faults: faults.imu(1, "dead", 2), "swapped with that of another body"),
        (lambda faults: faults.imu(1, "swapped", 0), "no body 0"),
        (lambda faults: faults.bus(3, True), "no bus 3: 1 to 2"),
        (lambda faults: faults.angle_sensor(7, "dead"), "no angle sensor 7"),
        (lambda faults: faults.angle_sensor(1, "turned"), "turned magnet has an angle"),
        (lambda faults: faults.angle_sensor(1, "turned", float("nan")), "turned magnet has an angle"),
        (lambda faults: faults.angle_sensor(1, "dead", 3.0), "turned magnet has an angle"),
        (lambda faults: faults.servo(4, "dead"), "no joint 4"),
        (lambda faults: faults.servo(1, "fast"), "no such fault of servos as 'fast': dead, slow, reversed"),
        (lambda faults: faults.switch(3, "stuck-open"), "no release switch 3"),
        (lambda faults: faults.switch(1, "stuck"), "no such fault of switches as 'stuck'"),
        (lambda faults: faults.bounce(0), "do not bounce for 0 us"),
        (lambda faults: faults.bounce(1_000_001), "do not bounce for"),
        (lambda faults: faults.card_stalls(0), "does not stall for 0 us"),
        (lambda faults: faults.card_stalls(1, -1), "does not stall for 1 us each -1 us"),
        (lambda faults: faults.clock("logger", 20_001.0), "cannot be off by 20001 ppm"),
        (lambda faults: faults.clock("logger", float("nan")), "cannot be off by nan ppm"),
        (lambda faults: faults.clock("robot", 1.0), "no board 'robot'"),
    ],
)
def test_what_does_not_exist_cannot_break(break_it: Callable[[Faults], object], reason: str) -> None:
    with EmulatedRobot(seed=1) as robot, pytest.raises(EmulationError, match=reason):
        break_it(robot.faults)


def test_what_heals_all_leaves_a_robot_that_records_as_if_nothing_had_been() -> None:
    def break_all(robot: EmulatedRobot) -> None:
        faults = robot.faults
        faults.imu(1, "swapped", 3)
        faults.imu(2, "saturated")
        faults.bus(2, True)
        faults.angle_sensor(1, "turned", 30.0)
        faults.angle_sensor(2, "dead")
        faults.servo(1, "dead")
        faults.switch(1, "stuck-open")
        faults.bounce(50_000)
        faults.card_stalls(400_000)
        faults.heal()

    mended, _, after = record(break_all, swing_joint, then_us=SWING_US)
    straight, _, _ = record(do_nothing, swing_joint, then_us=SWING_US)
    assert np.array_equal(mended.imu_counts[after], straight.imu_counts[after])
    assert np.array_equal(mended.angle_counts[after], straight.angle_counts[after])
    assert mended.samples_lost == 0


def test_the_log_of_a_broken_sensor_is_the_same_for_the_same_seed() -> None:
    cards = []
    for _ in range(2):
        with releaser(seed=SEED) as (robot, _, logger):
            logger.start_recording()
            robot.faults.imu(4, "saturated")
            robot.faults.card_stalls(100_000, 300_000)
            robot.advance(1_000_000)
            logger.stop_recording()
            cards.append(robot.card())
            assert read_card(robot).samples_lost == 0
    assert cards[0] == cards[1]
