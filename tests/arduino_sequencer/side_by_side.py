"""The board and its model side by side: every request asked of both, every state compared."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant

from tests.arduino_sequencer.maneuvers import RawManeuver
from tests.arduino_sequencer.model import ARMED, DONE, FAULT, RUNNING, SAFE, Model
from tests.arduino_sequencer.store_model import Store
from tests.fixtures.sequencer.board import ERASED, ResetCause
from tests.fixtures.sequencer.cable import OLD, client, connect, native_board
from tests.fixtures.sequencer.pulses import pulses
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.limits import RELEASE_SEATED_US, SERVO_PULSE_MAX_US, STROKE_NOT_BEGUN_US
from tfsat_host.protocol.messages import (
    JogReply,
    RunReportReply,
    RunReportRequest,
    SequencerStatusReply,
    SettingsReadReply,
    SettingsReadRequest,
    SettingsWriteRequest,
)
from tfsat_host.protocol.record import Payload

SETTLE_US = 10_000
STORE_US = 600_000
NO_RUN = RunReportReply(0, 0, 0, 0, 0, (STROKE_NOT_BEGUN_US,) * 16, 0, 0)
JOG_TOLERANCE_CDEG = 3  # the board's milliseconds against the model's microseconds


class SideBySide(RuleBasedStateMachine):
    """What rules are made of, and what must hold after each."""

    library: ctypes.CDLL

    def __init__(self) -> None:
        super().__init__()
        self.board = native_board(self.library, ERASED)
        self.model = Model(Store(RawManeuver.of(OLD)))
        self.sent: list[Payload] = []
        self.tokens: dict[int, SequencerState] = {}
        self.sequence = 0
        self.started_us = 0
        self.released_us = 0  # of the last run, since the board had started
        self.report: RunReportReply | None = NO_RUN  # of the last run, once it had ended

    @initialize(uploaded=st.sampled_from([True, True, True, False]))
    def take_a_board(self, uploaded: bool) -> None:
        """Start with a new board, or with one that already has a maneuver."""
        if uploaded:
            self.board = native_board(self.library)
            self.model.maneuver.store_record(RawManeuver.of(OLD))
            self.model.maneuver.busy = False
        self.learn_the_token()

    def learn_the_token(self) -> None:
        self.model.token = connect(self.board).status().arm_token
        assert self.model.token not in self.tokens, "a token came back"
        self.tokens[self.model.token] = self.model.state

    def read_the_token(self) -> None:
        """Read the arm token: it is unchanged and so is the state, or it was never used before."""
        token, state = connect(self.board).status().arm_token, self.model.state
        if token != self.model.token:
            assert token not in self.tokens, "a token came back"
        else:
            # A new state without a new token would let an old ARM through.
            assert self.tokens[token] == state, "the state changed, the token did not"
        self.tokens[token] = state
        self.model.token = token

    @property
    def opened(self) -> int:
        return sum(1 << index for index, closed in enumerate(self.board.closed) if not closed)

    def send(self, request: Payload, *, await_stores: bool = True) -> None:
        self.catch_up()
        self.sequence = (self.sequence + 1) & 0xFF
        expected = self.model.answer(request, self.opened, self.board.now_us)
        (answer,) = self.board.ask(Frame(request.TYPE, self.sequence, request.encode()))
        # An answer to another request would be judged as this one's.
        assert answer.sequence == self.sequence
        assert answer.type == expected.TYPE, (request, answer, expected)
        reply = type(expected).decode(answer.payload)
        if isinstance(reply, JogReply) and isinstance(expected, JogReply):
            self.on_its_way(reply, expected)
        else:
            assert reply == expected, request
        if await_stores:
            self.await_stores()

    def on_its_way(self, reply: JogReply, expected: JogReply) -> None:
        """Check a jog reply against the model, and set the model's joint to the angle that the board reports."""
        jogged = self.model.jogged
        assert jogged is not None
        assert abs(reply.angle_cdeg - expected.angle_cdeg) <= JOG_TOLERANCE_CDEG
        assert reply.arrived == (reply.angle_cdeg == jogged.to_cdeg)
        # The board's milliseconds against the model's microseconds: the model follows the board.
        jogged.from_cdeg = reply.angle_cdeg

    def await_stores(self) -> None:
        if self.model.storing:
            self.board.run(STORE_US)
            self.model.maneuver.busy = self.model.settings.busy = False

    def request(self, request: Payload) -> None:
        self.send(request)
        self.sent.append(request)

    def pass_by(self, moment_us: int) -> bool:
        """Leaves no moment within 20 ms ahead or 1 ms behind; True once it lies behind."""
        left_us = moment_us - self.board.now_us
        # Moments too near to a change are avoided: both sides may be right there.
        if -1000 < left_us < 20_000:
            self.board.run(left_us + 1000)
        return self.board.now_us > moment_us

    def catch_up(self) -> None:
        """Advance the model to the board's time, keeping requests clear of timed state changes."""
        model = self.model
        if model.state == RUNNING and model.hangs_us() < model.run_ends_us():
            if self.pass_by(model.hangs_us()):
                model.end_false_run()
                self.report = NO_RUN if model.state == ARMED else self.report
        elif model.state == RUNNING and self.pass_by(model.run_ends_us()):
            model.state = DONE
        if model.jogged is not None and self.pass_by(model.jogged.ends_us):
            model.end_jog()
        self.pass_by(model.report_ends_us())

    def close_both(self) -> None:
        """Close both switches, but not when that would revoke a release at the very moment of a stroke."""
        if self.model.state == RUNNING:
            for _, _, start_us in self.model.maneuver.record.strokes:
                self.pass_by(self.model.run_from_us + start_us - RELEASE_SEATED_US)
        for index in (0, 1):
            self.board.switch(index, closed=True)

    def settle(self) -> None:
        """Wait until the switches have settled, then update the model with the release detector's result."""
        moved_us = self.board.now_us
        self.model.closed_from_us = moved_us if self.opened == 0 else None
        self.board.run(SETTLE_US)
        if self.model.switches_stand(self.opened, moved_us):
            # The release's time is of the board's own clock since its start.
            self.report, self.released_us = None, moved_us - self.started_us

    def restart(self, cause: ResetCause | None, flips: Iterable[tuple[int, int]] = ()) -> None:
        """Restart the board and the model, by a power cut if `cause` is None.

        Requests sent before a reset may still arrive late; after a power cut, tokens begin again. `flips` are
        the EEPROM bits (address, bit) that flip while there is no power.
        """
        self.catch_up()
        if self.model.state == RUNNING:
            for _, _, start_us in self.model.maneuver.record.strokes:
                self.pass_by(self.model.run_from_us + start_us + SERVO_PULSE_MAX_US)
            self.catch_up()
        reset_us = self.board.now_us
        if cause is None:
            image = bytearray(self.board.eeprom())
            for address, bit in flips:
                image[address] ^= 1 << bit
            self.board.power_cycle(bytes(image))
            self.sent.clear()
            self.tokens.clear()
            self.report = NO_RUN
            self.started_us = self.board.now_us - 1000
        else:
            self.board.reset(cause)
            self.started_us = reset_us
        self.board.edges()
        self.board.run(SETTLE_US)
        self.model.restart(power_lost=cause is None, opened=self.opened, now_us=reset_us)
        self.learn_the_token()
        self.servos_are_held(self.model.held_ns())

    def servos_are_held(self, widths_ns: tuple[int, ...]) -> None:
        """Since the edges were last taken: pulses of these widths and no other, or none at all."""
        self.board.run(50_000)
        edges = self.board.edges()
        if not widths_ns:
            assert edges == []
        for pin, width_ns in enumerate(widths_ns):
            assert {pulse.width_ns for pulse in pulses(edges, pin)} == {width_ns}

    @invariant()
    def the_board_is_what_the_model_says(self) -> None:
        if not self.tokens:
            return
        self.catch_up()
        sequencer, model = connect(self.board), self.model
        status = sequencer.status()
        assert (status.state, status.fault) == (model.state, model.fault)
        assert (status.last_refusal, status.resets_while_armed) == (model.refusal, model.resets)
        assert (status.knocks, status.switches_open) == (model.knocks, self.opened)
        assert status.false_releases == model.false_releases
        stored_maneuver = sequencer.read_back()
        assert (stored_maneuver.strokes, stored_maneuver.speed_cdeg_s) == (
            model.maneuver.record.strokes,
            model.maneuver.record.speed_cdeg_s,
        )
        assert (stored_maneuver.origin, stored_maneuver.generation) == (
            model.maneuver.origin,
            model.maneuver.generation,
        )
        self.settings_are_kept()
        self.read_the_token()
        self.the_pins_fit(status)
        self.the_run_is_reported(status.strokes_started)

    def settings_are_kept(self) -> None:
        store = self.model.settings
        settings_reply = client(self.board).request(SettingsReadRequest(), SettingsReadReply)
        assert (settings_reply.origin, settings_reply.generation) == (store.origin, store.generation)
        assert (
            SettingsWriteRequest(settings_reply.frame_us, settings_reply.servo, settings_reply.moving_at_once)
            == store.record
        )

    def the_pins_fit(self, status: SequencerStatusReply) -> None:
        model = self.model
        if model.state == DONE:
            strokes = len(model.maneuver.record.strokes)
            assert status.strokes_started == strokes
            assert status.joint_angle_cdeg == model.angles_cdeg(strokes)
        if model.state == FAULT:
            assert status.joint_angle_cdeg == model.held_cdeg
        if model.state in (SAFE, ARMED):
            assert status.joint_angle_cdeg == (0, 0, 0)
        if model.state == SAFE and len(self.tokens) == 1:  # never armed or jogged since it started
            assert self.board.edges() == []
        if model.state == RUNNING:
            # A stroke may begin between the two looks at it.
            assert (
                abs(status.strokes_started - model.strokes_begun(self.board.now_us)) <= self.most_together()
            )
        if model.jogged is not None:
            now_cdeg = model.jogged.angle_cdeg(self.board.now_us)
            for joint, angle_cdeg in enumerate(status.joint_angle_cdeg, start=1):
                expected_cdeg = now_cdeg if joint == model.jogged.joint else 0
                assert abs(angle_cdeg - expected_cdeg) <= 20  # the invariant's own requests take 10 ms

    def most_together(self) -> int:
        """Return how many strokes begin at the same time at the most."""
        starts_us = [start_us for _, _, start_us in self.model.maneuver.record.strokes]
        return max(map(starts_us.count, starts_us))

    def the_run_is_reported(self, strokes_started: int) -> None:
        """Check the run report: times are in the board's own clock, and it stays the same until another run."""
        report = client(self.board).request(RunReportRequest(), RunReportReply)
        if self.report is not None:
            assert report == self.report
        else:
            release_us = self.released_us
            assert (report.released, report.bounces) == (1, 1)
            assert (report.release_ms, report.release_us) == divmod(release_us, 1000)
            starts_us = [start_us for _, _, start_us in self.model.maneuver.record.strokes]
            assert report.stroke_count == len(starts_us)
            begun = sum(start_us != STROKE_NOT_BEGUN_US for start_us in report.start_us)
            assert list(report.start_us) == starts_us[:begun] + [STROKE_NOT_BEGUN_US] * (16 - begun)
            if strokes_started or self.model.state != SAFE:  # SAFE may have come by a reset
                assert 0 <= begun - strokes_started <= self.most_together()
        if self.model.state != RUNNING:
            # The report must stay the same until another run.
            self.report = report
