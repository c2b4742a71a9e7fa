"""One library for all tests of the sequencer's core, a fresh board for each test."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import pytest

from tests.fixtures.sequencer.board import ERASED, Board, load_library
from tests.fixtures.sequencer.building import build_native_library
from tests.fixtures.sequencer.cable import native_board


@pytest.fixture(scope="session")
def board_library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    return load_library(build_native_library(tmp_path_factory.mktemp("sequencer")))


@pytest.fixture(scope="session")
def new_board(board_library: ctypes.CDLL) -> Callable[..., Board]:
    """Makes a board: `new_board(eeprom)`."""
    return lambda eeprom=None: native_board(board_library, eeprom)


@pytest.fixture
def fresh_board(new_board: Callable[..., Board]) -> Board:
    """Return a board like `board`, but with an erased EEPROM."""
    return new_board(ERASED)


@pytest.fixture
def board(new_board: Callable[..., Board]) -> Board:
    """Return a powered board with the factory maneuver uploaded, cable in, both switches closed."""
    return new_board()
