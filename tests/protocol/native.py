"""Compiles firmware sources for tests, several at a time: every warning an error, sanitizers on.

The address sanitizer must be in a process from its start: it watches programs, not the libraries that
Python loads.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
SKETCHES = ("arduino_sequencer", "teensy_logger")
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror")
UNDEFINED_BEHAVIOUR = ("-fsanitize=undefined", "-fno-sanitize-recover=all", "-D_GLIBCXX_ASSERTIONS")


def compiler() -> str:
    found = os.environ.get("CXX") or shutil.which("g++") or shutil.which("c++")
    assert found is not None, "no C++ compiler: install g++ or set CXX"
    return found


def run(command: Sequence[str | Path]) -> str:
    """Runs a command; its complaint fails the test."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def compile_objects(
    sources: Sequence[Path], folder: Path, includes: Sequence[Path], flags: Sequence[str]
) -> list[Path]:
    """Compiles each source on its own, several at a time."""
    common = [*flags, *WARNINGS, *(f"-I{path}" for path in includes)]

    def compile_one(numbered: tuple[int, Path]) -> Path:
        number, source = numbered
        target = folder / f"{number}-{source.stem}.o"
        run([compiler(), *common, "-c", source, "-o", target])
        return target

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        return list(pool.map(compile_one, enumerate(sources)))


def build_shared(
    sources: Sequence[Path], library: Path, includes: Sequence[Path], standard: str = "c++17"
) -> Path:
    """A shared library with the undefined-behaviour sanitizer."""
    flags = [f"-std={standard}", "-O1", "-fPIC", *UNDEFINED_BEHAVIOUR]
    objects = compile_objects(sources, library.parent, includes, flags)
    run([compiler(), "-shared", *UNDEFINED_BEHAVIOUR, *objects, "-o", library])
    return library


def build_program(
    sources: Sequence[Path], program: Path, includes: Sequence[Path], standard: str = "c++17"
) -> Path:
    """A program with the address sanitizer as well."""
    sanitizers = [*UNDEFINED_BEHAVIOUR, "-fsanitize=address"]
    program.parent.mkdir(exist_ok=True)
    objects = compile_objects(
        sources, program.parent, includes, [f"-std={standard}", "-O1", "-g1", *sanitizers]
    )
    run([compiler(), *sanitizers, *objects, "-o", program])
    return program
