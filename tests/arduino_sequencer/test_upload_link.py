"""Uploads over bad cables: the board holds the old or the new maneuver, whole."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from tests.arduino_sequencer.store_model import without_markers
from tests.fixtures.sequencer.board import Board
from tests.fixtures.sequencer.cable import NEW, OLD, Cable, connect, rows
from tfsat_host.devices.board_errors import BoardError, BoardRefusal, NoAnswer, VerifyError
from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.messages import (
    DisarmRequest,
    ManeuverBeginRequest,
    ManeuverCommitRequest,
)
from tfsat_host.protocol.record import ProtocolError

NewBoard = Callable[..., Board]


def why_not_armed(board: Board) -> ErrorCode:
    sequencer = connect(board)
    try:
        sequencer.arm()
    except BoardRefusal as refusal:
        return refusal.code
    sequencer.disarm()
    return ErrorCode.NONE


def held_after_power_cycle(board: Board) -> StoredManeuver:
    """Return the stored maneuver, the same from RAM and, after a power cycle, from EEPROM."""
    before = connect(board).read_back()
    assert connect(board).status().state == SequencerState.SAFE
    board.power_cycle()
    after = connect(board).read_back()
    assert before == after
    assert board.edges() == []
    return after


class LossyCable(Cable):
    """Drops, damages, cuts, doubles and delays what goes either way; late frames come out of order."""

    def __init__(self, board: Board, seed: int, rate: float) -> None:
        super().__init__(board)
        self._rng = random.Random(seed)
        self._rate = rate
        self._late: list[bytes] = []
        self.faults = 0

    def _fault(self) -> bool:
        hit = self._rng.random() < self._rate
        self.faults += hit
        return hit

    def _damage(self, data: bytes) -> bytes:
        kind = self._rng.randrange(4)
        at = self._rng.randrange(len(data))
        if kind == 0:
            return data[:at] + bytes([data[at] ^ self._rng.randint(1, 255)]) + data[at + 1 :]
        if kind == 1:
            return data[:at]
        if kind == 2:
            return data[:at] + self._rng.randbytes(self._rng.randint(1, 9)) + data[at:]
        return b""

    def write(self, data: bytes) -> None:
        if self._late and self._rng.random() < 0.3:
            super().write(self._late.pop(self._rng.randrange(len(self._late))))
        if self._fault():
            kind = self._rng.randrange(4)
            if kind == 0:
                self._late.append(data)
                return
            if kind == 1:
                self._late.append(data)
            data = data + data if kind == 2 else self._damage(data)
        super().write(data)

    def read(self, timeout_s: float) -> bytes:
        data = super().read(timeout_s)
        return self._damage(data) if data and self._fault() else data

    def deliver_late(self) -> None:
        """Deliver the remaining late frames, in any order."""
        self._rng.shuffle(self._late)
        for data in self._late:
            super().write(data)
            self.board.run(2000)


@pytest.mark.parametrize("rate", [0.02, 0.2, 0.5])
def test_a_lossy_cable_leaves_the_old_or_the_new_maneuver(new_board: NewBoard, rate: float) -> None:
    outcomes = {"old": 0, "new": 0, "verified": 0}
    for seed in range(40):
        board = new_board()
        connect(board).upload(OLD)
        cable = LossyCable(board, seed, rate)
        verified = False
        try:
            SequencerClient.connect(cable).upload(NEW)
            verified = True
        except (BoardError, NoAnswer, VerifyError, ProtocolError):
            pass
        cable.deliver_late()
        board.run(1_000_000)
        board.write(b"\0")
        stored_strokes = held_after_power_cycle(board).strokes
        assert stored_strokes in (rows(OLD), rows(NEW)), f"seed {seed}"
        assert stored_strokes == rows(NEW) or not verified, f"seed {seed}"
        outcomes["new" if stored_strokes == rows(NEW) else "old"] += 1
        outcomes["verified"] += verified
    assert outcomes["new"] >= outcomes["verified"]
    if rate < 0.3:
        assert outcomes["verified"] > 20  # repeats make up for what the cable loses
    if rate > 0.3:
        assert outcomes["old"] > 0


# ------------------------------------------------------------------ the cable is pulled


class CutCable(Cable):
    """Pulled after so many bytes to the board, at once or when the board has served them."""

    def __init__(self, board: Board, n_bytes: int, settle_us: int) -> None:
        super().__init__(board)
        self._left = n_bytes
        self._settle_us = settle_us

    def write(self, data: bytes) -> None:
        super().write(data[: self._left])
        self._left -= len(data)
        if self._left < 0:
            self.board.run(self._settle_us)
            self.board.cable(False)
            raise PortError(PortProblem.OTHER, what="The cable was pulled.", next_step="Plug it in.")


class CountingCable(Cable):
    """Counts the bytes to the board up to and with the first begin, and the first commit."""

    begun = 0
    committed = 0
    total = 0

    def write(self, data: bytes) -> None:
        super().write(data)
        self.total += len(data)
        types = {frame.type for frame in FrameReceiver().feed(data)}
        if not self.begun and ManeuverBeginRequest.TYPE in types:
            self.begun = self.total
        if not self.committed and ManeuverCommitRequest.TYPE in types:
            self.committed = self.total


@pytest.mark.parametrize("settle_us", [0, 60, 5000])
def test_cable_pulled_at_every_byte_of_an_upload(new_board: NewBoard, settle_us: int) -> None:
    reference_board = new_board()
    connect(reference_board).upload(OLD)
    image = reference_board.eeprom()
    counter = CountingCable(new_board(image))
    SequencerClient.connect(counter).upload(NEW)
    assert counter.committed > 60
    for n_bytes in range(counter.committed + 20):
        board = new_board(image)
        with pytest.raises(PortError):
            SequencerClient.connect(CutCable(board, n_bytes, settle_us)).upload(NEW)
        board.run(700_000)
        assert board.eeprom() == image or n_bytes >= counter.begun
        assert without_markers(board.eeprom()) == without_markers(image) or n_bytes >= counter.committed
        board.cable(True)
        stored_maneuver = held_after_power_cycle(board)
        stored = n_bytes >= counter.committed and (settle_us > 0 or n_bytes > counter.committed)
        if settle_us == 5000 or n_bytes != counter.committed:
            assert stored_maneuver.strokes == rows(NEW if stored else OLD), n_bytes
        if counter.begun < n_bytes < counter.committed:
            assert why_not_armed(board) == ErrorCode.UPLOAD_INTERRUPTED
        if n_bytes < counter.begun or n_bytes > counter.committed:
            assert why_not_armed(board) == ErrorCode.NONE
        assert stored_maneuver.strokes in (rows(OLD), rows(NEW))
        if n_bytes % 10 == 0:
            assert connect(board).upload(NEW).stored.strokes == rows(NEW)


def test_half_a_frame_before_the_cable_was_pulled_does_not_spoil_the_next(board: Board) -> None:
    frame = encode_frame(Frame(DisarmRequest.TYPE, 1, b""))
    for cut in range(1, len(frame)):
        board.write(frame[:cut])
        board.run(1000)
        board.cable(False)
        board.run(1000)
        board.cable(True)
        board.write(encode_frame(Frame(DisarmRequest.TYPE, 2, b"")))
        (answer,) = FrameReceiver().feed(board.read(10_000))
        assert answer.sequence == 2
