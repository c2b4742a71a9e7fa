"""What each wire is called and where it ends: the names that findings give to a person with a screwdriver.

The pins are those of docs/wiring.toml; tests compare them.
"""

from __future__ import annotations

from typing import Final

ANGLE_SENSORS: Final = ("1a", "1b", "2a", "2b", "3a", "3b")
"""In the order of the log: a joint's two sensors."""
ANGLE_PINS: Final = (14, 15, 20, 21, 22, 23)
"""Of the Teensy."""
BUS_PINS: Final = ("18 (SDA), 19 (SCL)", "17 (SDA1), 16 (SCL1)")
"""Of the Teensy: of IMUs 1 and 2, of IMUs 3 and 4."""
IMU_ADDRESSES: Final = ("0x68", "0x69")
"""Of a bus's two IMUs: AD0 low, AD0 high."""
SERVO_PINS: Final = (9, 10, 11)
"""Of the Micro, by joint."""
SWITCH_PINS: Final = {"sequencer": (4, 13), "logger": (2, 3)}
STROKE_LINE_PINS: Final = (12, 4)
"""Out of the Micro, into the Teensy."""
BOARD_NAMES: Final = {"sequencer": "Micro", "logger": "Teensy"}


def name_angle_sensor(sensor: int) -> str:
    """Name an angle sensor, from 0, with its pin."""
    return f"angle sensor {ANGLE_SENSORS[sensor]} (Teensy pin {ANGLE_PINS[sensor]})"


def name_imu(imu: int) -> str:
    """Name an IMU, from 0, with its address and the pins of its bus."""
    bus, place = divmod(imu, 2)
    return f"IMU {imu + 1} (address {IMU_ADDRESSES[place]}, Teensy pins {BUS_PINS[bus]})"


def name_servo(joint: int) -> str:
    """Name the servo of a joint, from 0, with its pin."""
    return f"the servo of joint {joint + 1} (Micro pin {SERVO_PINS[joint]})"
