"""Release and knocks: what starts the strokes, when, and what never does."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from tests.sequencer.board import (
    JOINTS,
    OLD,
    STROKE_LINE,
    Board,
    assert_servo_signal,
    client,
    connect,
    pulses,
    rows,
    width_ns,
)
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import RELEASE_BOUNCE_US, RELEASE_CHATTER_US, RELEASE_SEATED_US
from tfsat_host.protocol.messages import (
    RunReportReply,
    RunReportRequest,
)

TICK_NS = 500
DEBOUNCE_US = 5000


def bounce(rng: random.Random, board: Board) -> int:
    """Both switches open with chatter; returns when both first were open, us."""
    first = rng.randrange(2)
    events = [(0, first, True), (rng.randint(0, 4000), 1 - first, True)]
    for index in (0, 1):
        t_us = next(t for t, i, _ in events if i == index)
        for _ in range(rng.randint(0, 8)):
            t_us += rng.randint(1, 500)
            events.append((t_us, index, False))
            t_us += rng.randint(1, 500)
            events.append((t_us, index, True))
    origin_us, both_us = board.now_us, None
    for t_us, index, opened in sorted(events):
        board.advance_to(origin_us + t_us)
        board.switch(index, opened=opened)
        if both_us is None and all(board.opened.values()):
            both_us = board.now_us
    assert both_us is not None
    return both_us


def test_strokes_begin_on_their_ticks_after_the_second_opening(new_board: Callable[..., Board]) -> None:
    for seed in range(200):
        check_a_drop(new_board(), random.Random(seed))


def check_a_drop(board: Board, rng: random.Random) -> None:
    sequencer = connect(board)
    sequencer.arm()
    board.advance(rng.randint(0, 60_000))
    released_us = bounce(rng, board)
    board.advance(2_400_000)
    edges = board.edges()
    expected_ns = [1000 * (released_us + start_us) for _, _, start_us in rows(OLD)]
    marks = pulses(edges, STROKE_LINE)
    assert [pulse.rise_ns for pulse in marks] == pytest.approx(expected_ns, abs=TICK_NS)
    assert [pulse.width_ns for pulse in marks] == [1_000_000] * 4
    angle_cdeg = dict.fromkeys(range(1, JOINTS + 1), 0)
    for (joint, change_cdeg, _), onset_ns in zip(rows(OLD), expected_ns, strict=True):
        angle_cdeg[joint] += change_cdeg
        train = pulses(edges, joint - 1)
        onset = next(pulse for pulse in train if pulse.rise_ns >= onset_ns - TICK_NS)
        assert onset.rise_ns == pytest.approx(onset_ns, abs=TICK_NS)
        assert onset.width_ns == pytest.approx(width_ns(angle_cdeg[joint]), abs=TICK_NS)
    for joint in range(JOINTS):
        assert_servo_signal(pulses(edges, joint))
    status = sequencer.status()
    assert (status.state, status.strokes_started, status.knocks) == (SequencerState.DONE, 4, 0)
    assert status.joint_angle_cdeg == (0, 0, 0)


def test_one_switch_alone_never_starts_anything(board: Board) -> None:
    sequencer = connect(board)
    sequencer.arm()
    for index in (0, 1):
        board.switch(index, opened=True)
        board.advance(3_000_000)
        assert sequencer.status().state == SequencerState.ARMED
        assert sequencer.status().switches_open == 1 << index
        assert sequencer.status().knocks == index
        board.switch(index, opened=False)
        board.advance(10_000)
    assert sequencer.status().knocks == 2
    assert pulses(board.edges(), STROKE_LINE) == []


@pytest.mark.parametrize("open_us", [1, 50, 1000, 4000, DEBOUNCE_US - 50])
def test_both_open_for_less_than_the_debounce_is_a_knock(board: Board, open_us: int) -> None:
    sequencer = connect(board)
    sequencer.arm()
    for number in range(1, 4):
        for opened in (True, False):
            board.switch(0, opened=opened)
            board.switch(1, opened=opened)
            board.advance(open_us if opened else 20_000)
        status = sequencer.status()
        assert (status.state, status.knocks) == (SequencerState.ARMED, number)


def test_knocks_before_a_drop_change_nothing_of_it(new_board: Callable[..., Board]) -> None:
    """A lift by crane: one switch open for up to 20 ms, or both for less than the debounce."""
    for seed in range(60):
        check_a_lift_and_a_drop(new_board(), random.Random(1000 + seed))


def check_a_lift_and_a_drop(board: Board, rng: random.Random) -> None:
    sequencer = connect(board)
    sequencer.arm()
    count = rng.randint(1, 5)
    for _ in range(count):
        both = rng.random() < 0.5
        index = rng.randrange(2)
        board.switch(index, opened=True)
        if both:
            board.switch(1 - index, opened=True)
        board.advance(rng.randint(100, 4900 if both else 20_000))
        board.switch(0, opened=False)
        board.switch(1, opened=False)
        board.advance(rng.randint(6000, 50_000))
    assert sequencer.status().knocks == count
    released_us = bounce(rng, board)
    board.advance(800_000)
    (mark,) = pulses(board.edges(), STROKE_LINE)
    assert mark.rise_ns == pytest.approx(1000 * (released_us + 700_000), abs=TICK_NS)
    assert sequencer.status().knocks == count


def test_a_switch_that_opened_long_before_the_other(board: Board) -> None:
    sequencer = connect(board)
    sequencer.arm()
    board.switch(1, opened=True)
    board.advance(700_123)
    board.switch(0, opened=True)
    released_us = board.now_us
    board.advance(800_000)
    (mark,) = pulses(board.edges(), STROKE_LINE)
    assert mark.rise_ns == pytest.approx(1000 * (released_us + 700_000), abs=TICK_NS)


@pytest.mark.parametrize("open_us", [6_000, 60_000, 450_000])
def test_a_jolt_on_the_crane_starts_nothing_and_the_drop_after_it_flies(board: Board, open_us: int) -> None:
    sequencer = connect(board)
    sequencer.arm()
    for opened in (True, False):
        board.switch(0, opened=opened)
        board.switch(1, opened=opened)
        board.advance(open_us if opened else RELEASE_SEATED_US + 2_000)
    status = sequencer.status()
    assert (status.state, status.false_releases, status.knocks) == (SequencerState.ARMED, 1, 0)
    board.advance(2_500_000)
    edges = board.edges()
    assert pulses(edges, STROKE_LINE) == []
    for joint in range(JOINTS):
        assert_servo_signal(pulses(edges, joint))
    released_us = board.now_us
    for index in (0, 1):
        board.switch(index, opened=True)
    board.advance(2_400_000)
    marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
    expected_ns = [1000 * (released_us + start_us) for _, _, start_us in rows(OLD)]
    assert marks == pytest.approx(expected_ns, abs=TICK_NS)
    assert sequencer.status().state == SequencerState.DONE


def test_both_closed_again_after_two_strokes_holds_the_servos_until_somebody_disarms(board: Board) -> None:
    sequencer = connect(board)
    sequencer.arm()
    for opened in (True, False):
        board.switch(0, opened=opened)
        board.switch(1, opened=opened)
        board.advance(1_150_000 if opened else RELEASE_SEATED_US + 2_000)
    over_ns = 1000 * board.now_us
    board.advance(2_000_000)
    edges = board.edges()
    assert len(pulses(edges, STROKE_LINE)) == 2
    held_cdeg = (5900, 7000, 0)
    for joint, angle_cdeg in enumerate(held_cdeg):
        train = pulses(edges, joint)
        assert_servo_signal(train)
        (held_ns,) = {pulse.width_ns for pulse in train if pulse.rise_ns > over_ns}
        assert held_ns == pytest.approx(width_ns(angle_cdeg), abs=TICK_NS)
    status = sequencer.status()
    assert (status.state, status.fault) == (SequencerState.FAULT, ErrorCode.CLOSED_WHILE_RUNNING)
    assert status.joint_angle_cdeg == held_cdeg
    sequencer.disarm()
    board.advance(50_000)
    board.edges()
    board.advance(500_000)
    assert board.edges() == []


@pytest.mark.parametrize("shaken_us", [100_000, 1_500_000])
def test_a_robot_that_is_shaken_before_its_release_keeps_its_pause(board: Board, shaken_us: int) -> None:
    """Chatter for longer than any release must not let the schedule begin long before the release."""
    sequencer = connect(board)
    sequencer.arm()
    board.switch(0, opened=True)
    for _ in range(shaken_us // 5000):
        for opened in (True, False):
            board.switch(1, opened=opened)
            board.advance(2500)
    board.switch(1, opened=True)
    released_us = board.now_us
    board.advance(2_400_000)
    marks = [pulse.rise_ns // 1000 for pulse in pulses(board.edges(), STROKE_LINE)]
    early_us = released_us + rows(OLD)[0][2] - marks[0]
    assert 0 <= early_us <= RELEASE_BOUNCE_US
    report = client(board).request(RunReportRequest(), RunReportReply)
    assert early_us - report.later_us == 0
    assert report.earlier_us + report.later_us == RELEASE_CHATTER_US
    assert [mark - marks[0] for mark in marks] == [row[2] - rows(OLD)[0][2] for row in rows(OLD)]
