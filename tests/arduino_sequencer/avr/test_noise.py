"""A square wave on a release switch, as no contact makes it: the servos' pulses do not suffer."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tests.arduino_sequencer.avr.flight import run_until_lines_are_low
from tests.fixtures.sequencer.board import AvrBoard
from tests.fixtures.sequencer.cable import connect
from tests.fixtures.sequencer.pulses import pulses
from tfsat_host.protocol.enums import ResetCause, SequencerState

NOISE_US = 60_000


@pytest.mark.parametrize("switch", [0, 1])
# From shorter than an interrupt takes to many times as long.
@pytest.mark.parametrize("half_period_us", [3, 5, 7, 12, 40])
def test_noise_on_a_switch_leaves_the_pulses_alone(
    sequencer: AvrBoard, half_period_us: int, switch: int
) -> None:
    client = connect(sequencer)
    client.arm()
    run_until_lines_are_low(sequencer)
    sequencer.edges()
    end_us, closed = sequencer.now_us + NOISE_US, True
    while sequencer.now_us < end_us:
        closed = not closed
        sequencer.switch(switch, closed=closed)
        sequencer.run(half_period_us)
    sequencer.switch(switch, closed=True)
    sequencer.run(100_000)
    edges = sequencer.edges()
    for pin in range(3):
        train = pulses(edges, pin)
        assert len(train) >= 7
        assert {pulse.width_ns for pulse in train} == {1_000_000}
        gaps_ns = [after.rise_ns - before.rise_ns for before, after in pairwise(train)]
        # Exactly 20 ms between all pulses: noise costs not even a tick.
        assert set(gaps_ns) == {20_000_000}
    status = client.status()
    assert (status.state, status.reset_cause) == (SequencerState.ARMED, ResetCause.POWER_ON)
    assert status.knocks >= 1
