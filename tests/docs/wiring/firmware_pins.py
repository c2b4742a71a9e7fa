"""Which pin carries what, read from the sources of both firmwares."""

from __future__ import annotations

import re

from tests.paths import REPOSITORY

FIRMWARE = REPOSITORY / "firmware"

# ATmega32U4 port bits to the Micro's numbers: variants/leonardo/pins_arduino.h of the Arduino core.
MICRO = {"PB5": "9", "PB6": "10", "PB7": "11", "PD4": "4", "PD6": "12", "PD7": "6", "PC7": "13"}
# variants of the Teensy core, pins_arduino.h (core_pins.h): A0 to A9 are 14 to 23.
TEENSY_ANALOG = {f"A{i}": str(14 + i) for i in range(10)}


def source(path: str) -> str:
    return (FIRMWARE / path).read_text(encoding="utf-8")


def _match_groups(pattern: str, text: str) -> tuple[str, ...]:
    match = re.search(pattern, text)
    assert match, pattern
    return match.groups()


def sequencer_pins() -> dict[str, str]:
    """Pin to what it carries, from the drivers."""
    servos = source("arduino_sequencer/src/drivers/timer1_servos.cpp")
    switches = source("arduino_sequencer/src/drivers/release_capture.cpp")
    led = source("arduino_sequencer/src/drivers/status_pin.h")
    bits = _match_groups(r"kServoPins = _BV\((P\w\d)\) \| _BV\((P\w\d)\) \| _BV\((P\w\d)\)", servos)
    pins = {MICRO[bit]: f"servo, joint {joint}" for joint, bit in enumerate(bits, 1)}
    pins[MICRO[_match_groups(r"kStrokePin = _BV\((P\w\d)\)", servos)[0]]] = "stroke line, out"
    first, second = _match_groups(r"kFirstPin = _BV\((P\w\d)\), kSecondPin = _BV\((P\w\d)\)", switches)
    pins[MICRO[first]] = "release switch 1"
    pins[MICRO[second]] = "release switch 2"
    pins[MICRO[_match_groups(r"DDRD \|= _BV\((P\w\d)\)", led)[0]]] = "status LED"
    # Three servos, the stroke line, two switches, the LED: a pin assigned twice would be one less.
    assert len(pins) == 7
    return pins


def logger_pins() -> dict[str, str]:
    """Pin to what it carries, from the sketch."""
    sketch = source("teensy_logger/teensy_logger.ino")
    pins: dict[str, str] = {}
    for bus, suffix, imus in (("Wire", "", "1 and 2"), ("Wire1", "1", "3 and 4")):
        sda, scl = _match_groups(rf"\({bus}, IMXRT_LPI2C\d, (\d+), (\d+)\)", sketch)
        pins |= {sda: f"SDA{suffix}, IMU {imus}", scl: f"SCL{suffix}, IMU {imus}"}
    analog = re.findall(r"A\d", _match_groups(r"kAnglePins\[\] = \{([^}]*)\}", sketch)[0])
    for index, name in enumerate(analog):
        pins[TEENSY_ANALOG[name]] = f"angle sensor {index // 2 + 1}{'ab'[index % 2]}"
    first_pin, two, stroke = _match_groups(r"EdgeInputs::Pins\{\{(\d+), (\d+)\}, (\d+)\}", sketch)
    pins |= {first_pin: "release switch 1", two: "release switch 2", stroke: "stroke line, in"}
    assert "pinMode(LED_BUILTIN, OUTPUT)" in sketch
    pins["13"] = "status LED, on the board"
    # Four bus lines, six angle sensors, two switches, the stroke line, the LED.
    assert len(pins) == 14
    return pins
