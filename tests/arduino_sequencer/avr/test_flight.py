"""The HEX that would be flashed flies what was uploaded: what its pins do, in nanoseconds."""

from __future__ import annotations

import random

import pytest

from tests.arduino_sequencer.avr.flight import assert_maneuver_flown, release
from tests.fixtures.sequencer.board import AvrBoard
from tests.fixtures.sequencer.cable import connect
from tests.fixtures.sequencer.pulses import onsets_ns
from tfsat_host.protocol.enums import ResetCause, SequencerState
from tfsat_host.protocol.framing import Frame, encode_frame
from tfsat_host.protocol.messages import SequencerStatusRequest


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.prove) for seed in range(1, 6))])
def test_strokes_begin_on_their_ticks_without_a_cable(sequencer: AvrBoard, seed: int) -> None:
    client = connect(sequencer)
    assert client.arm() == SequencerState.ARMED
    # A prime step: another phase of the frame for each seed.
    sequencer.run(100_000 + 7919 * seed)
    client.close()
    sequencer.run(200_000)
    released_ns = release(sequencer, seed)
    sequencer.run(2_600_000)
    assert_maneuver_flown(sequencer, released_ns)
    status = connect(sequencer).status()
    assert status.state == SequencerState.DONE
    assert status.strokes_started == 4
    # The maneuver brings every joint back to where it began.
    assert status.joint_angle_cdeg == (0, 0, 0)


def test_a_flooding_host_moves_no_stroke(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    sequencer.run(50_000)
    released_ns = release(sequencer, 1)
    noise = random.Random(2)
    while sequencer.now_us * 1000 < released_ns + 2_600_000_000:
        # 512 random bytes a millisecond: far more than the link carries.
        sequencer.write(noise.randbytes(512))
        sequencer.run(1000)
    assert_maneuver_flown(sequencer, released_ns)
    assert connect(sequencer).status().state == SequencerState.DONE


def test_a_host_that_asks_and_never_reads_moves_no_stroke(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    sequencer.run(50_000)
    released_ns = release(sequencer, 3)
    question = encode_frame(Frame(SequencerStatusRequest.TYPE, 7, b""))
    while sequencer.now_us * 1000 < released_ns + 2_600_000_000:
        # Requests without end, and nobody reads the answers: the cable's buffer fills.
        sequencer.write(question * 40)
        sequencer.run(2000)
    assert_maneuver_flown(sequencer, released_ns)
    assert len(sequencer.read()) > 4000  # the cable was full


def test_plugging_the_cable_in_and_out_during_the_run_moves_no_stroke(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    released_ns = release(sequencer, 4)
    plugged = True
    while sequencer.now_us * 1000 < released_ns + 2_600_000_000:
        plugged = not plugged
        sequencer.cable(plugged)
        # Not a multiple of the frame: plugging meets every phase of it.
        sequencer.run(23_700)
    assert_maneuver_flown(sequencer, released_ns)
    sequencer.cable(False)
    status = connect(sequencer).status()
    assert (status.state, status.reset_cause) == (SequencerState.DONE, ResetCause.POWER_ON)


def test_a_glitch_shorter_than_the_interrupt_does_not_blind_a_switch(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    sequencer.run(50_000)
    sequencer.switch(1, closed=False)
    # 3 us: over before the interrupt looks at the pin.
    sequencer.run(3)
    sequencer.switch(1, closed=True)
    sequencer.run(5_000)
    sequencer.switch(0, closed=False)
    sequencer.run(300)
    sequencer.switch(1, closed=False)
    # The release is when the second switch opens for good.
    released_ns = sequencer.now_us * 1000
    sequencer.run(2_600_000)
    assert_maneuver_flown(sequencer, released_ns)


def test_one_switch_alone_starts_nothing(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    sequencer.switch(1, closed=False)
    sequencer.run(20_000)
    sequencer.switch(1, closed=True)
    sequencer.run(1_000_000)
    status = client.status()
    assert status.state == SequencerState.ARMED
    assert status.knocks == 1
    assert onsets_ns(sequencer.edges()) == []
