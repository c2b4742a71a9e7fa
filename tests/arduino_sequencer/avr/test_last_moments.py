"""Moments of some microseconds at the first stroke in which main loop and interrupts could disagree, swept."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.fixtures.sequencer.board import AvrBoard, PinHold
from tests.fixtures.sequencer.cable import OLD, connect, eeprom_after_upload
from tests.fixtures.sequencer.pulses import Pulse, pulses
from tfsat_host.protocol.enums import ErrorCode, SequencerState

CYCLES_PER_US = 16
LOOP_US = 1_024
"""The main loop runs once in so long."""
FIRST_US = OLD.strokes[0].t_us
START_POSE_NS = 1_000_000
AFTER_US = FIRST_US + 60_000


@dataclass(frozen=True)
class Fall:
    """A board that was armed and has both switches open since `open_us`."""

    board: AvrBoard
    open_us: int

    def run_to(self, after_us: int) -> None:
        self.board.run_to(self.open_us + after_us)

    def switches(self, *, closed: bool) -> None:
        for index in (0, 1):
            self.board.switch(index, closed=closed)

    def pulses_since_release(self) -> list[Pulse]:
        """Return the pulses of joint 1, with times counted from the release."""
        return [
            Pulse(pulse.rise_ns - 1000 * self.open_us, pulse.width_ns)
            for pulse in pulses(self.board.edges(), 0)
        ]


@pytest.fixture
def fall(library: ctypes.CDLL, sequencer_hex: Path) -> Callable[[int], Fall]:
    """Boards that were released so many µs after a fixed time, one after the other."""
    stored = eeprom_after_upload(library, sequencer_hex)

    def begin(phase_us: int) -> Fall:
        board = AvrBoard(library, sequencer_hex)
        board.set_eeprom(stored)
        for index in (0, 1):
            board.switch(index, closed=True)
        board.power(True)
        board.run(300_000)
        client = connect(board)
        client.arm()
        board.run(50_000)
        client.close()
        board.edges()
        # The phase of the main loop at which the release falls.
        board.run(phase_us)
        drop = Fall(board, board.now_us)
        drop.switches(closed=False)
        return drop

    return begin


STEP = pytest.mark.parametrize("step", [56, pytest.param(8, marks=pytest.mark.prove)])


@STEP
# The false release is noticed 200 ms after closing: just as the first stroke begins.
@pytest.mark.parametrize("closed_us", [FIRST_US - 200_400, FIRST_US - 200_100])
def test_a_false_release_that_is_detected_as_the_first_stroke_begins(
    fall: Callable[[int], Fall], closed_us: int, step: int
) -> None:
    """Either nothing moved and it is armed, or the joint got its stroke and the board says so: at any loop phase."""
    for phase_us in range(20_000, 20_000 + LOOP_US, step):
        drop = fall(phase_us)
        drop.run_to(closed_us)
        drop.switches(closed=True)
        drop.run_to(AFTER_US)
        moved = {pulse.width_ns for pulse in drop.pulses_since_release()} != {START_POSE_NS}
        status = connect(drop.board).status()
        # Either moved and said so, or not moved: nothing in between.
        if moved:
            assert (status.state, status.fault) == (SequencerState.FAULT, ErrorCode.CLOSED_WHILE_RUNNING)
            assert (status.strokes_started, status.joint_angle_cdeg) == (1, (5900, 0, 0))
        else:
            assert status.joint_angle_cdeg == (0, 0, 0) and status.strokes_started == 0
        drop.board.close()


@STEP
@pytest.mark.parametrize("hold", [PinHold.HIGH, PinHold.LOW])
def test_a_pin_that_is_let_go_right_after_a_pulse_loses_no_stroke(
    fall: Callable[[int], Fall], hold: PinHold, step: int
) -> None:
    """Held across the fall of the last pulse before the stroke, and free again 20 ms before it: it begins on time."""
    free = fall(20_000)
    free.run_to(AFTER_US)
    # The last pulse before the stroke, of a flight that nobody disturbs.
    # The stroke's own pulse may rise a tick before its time, as the release may be stamped one early.
    last = [pulse for pulse in free.pulses_since_release() if pulse.rise_ns < 1000 * (FIRST_US - 1_000)][-1]
    fall_ns = last.rise_ns + last.width_ns
    free.board.close()
    for cycles in range(-64, 1_000, step):
        drop = fall(20_000)
        drop.run_to(fall_ns // 1000 - 500)
        drop.board.hold_pin(1, hold)
        # To the cycle: from just before the fall of the pulse to 60 us after it.
        drop.board.run_to_cycle((1000 * drop.open_us + fall_ns) * CYCLES_PER_US // 1000 + cycles)
        drop.board.hold_pin(1, PinHold.FREE)
        drop.run_to(AFTER_US)
        assert connect(drop.board).run_report().start_us[0] == FIRST_US, (
            f"let go {cycles} cycles after the fall"
        )
        drop.board.close()
