"""The emulated Arduino Micro against the ATmega32U4's datasheet, with a sketch made for it."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.fixtures.sequencer.board import AvrBoard, Edge, ResetCause

TICK_NS = 500
POWER_ON, EXTERNAL, BROWN_OUT, WATCHDOG = 1, 2, 4, 8


def ask(board: AvrBoard, command: bytes, reply_bytes: int) -> bytes:
    assert board.write(command) == len(command)
    return board.read_exactly(reply_bytes)


def counters(board: AvrBoard) -> tuple[int, int, int]:
    timer1, timer3, reset_flags = struct.unpack("<HHB", ask(board, b"n", 5))
    return timer1, timer3, reset_flags


def captures(board: AvrBoard) -> tuple[int, int, int, int]:
    count, first, second, levels = struct.unpack("<BHHB", ask(board, b"c", 6))
    return count, first, second, levels


def test_bytes_come_back_in_order(probe: AvrBoard) -> None:
    payload = bytes(range(256))
    probe.write(b"".join(b"e" + bytes([value]) for value in payload))
    # All values, the framing's zero and 255 too.
    assert probe.read_exactly(256) == payload


def test_both_timers_started_together(probe: AvrBoard) -> None:
    timer1, timer3, reset_flags = counters(probe)
    assert (timer3 - timer1) % 65536 <= 2  # the reads are a few cycles apart
    assert reset_flags == POWER_ON


@pytest.mark.parametrize("channel", [0, 1, 2])
@pytest.mark.parametrize("width", [1000, 5000])
def test_pulse_is_exact_to_the_tick(probe: AvrBoard, channel: int, width: int) -> None:
    """Pulses at counts 20000 ticks apart rise exactly that far apart, and each is `width` long."""
    rises = []
    for at in (10000, 30000):
        probe.write(b"p" + struct.pack("<BHH", channel, at, width))
        probe.run(70_000)
        rise, fall = probe.edges()
        assert (rise.pin, rise.high, fall.pin, fall.high) == (channel, True, channel, False)
        assert fall.t_ns - rise.t_ns == width * TICK_NS
        rises.append(rise.t_ns)
    # Modulo the timer: it wraps once every 33 ms.
    assert (rises[1] - rises[0]) % (65536 * TICK_NS) == 20000 * TICK_NS


def test_three_pulses_at_the_same_tick(probe: AvrBoard) -> None:
    for channel in range(3):
        probe.write(b"p" + struct.pack("<BHH", channel, 40000, 3000))
        probe.run(1000)
    probe.run(70_000)
    edges = probe.edges()
    assert sorted(edge.pin for edge in edges if edge.high) == [0, 1, 2]
    # Compare matches of one timer: not even a cycle apart.
    assert len({edge.t_ns for edge in edges if edge.high}) == 1
    assert len({edge.t_ns for edge in edges if not edge.high}) == 1


@pytest.mark.parametrize("index", [0, 1])
def test_capture_stamps_the_switch_edge(probe: AvrBoard, index: int) -> None:
    """Captured counts agree with a compare match of the same timer, to the tick."""
    probe.write(b"p" + struct.pack("<BHH", 0, 1000, 2000))
    probe.run(70_000)
    rise = probe.edges()[0]
    before, *_ = captures(probe)
    probe.run_to(probe.now_us + 12_345)
    opened_ns = probe.now_us * 1000
    probe.switch(index, closed=False)
    probe.run(1000)
    count, *stamps, levels = captures(probe)
    assert count == before + 1
    assert levels == 1 << index
    expected = 1000 + (opened_ns - rise.t_ns) // TICK_NS
    assert (stamps[index] - expected) % 65536 <= 1  # the noise canceler takes four cycles


def test_closing_is_not_captured_on_the_rising_edge(probe: AvrBoard) -> None:
    probe.switch(0, closed=False)
    probe.run(1000)
    before, *_ = captures(probe)
    probe.switch(0, closed=True)
    probe.run(1000)
    assert captures(probe)[0] == before


def test_an_eeprom_write_takes_3400_us(probe: AvrBoard) -> None:
    probe.write(b"w" + struct.pack("<HB", 300, 0x5A))
    # 2.5 ms: the write is still under way, and the cell reads as erased.
    probe.run(2500)
    assert probe.eeprom()[300] == 0xFF
    assert probe.eeprom_writes == 1
    assert ask(probe, b"b", 1) == b"\x01"
    probe.run(2000)
    assert ask(probe, b"b", 1) == b"\x00"
    assert probe.eeprom()[300] == 0x5A
    assert ask(probe, b"r" + struct.pack("<H", 300), 1) == b"\x5a"


def test_a_power_cut_keeps_what_was_written_and_tears_the_byte_under_way(probe: AvrBoard) -> None:
    probe.set_eeprom(bytes([0x11]) * 1024)
    for address in (10, 11):
        probe.write(b"w" + struct.pack("<HB", address, 0x22))
        probe.run(6000)
    probe.write(b"w" + struct.pack("<HB", 12, 0x22))
    while probe.eeprom_writes < 3:
        probe.run(50)
    probe.run(1000)
    probe.power(False)
    probe.run(10_000)
    # Two whole bytes, one torn to 0xFF, its neighbours untouched.
    assert probe.eeprom()[9:14] == bytes([0x11, 0x22, 0x22, 0xFF, 0x11])


def test_a_reset_lets_the_eeprom_write_end(probe: AvrBoard) -> None:
    probe.write(b"w" + struct.pack("<HB", 12, 0x22))
    while probe.eeprom_writes < 1:
        probe.run(50)
    probe.reset(ResetCause.BROWN_OUT)
    # The EEPROM's own timer runs on through a brown-out reset.
    probe.run(4000)
    assert probe.eeprom()[12] == 0x22


def test_power_off_ends_a_pulse(probe: AvrBoard) -> None:
    probe.write(b"p" + struct.pack("<BHH", 1, 20000, 30000))
    edges: list[Edge] = []
    while not edges:
        probe.run(100)
        edges = probe.edges()
    probe.power(False)
    # The pin falls with the supply, in the middle of its pulse.
    assert probe.edges() == [Edge(probe.now_us * 1000, 1, False)]


@pytest.mark.parametrize(
    ("cause", "flag"),
    [
        (ResetCause.WATCHDOG, WATCHDOG),
        (ResetCause.BROWN_OUT, BROWN_OUT),
        (ResetCause.EXTERNAL, EXTERNAL),
    ],
)
def test_reset_causes(probe: AvrBoard, cause: ResetCause, flag: int) -> None:
    probe.reset(cause)
    probe.connect()
    assert counters(probe)[2] == flag


def test_a_program_that_hangs_is_reset_by_its_watchdog(probe: AvrBoard) -> None:
    probe.write(b"x")
    # Just short of the watchdog's second.
    probe.run(900_000)
    assert probe.link_ready
    probe.run(200_000)
    probe.connect()
    assert counters(probe)[2] == WATCHDOG


def test_unplugging_loses_bytes_and_replugging_enumerates_again(probe: AvrBoard) -> None:
    probe.cable(False)
    # Without a cable nothing is taken.
    assert probe.write(b"e1") == 0
    probe.run(50_000)
    assert not probe.link_ready
    probe.connect()
    assert ask(probe, b"e2", 1) == b"2"


def test_the_1200_baud_touch_resets_the_board(probe: AvrBoard) -> None:
    """Make the sketch hang after the touch, so that the core's 120 ms watchdog resets the board.

    The core only arms the watchdog, and this sketch would keep feeding it.
    """
    probe.port(True, 1200)
    probe.run(10_000)
    probe.write(b"x")
    probe.run(2000)
    probe.port(False, 1200)
    probe.run(300_000)
    probe.port(True)
    probe.connect()
    assert counters(probe)[2] == WATCHDOG


def test_serial_number_of_the_signature_row(probe: AvrBoard) -> None:
    serial = bytes(range(100, 110))
    probe.set_serial_number(serial)
    assert ask(probe, b"s", 10) == serial


def test_a_file_that_is_no_image_is_refused(make_board: Callable[[Path], AvrBoard], tmp_path: Path) -> None:
    path = tmp_path / "no.hex"
    path.write_text("not an image\n")
    with pytest.raises(RuntimeError, match="no readable Intel HEX image"):
        make_board(path)
