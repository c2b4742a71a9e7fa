"""The wires of docs/wiring.toml end at the pins that both firmwares use, and all of them are in the drawing."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass

from tests.docs.wiring.firmware_pins import TEENSY_ANALOG, logger_pins, sequencer_pins
from tests.docs.wiring.wirings import load_committed
from tests.paths import REPOSITORY

SVG = ET.parse(REPOSITORY / "docs" / "wiring.svg").getroot()
NAMESPACE = {"svg": "http://www.w3.org/2000/svg"}


def test_the_sequencers_wires_are_the_firmwares() -> None:
    wired = {
        wire.pin.removeprefix("D"): wire.carries
        for wire in load_committed().wires
        if wire.panel == "sequencer"
    }
    assert wired == {pin: use.removesuffix(", out") for pin, use in sequencer_pins().items()}


def test_the_loggers_wires_are_the_firmwares() -> None:
    wires = load_committed().wires
    wired = {
        wire.terminal: wire.carries
        for wire in wires
        if wire.device == "Teensy 4.1" and wire.panel == "sequencer"
    }
    wired |= {
        wire.pin.split(" ")[0]: wire.carries
        for wire in wires
        if wire.panel == "logger" and wire.pin not in ("3.3V", "GND")
    }
    # The Teensy's LED needs no wire.
    on_the_board = {"13"}
    assert wired == {
        pin: use.removesuffix(", in") for pin, use in logger_pins().items() if pin not in on_the_board
    }
    named = dict(re.findall(r"(\d+) \((A\d)\)", " ".join(wire.pin for wire in wires)))
    assert named == {TEENSY_ANALOG[name]: name for name in named.values()} and len(named) == 6


def test_nothing_flows_from_usb_through_the_micro_to_the_battery_and_servos() -> None:
    """Block current from USB through the Micro to the battery and servos by a diode in the Micro's supply.

    The Micro's regulator conducts backwards; the diode passes current towards VIN only.
    """
    (supply,) = [wire for wire in load_committed().wires if wire.device == "Arduino Micro"]
    parts = [element.part for element in supply.path]
    assert [(part.kind, part.cathode) for part in parts[-1:]] == [("diode", "right")]


def _texts() -> list[ET.Element]:
    return SVG.findall("svg:text", NAMESPACE)


def test_every_pin_terminal_part_and_value_is_in_the_drawing() -> None:
    drawing_texts = {text.text for text in _texts()}
    wiring = load_committed()
    for wire in wiring.wires:
        assert {wire.pin, wire.carries, wire.device, wire.terminal} <= drawing_texts
        for element in wire.path:
            assert {element.part.ref, element.part.short} <= drawing_texts
            assert element.net in ("", "GND") or element.net in drawing_texts
    assert {panel.board for panel in wiring.panels} <= drawing_texts


@dataclass(frozen=True)
class Area:
    left: float
    right: float
    top: float
    bottom: float

    def covers(self, other: Area) -> bool:
        return (
            self.left < other.right
            and other.left < self.right
            and self.top < other.bottom
            and other.top < self.bottom
        )


def _area(text: ET.Element) -> Area:
    """About what the words take up: 0.58 of their height a letter."""
    height = {"s": 12.0, "t": 19.0}.get(text.get("class", ""), 14.0)
    width = 0.58 * height * len(text.text or "")
    x, y = float(text.get("x", "")), float(text.get("y", ""))
    left_x = x - {"middle": width / 2, "end": width}.get(text.get("text-anchor", ""), 0.0)
    return Area(left_x, left_x + width, y - 0.75 * height, y)


def test_no_words_lie_over_others_or_outside() -> None:
    frame = Area(0.0, float(SVG.get("width", "")), 0.0, float(SVG.get("height", "")))
    placed: list[tuple[str, Area]] = []
    for text in _texts():
        area = _area(text)
        assert area.left >= frame.left and area.right <= frame.right, text.text
        assert area.bottom <= frame.bottom, text.text
        assert [other for other, there in placed if area.covers(there)] == [], text.text
        placed.append((text.text or "", area))
    assert len(placed) > 100
