"""The emulated robot's parts, by their C++ tests: servo, hands, IMU, I2C bus, angle sensor, card, clock, switches."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.cpp.compiling import EMULATOR_SOURCES, compile_cpp

HERE = Path(__file__).parent
HANDS = ["physics/hands.cpp", "physics/leg_path.cpp", "physics/shake.cpp"]
SERVO = ["physics/servo.cpp", "physics/servo_linkage.cpp", *HANDS]
PARTS = {
    "servo": SERVO,
    "servo_errors": SERVO,
    "servo_overshoot": SERVO,
    "hands": [*HANDS, "physics/chain.cpp", "physics/body_tree.cpp"],
    "mpu6050": ["sensors/mpu6050.cpp", "sensors/low_pass.cpp"],
    "bus_and_angle": ["sensors/mpu6050.cpp", "sensors/low_pass.cpp", "sensors/angle_sensor.cpp"],
    "block_device": ["card/block_device.cpp"],
    "board_clock": [],
    "release_switches": ["physics/release_switches.cpp"],
    "part_faults": [
        *SERVO,
        "sensors/mpu6050.cpp",
        "sensors/low_pass.cpp",
        "sensors/angle_sensor.cpp",
        "card/block_device.cpp",
    ],
}


@pytest.mark.parametrize("part", PARTS)
def test_part(part: str, tmp_path: Path) -> None:
    sources = [HERE / "main.cpp", HERE / f"test_{part}.cpp", *(EMULATOR_SOURCES / s for s in PARTS[part])]
    program = compile_cpp(sources, tmp_path / part)
    done = subprocess.run([program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
