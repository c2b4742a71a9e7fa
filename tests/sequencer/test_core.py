"""The sequencer's core by its C++ tests on fake ports, with the sanitizers on."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.protocol.native import REPOSITORY, build_program

HERE = Path(__file__).parent
CORE = REPOSITORY / "firmware" / "arduino_sequencer" / "src" / "core"


def test_core(tmp_path: Path) -> None:
    """Store, release detector and pulse trains, state machine and link: each case prints its name."""
    sources = [*HERE.glob("test_*.cpp"), HERE / "main.cpp", *CORE.glob("*.cpp")]
    program = build_program(sorted(sources), tmp_path / "core", [REPOSITORY / "tests" / "cpp"])
    done = subprocess.run([program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("\nok ") > 20
