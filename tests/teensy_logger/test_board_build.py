"""The logger's core, drivers and sketch compile and link for the Teensy 4.1, and fit into it.

The stubs of ``tests/teensy_logger/stubs`` declare the calls that the drivers use, as Teensyduino 1.59 does, and
no others: that the build succeeds shows that the sketch uses nothing else.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.paths import REPOSITORY

SKETCH = REPOSITORY / "firmware" / "teensy_logger"

# Bytes. The chip has 512 KiB of RAM2 and as much tightly coupled memory for code and data together;
# the Teensy core and SdFat need 12 KiB of the one and 60 KiB of the other.
RING_BYTES = 896 * 512
BUDGETS = {".text": 64 * 1024, ".data": 4 * 1024, ".bss": 28 * 1024, ".progmem": 16 * 1024}


def build(tmp_path: Path, *variables: str, path: str | None = None) -> subprocess.CompletedProcess[str]:
    make = shutil.which("make")
    assert make is not None, "make is missing: run tools/install-toolchain.sh"
    command = [make, "-f", "tools/firmware/logger.mk", f"BUILD={tmp_path / 'build'}", *variables]
    environment = dict(os.environ) if path is None else {**os.environ, "PATH": path}
    return subprocess.run(
        command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, check=False
    )


class Built(NamedTuple):
    process: subprocess.CompletedProcess[str]
    folder: Path


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    folder = tmp_path_factory.mktemp("board")
    return Built(build(folder), folder)


def test_the_sketch_builds_without_a_warning_and_fits(built: Built) -> None:
    assert built.process.returncode == 0, built.process.stdout + built.process.stderr
    assert built.process.stderr == ""
    assert (built.folder / "build" / "teensy_logger.elf").is_file()
    sizes = {name: int(size) for name, size in map(str.split, built.process.stdout.splitlines())}
    assert sizes.pop(".dmabuffers") == RING_BYTES, "nothing but the ring in RAM2"
    assert sizes.keys() == BUDGETS.keys()
    over = {name: size for name, size in sizes.items() if size > BUDGETS[name]}
    assert not over


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("void logger_spare() { int unused; }", "unused"),
        ("int* volatile logger_spare = new int;", "heap"),
        ("void logger_spare() { throw 1; }", "exception"),
        ("DMAMEM uint8_t logger_spare[56 * 1024];", "RAM2"),
        ("void logger_spare() { Serial.println(1); }", "println"),
        ("bool logger_spare() { return SdFs().volumeBegin(0); }", "volumeBegin"),
    ],
    ids=["warning", "heap", "exception", "too-big", "undeclared-call", "wrong-arguments"],
)
def test_what_the_board_cannot_carry_fails_the_build(
    built: Built, tmp_path: Path, line: str, complaint: str
) -> None:
    # Only the sketch file is newer than its object: the rest need not be compiled again.
    shutil.copytree(built.folder / "build", tmp_path / "build")
    copy = tmp_path / "teensy_logger"
    shutil.copytree(SKETCH, copy)
    sketch = copy / "teensy_logger.ino"
    sketch.write_text(sketch.read_text() + line + "\n")
    process = build(tmp_path, f"SKETCH={copy}")
    assert process.returncode != 0
    assert complaint in process.stdout + process.stderr


def test_a_missing_compiler_is_an_error_that_says_what_to_run(tmp_path: Path) -> None:
    process = build(tmp_path, path=str(tmp_path))
    assert process.returncode != 0
    assert "arm-none-eabi-g++ is missing" in process.stderr
    assert "tools/install-toolchain.sh" in process.stderr
