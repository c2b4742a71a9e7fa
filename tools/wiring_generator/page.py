"""docs/wiring.md: prose from wiring.in.md, tables and numbers from the wiring."""

from __future__ import annotations

import re
from itertools import groupby
from pathlib import Path

from .levels import Check, Levels, burst_deadline_us, bus_pullups, max_bus_ohm, min_bus_ohm
from .spec import Element, Part, Wire, Wiring, WiringError

_PROSE = Path(__file__).with_name("wiring.in.md")


def generate(wiring: Wiring) -> str:
    """Write the page.

    Raises WiringError for a limit that does not hold, and a name between @ signs that nothing fills.
    """
    levels = Levels(wiring)
    checks = levels.checks()
    for check in checks:
        if not check.holds:
            raise WiringError(f"{check.what}: {_span(check)} {check.unit}, {check.side} {check.limit:g}")
    opening, closing = levels.edge_delays_s()
    values = {f"pins_{panel.name}": _pins(wiring, panel.name) for panel in wiring.panels}
    values |= {f"cite_{name}": _name(wiring, name) for name in wiring.sources}
    values |= {
        "parts": _parts(wiring),
        "checks": _checks(wiring, checks),
        "pullups": _pullups(wiring),
        "sources": _sources(wiring),
        "opening_us": f"{opening[0] * 1e6:.0f} to {opening[1] * 1e6:.0f}",
        "closing_us": f"{closing[0] * 1e6:.0f} to {closing[1] * 1e6:.0f}",
        "min_bus_ohm": f"{min_bus_ohm(wiring) / 1e3:.2f} kΩ",
        "max_bus_ohm": f"{max_bus_ohm(wiring) / 1e3:.2f} kΩ",
        "max_rise_ns": f"{wiring.limit['i2c_bit_rise_s'] * 1e9:.0f} ns",
        "margin_ns": f"{wiring.limit['i2c_margin_s'] * 1e9:.0f} ns",
        "deadline_us": f"{burst_deadline_us(wiring)} µs",
    }

    def value(match: re.Match[str]) -> str:
        if match[1] not in values:
            raise WiringError(f"{_PROSE.name}: nothing is called @{match[1]}@")
        return values[match[1]]

    return re.sub(r"@(\w+)@", value, _PROSE.read_text(encoding="utf-8"))


def _table(head: str, rows: list[str]) -> str:
    return "\n".join([head, "|".join(["", *["---"] * (head.count("|") - 1), ""]), *rows])


def _pins(wiring: Wiring, panel: str) -> str:
    return _table(
        "| pin | what | on the way | ends at |",
        [
            f"| {wire.pin} | {wire.carries} | {'; '.join(_element(element, wire) for element in wire.path)} "
            f"| {wire.device}: {wire.terminal} |"
            for wire in wiring.wires
            if wire.panel == panel
        ],
    )


def _element(element: Element, wire: Wire) -> str:
    part = element.part
    text = f"{part.ref} {part.short}"
    if part.kind == "diode":
        text += f", ring towards {wire.pin if part.cathode == 'left' else wire.device}"
    return f"{text} to {element.net}" if element.net else text


def _parts(wiring: Wiring) -> str:
    def key(part: Part) -> tuple[str, str]:
        return part.kind, part.value

    rows = []
    for (_, value), group in groupby(sorted(wiring.parts.values(), key=key), key=key):
        refs = sorted((part.ref for part in group), key=lambda ref: (ref[0], int(re.sub(r"\D", "", ref))))
        rows.append(f"| {value} | {', '.join(refs)} |")
    return _table("| part | in the drawing |", rows)


def _checks(wiring: Wiring, checks: list[Check]) -> str:
    return _table(
        "| what | set by | least to most | limit |",
        [
            f"| {check.what} | {check.how} | {_span(check)} | {check.side} {check.limit:g} {check.unit} "
            f"{_name(wiring, check.source)} |"
            for check in checks
        ],
    )


def _span(check: Check) -> str:
    return f"{check.span[0]:.3g} to {check.span[1]:.3g}"


def _name(wiring: Wiring, source: str) -> str:
    return f"[{list(wiring.sources).index(source) + 1}]"


def _pullups(wiring: Wiring) -> str:
    rows = []
    for bus in bus_pullups(wiring):
        module = f"{bus.module_ohm / 1e3:g} kΩ" if bus.module_ohm else "none"
        use = f"{bus.external_ohm / 1e3:g} kΩ" if bus.external_ohm else "leave out"
        rows.append(
            f"| {module} | {bus.bare_ohm / 1e3:.2f} kΩ | {use} | {bus.total_ohm / 1e3:.2f} kΩ "
            f"| {bus.max_farad * 1e12:.0f} pF |"
        )
    return _table(
        "| on each of two modules | they and the Teensy | R14 to R17 | together | cable and parts up to |",
        rows,
    )


def _sources(wiring: Wiring) -> str:
    return _table(
        "| | document |",
        [f"| {_name(wiring, name)} | {source.title} |" for name, source in wiring.sources.items()],
    )
