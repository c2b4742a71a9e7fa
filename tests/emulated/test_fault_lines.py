"""Control lines that break the served robot, as its boards' status and its motion show it."""

from __future__ import annotations

import pytest

from tests.emulated.test_control import Person
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.server import RobotServer


@pytest.mark.parametrize(
    ("line", "present"),
    [
        ("fault imu 2 dead", 0b1101),
        # Bit 2 is IMU 3: a frozen one answers, but is not present.
        ("fault imu 3 frozen", 0b1011),
        ("fault imu 1 saturated", 0b1111),
        ("fault imu 1 swapped 4", 0b1111),
        ("fault bus 2 stuck", 0b0011),
        ("FAULT IMU 2 Dead", 0b1101),
    ],
)
def test_sensors_break_and_heal_by_a_line(server: RobotServer, line: str, present: int) -> None:
    person = Person(server)
    server.robot.advance(SETTLE_US)
    logger = LoggerClient.connect(EmulatedTransport(server.robot, BoardIndex.LOGGER))
    assert person(line) == "ok"
    # Half a second: the logger has noticed.
    server.robot.advance(500_000)
    assert logger.status().imu_present == present
    assert person("fault none") == "ok"
    server.robot.advance(500_000)
    assert logger.status().imu_present == 0b1111


@pytest.mark.parametrize(
    ("line", "open_switches"), [("fault switch 1 stuck-open", 0b01), ("release 2", 0b10)]
)
def test_a_stuck_switch_is_what_both_boards_see(server: RobotServer, line: str, open_switches: int) -> None:
    person = Person(server)
    server.robot.advance(SETTLE_US)
    logger = LoggerClient.connect(EmulatedTransport(server.robot, BoardIndex.LOGGER))
    assert person(line) == "ok"
    server.robot.advance(100_000)
    assert logger.status().switches_open == open_switches
    assert person("fault switch 1 none") == "ok"
    assert person("fault switch 2 stuck-closed") == "ok"
    server.robot.advance(100_000)
    assert logger.status().switches_open == 0


def test_each_line_is_the_call_that_it_says(server: RobotServer, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[tuple[object, ...]] = []
    for name in (
        "imu",
        "angle_sensor",
        "battery",
        "servo",
        "switch",
        "bounce",
        "card_stalls",
        "clock",
        "heal",
    ):

        def note(*values: object, name: str = name) -> None:
            calls.append((name, *values))

        # The call itself is noted; what it does to the robot is another test's.
        monkeypatch.setattr(server.robot.faults, name, note)
    person = Person(server)
    for line in (
        "fault imu 1 none",
        "fault angle 3 turned -30.5",
        "fault angle 6 dead",
        "fault servo 2 slow",
        "fault battery 0.7",
        "fault battery none",
        "fault bounce 50ms",
        "fault bounce none",
        "fault card 400ms",
        "fault card 0.4 100ms",
        "fault card none",
        "fault clock sequencer 10000",
        "fault clock logger -35.5",
        "fault none",
    ):
        assert person(line) == "ok"
    assert calls == [
        ("imu", 1, None, None),
        ("angle_sensor", 3, "turned", -30.5),
        ("angle_sensor", 6, "dead"),
        ("servo", 2, "slow"),
        ("battery", 0.7),
        ("battery", None),
        ("bounce", 50_000),
        ("bounce", None),
        # Without a distance: the next stall 2 s later.
        ("card_stalls", 400_000, 2_000_000),
        ("card_stalls", 400_000, 100_000),
        ("card_stalls", None, 2_000_000),
        ("clock", "sequencer", 10_000.0),
        ("clock", "logger", -35.5),
        ("heal",),
    ]
