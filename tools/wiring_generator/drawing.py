"""docs/wiring.svg: each board with its wires, one row a wire, from the pin on the left to the terminal on the right."""

from __future__ import annotations

from itertools import groupby
from xml.sax.saxutils import escape

from .spec import Element, Panel, Wire, Wiring

_WIDTH = 1090
_LEFT, _BOARD = 14, 160  # the board's box
_RIGHT, _DEVICE = 822, 254  # the devices' boxes
_FIRST, _STEP = 362, 86  # the parts' places along a wire
_ABOVE, _BELOW, _FLAT = 82, 76, 22
_SERIES, _NAME = 44, 16

_ELECTROLYTIC_F = 10e-6

_STYLE = (
    "text{font:14px sans-serif;fill:#111}.b{font-weight:bold}.s{font-size:12px;fill:#333}"
    ".t{font-size:19px;font-weight:bold}"
    "path,rect,circle{stroke:#111;stroke-width:1.6;fill:none}.f{fill:#111}.w{fill:#fff}.o{fill:#eef3f8}"
)


def draw(wiring: Wiring) -> str:
    """Draw the picture as SVG."""
    pen = _Pen()
    y = 20.0
    for panel in wiring.panels:
        y = _panel(pen, panel, [wire for wire in wiring.wires if wire.panel == panel.name], y) + 34
    for line in _LEGEND:
        pen.text(_LEFT, y, line, "s")
        y += 19
    height = round(y + 6)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" width="{_WIDTH}" height="{height}">\n'
        "<!-- Drawn by tools/generate_wiring.py from docs/wiring.toml. -->\n"
        f"<style>{_STYLE}</style>\n"
        f'<rect class="w" x="0" y="0" width="{_WIDTH}" height="{height}" style="stroke:none"/>\n'
        + "\n".join(pen.shapes)
        + "\n</svg>\n"
    )


_LEGEND = (
    "A dot joins wires. GND: the ground of the board at the left; of R8 to R10, which sit at the servos' plugs, that "
    "of the servos.",
    "5V: the Micro's pin 5V, used as an output. 3.3V: the Teensy's pin 3.3V. Behind S3: the wire that leaves S3.",
    "CR: diode; the bar is the end with the ring (cathode): at the switch, and of CR3 at the Micro. LED1: the short "
    "leg is at GND.",
    "S1, S2 are drawn open: robot not seated.",
    "* R14 to R17: fitted or left out by the table of pull-ups.",
)


class _Pen:
    def __init__(self) -> None:
        self.shapes: list[str] = []

    def line(self, *points: float) -> None:
        pairs = " L".join(f"{x:g} {y:g}" for x, y in zip(points[::2], points[1::2], strict=True))
        self.shapes.append(f'<path d="M{pairs}"/>')

    def box(self, x: float, y: float, width: float, height: float, kind: str = "w") -> None:
        self.shapes.append(
            f'<rect class="{kind}" x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="3"/>'
        )

    def dot(self, x: float, y: float, kind: str = "f", radius: float = 3.2) -> None:
        self.shapes.append(f'<circle class="{kind}" cx="{x:g}" cy="{y:g}" r="{radius:g}"/>')

    def shape(self, points: str, kind: str = "f") -> None:
        self.shapes.append(f'<path class="{kind}" d="M{points}Z"/>')

    def text(self, x: float, y: float, text: str, kind: str = "", anchor: str = "start") -> None:
        self.shapes.append(
            f'<text class="{kind}" x="{x:g}" y="{y:g}" text-anchor="{anchor}">{escape(text)}</text>'
        )


def _panel(pen: _Pen, panel: Panel, wires: list[Wire], top: float) -> float:
    """Draws it; where it ends."""
    pen.text(_LEFT, top + 14, panel.title, "t")
    edge = y = top + 26
    rows: list[tuple[Wire, float, float]] = []  # wire, height of its line, end of its room
    before = ""
    for wire in wires:
        y += _room_above(wire) + (_NAME if wire.device != before else 0)
        rows.append((wire, y, y + (_BELOW if any(element.net == "GND" for element in wire.path) else _FLAT)))
        y, before = rows[-1][2], wire.device
    pen.box(_LEFT, edge, _BOARD, y - edge, "o")
    pen.text(_LEFT + 12, edge + 19, panel.board, "b")
    start = edge
    for device, group in groupby(rows, key=lambda row: row[0].device):
        members = list(group)
        end = members[-1][2]
        pen.box(_RIGHT, start + 3, _DEVICE, end - start - 6, "o")
        pen.text(_RIGHT + _DEVICE - 12, start + 20, device, "b", "end")
        start = end
    for wire, line, _ in rows:
        _wire(pen, wire, line)
    return y


