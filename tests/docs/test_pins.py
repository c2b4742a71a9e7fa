"""The pin maps that people solder by are the firmware's."""

from __future__ import annotations

import re

from tests.docs.wiring.firmware_pins import TEENSY_ANALOG, logger_pins, sequencer_pins, source
from tests.paths import REPOSITORY

MAPS = (REPOSITORY / "docs" / "guide" / "pin-map.md").read_text(encoding="utf-8")


def _map_of(board: str) -> dict[str, str]:
    """Numbered pins of a pin map, with what they carry."""
    section = MAPS.split(f"## {board}")[1].split("\n## ")[0]
    pins: dict[str, str] = {}
    # The first two rows are the head of the table and its rule.
    for row in re.findall(r"^\|(.*)\|$", section, re.MULTILINE)[2:]:
        left_use, left_pin, right, right_use = (cell.strip() for cell in row.split("|"))
        pins |= {left_pin.split(" ")[0]: left_use, right.split(" ")[0]: right_use}
    return {pin: use for pin, use in pins.items() if pin.isdigit() and use}


def test_the_pin_map_of_the_sequencer_is_the_firmwares() -> None:
    assert _map_of("Sequencer") == sequencer_pins()


def test_the_pin_map_of_the_logger_is_the_firmwares() -> None:
    assert _map_of("Logger") == logger_pins()


def test_analog_names_in_the_pin_map_are_right() -> None:
    named = dict(re.findall(r"(\d+) \((A\d)\)", MAPS))
    assert named == {TEENSY_ANALOG[name]: name for name in ("A0", "A1", "A6", "A7", "A8", "A9")}


def test_the_comments_of_the_sequencers_sketch_name_the_same_pins() -> None:
    # Before the first include: what somebody who opens the sketch reads.
    head = source("arduino_sequencer/arduino_sequencer.ino").split("#include")[0]
    pins = {use: pin for pin, use in sequencer_pins().items()}
    assert re.search(
        rf"D{pins['servo, joint 1']} D{pins['servo, joint 2']} D{pins['servo, joint 3']} +servo", head
    )
    assert re.search(rf"D{pins['release switch 1']} D{pins['release switch 2']} +release switches 1, 2", head)
    assert re.search(rf"D{pins['stroke line, out']} +stroke line", head)
    assert re.search(rf"D{pins['status LED']} +status LED", head)
