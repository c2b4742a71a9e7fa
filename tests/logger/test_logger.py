"""The logger's core by its C++ tests, with the address and undefined-behaviour sanitizers on."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from tests.cpp.compiling import EMULATOR_SOURCES, REPOSITORY, compile_cpp
from tests.logger.golden_blocks import write_header

HERE = Path(__file__).parent
CORE = REPOSITORY / "firmware" / "teensy_logger" / "src" / "core"
STAND_INS = REPOSITORY / "tests" / "standins"
RECORDER = ["block_builder", "card_writer", "drop_watch", "../release/release_detector", "recorder"]
SENSORS = ["settings", "mpu6050", "sampler"]
LOGGER = [*RECORDER, *SENSORS, "log_server", "request_server", "logger"]
CORE_SOURCES: dict[str, list[str]] = {
    "ring": [],
    "interval_stats": [],
    "builder": ["block_builder"],
    "drop_watch": ["drop_watch", "../release/release_detector"],
    "recorder": RECORDER,
    "card_trouble": RECORDER,
    "rewrite": RECORDER,
    "ram": RECORDER,
    "log_server": [*RECORDER, "log_server"],
    "settings_store": ["settings"],
    "settings": ["settings"],
    "sensors": SENSORS,
    "sampling_faults": SENSORS,
    "core": LOGGER,
    "board": LOGGER,
    "requests": LOGGER,
    "long_wait": LOGGER,
    "chatter": LOGGER,
    "slow_card": LOGGER,
    "bus_recovery": ["../drivers/lpi2c_bus"],
}
IMU = ["sensors/mpu6050", "sensors/low_pass"]
BOARD = [*IMU, "sensors/angle_sensor", "card/block_device", "boards/logger_board"]
EMULATED = {
    "sensors": IMU,
    "sampling_faults": IMU,
    "board": BOARD,
    "requests": BOARD,
    "long_wait": BOARD,
    "chatter": BOARD,
    "slow_card": BOARD,
}


@pytest.mark.parametrize("part", CORE_SOURCES)
def test_core(part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sources = [HERE / "main.cpp", HERE / f"test_{part}.cpp"]
    sources += [CORE / f"{name}.cpp" for name in CORE_SOURCES[part]]
    sources += [EMULATOR_SOURCES / f"{name}.cpp" for name in EMULATED.get(part, [])]
    write_header(tmp_path / "golden_blocks.h")
    monkeypatch.setenv("CPLUS_INCLUDE_PATH", os.pathsep.join([str(tmp_path), str(STAND_INS)]))
    program = compile_cpp(sources, tmp_path / part)
    done = subprocess.run([program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
