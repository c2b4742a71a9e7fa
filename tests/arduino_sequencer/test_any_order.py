"""Requests, repeats, late copies, power cycles, resets, jogs, knocks and drops in any order, against a model."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from dataclasses import replace

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import precondition, rule

from tests.arduino_sequencer.maneuvers import RawManeuver
from tests.arduino_sequencer.model import ARMED, DONE, FAULT, JOGGING
from tests.arduino_sequencer.servo_model import FACTORY_SERVO, FACTORY_SETTINGS
from tests.arduino_sequencer.side_by_side import STORE_US, SideBySide
from tests.arduino_sequencer.store_model import (
    MANEUVER_AT,
    MANEUVER_USED_BYTES,
    SETTINGS_AT,
    SETTINGS_USED_BYTES,
    SLOT_BYTES,
)
from tests.fixtures.sequencer.board import STROKE_LINE, Board, ResetCause
from tests.fixtures.sequencer.cable import NEW, OLD, connect
from tests.fixtures.sequencer.pulses import pulses, release
from tfsat_host.maneuver import Maneuver, Stroke, schedule_maneuver
from tfsat_host.protocol.framing import Frame, crc16
from tfsat_host.protocol.limits import JOG_CONFIRM, START_POSE_TOLERANCE_CDEG
from tfsat_host.protocol.messages import (
    ArmRequest,
    DisarmRequest,
    JogRequest,
    JointReportRequest,
    ManeuverBeginRequest,
    ManeuverCommitRequest,
    ManeuverStrokeRequest,
    ServoSetting,
    SettingsWriteRequest,
)
from tfsat_host.protocol.record import Payload

FACTORY = RawManeuver.of(OLD)
MANEUVERS = [
    RawManeuver.of(NEW),
    FACTORY,
    RawManeuver(17_000, ((3, 9000, 700_000),)),
    RawManeuver(40_000, ((2, 1, 700_000), (2, -1, 710_000))),
    # All three joints at once, and one more while the third is under way.
    RawManeuver(40_000, ((1, 9000, 700_000), (2, 9000, 700_000), (3, 4000, 760_000), (2, -9000, 930_000))),
    RawManeuver(17_000, ((1, 9001, 700_000),)),  # the board refuses it
]
NARROW = replace(FACTORY_SERVO, max_cdeg=4150)
SETTINGS = [
    FACTORY_SETTINGS,
    SettingsWriteRequest(10_000, (ServoSetting(2100, 11_000, 1, 0, 9000), FACTORY_SERVO, FACTORY_SERVO), 3),
    SettingsWriteRequest(20_000, (NARROW, FACTORY_SERVO, NARROW), 2),  # NEW and the shortest fit, no other
    # As an earlier firmware stored them: one joint at a time.
    SettingsWriteRequest(20_000, (FACTORY_SERVO,) * 3, 0),
]
SENSELESS = [
    SettingsWriteRequest(20_000, (replace(FACTORY_SERVO, zero_us=499), FACTORY_SERVO, FACTORY_SERVO), 1),
    SettingsWriteRequest(20_000, (FACTORY_SERVO, replace(FACTORY_SERVO, reversed=2), FACTORY_SERVO), 1),
    SettingsWriteRequest(20_000, (FACTORY_SERVO, FACTORY_SERVO, replace(FACTORY_SERVO, max_cdeg=0)), 1),
    SettingsWriteRequest(4999, (FACTORY_SERVO,) * 3, 1),
    SettingsWriteRequest(20_000, (FACTORY_SERVO,) * 3, 4),
]
START_POSES = [(0, 0, 0), (START_POSE_TOLERANCE_CDEG, -START_POSE_TOLERANCE_CDEG, 12)]
OTHER_POSES = [(0, 0, START_POSE_TOLERANCE_CDEG + 1), (-32_768, 0, 0)]


class AnyOrder(SideBySide):
    """What a host, a cable, a supply and two hands can do to a board."""

    @rule(count=st.sampled_from([0, 1, 2, 4, 16, 17]), speed=st.sampled_from([0, 17_000, 40_000]))
    def begin(self, count: int, speed: int) -> None:
        self.request(ManeuverBeginRequest(count, speed))

    @rule(raw=st.sampled_from(MANEUVERS), index=st.integers(0, 4))
    def stroke(self, raw: RawManeuver, index: int) -> None:
        self.request(ManeuverStrokeRequest(index, *raw.strokes[index % len(raw.strokes)]))

    @rule(raw=st.sampled_from(MANEUVERS), skip=st.none() | st.integers(0, 5), times=st.integers(1, 2))
    def upload(self, raw: RawManeuver, skip: int | None, times: int) -> None:
        """Upload a maneuver `times` times, leaving out frame `skip` unless it is None."""
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

    @rule()
    def get_ready_and_arm(self) -> None:
        """Prepare the board and arm it as an operator does; other obstacles may still forbid arming."""
        self.hang_in_the_releaser()
        self.request(DisarmRequest())
        self.read_the_token()
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
        self.board.run(2000)
        self.board.read()

    @rule(index=st.integers(0, 1))
    def move_a_switch(self, index: int) -> None:
        if self.opened == 1 << index:
            self.close_both()
        else:
            self.board.switch(index, closed=not self.board.closed[index])
        self.settle()

    @rule()
    def hang_in_the_releaser(self) -> None:
        if self.opened:
            self.close_both()
            self.settle()

    @precondition(lambda self: self.model.state == ARMED)
    @rule()
    def drop(self) -> None:
        for index in (0, 1):
            self.board.switch(index, closed=False)
        self.settle()

    @rule(open_us=st.integers(1, 4900))
    def knock(self, open_us: int) -> None:
        """Open both switches for `open_us`, less than the debounce, then put them back as they were."""
        before = list(self.board.closed)
        for index in (0, 1):
            self.board.switch(index, closed=False)
        if self.model.state == ARMED and any(before):
            self.model.touched = True
        self.board.run(open_us)
        if all(before):
            self.close_both()
        for index, closed in enumerate(before):
            self.board.switch(index, closed=closed)
        self.settle()

    @rule(ms=st.integers(1, 3000))
    def wait(self, ms: int) -> None:
        self.board.run(1000 * ms)
        self.catch_up()

    @precondition(lambda self: self.model.state == JOGGING or not self.model.at_start_pose())
    @rule(s=st.sampled_from([15, 31]))
    def wait_long(self, s: int) -> None:
        """Jogs and reports grow old."""
        self.board.run(1_000_000 * s)
        self.catch_up()

    @rule(angles_cdeg=st.sampled_from([*START_POSES, *OTHER_POSES]))
    def report_joints(self, angles_cdeg: tuple[int, ...]) -> None:
        self.request(JointReportRequest(angles_cdeg))

    @rule(
        joint=st.sampled_from([1, 2, 3, 1, 2, 3, 0, 4]),
        from_cdeg=st.sampled_from([0, 4000, 4150, 4151, 9000, -1, 9001]),
        to_cdeg=st.integers(0, 4150) | st.sampled_from([4151, 9000, -1, 9001, 32_767]),
        confirm=st.sampled_from([*[JOG_CONFIRM] * 4, 0, JOG_CONFIRM + 1]),
    )
    def jog(self, joint: int, from_cdeg: int, to_cdeg: int, confirm: int) -> None:
        self.request(JogRequest(joint, from_cdeg, to_cdeg, confirm))

    @precondition(lambda self: self.model.jogged is not None)
    @rule(to_cdeg=st.integers(0, 4150))
    def jog_on(self, to_cdeg: int) -> None:
        """Continue a jog with another `from` angle, which the board heeds only at the start of a jog."""
        assert self.model.jogged is not None
        self.request(JogRequest(self.model.jogged.joint, 9001, to_cdeg, JOG_CONFIRM))

    @rule(settings_request=st.sampled_from([*SETTINGS, *SENSELESS]), times=st.integers(1, 2))
    def write_settings(self, settings_request: SettingsWriteRequest, times: int) -> None:
        for _ in range(times):
            self.request(settings_request)

    @rule(settings_request=st.sampled_from(SETTINGS), data=st.data())
    def ask_while_settings_are_stored(
        self, settings_request: SettingsWriteRequest, data: st.DataObject
    ) -> None:
        others: list[Payload] = [*SETTINGS, ArmRequest(self.model.token), JogRequest(1, 0, 100, JOG_CONFIRM)]
        others += [request for request in self.sent if isinstance(request, ManeuverCommitRequest)]
        self.send(settings_request, await_stores=False)
        for other in data.draw(st.lists(st.sampled_from(others), min_size=1, max_size=4)):
            self.send(other, await_stores=False)
        self.await_stores()

    @rule(joint=st.integers(1, 3), to_cdeg=st.integers(0, 4150))
    def put_aside_and_jog(self, joint: int, to_cdeg: int) -> None:
        self.request(DisarmRequest())
        self.read_the_token()
        self.request(JogRequest(joint, 4150, to_cdeg, JOG_CONFIRM))

    @precondition(lambda self: self.model.jogged is not None)
    @rule()
    def pull_the_cable_from_a_jog(self) -> None:
        self.pull_the_cable()

    @rule()
    def pull_the_cable(self) -> None:
        self.board.cable(False)
        self.board.run(2000)
        self.board.cable(True)
        self.model.end_jog()

    @rule(cause=st.sampled_from([None, *ResetCause]))
    def start_again(self, cause: ResetCause | None) -> None:
        self.restart(cause)

    @rule(
        flips=st.lists(
            st.tuples(
                st.booleans(),
                st.integers(0, 1),
                st.integers(0, 11) | st.integers(0, MANEUVER_USED_BYTES - 1),
                st.integers(0, 7),
            ),
            min_size=1,
            max_size=2,
        )
    )
    def bits_turn_over_in_the_dark(self, flips: list[tuple[bool, int, int, int]]) -> None:
        """Flip bits of the stored or erased EEPROM while the power is off, marker and generation included."""
        turned = []
        for of_settings, slot, byte, bit in flips:
            if of_settings:
                at, used_bytes = SETTINGS_AT, SETTINGS_USED_BYTES
                self.model.settings.slots[slot].flip(byte % used_bytes, bit)
            else:
                at, used_bytes = MANEUVER_AT, MANEUVER_USED_BYTES
                self.model.maneuver.slots[slot].flip(byte % used_bytes, bit)
            turned.append((at + slot * SLOT_BYTES + byte % used_bytes, bit))
        self.restart(None, turned)

    @rule()
    def store_both_anew(self) -> None:
        """Store maneuver and settings anew as STORE_DAMAGED demands: repeat until all is reported as stored."""
        self.request(DisarmRequest())
        for request in [*FACTORY.requests(), *[ManeuverCommitRequest(crc16(FACTORY.canonical()))] * 2]:
            self.request(request)
        for _ in range(3):
            self.request(FACTORY_SETTINGS)

    @precondition(lambda self: self.model.state == ARMED)
    @rule(cause=st.sampled_from(list(ResetCause)), opened=st.sampled_from([(), (0,), (1,)]))
    def reset_while_armed(self, cause: ResetCause, opened: tuple[int, ...]) -> None:
        for index in opened:
            self.board.switch(index, closed=False)
        self.settle()
        self.restart(cause)

    @precondition(lambda self: self.model.state == ARMED)
    @rule(cause=st.sampled_from(list(ResetCause)), ms=st.integers(0, 2400))
    def drop_and_reset(self, cause: ResetCause, ms: int) -> None:
        self.drop()
        self.board.run(1000 * ms)
        self.restart(cause)

    @precondition(lambda self: self.model.state in (FAULT, JOGGING, DONE))
    @rule(cause=st.sampled_from(list(ResetCause)))
    def reset_again(self, cause: ResetCause) -> None:
        self.restart(cause)


@pytest.fixture
def machine(board_library: ctypes.CDLL) -> Iterator[type[AnyOrder]]:
    AnyOrder.library = board_library
    yield AnyOrder
    del AnyOrder.library


@pytest.mark.parametrize("examples", [25, pytest.param(250, marks=pytest.mark.prove)])
def test_any_order(machine: type[AnyOrder], examples: int) -> None:
    case = machine.TestCase
    case.settings = settings(max_examples=examples, stateful_step_count=40)
    case("runTest").debug()


def test_the_model_flies(board: Board) -> None:
    """Fly the shortest strokes that the model knows: 0.01 deg, 10 ms apart on one joint."""
    sequencer = connect(board)
    for request in MANEUVERS[3].requests():
        board.ask(Frame(request.TYPE, 1, request.encode()))
    board.run(STORE_US)
    sequencer.arm()
    board.switch(0, closed=False)
    board.switch(1, closed=False)
    released_ns = 1000 * board.now_us
    board.run(800_000)
    edges = board.edges()
    assert [p.rise_ns - released_ns for p in pulses(edges, STROKE_LINE)] == [700_000_000, 710_000_000]


def test_status_of_a_shorter_maneuver_after_a_run(board: Board) -> None:
    """STATUS counts the last run's strokes; a maneuver uploaded since may have fewer."""
    sequencer = connect(board)
    sequencer.arm()
    release(board)
    board.run(2_500_000)
    for index in (0, 1):
        board.switch(index, closed=True)
    sequencer.disarm()
    sequencer.upload(schedule_maneuver(Maneuver((Stroke(3, 77.0),))))
    status = sequencer.status()
    assert (status.strokes_started, status.joint_angle_cdeg) == (4, (0, 0, 0))
