"""Compiles test programs with every warning an error and the sanitizers on."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
EMULATOR_SOURCES = REPOSITORY / "tools" / "emulator" / "src"
FLAGS = [
    *("-std=c++17", "-O1", "-g"),
    *("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"),
    *("-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
]


def compile_cpp(sources: Sequence[Path], program: Path) -> Path:
    """Compile and link `sources` into `program`; a compiler's complaint fails the test with its text."""
    compiler = os.environ.get("CXX") or shutil.which("g++") or shutil.which("c++")
    assert compiler is not None, "no C++ compiler: install g++ or set CXX"
    includes = [f"-I{EMULATOR_SOURCES}", f"-I{REPOSITORY / 'tests' / 'cpp'}"]
    command = [compiler, *FLAGS, *includes, *map(str, sources), "-o", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return program
