"""The logger's core, drivers and sketch compile and link for the Teensy 4.1 without a warning."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.cpp.compiling import REPOSITORY

SKETCH = REPOSITORY / "firmware" / "teensy_logger"
DTCM_BYTES = 512 * 1024


def build(tmp_path: Path, *variables: str, path: str | None = None) -> subprocess.CompletedProcess[str]:
    make = shutil.which("make")
    assert make is not None, "make is missing: run tools/install-toolchain.sh"
    command = [make, "-f", "tools/firmware/logger.mk", f"BUILD={tmp_path / 'build'}", *variables]
    environment = dict(os.environ) if path is None else {**os.environ, "PATH": path}
    return subprocess.run(
        command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, check=False
    )


def copy_of_sketch(tmp_path: Path) -> Path:
    copy = tmp_path / "teensy_logger"
    shutil.copytree(SKETCH, copy)
    return copy


def test_the_sketch_builds_and_fits(tmp_path: Path) -> None:
    done = build(tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "build" / "teensy_logger.elf").is_file()
    sizes = {name: int(size) for name, size in map(str.split, done.stdout.splitlines())}
    assert sizes[".dmabuffers"] == 512 * 512, "the ring, in RAM2"
    assert sizes[".data"] + sizes[".bss"] < DTCM_BYTES / 8
    assert sizes[".text"] < 64 * 1024


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("void logger_spare() { int unused; }", "unused"),
        ("int* volatile logger_spare = new int;", "heap"),
    ],
    ids=["warning", "heap"],
)
def test_a_warning_or_the_heap_fails_the_build(tmp_path: Path, line: str, complaint: str) -> None:
    copy = copy_of_sketch(tmp_path)
    sketch = copy / "teensy_logger.ino"
    sketch.write_text(sketch.read_text() + line + "\n")
    done = build(tmp_path, f"SKETCH={copy}")
    assert done.returncode != 0
    assert complaint in done.stdout + done.stderr


def test_a_missing_compiler_is_an_error_that_says_what_to_run(tmp_path: Path) -> None:
    done = build(tmp_path, path=str(tmp_path))
    assert done.returncode != 0
    assert "arm-none-eabi-g++ is missing" in done.stderr
    assert "tools/install-toolchain.sh" in done.stderr
