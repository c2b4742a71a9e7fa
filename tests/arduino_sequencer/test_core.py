"""The sequencer's core by its C++ tests on the emulator's ports, with the sanitizers on."""

from __future__ import annotations

from pathlib import Path

from tests.fixtures.cpp.compiling import EMULATOR_SOURCES, build_program, run
from tests.paths import REPOSITORY

HERE = Path(__file__).parent
CORE = REPOSITORY / "firmware" / "arduino_sequencer" / "src" / "core"


def test_core(tmp_path: Path) -> None:
    """Store, release detector and pulse trains, state machine and link: each case prints its name."""
    sources = [*HERE.glob("test_*.cpp"), HERE / "main.cpp", *CORE.glob("*.cpp")]
    sources.append(EMULATOR_SOURCES / "boards" / "native_ports.cpp")
    assert run([build_program(sorted(sources), tmp_path / "core")]).count("\nok ") > 20
