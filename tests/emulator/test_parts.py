"""The emulated robot's parts, by their C++ tests: servo, hands, IMU, I2C bus, angle sensor, card, clock, switches."""

from __future__ import annotations

from pathlib import Path

from tests.fixtures.cpp.compiling import EMULATOR_SOURCES, build_program, run

HERE = Path(__file__).parent
PARTS = ("physics", "sensors", "card")


def test_parts(tmp_path: Path) -> None:
    """Run the C++ part tests: each case prints its name."""
    sources = [
        *HERE.glob("*.cpp"),
        *(path for part in PARTS for path in (EMULATOR_SOURCES / part).glob("*.cpp")),
    ]
    assert run([build_program(sorted(sources), tmp_path / "parts")]).count("\nok ") > 30
