"""Builds what these tests fly: the boards' images and the emulated Arduino Micro around them."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.emulator_avr.avr_board import AvrBoard, load_library
from tests.emulator_avr.building import SEQUENCER, build_board_library, build_sketch


@pytest.fixture(scope="session")
def build_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("avr")


@pytest.fixture(scope="session")
def probe_hex(build_folder: Path) -> Path:
    return build_sketch("tests/emulator_avr/probe", build_folder / "probe")


@pytest.fixture(scope="session")
def sequencer_hex(build_folder: Path) -> Path:
    return build_sketch(SEQUENCER, build_folder / "sequencer")


@pytest.fixture(scope="session")
def library(build_folder: Path) -> ctypes.CDLL:
    return load_library(build_board_library(build_folder))


@pytest.fixture
def make_board(library: ctypes.CDLL) -> Iterator[Callable[[Path], AvrBoard]]:
    boards: list[AvrBoard] = []

    def make(hex_path: Path) -> AvrBoard:
        boards.append(AvrBoard(library, hex_path))
        return boards[-1]

    yield make
    for board in boards:
        board.close()


@pytest.fixture
def probe(make_board: Callable[[Path], AvrBoard], probe_hex: Path) -> AvrBoard:
    """The probe sketch, powered, cable in, port open, both switches closed."""
    board = make_board(probe_hex)
    board.switch(0, closed=True)
    board.switch(1, closed=True)
    board.power(True)
    board.connect()
    return board


@pytest.fixture
def sequencer(make_board: Callable[[Path], AvrBoard], sequencer_hex: Path) -> AvrBoard:
    """The firmware that would be flashed, on the crane: powered, both switches closed, no cable."""
    board = make_board(sequencer_hex)
    board.switch(0, closed=True)
    board.switch(1, closed=True)
    board.power(True)
    board.run(300_000)
    return board