def _room_above(wire: Wire) -> float:
    if any(element.net not in ("", "GND") for element in wire.path):
        return _ABOVE
    return _SERIES if any(not element.net for element in wire.path) else _FLAT


def _wire(pen: _Pen, wire: Wire, y: float) -> None:
    pen.text(_LEFT + _BOARD - 10, y + 5, wire.pin, "b", "end")
    pen.text(_LEFT + _BOARD + 8, y - 6, wire.carries, "s")
    pen.text(_RIGHT + 10, y + 5, wire.terminal)
    x = float(_LEFT + _BOARD)
    for place, element in enumerate(wire.path):
        at = float(_FIRST + place * _STEP)
        if element.net:
            pen.dot(at, y)
            _shunt(pen, element, at, y)
        else:
            pen.line(x, y, at - 24, y)
            _series(pen, element, at, y)
            x = at + 24
    pen.line(x, y, _RIGHT, y)


def _series(pen: _Pen, element: Element, x: float, y: float) -> None:
    part = element.part
    pen.text(x, y - 28, part.ref, "b", "middle")
    pen.text(x, y - 14, part.short, "s", "middle")
    if part.kind in ("diode", "led"):
        bar = -1 if part.cathode == "left" else 1
        pen.line(x - 24, y, x + 24, y)
        pen.shape(f"{x - 9 * bar:g} {y - 9:g} L{x - 9 * bar:g} {y + 9:g} L{x + 9 * bar:g} {y:g} ")
        pen.line(x + 9 * bar, y - 10, x + 9 * bar, y + 10)
        if part.kind == "led":
            pen.line(x + 2, y + 12, x + 10, y + 22)
            pen.line(x + 10, y + 10, x + 18, y + 20)
        return
    if part.kind == "box":
        pen.box(x - 24, y - 11, 48, 22, "o")
    else:
        pen.box(x - 24, y - 8, 48, 16)


def _shunt(pen: _Pen, element: Element, x: float, y: float) -> None:
    part = element.part
    up = -1 if element.net != "GND" else 1
    if up < 0:  # wire, part, net at the top
        pen.line(x, y, x, y - 10)
        pen.box(x - 7, y - 46, 14, 36)
        pen.line(x, y - 46, x, y - 56)
        pen.line(x - 9, y - 56, x + 9, y - 56)
        pen.text(x, y - 61, element.net, "b", "middle")
        pen.text(x + 13, y - 30, part.ref, "b")
        pen.text(x + 13, y - 15, part.short, "s")
        return
    pen.line(x, y, x, y + 14)
    if part.kind == "resistor":
        pen.box(x - 7, y + 14, 14, 34)
    elif part.kind == "capacitor":
        pen.line(x, y + 14, x, y + 27)
        pen.line(x - 11, y + 27, x + 11, y + 27)
        pen.line(x - 11, y + 34, x + 11, y + 34)
        pen.line(x, y + 34, x, y + 48)
        if part.of >= _ELECTROLYTIC_F:
            pen.text(x - 22, y + 25, "+", "b")
    else:  # a switch
        pen.line(x, y + 14, x, y + 18)
        pen.dot(x, y + 19, "w", 2.6)
        pen.dot(x, y + 44, "w", 2.6)
        pen.line(x, y + 42, x - 12, y + 21)
        pen.line(x, y + 46, x, y + 48)
    pen.line(x, y + 48, x, y + 60)
    for width, drop in ((11, 60), (7, 65), (3, 70)):
        pen.line(x - width, y + drop, x + width, y + drop)
    pen.text(x + 15, y + 28, part.ref, "b")
    pen.text(x + 15, y + 43, part.short, "s")
