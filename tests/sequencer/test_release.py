"""Release, knocks and arming: what starts the strokes, when, and what never does."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from tests.sequencer.board import (
    ERASED,
    JOINTS,
    NEW,
    OLD,
    STROKE_LINE,
    Board,
    Cable,
    assert_servo_signal,
    client,
    connect,
    pulses,
    release,
    rows,
    width_ns,
)
from tests.sequencer.store_model import BEGUN, MANEUVER_AT, MARKER_BYTES, SLOT_BYTES
from tfsat_host.devices.client import BoardRefusal
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.maneuver import Maneuver, Stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.limits import RELEASE_BOUNCE_US, RELEASE_CHATTER_US, RELEASE_SEATED_US
from tfsat_host.protocol.messages import (
    ArmReply,
    ArmRequest,
    ErrorReply,
    ManeuverBeginRequest,
    ManeuverStrokeRequest,
    RunReportReply,
    RunReportRequest,
)
from tfsat_host.servo_settings import FACTORY

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


@pytest.mark.parametrize(("opened", "mask"), [((0,), 1), ((1,), 2), ((0, 1), 3)])
def test_arming_with_an_open_switch_is_refused(board: Board, opened: tuple[int, ...], mask: int) -> None:
    sequencer = connect(board)
    for index in opened:
        board.switch(index, opened=True)
    with pytest.raises(BoardRefusal) as caught:
        sequencer.arm()
    assert (caught.value.code, caught.value.detail, caught.value.exit_code) == (
        ErrorCode.SWITCH_OPEN,
        mask,
        4,
    )
    board.advance(100_000)
    assert sequencer.status().state == SequencerState.SAFE
    assert sequencer.status().last_refusal == ErrorCode.SWITCH_OPEN
    assert board.edges() == []
    for index in opened:
        board.switch(index, opened=False)
    assert sequencer.arm() == SequencerState.ARMED
    assert sequencer.status().last_refusal == ErrorCode.NONE


def test_arming_while_running_is_refused_and_moves_no_stroke(board: Board) -> None:
    sequencer = connect(board)
    sequencer.arm()
    released_us = release(board)
    board.advance(10_000)
    for _ in range(3):
        with pytest.raises(BoardRefusal) as caught:
            sequencer.arm()
        assert caught.value.code == ErrorCode.WRONG_STATE
    board.advance(2_400_000)
    marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
    assert marks == pytest.approx([1000 * (released_us + start) for _, _, start in rows(OLD)], abs=TICK_NS)


def test_a_token_of_an_earlier_state_does_not_arm(board: Board) -> None:
    sequencer = connect(board)
    token = sequencer.status().arm_token
    link = client(board)
    assert link.request(ArmRequest(token), ArmReply).state == SequencerState.ARMED
    assert link.request(ArmRequest(token), ArmReply).state == SequencerState.ARMED  # the second copy
    sequencer.disarm()
    for stale in (token, (token + 1) & 0xFFFF, (token - 1) & 0xFFFF):
        with pytest.raises(BoardRefusal) as caught:
            link.request(ArmRequest(stale), ArmReply)
        assert caught.value.code == ErrorCode.STALE_TOKEN
    assert sequencer.status().state == SequencerState.SAFE


class Interrupted(Exception):
    """The host was stopped here."""


class StopsAtFirstByteOfTheRecord(Cable):
    """The host dies as soon as the board has begun to store more than the marker of an upload begun."""

    def read(self, timeout_s: float) -> bytes:
        slots = (MANEUVER_AT + slot * SLOT_BYTES for slot in (0, 1))
        if any(self.board.eeprom()[at : at + MARKER_BYTES + 1] == BEGUN + b"\x02" for at in slots):
            raise Interrupted
        return super().read(timeout_s)


def test_arming_while_the_eeprom_is_written_is_refused(board: Board) -> None:
    with pytest.raises(Interrupted):
        SequencerClient.connect(StopsAtFirstByteOfTheRecord(board)).upload(NEW)
    sequencer = connect(board)
    with pytest.raises(BoardRefusal) as caught:
        sequencer.arm()
    assert caught.value.code == ErrorCode.WRONG_STATE
    board.advance(600_000)
    assert sequencer.read_back().strokes == rows(NEW)
    assert sequencer.arm() == SequencerState.ARMED


@pytest.mark.parametrize("after_us", [0, 3000, 6000, 350_000, 1_052_000, 1_600_123])
def test_disarming_stops_the_pulses_in_any_state(board: Board, after_us: int) -> None:
    sequencer = connect(board)
    sequencer.arm()
    board.advance(100_000)
    release(board)
    board.advance(after_us)
    assert sequencer.disarm() == SequencerState.SAFE
    stopped_ns = 1000 * board.now_us
    board.advance(3_000_000)
    edges = board.edges()
    for pin in range(JOINTS):
        train = pulses(edges, pin)
        assert_servo_signal(train)
        assert train[-1].rise_ns <= stopped_ns
    assert sequencer.status().state == SequencerState.SAFE
    assert len(pulses(edges, STROKE_LINE)) == sequencer.status().strokes_started


def test_done_can_be_armed_again_and_flies_again(board: Board) -> None:
    sequencer = connect(board)
    for _ in range(3):
        assert sequencer.arm() == SequencerState.ARMED
        released_us = release(board)
        board.advance(2_500_000)
        assert sequencer.status().state == SequencerState.DONE
        marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
        assert marks == pytest.approx(
            [1000 * (released_us + start) for _, _, start in rows(OLD)], abs=TICK_NS
        )
        with pytest.raises(BoardRefusal) as caught:
            sequencer.arm()
        assert caught.value.code == ErrorCode.SWITCH_OPEN
        board.switch(0, opened=False)
        board.switch(1, opened=False)
        board.advance(30_000)
        assert sequencer.status().state == SequencerState.DONE


@pytest.mark.parametrize("state", [SequencerState.ARMED, SequencerState.RUNNING, SequencerState.DONE])
def test_uploads_are_refused_unless_safe(board: Board, state: SequencerState) -> None:
    sequencer = connect(board)
    sequencer.arm()
    if state != SequencerState.ARMED:
        release(board)
        board.advance(100_000 if state == SequencerState.RUNNING else 2_500_000)
    assert sequencer.status().state == state
    image = board.eeprom()
    with pytest.raises(BoardRefusal) as caught:
        sequencer.upload(NEW)
    assert (caught.value.code, caught.value.exit_code) == (ErrorCode.WRONG_STATE, 4)
    assert "disarm" in caught.value.next_step
    board.advance(500_000)
    assert board.eeprom() == image
    assert sequencer.read_back().strokes == rows(OLD)
    sequencer.disarm()
    assert sequencer.upload(NEW).written


@pytest.mark.parametrize("state", ["armed", "running"])
def test_a_pulled_cable_changes_nothing(board: Board, state: str) -> None:
    sequencer = connect(board)
    sequencer.arm()
    if state == "armed":
        board.cable(False)
        board.advance(60_000_000)
    released_us = release(board)
    board.advance(500_000)
    board.cable(False)
    board.advance(2_000_000)
    board.cable(True)
    marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
    assert marks == pytest.approx([1000 * (released_us + start) for _, _, start in rows(OLD)], abs=TICK_NS)
    assert connect(board).status().state == SequencerState.DONE


def test_status_of_a_shorter_maneuver_after_a_run(new_board: Callable[..., Board]) -> None:
    """STATUS counts the last run's strokes; a maneuver uploaded since may have fewer."""
    board = new_board(b"\x33" * 1024)
    sequencer = connect(board)
    sequencer.upload(OLD)
    sequencer.write_settings(FACTORY)
    sequencer.arm()
    release(board)
    board.advance(2_500_000)
    board.switch(0, opened=False)
    board.switch(1, opened=False)
    sequencer.disarm()
    sequencer.upload(schedule_maneuver(Maneuver((Stroke(3, 77.0),))))
    status = sequencer.status()
    assert status.strokes_started == 4
    assert status.joint_angle_cdeg == (0, 0, 0)


