"""The HEX that would be flashed flies the factory maneuver: what its pins do, in nanoseconds."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest

from tests.emulator_avr.avr_board import AvrBoard
from tests.emulator_avr.flight import STROKE_LINE, connect, onsets_ns, pulses, release
from tfsat_host.protocol.enums import ResetCause, SequencerState
from tfsat_host.protocol.framing import Frame, encode_frame
from tfsat_host.protocol.messages import SequencerStatusRequest

FACTORY_STROKES = [(1, 700_000), (2, 1_050_000), (1, 1_470_000), (2, 1_820_000)]
TICK_NS = 500
NOISE_CANCELER_NS = 250


def assert_factory_maneuver_flown(board: AvrBoard, released_ns: int) -> None:
    edges = board.edges()
    onsets = onsets_ns(edges)
    assert [joint for joint, _ in onsets] == [joint for joint, _ in FACTORY_STROKES]
    for (_, onset_ns), (_, start_us) in zip(onsets, FACTORY_STROKES, strict=True):
        assert -TICK_NS <= onset_ns - released_ns - start_us * 1000 <= NOISE_CANCELER_NS

    widths_us = [sorted({pulse.width_ns / 1000 for pulse in pulses(edges, pin)}) for pin in range(3)]
    assert widths_us == [[1000, 1655.5], [1000, 1778], [1000]]
    for pin in range(3):
        gaps_ms = [(after.rise_ns - before.rise_ns) / 1e6 for before, after in pairwise(pulses(edges, pin))]
        assert 19.5 <= min(gaps_ms) <= max(gaps_ms) <= 20.5

    marks = pulses(edges, STROKE_LINE)
    assert len(marks) == len(onsets)
    for mark, (_, onset_ns) in zip(marks, onsets, strict=True):
        assert 0 < mark.rise_ns - onset_ns < 60_000
        assert 990_000 < mark.width_ns < 1_050_000


@pytest.mark.parametrize("seed", range(6))
def test_strokes_begin_on_their_ticks_without_a_cable(sequencer: AvrBoard, seed: int) -> None:
    client = connect(sequencer)
    assert client.arm() == SequencerState.ARMED
    sequencer.run(100_000 + 7919 * seed)
    client.close()
    sequencer.run(200_000)
    released_ns = release(sequencer, seed)
    sequencer.run(2_600_000)
    assert_factory_maneuver_flown(sequencer, released_ns)
    status = connect(sequencer).status()
    assert status.state == SequencerState.DONE
    assert status.strokes_started == 4
    assert status.joint_angle_cdeg == (0, 0, 0)


def test_a_flooding_host_moves_no_stroke(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    sequencer.run(50_000)
    released_ns = release(sequencer, 1)
    noise = random.Random(2)
    while sequencer.now_us * 1000 < released_ns + 2_600_000_000:
        sequencer.send(noise.randbytes(512))
        sequencer.run(1000)
    assert_factory_maneuver_flown(sequencer, released_ns)
    assert connect(sequencer).status().state == SequencerState.DONE


def test_a_host_that_asks_and_never_reads_moves_no_stroke(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    sequencer.run(50_000)
    released_ns = release(sequencer, 3)
    question = encode_frame(Frame(SequencerStatusRequest.TYPE, 7, b""))
    while sequencer.now_us * 1000 < released_ns + 2_600_000_000:
        sequencer.send(question * 40)
        sequencer.run(2000)
    assert_factory_maneuver_flown(sequencer, released_ns)
    assert len(sequencer.receive()) > 4000  # the cable was full


def test_plugging_the_cable_in_and_out_during_the_run_moves_no_stroke(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    released_ns = release(sequencer, 4)
    plugged = True
    while sequencer.now_us * 1000 < released_ns + 2_600_000_000:
        plugged = not plugged
        sequencer.cable(plugged)
        sequencer.run(23_700)
    assert_factory_maneuver_flown(sequencer, released_ns)
    sequencer.cable(False)
    status = connect(sequencer).status()
    assert (status.state, status.reset_cause) == (SequencerState.DONE, ResetCause.POWER_ON)


def test_a_glitch_shorter_than_the_interrupt_does_not_blind_a_switch(sequencer: AvrBoard) -> None:
    client = connect(sequencer)
    client.arm()
    sequencer.run(50_000)
    sequencer.switch(1, closed=False)
    sequencer.run(3)
    sequencer.switch(1, closed=True)
    sequencer.run(5_000)
    sequencer.switch(0, closed=False)
    sequencer.run(300)
    sequencer.switch(1, closed=False)
    released_ns = sequencer.now_us * 1000
    sequencer.run(2_600_000)
    assert_factory_maneuver_flown(sequencer, released_ns)


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
