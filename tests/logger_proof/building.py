"""Builds the program of board/ with the logger's core: for this computer and for a Cortex-M7."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.emulator_avr.building import REPOSITORY, BuildError, Edit

BOARD = Path(__file__).resolve().parent / "board"
FIRMWARE = Path("firmware", "teensy_logger", "src")
SOURCES = REPOSITORY / FIRMWARE
PORTABLE = ("core", "protocol", "release")
"""Folders of the firmware that know no hardware."""
RUN = ("main", "world", "robot", "card", "cable", "scenario")
INSTRUCTIONS = ("instructions", "cable")

WARNINGS = ("-Wall", "-Wextra", "-Wshadow", "-Werror")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")
PC_FLAGS = ("-std=c++17", "-O1", "-g1", "-Wpedantic", *WARNINGS, *SANITIZERS)
M7_FLAGS = (
    *("-mthumb", "-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16", "-O2", "-std=gnu++17"),
    *("-ffunction-sections", "-fdata-sections", "-fno-exceptions", "-fno-rtti"),
    *("-fno-threadsafe-statics", *WARNINGS),
)
M7_LINK = (
    *("-nostartfiles", "--specs=nano.specs", "--specs=rdimon.specs", "-Wl,--gc-sections"),
    *("-T", str(BOARD / "mps2_an500.ld")),
)


def core_sha256() -> str:
    """Of all sources that these programs take from the firmware: what the report belongs to."""
    digest = hashlib.sha256()
    for path in core_files():
        digest.update(f"{path.relative_to(SOURCES).as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def core_files() -> list[Path]:
    """Sources and headers, sorted."""
    return sorted(path for folder in PORTABLE for path in (SOURCES / folder).iterdir())


def build_for_pc(folder: Path, programs: Sequence[str] = RUN) -> Path:
    """With the sanitizers on. Raises BuildError."""
    return _build(compiler(), PC_FLAGS, SANITIZERS, _copy(folder), programs)


def build_for_m7(folder: Path, programs: Sequence[str] = RUN, edits: Iterable[Edit] = ()) -> Path:
    """An ELF for QEMU's mps2-an500. Raises BuildError, and ValueError as `plant`."""
    tree = _copy(folder)
    _edit(tree, edits)
    return _build("arm-none-eabi-g++", M7_FLAGS, M7_LINK, tree, (*programs, "cortex_m7"))


def plant(like: Path, folder: Path, edits: Sequence[Edit]) -> Path:
    """The program `like` for this computer with defects in its core; only what they change is compiled.

    Args:
        like: As `build_for_pc` returned it.
        edits: In sources of the core, below `firmware/teensy_logger/src`; headers cannot be changed.

    Raises:
        BuildError: it does not compile.
        ValueError: a text is not there, or is there more than once.
    """
    tree = _copy(folder)
    _edit(tree, edits)
    changed = {tree / FIRMWARE / edit.file for edit in edits}
    if any(path.suffix != ".cpp" for path in changed):
        raise ValueError("only sources can be changed, headers are compiled into everything")
    for made in like.parent.glob("*.o"):
        shutil.copy2(made, tree)
    for path in changed:
        _compile(compiler(), PC_FLAGS, tree, path)
    return _link(compiler(), PC_FLAGS, SANITIZERS, tree)


def _copy(folder: Path) -> Path:
    """Everything to compile, laid out as in the repository, so that no path of this machine is compiled in."""
    tree = folder / "tree"
    for name in PORTABLE:
        shutil.copytree(SOURCES / name, tree / FIRMWARE / name)
    shutil.copytree(BOARD, tree / "tests" / "logger_proof" / "board")
    return tree


def _edit(tree: Path, edits: Iterable[Edit]) -> None:
    for name, old, new in edits:
        path = tree / FIRMWARE / name
        text = path.read_text()
        if text.count(old) != 1:
            raise ValueError(f"{name} has {old!r} {text.count(old)} times: the edit must be renewed")
        path.write_text(text.replace(old, new))


def _build(
    compiler: str, flags: Sequence[str], link: Sequence[str], tree: Path, programs: Sequence[str]
) -> Path:
    firmware = tree / FIRMWARE
    sources = [path for name in PORTABLE for path in sorted((firmware / name).glob("*.cpp"))]
    sources += [tree / "tests" / "logger_proof" / "board" / f"{name}.cpp" for name in programs]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for made in [pool.submit(_compile, compiler, flags, tree, path) for path in sources]:
            made.result()
    return _link(compiler, flags, link, tree)


def _compile(compiler: str, flags: Sequence[str], tree: Path, source: Path) -> None:
    relative = source.relative_to(tree)
    run_tool(tree, compiler, *flags, "-c", str(relative), "-o", f"{source.stem}.o")


def _link(compiler: str, flags: Sequence[str], link: Sequence[str], tree: Path) -> Path:
    objects = sorted(path.name for path in tree.glob("*.o"))
    run_tool(tree, compiler, *flags, *objects, *link, "-o", "program")
    return tree / "program"


def compiler() -> str:
    """Of this computer. Raises BuildError."""
    found = os.environ.get("CXX") or shutil.which("g++") or shutil.which("c++")
    if found is None:
        raise BuildError("no C++ compiler: install g++ or set CXX")
    return found


def run_tool(folder: Path, *command: str) -> None:
    """Runs a compiler or linker. Raises BuildError with what it said."""
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise BuildError(f"{' '.join(command)}\n{result.stdout}{result.stderr}")
