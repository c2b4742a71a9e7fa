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
    """Of all sources that these programs take from the firmware: what the report belongs to."""
    digest = hashlib.sha256()
    for path in core_files():
        digest.update(f"{path.relative_to(SOURCES).as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def core_files() -> list[Path]:
    """Sources and headers, sorted."""
    return sorted(path for folder in PORTABLE for path in (SOURCES / folder).iterdir())


def build_for_pc(folder: Path, edits: Sequence[Edit] = ()) -> Path:
    """With the sanitizers on. `edits`: defects, in files below `firmware/teensy_logger/src`."""
    root = _tree(folder, edits)
    return build_program(_sources(root, RUN), folder / "program", root=root)


def build_for_m7(folder: Path, programs: Sequence[str] = RUN, edits: Sequence[Edit] = ()) -> Path:
    """Likewise, an ELF for QEMU's mps2-an500."""
    root, program = _tree(folder, edits), folder / "program"
    objects = compile_objects(_sources(root, (*programs, "cortex_m7")), (), M7_FLAGS, M7_COMPILER, root)
    run([M7_COMPILER, *M7_FLAGS, *objects, *M7_LINK, "-o", program])
    return program


def _sources(root: Path, programs: Sequence[str]) -> list[Path]:
    core = [path for name in PORTABLE for path in sorted((root / FIRMWARE / name).glob("*.cpp"))]
    return [*core, *(root / BOARD.relative_to(REPOSITORY) / f"{name}.cpp" for name in programs)]


def _tree(folder: Path, edits: Sequence[Edit]) -> Path:
    """The repository; or a copy of what is compiled, in which texts that stand there once are replaced."""
    folder.mkdir(parents=True, exist_ok=True)
    if not edits:
        return REPOSITORY
    tree = folder / "tree"
    for path in (*(SOURCES / name for name in PORTABLE), BOARD):
        shutil.copytree(path, tree / path.relative_to(REPOSITORY))
    plant(tree / FIRMWARE, edits)
    return tree
