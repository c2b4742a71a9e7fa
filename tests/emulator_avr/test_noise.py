"""A square wave on a release switch, as no contact makes it: the servos' pulses do not suffer."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tests.emulator_avr.avr_board import AvrBoard
from tests.emulator_avr.board_link import connect
from tests.emulator_avr.flight import pulses, run_until_lines_are_low
from tfsat_host.protocol.enums import ResetCause, SequencerState

NOISE_US = 60_000
# An interrupt that waits for a whole queue of captures and for the other servos' interrupts.
LATE_NS = 150_000


@pytest.mark.parametrize("half_period_us", [3, 5, 7, 12, 40])
def test_noise_on_a_switch_leaves_the_pulses_alone(sequencer: AvrBoard, half_period_us: int) -> None:
    client = connect(sequencer)
    client.arm()
    run_until_lines_are_low(sequencer)
    sequencer.edges()
    end_us, closed = sequencer.now_us + NOISE_US, True
    while sequencer.now_us < end_us:
        closed = not closed
        sequencer.switch(0, closed=closed)
        sequencer.run(half_period_us)
    sequencer.switch(0, closed=True)
    sequencer.run(100_000)
    edges = sequencer.edges()
    for pin in range(3):
        train = pulses(edges, pin)
        assert len(train) >= 7
        assert all(1_000_000 <= pulse.width_ns <= 1_000_000 + LATE_NS for pulse in train), train
        gaps_ns = [after.rise_ns - before.rise_ns for before, after in pairwise(train)]
        assert all(abs(gap - 20_000_000) <= LATE_NS for gap in gaps_ns), gaps_ns
    status = client.status()
    assert (status.state, status.reset_cause) == (SequencerState.ARMED, ResetCause.POWER_ON)
    assert status.knocks >= 1
