"""The drivers of the sequencer's HEX: identity, pulses at rest, USB, watchdog, EEPROM."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from tests.fixtures.sequencer.board import AvrBoard, ResetCause
from tests.fixtures.sequencer.cable import connect
from tests.fixtures.sequencer.pulses import pulses
from tfsat_host.present.boards_status import BOARDS, BoardsStatus
from tfsat_host.present.sequencer_state import SequencerReport
from tfsat_host.protocol import enums
from tfsat_host.quantity import record

HOLD_WIDTH_NS = 1_000_000
WDTCSR, WATCHDOG_TIMEOUT_BITS, ONE_SECOND = 0x60, 0x27, 0x06
MAX_STEP_CYCLES = 10
"""An instruction, and the entry into an interrupt."""
BOOTLOADER_KEY = 0x77  # both bytes of the Arduino core's MAGIC_KEY


def widths_ns(board: AvrBoard) -> set[int]:
    edges = board.edges()
    return {pulse.width_ns for pin in range(3) for pulse in pulses(edges, pin)}


def test_hello_says_that_the_chip_is_emulated(sequencer: AvrBoard) -> None:
    assert bytes.fromhex(connect(sequencer).identity.serial) == b"emulated"


def test_hello_names_the_flashed_image_and_the_chip(sequencer: AvrBoard, sequencer_hex: Path) -> None:
    report = json.loads(sequencer_hex.with_suffix(".json").read_text())
    sequencer.set_serial_number(b"\x01\x02\x03\x04\x05\x06\x07\x08\x10\x20")
    sequencer.power(False)
    # The serial number is read at start-up alone.
    sequencer.power(True)
    identity = connect(sequencer).identity
    assert identity.board == enums.Board.SEQUENCER
    assert identity.image_crc == report["image_crc32"]
    # The last two of the ten bytes are folded into the first two.
    assert identity.serial == "1122030405060708"


@pytest.mark.parametrize(
    ("extended_fuse", "brown_out_v", "attention_text"),
    [(0xCB, 2.6, "resets below 2.6 V only"), (0xFF, None, "never resets"), (0xC8, 4.3, ""), (0xF8, 4.3, "")],
)
def test_status_warns_of_a_brown_out_fuse_as_sold(
    sequencer: AvrBoard, extended_fuse: int, brown_out_v: float | None, attention_text: str
) -> None:
    sequencer.set_extended_fuse(extended_fuse)
    sequencer.power(False)
    sequencer.power(True)
    status = BoardsStatus(SequencerReport.ask(connect(sequencer)), None, {})
    state = record(BOARDS, status)["sequencer"]
    assert state["brown_out_v"] == brown_out_v
    assert [attention_text in text and "docs/wiring.md" in text for text in state["attention"]] == [
        True
    ] * bool(attention_text)
    assert status.warnings == state["attention"]


def test_it_is_silent_until_it_is_armed(sequencer: AvrBoard) -> None:
    status = connect(sequencer).status()
    assert status.state == enums.SequencerState.SAFE
    assert status.reset_cause == enums.ResetCause.POWER_ON
    sequencer.run(200_000)
    # SAFE means limp: not a single edge.
    assert sequencer.edges() == []


def test_disarming_completes_the_pulse_under_way_and_arming_starts_again(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    for _ in range(10):
        client.arm()
        sequencer.run(63_300)
        client.disarm()
        stopped_ns = sequencer.now_us * 1000
        sequencer.run(60_000)
        edges = sequencer.edges()
        assert [len(pulses(edges, pin)) >= 2 for pin in range(3)] == [True, True, True]
        # Every rise has its fall: no pulse is left under way.
        assert len(edges) % 2 == 0
        assert {pulse.width_ns for pin in range(3) for pulse in pulses(edges, pin)} == {HOLD_WIDTH_NS}
        # The last pulse may end after the order, but none may begin.
        assert max(edge.t_ns for edge in edges) < stopped_ns + HOLD_WIDTH_NS


def test_plugging_in_while_armed_does_not_touch_a_pulse(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    for _ in range(6):
        sequencer.cable(False)
        # Not a multiple of the frame: the cable is pulled at another phase each time.
        sequencer.run(37_000)
        sequencer.connect()
    assert widths_ns(sequencer) == {HOLD_WIDTH_NS}
    assert client.status().state == enums.SequencerState.ARMED


@pytest.mark.parametrize("after_us", range(20_500, 25_500, 250))
def test_a_cable_pulled_during_enumeration_stops_nothing(sequencer: AvrBoard, after_us: int) -> None:
    """Enumeration that the cable's removal interrupts does not stop the firmware.

    The Arduino core's own handler would wait for the host until the watchdog bites.
    """
    client = connect(sequencer)
    client.arm()
    sequencer.cable(False)
    sequencer.run(20_000)
    # The host begins to enumerate, and the cable goes in the middle of it.
    sequencer.cable(True)
    sequencer.run(after_us)
    sequencer.cable(False)
    # Longer than the watchdog: a firmware that waited for the host would have been reset.
    sequencer.run(1_500_000)
    assert widths_ns(sequencer) == {HOLD_WIDTH_NS}
    status = connect(sequencer).status()
    assert status.state == enums.SequencerState.ARMED


def test_a_sketch_upload_may_begin_only_while_safe(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    # Armed: the 1200 baud touch, by which the IDE starts the bootloader, must do nothing.
    client.arm()
    sequencer.port(True, 1200)
    sequencer.run(20_000)
    sequencer.port(False, 1200)
    sequencer.run(50_000)
    # The watchdog keeps its own second; the touch would have made it 120 ms.
    assert sequencer.peek(WDTCSR) & WATCHDOG_TIMEOUT_BITS == ONE_SECOND
    assert BOOTLOADER_KEY not in (sequencer.peek(0x800), sequencer.peek(0xAFE))
    sequencer.port(True)
    sequencer.run(20_000)
    assert client.status().state == enums.SequencerState.ARMED
    # Safe: the same touch resets the board, as an upload needs it.
    client.disarm()
    sequencer.port(True, 1200)
    sequencer.run(20_000)
    sequencer.port(False, 1200)
    sequencer.run(400_000)
    sequencer.port(True)
    assert connect(sequencer).status().reset_cause == enums.ResetCause.WATCHDOG


@pytest.mark.parametrize("cause", list(ResetCause))
def test_it_tells_why_it_restarted(sequencer: AvrBoard, cause: ResetCause) -> None:
    sequencer.reset(cause)
    assert connect(sequencer).status().reset_cause.name == cause.name


def test_a_processor_that_falls_asleep_stops_where_it_is_told(sequencer: AvrBoard) -> None:
    """Sleeping processors stop at the cycle that `run_to_cycle` asks for.

    An external event at that moment, such as a switch edge, would otherwise come up to a millisecond late.
    """
    chance = random.Random(1)
    cycle = sequencer.cycles
    # 20,000 random cycles: some of them fall into a sleep.
    for _ in range(20_000):
        cycle += chance.randint(20, 1500)
        sequencer.run_to_cycle(cycle)
        # One instruction late at the most, however long the processor would have slept.
        assert cycle <= sequencer.cycles <= cycle + MAX_STEP_CYCLES
