"""Builds a sketch for the Arduino Micro, and the library that emulates the board around it."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from tests.fixtures.cpp.compiling import compile_objects, compiler, run
from tests.fixtures.planting import Edit, plant
from tests.paths import REPOSITORY

SEQUENCER = "firmware/arduino_sequencer"
_HERE = Path(__file__).resolve().parent
_BOARDS = REPOSITORY / "tools" / "emulator" / "src" / "boards"


class BuildError(RuntimeError):
    """The command, and what it said."""


def build_sketch(sketch: str, build: Path) -> Path:
    """The HEX of a sketch folder, with its .elf and .json next to it. Raises BuildError."""
    _run("make", "-f", "tools/firmware/sequencer.mk", f"SKETCH={sketch}", f"BUILD={build}",
         f"PYTHON={sys.executable}")  # fmt: skip
    return build / f"{Path(sketch).name}.hex"


def build_changed_sequencer(edits: Iterable[Edit], folder: Path, like: Path) -> Path:
    """Build a copy of the sequencer with these changes; return its HEX.

    Args:
        edits: Of files below the sketch's folder, in this order.
        folder: Where copy and build go.
        like: A HEX of the unchanged sequencer, whose compiled Arduino core is used again.

    Raises:
        BuildError: it does not compile.
        ValueError: a text is not there, or is there more than once.
    """
    sketch = folder / "sketch" / Path(SEQUENCER).name
    shutil.copytree(REPOSITORY / SEQUENCER, sketch)
    plant(sketch, edits)
    build = folder / "build"
    shutil.copytree(like.parent / "core", build / "core")
    shutil.copy2(like.parent / "core.a", build)
    return build_sketch(str(sketch), build)


def build_board_library(folder: Path) -> Path:
    """The emulated board as a shared library for `AvrBoard`."""
    output = folder / "libavr_board.so"
    sources = [_HERE / "harness.cpp", *sorted(_BOARDS.glob("avr_*.cpp"))]
    objects = compile_objects(sources, [], ["-std=c++17", "-O2", "-fPIC"])
    run([compiler(), "-shared", *objects, "-o", output, "-lsimavr", "-lelf"])
    return output


def _run(*command: str) -> None:
    result = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise BuildError(f"{' '.join(command)}\n{result.stdout}{result.stderr}")