def test_each_disarm_is_answered_and_outdates_every_arm_from_before_it(board: Board) -> None:
    sequencer = connect(board)
    for _ in range(3):
        token = sequencer.status().arm_token
        board.switch(0, opened=True)
        with pytest.raises(BoardRefusal):
            sequencer.arm()
        assert sequencer.disarm() == SequencerState.SAFE
        board.switch(0, opened=False)
        (answer,) = board.ask(Frame(ArmRequest.TYPE, 9, ArmRequest(token).encode()))
        assert ErrorReply.decode(answer.payload).code == ErrorCode.STALE_TOKEN
        assert sequencer.status().state == SequencerState.SAFE


def assert_refused(board: Board, code: ErrorCode) -> None:
    with pytest.raises(BoardRefusal) as caught:
        connect(board).arm()
    assert (caught.value.code, caught.value.exit_code) == (code, 4)


def test_a_board_to_which_nothing_was_uploaded_does_not_arm(fresh_board: Board) -> None:
    assert_refused(fresh_board, ErrorCode.NO_MANEUVER)
    fresh_board.advance(100_000)
    assert fresh_board.edges() == []
    connect(fresh_board).upload(OLD)
    assert connect(fresh_board).arm() == SequencerState.ARMED


def test_a_run_that_ended_far_from_the_start_is_not_armed_until_disarmed(board: Board) -> None:
    sequencer = connect(board)
    sequencer.upload(schedule_maneuver(Maneuver((Stroke(2, 10.01),))))
    sequencer.arm()
    release(board)
    board.advance(2_500_000)
    for index in (0, 1):
        board.switch(index, opened=False)
    assert_refused(board, ErrorCode.NOT_AT_START_POSE)
    board.advance(100_000)
    assert pulses(board.edges(), 1)[-1].width_ns == pytest.approx(width_ns(1001), abs=TICK_NS)
    sequencer.disarm()
    assert sequencer.arm() == SequencerState.ARMED


