"""docs/wiring.toml, read and checked."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

KINDS = ("resistor", "capacitor", "diode", "led", "switch", "box")
_SHUNT = re.compile(r"(\w+) to (\S+)")


class WiringError(Exception):
    """The file does not describe a wiring; the message names the entry."""


@dataclass(frozen=True)
class Part:
    """A component. `of` is its value in ohm or farad, 0 where it has none."""

    ref: str
    kind: str
    value: str
    short: str
    of: float
    cathode: str


@dataclass(frozen=True)
class Element:
    """A part in the wire (net is ""), or from the wire to a net."""

    part: Part
    net: str


@dataclass(frozen=True)
class Wire:
    """From a pin of its panel's board to a terminal of a device."""

    panel: str
    pin: str
    carries: str
    path: tuple[Element, ...]
    device: str
    terminal: str


@dataclass(frozen=True)
class Panel:
    """One board with its wires, drawn together."""

    name: str
    title: str
    board: str


@dataclass(frozen=True)
class Range:
    """What a value may be, in `unit`."""

    low: float
    high: float
    unit: str
    source: str
    why: str


@dataclass(frozen=True)
class Source:
    """Where figures come from, and whether it was read."""

    title: str
    place: str
    read: str


@dataclass(frozen=True)
class Wiring:
    """The whole file."""

    panels: tuple[Panel, ...]
    wires: tuple[Wire, ...]
    parts: dict[str, Part]
    ranges: dict[str, Range]
    sources: dict[str, Source]
    tolerance: dict[str, float]
    limit: dict[str, float]
    i2c: dict[str, Any]


def load_wiring(path: Path) -> Wiring:
    """Raises WiringError."""
    with path.open("rb") as file:
        try:
            raw = tomllib.load(file)
        except tomllib.TOMLDecodeError as error:
            raise WiringError(str(error)) from error
    try:
        parts = {ref: _part(ref, entry) for ref, entry in raw["part"].items()}
        panels = tuple(Panel(name, **entry) for name, entry in raw["panel"].items())
        wiring = Wiring(
            panels=panels,
            wires=tuple(_wire(entry, parts, {panel.name for panel in panels}) for entry in raw["wire"]),
            parts=parts,
            ranges={name: Range(**entry) for name, entry in raw["range"].items()},
            sources={name: Source(**entry) for name, entry in raw["source"].items()},
            tolerance=raw["tolerance"],
            limit=raw["limit"],
            i2c=raw["i2c"],
        )
    except (KeyError, TypeError) as error:
        raise WiringError(f"an entry is missing or unknown: {error}") from error
    _check(wiring)
    return wiring


def _part(ref: str, entry: dict[str, Any]) -> Part:
    if entry["kind"] not in KINDS:
        raise WiringError(f"{ref}: kind {entry['kind']} is none of {', '.join(KINDS)}")
    if entry["kind"] == "diode" and entry.get("cathode") not in ("left", "right"):
        raise WiringError(f"{ref}: cathode is left or right")
    return Part(
        ref,
        entry["kind"],
        entry["value"],
        entry.get("short", entry["value"]),
        entry.get("of", 0.0),
        entry.get("cathode", ""),
    )


def _wire(entry: dict[str, Any], parts: dict[str, Part], panels: set[str]) -> Wire:
    name = f"wire {entry['panel']} {entry['from']}"
    if entry["panel"] not in panels:
        raise WiringError(f"{name}: there is no such panel")
    path = []
    for text in entry.get("path", []):
        shunt = _SHUNT.fullmatch(text)
        ref, net = (shunt[1], shunt[2]) if shunt else (text, "")
        if ref not in parts:
            raise WiringError(f"{name}: there is no part {ref}")
        path.append(Element(parts[ref], net))
    return Wire(entry["panel"], entry["from"], entry["carries"], tuple(path), entry["device"], entry["to"])


def _check(wiring: Wiring) -> None:
    wired_refs = [element.part.ref for wire in wiring.wires for element in wire.path]
    for ref in wiring.parts:
        if wired_refs.count(ref) != 1 and ref != "BT1":
            raise WiringError(f"{ref} is wired {wired_refs.count(ref)} times")
    for name, value in wiring.ranges.items():
        if not value.low < value.high:
            raise WiringError(f"range {name}: low is not below high")
        if value.source not in wiring.sources:
            raise WiringError(f"range {name}: there is no source {value.source}")
    ends = [
        (wire.device, wire.terminal)
        for wire in wiring.wires
        if wire.device in ("Teensy 4.1", "Arduino Micro")
    ]
    starts = [(wire.panel, wire.pin) for wire in wiring.wires if wire.panel != "supply"]
    for pins in (ends, starts):
        for pin in pins:
            if pins.count(pin) > 1:
                raise WiringError(f"{' '.join(pin)} is wired twice")
