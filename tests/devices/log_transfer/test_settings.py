"""The logger's settings, from the host to the header of a recording."""

from __future__ import annotations

from dataclasses import fields, replace

import pytest

from tests.devices.log_transfer.bench import Bench
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.logger_configuration import bus_arithmetic, check, rate_max_hz
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.errors import UsageError
from tfsat_host.protocol.enums import ErrorCode, Origin
from tfsat_host.protocol.messages import LoggerSettings
from tfsat_host.sdlog import load

FACTORY = LoggerSettings(280, 500, 16, 3, 400, 30, 32)
OTHER = LoggerSettings(1000, 2000, 8, 2, 400, 60, 8)
WRONG = {
    "rate_hz": (9, 1001),
    "gyro_range_deg_s": (0, 251, 4000),
    "accel_range_g": (0, 3, 32),
    "dlpf_cfg": (7,),
    "bus_khz": (200, 1000),
    "after_landing_s": (4, 601),
    "file_mib": (0, 1025),
}


def test_a_new_board_has_the_factorys(bench: Bench) -> None:
    stored = bench.logger.settings()
    assert (stored.settings, stored.origin, stored.rate_max_hz) == (FACTORY, Origin.FACTORY, 1000)


def test_what_was_stored_stands_in_the_header_and_outlasts_the_power(bench: Bench) -> None:
    stored = bench.logger.write_settings(OTHER)
    assert (stored.settings, stored.origin) == (OTHER, Origin.UPLOADED)
    # Off and on: what was written must come from EEPROM.
    bench.robot.set_power(BoardIndex.LOGGER, False)
    bench.robot.set_power(BoardIndex.LOGGER, True)
    bench.wait(0.5)
    assert bench.logger.settings() == stored
    bench.record(0.5)
    path = bench.folder / "DROP0001.BIN"
    path.write_bytes(bench.robot.card())
    log = load(path)
    header = log.header
    assert (header.rate_hz, header.gyro_range_deg_s, header.accel_range_g) == (1000, 2000, 8)
    assert (header.dlpf_cfg, header.bus_khz, header.after_landing_s) == (2, 400, 60)
    assert log.rate_hz == pytest.approx(1000)
    assert log.verdict == "complete"


def test_another_robot_with_the_same_memory_has_them(bench: Bench) -> None:
    bench.logger.write_settings(OTHER)
    # The memory alone, without the board's own RAM.
    with EmulatedRobot(logger_memory=bench.robot.logger_memory()) as robot:
        robot.advance(SETTLE_US)
        other = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        assert other.settings().settings == OTHER


@pytest.mark.parametrize(("name", "value"), [(name, value) for name in WRONG for value in WRONG[name]])
def test_host_and_board_refuse_the_same(bench: Bench, name: str, value: int) -> None:
    wrong = replace(FACTORY, **{name: value})
    with pytest.raises(UsageError, match=str(value)):
        check(wrong)
    with pytest.raises(BoardError) as refused:
        bench.logger.write_settings(wrong)
    assert refused.value.code == ErrorCode.LOGGER_SETTING_OUT_OF_RANGE
    # Which setting it was, by its place in the message.
    assert refused.value.detail == [field.name for field in fields(LoggerSettings)].index(name)
    assert f"({name})" in refused.value.what
    assert bench.logger.settings().settings == FACTORY


@pytest.mark.parametrize("bus_khz", [100, 400])
def test_host_and_board_agree_on_what_the_buses_carry(bench: Bench, bus_khz: int) -> None:
    # The bus's arithmetic of the host is the board's own.
    most = rate_max_hz(bus_khz)
    fits = replace(FACTORY, bus_khz=bus_khz, rate_hz=most)
    check(fits)
    assert bench.logger.write_settings(fits).rate_max_hz == most
    if most < 1000:
        too_fast = replace(fits, rate_hz=most + 1)
        with pytest.raises(BoardError) as refused:
            bench.logger.write_settings(too_fast)
        assert (refused.value.code, refused.value.detail) == (ErrorCode.RATE_TOO_HIGH, most)
        assert f"(at most {most} Hz)" in refused.value.what
        with pytest.raises(UsageError, match=f"so at most {most} Hz") as too_high:
            check(too_fast)
        assert f"--rate {most}" in too_high.value.next_step


def test_the_arithmetic_is_shown() -> None:
    assert bus_arithmetic(1000, 100) == (
        "1000 Hz leaves 1000 us; two 14-byte bursts of 156 bits take 2 x 1560 us at 100 kHz, plus 410 us kept for "
        "what else a sensor takes: 3530 us, so at most 283 Hz"
    )


def test_they_are_refused_while_it_records(bench: Bench) -> None:
    bench.logger.start_recording()
    with pytest.raises(BoardError) as refused:
        bench.logger.write_settings(OTHER)
    assert refused.value.code == ErrorCode.WRONG_STATE
    assert bench.logger.settings().settings == FACTORY
