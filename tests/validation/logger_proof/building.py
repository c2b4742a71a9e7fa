"""Builds the program of board/ with the logger's core: for this computer and for a Cortex-M7."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Sequence
from pathlib import Path

from tests.fixtures.cpp.compiling import build_program, compile_objects, run
from tests.fixtures.planting import Edit, plant
from tests.paths import REPOSITORY

BOARD = Path(__file__).resolve().parent / "board"
FIRMWARE = Path("firmware", "teensy_logger", "src")
SOURCES = REPOSITORY / FIRMWARE
PORTABLE = ("core", "protocol", "release")
"""Folders of the firmware that know no hardware."""
RUN = ("main",)
INSTRUCTIONS = ("instructions",)

M7_COMPILER = "arm-none-eabi-g++"
M7_FLAGS = (
    *("-mthumb", "-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16", "-O2", "-std=gnu++17"),
    *("-ffunction-sections", "-fdata-sections", "-fno-exceptions", "-fno-rtti"),
    "-fno-threadsafe-statics",
)
M7_LINK = (
    *("-nostartfiles", "--specs=nano.specs", "--specs=rdimon.specs", "-Wl,--gc-sections"),
    *("-T", str(BOARD / "mps2_an500.ld")),
)


def core_sha256() -> str:
    """Return the SHA-256 of all sources that these programs take from the firmware.

    It identifies the firmware to which the report belongs.
    """
    digest = hashlib.sha256()
    # Name and content, separated by zeros: two files cannot exchange bytes unnoticed.
    for path in core_files():
        digest.update(f"{path.relative_to(SOURCES).as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def core_files() -> list[Path]:
    """Sources and headers, sorted."""
    return sorted(path for folder in PORTABLE for path in (SOURCES / folder).iterdir())


def build_for_pc(folder: Path, edits: Sequence[Edit] = ()) -> Path:
    """Build the program for the PC with the sanitizers on.

    `edits` are defects to plant in files below `firmware/teensy_logger/src`.
    """
    # Sanitizers turn undefined behaviour of the firmware into a failing run.
    root = _tree(folder, edits)
    return build_program(_sources(root, RUN), folder / "program", root=root)


def build_for_m7(folder: Path, programs: Sequence[str] = RUN, edits: Sequence[Edit] = ()) -> Path:
    """Build the programs as a Cortex-M7 ELF for QEMU's mps2-an500.

    `edits` are defects, as for `build_for_pc`.
    """
    root, program = _tree(folder, edits), folder / "program"
    # The portable core with the board's start code for QEMU, and nothing of the Teensy.
    objects = compile_objects(_sources(root, (*programs, "cortex_m7")), (), M7_FLAGS, M7_COMPILER, root)
    run([M7_COMPILER, *M7_FLAGS, *objects, *M7_LINK, "-o", program])
    return program


def _sources(root: Path, programs: Sequence[str]) -> list[Path]:
    core = [path for name in PORTABLE for path in sorted((root / FIRMWARE / name).glob("*.cpp"))]
    return [*core, *(root / BOARD.relative_to(REPOSITORY) / f"{name}.cpp" for name in programs)]


def _tree(folder: Path, edits: Sequence[Edit]) -> Path:
    """Return the repository, or a copy of the compiled sources with the edits applied.

    Each text that an edit replaces stands there once.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if not edits:
        return REPOSITORY
    tree = folder / "tree"
    for path in (*(SOURCES / name for name in PORTABLE), BOARD):
        shutil.copytree(path, tree / path.relative_to(REPOSITORY))
    plant(tree / FIRMWARE, edits)
    return tree
