"""Builds what these tests fly: the boards' images and the emulated Arduino Micro around them."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.emulator_avr.avr_board import AvrBoard, load_library

REPOSITORY = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
BOARDS = REPOSITORY / "tools" / "emulator" / "src" / "boards"


def run(*command: str) -> None:
    result = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        pytest.fail(f"{' '.join(command)}\n{result.stdout}{result.stderr}", pytrace=False)


def build_sketch(sketch: str, build: Path) -> Path:
    run("make", "-f", "tools/firmware/sequencer.mk", f"SKETCH={sketch}", f"BUILD={build}")
    return build / f"{Path(sketch).name}.hex"


@pytest.fixture(scope="session")
def build_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("avr")


@pytest.fixture(scope="session")
def probe_hex(build_folder: Path) -> Path:
    return build_sketch("tests/emulator_avr/probe", build_folder / "probe")


@pytest.fixture(scope="session")
def sequencer_hex(build_folder: Path) -> Path:
    return build_sketch("firmware/arduino_sequencer", build_folder / "sequencer")


@pytest.fixture(scope="session")
def library(build_folder: Path) -> ctypes.CDLL:
    output = build_folder / "libavr_board.so"
    sources = [str(HERE / "harness.cpp"), *sorted(str(path) for path in BOARDS.glob("avr_*.cpp"))]
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    include = str(BOARDS.parent)
    run("g++", "-std=c++17", "-O2", *warnings, "-shared", "-fPIC", "-I", include, *sources,
        "-o", str(output), "-lsimavr", "-lelf")  # fmt: skip
    return load_library(output)


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
