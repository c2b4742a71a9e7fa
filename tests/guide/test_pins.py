"""The wiring that people solder is the firmware's."""

from __future__ import annotations

import re

from tests.guide.documents import ROOT

FIRMWARE = ROOT / "firmware"
WIRING = (ROOT / "docs" / "wiring.md").read_text(encoding="utf-8")
MAPS = (ROOT / "docs" / "guide" / "pin-map.md").read_text(encoding="utf-8")

# ATmega32U4 port bits to the Micro's numbers: variants/leonardo/pins_arduino.h of the Arduino core.
MICRO = {"PB5": "9", "PB6": "10", "PB7": "11", "PD4": "4", "PD6": "12", "PD7": "6", "PC7": "13"}
# variants of the Teensy core, pins_arduino.h (core_pins.h): A0 to A9 are 14 to 23.
TEENSY_ANALOG = {f"A{i}": str(14 + i) for i in range(10)}


def _source(path: str) -> str:
    return (FIRMWARE / path).read_text(encoding="utf-8")


def _one(pattern: str, text: str) -> tuple[str, ...]:
    found = re.search(pattern, text)
    assert found, pattern
    return found.groups()


def sequencer_pins() -> dict[str, str]:
    """Pin to what it carries, from the drivers."""
    servos = _source("arduino_sequencer/src/drivers/timer1_servos.cpp")
    switches = _source("arduino_sequencer/src/drivers/release_capture.cpp")
    led = _source("arduino_sequencer/src/drivers/status_pin.h")
    bits = _one(r"kServoPins = _BV\((P\w\d)\) \| _BV\((P\w\d)\) \| _BV\((P\w\d)\)", servos)
    pins = {MICRO[bit]: f"servo, joint {joint}" for joint, bit in enumerate(bits, 1)}
    pins[MICRO[_one(r"kStrokePin = _BV\((P\w\d)\)", servos)[0]]] = "stroke line, out"
    first, second = _one(r"kFirstPin = _BV\((P\w\d)\), kSecondPin = _BV\((P\w\d)\)", switches)
    pins[MICRO[first]] = "release switch 1"
    pins[MICRO[second]] = "release switch 2"
    pins[MICRO[_one(r"DDRD \|= _BV\((P\w\d)\)", led)[0]]] = "status LED"
    assert len(pins) == 7
    return pins


def logger_pins() -> dict[str, str]:
    """Pin to what it carries, from the sketch."""
    sketch = _source("teensy_logger/teensy_logger.ino")
    pins: dict[str, str] = {}
    for bus, suffix, imus in (("Wire", "", "1 and 2"), ("Wire1", "1", "3 and 4")):
        sda, scl = _one(rf"\({bus}, IMXRT_LPI2C\d, (\d+), (\d+)\)", sketch)
        pins |= {sda: f"SDA{suffix}, IMU {imus}", scl: f"SCL{suffix}, IMU {imus}"}
    analog = re.findall(r"A\d", _one(r"kAnglePins\[\] = \{([^}]*)\}", sketch)[0])
    for index, name in enumerate(analog):
        pins[TEENSY_ANALOG[name]] = f"angle sensor {index // 2 + 1}{'ab'[index % 2]}"
    one, two, stroke = _one(r"EdgeInputs::Pins\{\{(\d+), (\d+)\}, (\d+)\}", sketch)
    pins |= {one: "release switch 1", two: "release switch 2", stroke: "stroke line, in"}
    assert "pinMode(LED_BUILTIN, OUTPUT)" in sketch
    pins["13"] = "status LED, on the board"
    assert len(pins) == 14
    return pins


def _map_of(board: str) -> dict[str, str]:
    """Numbered pins of a pin map, with what they carry."""
    section = MAPS.split(f"## {board}")[1].split("\n## ")[0]
    pins: dict[str, str] = {}
    for row in re.findall(r"^\|(.*)\|$", section, re.MULTILINE)[2:]:
        left_use, left, right, right_use = (cell.strip() for cell in row.split("|"))
        pins |= {left.split(" ")[0]: left_use, right.split(" ")[0]: right_use}
    return {pin: use for pin, use in pins.items() if pin.isdigit() and use}


def test_the_pin_map_of_the_sequencer_is_the_firmwares() -> None:
    assert _map_of("Sequencer") == sequencer_pins()


def test_the_pin_map_of_the_logger_is_the_firmwares() -> None:
    assert _map_of("Logger") == logger_pins()


def test_analog_names_in_the_pin_map_are_right() -> None:
    named = dict(re.findall(r"(\d+) \((A\d)\)", MAPS))
    assert named == {TEENSY_ANALOG[name]: name for name in ("A0", "A1", "A6", "A7", "A8", "A9")}


def _wiring_rows(board: str) -> dict[str, str]:
    section = WIRING.split(f"## {board}")[1].split("\n## ")[0]
    rows = [row.split("|") for row in re.findall(r"^\|(.*)\|$", section, re.MULTILINE)[2:]]
    return {row[0].strip(): row[1].strip() for row in rows}


def test_the_wiring_of_the_sequencer_is_the_firmwares() -> None:
    rows = _wiring_rows("Sequencer")
    by_use = {use: f"D{pin}" for pin, use in sequencer_pins().items()}
    assert rows == {
        ", ".join(by_use[f"servo, joint {joint}"] for joint in (1, 2, 3)): "servo signals of joints 1, 2, 3",
        by_use["release switch 1"]: "release switch 1",
        by_use["release switch 2"]: "release switch 2",
        by_use["stroke line, out"]: "stroke line to the logger",
        by_use["status LED"]: "status LED",
    }


def test_the_wiring_of_the_logger_is_the_firmwares() -> None:
    rows = _wiring_rows("Logger")
    pin = {use: number for number, use in logger_pins().items()}
    analog = {number: name for name, number in TEENSY_ANALOG.items()}
    for suffix, imus in (("", "1 and 2"), ("1", "3 and 4")):
        sda, scl = pin[f"SDA{suffix}, IMU {imus}"], pin[f"SCL{suffix}, IMU {imus}"]
        assert f"IMU {imus[0]}" in rows[f"{sda} (SDA{suffix}), {scl} (SCL{suffix})"]
    for joint in (1, 2, 3):
        names = ", ".join(analog[pin[f"angle sensor {joint}{letter}"]] for letter in "ab")
        assert rows[names] == f"absolute angle sensors of joint {joint}"
    assert rows[f"{pin['release switch 1']}, {pin['release switch 2']}"] == "release switches 1, 2"
    assert rows[pin["stroke line, in"]] == "stroke line"


def test_the_comments_of_the_sequencers_sketch_name_the_same_pins() -> None:
    head = _source("arduino_sequencer/arduino_sequencer.ino").split("#include")[0]
    pins = {use: pin for pin, use in sequencer_pins().items()}
    assert re.search(
        rf"D{pins['servo, joint 1']} D{pins['servo, joint 2']} D{pins['servo, joint 3']} +servo", head
    )
    assert re.search(rf"D{pins['release switch 1']} D{pins['release switch 2']} +release switches 1, 2", head)
    assert re.search(rf"D{pins['stroke line, out']} +stroke line", head)
    assert re.search(rf"D{pins['status LED']} +status LED", head)
