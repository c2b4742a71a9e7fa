"""The real host client talking to the emulated board."""

from __future__ import annotations

import ctypes
from pathlib import Path

from tests.arduino_sequencer.avr.avr_board import AvrBoard
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.maneuver import four_stroke, schedule_maneuver

UPLOADED = schedule_maneuver(four_stroke(59, 70))


class BoardTransport:
    """The cable, in the board's virtual time."""

    def __init__(self, board: AvrBoard) -> None:
        self._board = board

    @property
    def name(self) -> str:
        return "emulated Arduino Micro"

    def now_s(self) -> float:
        return self._board.now_us / 1e6

    def write(self, data: bytes) -> None:
        while data:
            data = data[self._board.send(data) :]
            self._board.run(250)

    def read(self, timeout_s: float) -> bytes:
        deadline_s = self.now_s() + timeout_s
        while not (data := self._board.receive()) and self.now_s() < deadline_s:
            self._board.run(250)
        return data

    def close(self) -> None:
        self._board.cable(False)


def connect(board: AvrBoard) -> SequencerClient:
    board.connect()
    return SequencerClient.connect(BoardTransport(board))


def eeprom_after_upload(library: ctypes.CDLL, hex_path: Path) -> bytes:
    """What the EEPROM of a new board holds once the host has uploaded UPLOADED to it."""
    board = AvrBoard(library, hex_path)
    board.power(True)
    connect(board).upload(UPLOADED)
    image = board.eeprom()
    board.close()
    return image