def test_an_upload_that_died_half_way_is_named_until_one_is_complete(board: Board) -> None:
    """The maneuver before is still there to be read, and is not flown."""
    for request in (ManeuverBeginRequest(4, 17_000), ManeuverStrokeRequest(0, *rows(OLD)[0])):
        board.ask(Frame(request.TYPE, 1, request.encode()))
    board.advance(20_000)  # to write the marker takes 14 ms
    for _ in range(3):
        board.power_cycle()
        sequencer = connect(board)
        assert sequencer.read_back().strokes == rows(OLD)
        assert_refused(board, ErrorCode.UPLOAD_INTERRUPTED)
        assert sequencer.status().stores_damaged == 1 << 2
    connect(board).upload(OLD)
    assert connect(board).arm() == SequencerState.ARMED


def test_a_store_of_the_old_layout_is_named_until_both_are_uploaded(new_board: Callable[..., Board]) -> None:
    """Layout 1: from address 0 and 256 on, the marker 0xA5 first."""
    image = bytearray(ERASED)
    image[0], image[256] = 0xA5, 0xA5
    board = new_board(bytes(image))
    sequencer = connect(board)
    assert sequencer.status().stores_damaged == 0b11_0000
    assert_refused(board, ErrorCode.STORE_OLD_LAYOUT)
    sequencer.upload(NEW)
    assert sequencer.status().stores_damaged == 0b10_0000
    assert_refused(board, ErrorCode.STORE_OLD_LAYOUT)
    assert sequencer.write_settings(FACTORY).written
    board.power_cycle()
    assert connect(board).arm() == SequencerState.ARMED


@pytest.mark.parametrize("slot_marker", range(MARKER_BYTES))
def test_one_bit_in_the_newest_marker_does_not_bring_the_older_maneuver_back(
    board: Board, slot_marker: int
) -> None:
    connect(board).upload(NEW)
    image = bytearray(board.eeprom())
    image[MANEUVER_AT + SLOT_BYTES + slot_marker] ^= 1
    board.power_cycle(bytes(image))
    assert_refused(board, ErrorCode.STORE_DAMAGED)


@pytest.mark.parametrize("hit", [(0,), (1,), (0, 1)])
def test_a_maneuver_damaged_in_the_dark_is_told_and_healed_by_one_upload(
    board: Board, hit: tuple[int, ...]
) -> None:
    """Both slots hold a maneuver."""
    connect(board).upload(NEW)
    image = bytearray(board.eeprom())
    for slot in hit:
        image[MANEUVER_AT + SLOT_BYTES * slot + 30] ^= 1
    board.power_cycle(bytes(image))
    assert_refused(board, ErrorCode.STORE_DAMAGED)
    assert connect(board).upload(NEW).stored.strokes == rows(NEW)
    for _ in range(2):
        assert connect(board).arm() == SequencerState.ARMED
        board.power_cycle()
