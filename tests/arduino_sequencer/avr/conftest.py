"""Builds what these tests fly: the boards' images and the emulated Arduino Micro around them."""

from __future__ import annotations

import ctypes
import fcntl
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.fixtures.sequencer.board import AvrBoard, load_library
from tests.fixtures.sequencer.building import build_avr_library, build_sketch
from tests.fixtures.sequencer.cable import eeprom_after_upload
from tests.paths import REPOSITORY
from tfsat_host.emulated import build

pytest.register_assert_rewrite("tests.arduino_sequencer.avr.flight")
LOCK = REPOSITORY / "build" / "avr.lock"
"""Of all processes that build."""


@pytest.fixture(scope="session")
def build_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("avr")


@pytest.fixture(scope="session")
def probe_hex() -> Path:
    """Built once a checkout."""
    # Test processes run side by side: only one of them may build into the shared folder.
    with LOCK.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return build_sketch("tests/arduino_sequencer/avr/probe", REPOSITORY / "build" / "probe")


@pytest.fixture(scope="session")
def sequencer_hex() -> Path:
    """Build the sequencer's HEX, the one that `make firmware` builds."""
    with LOCK.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return build.sequencer_hex()


@pytest.fixture(scope="session")
def library(build_folder: Path) -> ctypes.CDLL:
    return load_library(build_avr_library(build_folder))


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
    """Return a board with the probe sketch: powered, cable in, port open, both switches closed."""
    board = make_board(probe_hex)
    board.switch(0, closed=True)
    board.switch(1, closed=True)
    board.power(True)
    board.connect()
    return board


@pytest.fixture(scope="session")
def uploaded_eeprom(library: ctypes.CDLL, sequencer_hex: Path) -> bytes:
    return eeprom_after_upload(library, sequencer_hex)


@pytest.fixture
def new_sequencer(make_board: Callable[[Path], AvrBoard], sequencer_hex: Path) -> AvrBoard:
    """Return an unpowered board with the real firmware and an erased EEPROM, both switches closed."""
    board = make_board(sequencer_hex)
    board.switch(0, closed=True)
    board.switch(1, closed=True)
    return board


@pytest.fixture
def sequencer(new_sequencer: AvrBoard, uploaded_eeprom: bytes) -> AvrBoard:
    """Return a powered sequencer on the crane: 59/70 uploaded, both switches closed, no cable."""
    new_sequencer.set_eeprom(uploaded_eeprom)
    new_sequencer.power(True)
    new_sequencer.run(300_000)
    return new_sequencer
