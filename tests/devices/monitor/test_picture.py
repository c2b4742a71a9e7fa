"""The monitor's picture in terminals of several sizes: nothing wider, nothing higher, alarms first."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace

import pytest
from rich.console import Console

from tfsat_host.devices.client import Client
from tfsat_host.devices.monitoring import WatchedBoards
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.present.monitor_view import Picture, one_line
from tfsat_host.protocol.enums import ErrorCode, LoggerState, SequencerState
from tfsat_host.robot import load_robot


@pytest.fixture
def picture() -> Iterator[Picture]:
    """Yield a picture of both boards at rest."""
    with EmulatedRobot() as robot:
        robot.advance(SETTLE_US)
        clients = [Client(EmulatedTransport(robot, board)) for board in BoardIndex]
        watched = WatchedBoards(clients[0].transport.now_s)
        for client in clients:
            watched.add(client, load_robot(None).angle_sensors)
        assert watched.logger is not None
        watched.logger.update(clients[1].transport.now_s() + 0.1)
        yield Picture(watched)


def draw_picture(picture: Picture, width: int, height: int) -> list[str]:
    stream = io.StringIO()
    Console(file=stream, width=width, height=height, no_color=True, legacy_windows=False).print(picture)
    lines = stream.getvalue().splitlines()
    assert len(lines) < height
    assert all(len(line) <= width for line in lines)
    return lines


def add_troubles(picture: Picture) -> Picture:
    """Return a picture with a fault, a refusal, a failed card, a missing gyro and a clipped one."""
    sequencer, logger = picture.watched.sequencer, picture.watched.logger
    assert sequencer is not None and logger is not None and logger.reading is not None
    sequencer.status = replace(
        sequencer.status,
        state=SequencerState.FAULT,
        fault=ErrorCode.RESET_WHILE_ARMED,
        last_refusal=ErrorCode.SWITCH_OPEN,
        resets_while_armed=1,
        switches_open=2,
    )
    logger.status = replace(
        logger.status,
        state=LoggerState.FAILED,
        error=ErrorCode.CARD_WRITE_FAILED,
        session=7,
        samples_dropped=3,
    )
    bodies = list(logger.reading.bodies)
    bodies[1], bodies[2] = replace(bodies[1], valid=False), replace(bodies[2], clipped=True)
    logger.reading = replace(logger.reading, bodies=tuple(bodies))
    return picture


def test_at_80x24_all_readings_are_shown(picture: Picture) -> None:
    text = "\n".join(draw_picture(picture, 80, 24))
    for words in (
        "sequencer  safe; switches 1 closed, 2 closed",
        "last refusal  none",
        "commanded     limp",
        "logger     idle; switches 1 closed, 2 closed",
        "280 Hz set",
        "joint angle/deg read/deg sensor",
        "uncalibrated",
    ):
        assert words in text
    assert text.splitlines()[-1] == "Ctrl-C ends it."


@pytest.mark.parametrize(("width", "height"), [(80, 24), (120, 40)])
def test_alarms_stand_at_the_top_with_their_words(picture: Picture, width: int, height: int) -> None:
    lines = draw_picture(add_troubles(picture), width, height)
    text = " ".join(" ".join(lines).split())
    assert lines[0].startswith("SEQUENCER FAULT: The board restarted while it was armed")
    for words in (
        "seat the robot and arm again.",
        "RESTARTS: the sequencer restarted 1 x while armed.",
        "LOGGER ERROR: ",
        "DROPPED: 3 samples of the recording.",
        "MISSING: gyro 2.",
        "CLIPPED: gyro 3.",
        "sequencer fault: reset while armed; switches 1 closed, 2 OPEN",
        "logger failed",
        "body x / deg/s",
    ):
        assert words in text
    assert lines[-1] == "Ctrl-C ends it."
    if height == 40:
        assert "last refusal switch open: A release switch is open." in text
        assert "firmware" in text and "uncalibrated" in text


def test_an_imu_that_answers_and_does_not_measure_is_told_by_its_name(picture: Picture) -> None:
    logger = add_troubles(picture).watched.logger
    assert logger is not None
    logger.status = replace(logger.status, imu_present=0b1101)
    text = "\n".join(draw_picture(picture, 80, 40))
    assert "NOT MEASURING: gyro 2 (MPU-6050)." in text
    assert "MISSING" not in text and "NO DATA" in text
    assert "2 NOT MEASURING (MPU-6050); 3" in one_line(0.0, picture.watched)
    logger.status = replace(logger.status, who_am_i=b"\x68\0\x68\x68")
    text = "\n".join(draw_picture(picture, 80, 40))
    assert "MISSING: gyro 2." in text and "NOT MEASURING" not in text
    assert "2 MISSING; 3" in one_line(0.0, picture.watched)


def test_a_low_terminal_keeps_alarms_states_and_the_way_out(picture: Picture) -> None:
    lost = PortError(PortProblem.LOST, what="The connection on robot/logger was lost.", next_step="")
    without_logger = replace(picture.watched, logger=None, lost={"logger": lost})
    lines = draw_picture(Picture(without_logger), 80, 6)
    assert lines[0] == "LOST: logger. The connection on robot/logger was lost. Waiting for it."
    assert lines[1] == "sequencer  safe; switches 1 closed, 2 closed"
    assert lines[-1] == "Ctrl-C ends it."


def test_what_does_not_fit_at_all_is_cut_below_the_alarms(picture: Picture) -> None:
    lines = draw_picture(add_troubles(picture), 80, 5)
    assert lines[0].startswith("SEQUENCER FAULT")
    assert len(lines) == 4 and lines[-1] == "Ctrl-C ends it."
