"""Servo settings and a sequencer that misbehaves; the good cases are told by the native board."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import pytest

from tests.devices.scripted import Answer, ScriptedTransport, hello, reply
from tfsat_host.devices.client import VerifyError
from tfsat_host.devices.sequencer import STORE_TIMEOUT_S, SequencerClient
from tfsat_host.protocol.enums import Origin
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.messages import (
    HelloRequest,
    SettingsReadReply,
    SettingsReadRequest,
    SettingsWriteReply,
    SettingsWriteRequest,
)
from tfsat_host.protocol.record import Record
from tfsat_host.servo_settings import FACTORY, ServoSettings

WANTED = replace(FACTORY, frame_us=10_000)


class Sequencer:
    """Answers that a test may spoil."""

    def __init__(self) -> None:
        self.writes_until_stored = 3
        self.held = FACTORY
        self.kept = WANTED
        self.generation = 7

    def __call__(self, frame: Frame) -> Iterable[Answer]:
        return [reply(frame, self.answer(frame))]

    def answer(self, frame: Frame) -> Record:
        if frame.type == HelloRequest.TYPE:
            return hello()
        if frame.type == SettingsReadRequest.TYPE:
            return SettingsReadReply(Origin.UPLOADED, self.generation, self.held.frame_us, self.held.servos)
        assert frame.type == SettingsWriteRequest.TYPE
        self.writes_until_stored -= 1
        if self.writes_until_stored == 0 and self.held != self.kept:
            self.held = self.kept
            self.generation += 1
        return SettingsWriteReply(int(self.writes_until_stored <= 0), 1)


def sequencer(board: Sequencer) -> tuple[SequencerClient, ScriptedTransport]:
    transport = ScriptedTransport(board)
    return SequencerClient.connect(transport), transport


def test_the_write_is_repeated_until_it_is_stored() -> None:
    client, transport = sequencer(Sequencer())
    done = client.write_settings(WANTED)
    assert (done.written, done.stored.settings, done.stored.generation) == (True, WANTED, 8)
    assert [frame.type for frame in transport.requests] == [0x01, 0x16, *[0x15] * 3, 0x16]
    writes = {frame.payload for frame in transport.requests if frame.type == SettingsWriteRequest.TYPE}
    assert writes == {SettingsWriteRequest(WANTED.frame_us, WANTED.servos).encode()}


def test_whether_it_was_there_already_is_told_by_the_generation() -> None:
    """The board's `written` is about its last request of that content, which may be of an earlier upload."""
    board = Sequencer()
    board.held = WANTED
    assert sequencer(board)[0].write_settings(WANTED).written is False


OTHER_LIMIT = replace(WANTED.servos[2], max_cdeg=8999)


@pytest.mark.parametrize(
    "kept", [replace(WANTED, frame_us=10_001), replace(WANTED, servos=(*WANTED.servos[:2], OTHER_LIMIT))]
)
def test_what_is_read_back_must_be_what_was_sent(kept: ServoSettings) -> None:
    board = Sequencer()
    board.kept = kept
    with pytest.raises(VerifyError, match="was sent") as caught:
        sequencer(board)[0].write_settings(WANTED)
    assert "Do not arm" in caught.value.meaning


def test_a_board_that_writes_for_ever_is_given_up() -> None:
    board = Sequencer()
    board.writes_until_stored = 10**9
    client, transport = sequencer(board)
    started_s = transport.now_s()
    with pytest.raises(VerifyError, match="still writing") as caught:
        client.write_settings(WANTED)
    assert transport.now_s() - started_s == pytest.approx(STORE_TIMEOUT_S, abs=0.1)
    assert "settings from before are still in force" in caught.value.meaning
