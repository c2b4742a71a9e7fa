"""Requests, repeats, late copies, power cycles, resets, knocks and drops in any order, against a model."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from tests.sequencer.board import NEW, OLD, STROKE_LINE, Board, Reset, connect, pulses
from tests.sequencer.maneuvers import RawManeuver, defect
from tfsat_host.protocol.enums import ErrorCode, ManeuverOrigin, SequencerState
from tfsat_host.protocol.framing import Frame, crc16
from tfsat_host.protocol.messages import (
    ArmReply,
    ArmRequest,
    DisarmReply,
    DisarmRequest,
    ErrorReply,
    ManeuverBeginReply,
    ManeuverBeginRequest,
    ManeuverCommitReply,
    ManeuverCommitRequest,
    ManeuverStrokeReply,
    ManeuverStrokeRequest,
)
from tfsat_host.protocol.record import Payload

SAFE, ARMED, RUNNING, DONE = list(SequencerState)[:4]
FACTORY = RawManeuver.of(OLD)
MANEUVERS = [
    RawManeuver.of(NEW),
    FACTORY,
    RawManeuver(17_000, ((3, 9000, 700_000),)),
    RawManeuver(40_000, ((2, 1, 700_000), (2, -1, 710_000))),
    RawManeuver(17_000, ((1, 9001, 700_000),)),  # the board refuses it
]
SETTLE_US = 10_000
STORE_US = 600_000


@dataclass
class Model:
    """What the board must hold and be in."""

    stored: RawManeuver = FACTORY
    origin: ManeuverOrigin = ManeuverOrigin.FACTORY
    generation: int = 0
    state: SequencerState = SAFE
    token: int = 0
    accepted_token: int = -1
    refusal: ErrorCode = ErrorCode.NONE
    knocks: int = 0
    touched: bool = False
    run_from_us: int = 0
    staged: tuple[int, int] | None = None
    strokes: dict[int, tuple[int, int, int]] = field(default_factory=dict)
    written: bool = False

    def restart(self) -> None:
        """Power or reset: what the EEPROM holds stays."""
        fresh = Model(self.stored, self.origin, self.generation)
        self.__dict__.update(fresh.__dict__)

    def error(self, request: Payload, code: ErrorCode, detail: int = -1) -> ErrorReply:
        return ErrorReply(request.TYPE, code, detail)

    def answer(self, request: Payload, opened: int) -> Payload:
        """The reply that `request` must get, and what it changes."""
        if isinstance(request, ArmRequest):
            return self.arm(request, opened)
        if isinstance(request, DisarmRequest):
            self.state = SAFE
            return DisarmReply(SAFE)
        if self.state != SAFE:
            return self.error(request, ErrorCode.WRONG_STATE)
        if isinstance(request, ManeuverBeginRequest):
            return self.begin(request)
        if self.staged is None:
            return self.error(request, ErrorCode.NO_STAGED_MANEUVER)
        if isinstance(request, ManeuverStrokeRequest):
            if request.index >= self.staged[0]:
                return self.error(request, ErrorCode.INDEX_OUT_OF_RANGE, request.index)
            self.strokes[request.index] = (request.joint, request.angle_cdeg, request.start_us)
            return ManeuverStrokeReply(request.index)
        assert isinstance(request, ManeuverCommitRequest)
        return self.commit(request, self.staged)

    def arm(self, request: ArmRequest, opened: int) -> Payload:
        if self.state == ARMED and request.arm_token == self.accepted_token:
            return ArmReply(ARMED)
        self.refusal = ErrorCode.NONE
        if self.state not in (SAFE, DONE):
            self.refusal = ErrorCode.WRONG_STATE
        elif request.arm_token != self.token:
            self.refusal = ErrorCode.STALE_TOKEN
        elif opened:
            self.refusal = ErrorCode.SWITCH_OPEN
        if self.refusal != ErrorCode.NONE:
            return self.error(request, self.refusal, opened)
        self.state, self.accepted_token = ARMED, request.arm_token
        self.knocks, self.touched = 0, False
        return ArmReply(ARMED)

    def begin(self, request: ManeuverBeginRequest) -> Payload:
        if not 1 <= request.stroke_count <= 16:
            return self.error(request, ErrorCode.TOO_MANY_STROKES, request.stroke_count)
        self.staged, self.strokes, self.written = (request.stroke_count, request.speed_cdeg_s), {}, False
        return ManeuverBeginReply(request.stroke_count)

    def commit(self, request: ManeuverCommitRequest, staged: tuple[int, int]) -> Payload:
        missing = [index for index in range(staged[0]) if index not in self.strokes]
        if missing:
            return self.error(request, ErrorCode.STEP_MISSING, missing[0])
        raw = RawManeuver(staged[1], tuple(self.strokes[index] for index in range(staged[0])))
        if request.crc != crc16(raw.canonical()):
            return self.error(request, ErrorCode.CRC_MISMATCH)
        code, detail = defect(raw)
        if code != ErrorCode.NONE:
            return self.error(request, code, detail)
        if raw == self.stored and self.origin == ManeuverOrigin.UPLOADED:
            return ManeuverCommitReply(1, int(self.written))
        self.stored, self.origin, self.generation = raw, ManeuverOrigin.UPLOADED, self.generation + 1
        self.written = True
        return ManeuverCommitReply(0, 1)


class AnyOrder(RuleBasedStateMachine):
    """The board and its model, side by side."""

    library: ctypes.CDLL

    def __init__(self) -> None:
        super().__init__()
        self.board = Board(self.library)
        self.model = Model()
        self.sent: list[Payload] = []
        self.tokens: dict[int, SequencerState] = {}
        self.sequence = 0

    @initialize()
    def learn_the_token(self) -> None:
        self.model.token = connect(self.board).status().arm_token
        self.tokens = {self.model.token: SAFE}

    @property
    def opened(self) -> int:
        return sum(1 << index for index, opened in self.board.opened.items() if opened)

    def send(self, request: Payload) -> None:
        self.let_the_run_end()
        self.sequence = (self.sequence + 1) & 0xFF
        expected = self.model.answer(request, self.opened)
        (answer,) = self.board.ask(Frame(request.TYPE, self.sequence, request.encode()))
        assert answer.sequence == self.sequence
        assert answer.type == expected.TYPE, (request, answer, expected)
        assert type(expected).decode(answer.payload) == expected, (request, answer, expected)
        if isinstance(request, ManeuverCommitRequest):
            self.board.advance(STORE_US)

    def request(self, request: Payload) -> None:
        self.send(request)
        self.sent.append(request)

    def let_the_run_end(self) -> None:
        """The model follows time; nothing is asked within a millisecond of the end of the run."""
        if self.model.state != RUNNING:
            return
        _, angle_cdeg, start_us = self.model.stored.strokes[-1]
        end_us = start_us - (-abs(angle_cdeg) * 1_000_000 // self.model.stored.speed_cdeg_s)
        left_us = self.model.run_from_us + end_us - self.board.now_us
        if left_us < 20_000:
            self.board.advance(max(0, left_us) + 1000)
            self.model.state = DONE

    def settle(self) -> None:
        """After the switches moved: what the release detector must have made of it."""
        moved_us = self.board.now_us
        self.board.advance(SETTLE_US)
        model = self.model
        if model.state != ARMED:
            return
        model.touched |= self.opened != 0
        if self.opened == 3:
            model.state, model.run_from_us, model.touched = RUNNING, moved_us, False
        elif self.opened == 0 and model.touched:
            model.touched = False
            model.knocks += 1

    @rule(count=st.sampled_from([0, 1, 2, 4, 16, 17]), speed=st.sampled_from([0, 17_000, 40_000]))
    def begin(self, count: int, speed: int) -> None:
        self.request(ManeuverBeginRequest(count, speed))

    @rule(raw=st.sampled_from(MANEUVERS), index=st.integers(0, 4))
    def stroke(self, raw: RawManeuver, index: int) -> None:
        self.request(ManeuverStrokeRequest(index, *raw.strokes[index % len(raw.strokes)]))

    @rule(raw=st.sampled_from(MANEUVERS), skip=st.none() | st.integers(0, 5), times=st.integers(1, 2))
    def upload(self, raw: RawManeuver, skip: int | None, times: int) -> None:
        """A whole upload, or one that lost a frame; once, or all of it again."""
        for _ in range(times):
            for number, request in enumerate(raw.requests()):
                if number != skip:
                    self.request(request)

    @rule(raw=st.sampled_from(MANEUVERS))
    def commit(self, raw: RawManeuver) -> None:
        self.request(ManeuverCommitRequest(crc16(raw.canonical())))

    @rule()
    def arm(self) -> None:
        self.request(ArmRequest(self.model.token))

    @rule(offset=st.integers(1, 0xFFFF))
    def arm_with_another_token(self, offset: int) -> None:
        self.request(ArmRequest((self.model.token + offset) & 0xFFFF))

    @rule()
    def disarm(self) -> None:
        self.request(DisarmRequest())

    @precondition(lambda self: self.sent)
    @rule(copies=st.integers(1, 3))
    def repeat_the_last(self, copies: int) -> None:
        for _ in range(copies):
            self.send(self.sent[-1])

    @precondition(lambda self: self.sent)
    @rule(data=st.data())
    def a_late_copy(self, data: st.DataObject) -> None:
        self.send(data.draw(st.sampled_from(self.sent)))

    @rule(noise=st.binary(max_size=40))
    def noise(self, noise: bytes) -> None:
        self.board.write(noise + b"\0")
        self.board.advance(2000)
        self.board.read()

    @rule(index=st.integers(0, 1))
    def move_a_switch(self, index: int) -> None:
        self.board.switch(index, opened=not self.board.opened[index])
        self.settle()

    @rule()
    def hang_in_the_releaser(self) -> None:
        for index in (0, 1):
            self.board.switch(index, opened=False)
        self.settle()

    @rule()
    def drop(self) -> None:
        for index in (0, 1):
            self.board.switch(index, opened=True)
        self.settle()

    @rule(open_us=st.integers(1, 4900))
    def knock(self, open_us: int) -> None:
        """Both open for less than the debounce, then as they were."""
        before = dict(self.board.opened)
        for index in (0, 1):
            self.board.switch(index, opened=True)
        if self.model.state == ARMED and not all(before.values()):
            self.model.touched = True
        self.board.advance(open_us)
        for index, opened in before.items():
            self.board.switch(index, opened=opened)
        self.settle()

    @rule(ms=st.integers(1, 3000))
    def wait(self, ms: int) -> None:
        self.board.advance(1000 * ms)
        self.let_the_run_end()

    @rule(cause=st.none() | st.sampled_from(list(Reset)))
    def start_again(self, cause: Reset | None) -> None:
        """USB goes down with a reset, so that no frame from before it can arrive after it."""
        if cause is None:
            self.board.power_cycle()
        else:
            self.board.reset(cause)
            self.board.advance(1000)
        self.board.edges()
        self.model.restart()
        self.sent.clear()
        self.tokens.clear()
        self.learn_the_token()

    @invariant()
    def the_board_is_what_the_model_says(self) -> None:
        if not self.tokens:
            return
        self.let_the_run_end()
        sequencer, model = connect(self.board), self.model
        status = sequencer.status()
        assert status.state == model.state
        assert (status.fault, status.last_refusal) == (ErrorCode.NONE, model.refusal)
        assert (status.knocks, status.switches_open) == (model.knocks, self.opened)
        held = sequencer.read_back()
        assert (held.strokes, held.speed_cdeg_s) == (model.stored.strokes, model.stored.speed_cdeg_s)
        assert (held.origin, held.generation) == (model.origin, model.generation)
        known = self.tokens.get(status.arm_token)
        if status.arm_token != model.token:
            assert known is None, "a token came back"
        else:
            assert known == model.state, "the state changed, the token did not"
        self.tokens[status.arm_token] = model.state
        model.token = status.arm_token
        self.the_pins_fit(status.strokes_started)

    def the_pins_fit(self, strokes_started: int) -> None:
        if self.model.state == DONE:
            assert strokes_started == len(self.model.stored.strokes)
        if self.model.state == SAFE and len(self.tokens) == 1:  # never armed since it started
            assert self.board.edges() == []
        if self.model.state == RUNNING:
            late_us = self.board.now_us - self.model.run_from_us
            begun = [start_us <= late_us for _, _, start_us in self.model.stored.strokes]
            assert abs(strokes_started - sum(begun)) <= 1


@pytest.fixture
def machine(board_library: ctypes.CDLL) -> Iterator[type[AnyOrder]]:
    AnyOrder.library = board_library
    yield AnyOrder
    del AnyOrder.library


def test_any_order(machine: type[AnyOrder]) -> None:
    case = machine.TestCase
    case.settings = settings(max_examples=80, stateful_step_count=40)
    case("runTest").debug()


def test_the_model_flies(board: Board) -> None:
    """The shortest strokes that the model knows: 0.01 deg, 10 ms apart on one joint."""
    sequencer = connect(board)
    for request in MANEUVERS[3].requests():
        board.ask(Frame(request.TYPE, 1, request.encode()))
    board.advance(STORE_US)
    sequencer.arm()
    board.switch(0, opened=True)
    board.switch(1, opened=True)
    released_ns = 1000 * board.now_us
    board.advance(800_000)
    edges = board.edges()
    assert [p.rise_ns - released_ns for p in pulses(edges, STROKE_LINE)] == [700_000_000, 710_000_000]
