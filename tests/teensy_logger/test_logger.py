"""The logger's core by its C++ tests, with the address and undefined-behaviour sanitizers on."""

from __future__ import annotations

from pathlib import Path

from tests.fixtures.cpp.compiling import EMULATOR_SOURCES, build_program, run
from tests.paths import REPOSITORY
from tests.teensy_logger.golden_blocks import write_header

HERE = Path(__file__).parent
SOURCES = REPOSITORY / "firmware" / "teensy_logger" / "src"
STUBS = REPOSITORY / "tests" / "teensy_logger" / "stubs"
OTHERS = [SOURCES / "release/release_detector.cpp", SOURCES / "drivers/lpi2c_bus.cpp"]
EMULATED = [
    "sensors/mpu6050",
    "sensors/low_pass",
    "sensors/angle_sensor",
    "card/block_device",
    "boards/logger_board",
]


def test_core(tmp_path: Path) -> None:
    """Ring, recorder, sensors, settings, link and whole board: each case prints its name."""
    write_header(tmp_path / "golden_blocks.h")
    sources = [*HERE.glob("*.cpp"), *(SOURCES / "core").glob("*.cpp"), *OTHERS]
    sources += [EMULATOR_SOURCES / f"{name}.cpp" for name in EMULATED]
    output = run([build_program(sorted(sources), tmp_path / "core", [tmp_path, STUBS])])
    assert output.count("\nok ") > 100
