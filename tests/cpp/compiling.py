"""Compiles C++ for tests: every warning an error, sanitizers on, each source once.

An object is kept under `build/test-objects` by the SHA-256 of its preprocessed source and its command, so that the
tests that share a source, their processes, a copied tree with a planted defect and the next run compile it once. The
address sanitizer must be in a process from its start: it watches programs, not the libraries that Python loads.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
EMULATOR_SOURCES = REPOSITORY / "tools" / "emulator" / "src"
SKETCHES = ("arduino_sequencer", "teensy_logger")
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror")
UNDEFINED_BEHAVIOUR = ("-fsanitize=undefined", "-fno-sanitize-recover=all", "-D_GLIBCXX_ASSERTIONS")
ALL_SANITIZERS = (*UNDEFINED_BEHAVIOUR, "-fsanitize=address")
INCLUDES = (Path("tools", "emulator", "src"), Path("tests", "cpp"))
"""Below the root."""
_KEPT = REPOSITORY / "build" / "test-objects"


def compiler() -> str:
    """The PC's C++ compiler."""
    found = os.environ.get("CXX") or shutil.which("g++") or shutil.which("c++")
    assert found is not None, "no C++ compiler: install g++ or set CXX"
    return found


def run(command: Sequence[str | Path], folder: Path = REPOSITORY) -> str:
    """What a command prints, run in this folder; its complaint fails the test."""
    done = subprocess.run(list(map(str, command)), cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def build_program(
    sources: Sequence[Path],
    program: Path,
    includes: Sequence[Path] = (),
    standard: str = "c++17",
    root: Path = REPOSITORY,
) -> Path:
    """A program with the address and undefined-behaviour sanitizers; of the tests' own code, quickly compiled."""
    flags = [f"-std={standard}", "-g1", *ALL_SANITIZERS]
    tests = [path for path in sources if path.is_relative_to(root / "tests")]
    tested = [path for path in sources if path not in tests]
    objects = compile_objects(tests, includes, [*flags, "-O0"], root=root)
    objects += compile_objects(tested, includes, [*flags, "-O1"], root=root)
    program.parent.mkdir(parents=True, exist_ok=True)
    run([compiler(), *ALL_SANITIZERS, *objects, "-o", program])
    return program


def build_shared(
    sources: Sequence[Path], library: Path, includes: Sequence[Path] = (), standard: str = "c++17"
) -> Path:
    """A shared library with the undefined-behaviour sanitizer."""
    flags = [f"-std={standard}", "-O1", "-fPIC", *UNDEFINED_BEHAVIOUR]
    run(
        [
            compiler(),
            "-shared",
            *UNDEFINED_BEHAVIOUR,
            *compile_objects(sources, includes, flags),
            "-o",
            library,
        ]
    )
    return library


def compile_objects(
    sources: Sequence[Path],
    includes: Sequence[Path],
    flags: Sequence[str],
    command: str | None = None,
    root: Path = REPOSITORY,
) -> list[Path]:
    """An object of each source, in the same order.

    `command` is the compiler's, by default the PC's. It runs in `root`, the repository or a copy of its folders, so
    that no path of this machine is compiled in.
    """
    start = [command or compiler(), *flags, *WARNINGS]
    found = [f"-I{path}" for path in (*INCLUDES, *includes)]
    below = [path.relative_to(root) if path.is_relative_to(root) else path for path in sources]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda source: _object(start, found, source, root), below))


def _object(start: Sequence[str], found: Sequence[str], source: Path, root: Path) -> Path:
    preprocessed = run([*start, *found, "-E", source], root)
    key = hashlib.sha256("\0".join([*start, preprocessed]).encode()).hexdigest()
    kept = _KEPT / f"{key}.o"
    if not kept.exists():
        _KEPT.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=_KEPT) as folder:
            made = Path(folder) / "made.o"
            run([*start, *found, "-c", source, "-o", made], root)
            made.replace(kept)  # whole, whoever else makes it at the same time
    return kept
