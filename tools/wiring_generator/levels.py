"""What the wiring does to levels, currents and edges, at the worst corner of every tolerance."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

from .spec import Wiring

Span = tuple[float, float]
"""Least and most."""


@dataclass(frozen=True)
class Check:
    """A span of a quantity, and the limit that it keeps: "at most" or "at least" in the same unit."""

    what: str
    how: str
    span: Span
    unit: str
    side: str
    limit: float
    source: str

    @property
    def holds(self) -> bool:
        return self.span[1] <= self.limit if self.side == "at most" else self.span[0] >= self.limit


def extremes(quantity: Callable[..., float], *spans: Span) -> Span:
    """Return least and most over the corners of `spans`: exact for what is monotonic in each."""
    values = [quantity(*corner) for corner in itertools.product(*spans)]
    return min(values), max(values)


def divider_v(top_v: float, bottom_v: float, top_ohm: float, bottom_ohm: float) -> float:
    """Compute the voltage between two resistors in a row, V."""
    return bottom_v + (top_v - bottom_v) * bottom_ohm / (top_ohm + bottom_ohm)


def parallel(*ohms: float) -> float:
    """Compute the resistance of resistors beside each other, ohm."""
    return 1 / sum(1 / ohm for ohm in ohms)


def avr_low_v(supply_v: float) -> float:
    """Read as low for certain up to here (table 29-1)."""
    return 0.2 * supply_v - 0.1


def avr_high_v(supply_v: float) -> float:
    """Read as high for certain from here (table 29-1)."""
    return 0.2 * supply_v + 0.9


def closed_v(supply_v: float, pullup_ohm: float, series_ohm: float) -> float:
    """Compute the voltage at D4 or D13 with the contact closed: the pin's own pull-up against the series resistor."""
    return divider_v(supply_v, 0.0, pullup_ohm, series_ohm)


def opening_s(
    supply_v: float, own_ohm: float, pullup_ohm: float, series_ohm: float, farad: float, threshold_v: float
) -> float:
    """Compute the time from an opening to the pin's threshold: the capacitor charges through all pull-ups."""
    # As long as the contact is closed, only the pin's own pull-up works against the series resistor.
    start_v = closed_v(supply_v, own_ohm, series_ohm)
    tau_s = parallel(own_ohm, pullup_ohm + series_ohm) * farad
    return tau_s * math.log((supply_v - start_v) / (supply_v - threshold_v))


def closing_s(supply_v: float, own_ohm: float, series_ohm: float, farad: float, threshold_v: float) -> float:
    """Compute the time from a closing to the pin's threshold: the capacitor empties through the series resistor.

    Infinite where it never gets there.
    """
    end_v = closed_v(supply_v, own_ohm, series_ohm)
    # The capacitor empties towards this voltage; a threshold below is never crossed.
    if end_v >= threshold_v:
        return math.inf
    tau_s = parallel(own_ohm, series_ohm) * farad
    return tau_s * math.log((supply_v - end_v) / (threshold_v - end_v))


class Levels:
    """All quantities of one wiring."""

    def __init__(self, wiring: Wiring) -> None:
        self._wiring = wiring

    def span(self, name: str) -> Span:
        """Return a range of the file, or a part's value with its tolerance."""
        if name in self._wiring.ranges:
            value = self._wiring.ranges[name]
            return value.low, value.high
        part = self._wiring.parts[name]
        tolerance = self._wiring.tolerance[part.kind]
        return part.of * (1 - tolerance), part.of * (1 + tolerance)

    def spans(self, *names: str) -> list[Span]:
        return [self.span(name) for name in names]

    def edge_delays_s(self) -> tuple[Span, Span]:
        """Compute how late D4 and D13 read an opening and a closing, s."""

        # The threshold lies anywhere between the two guaranteed levels.
        def delay_open(supply: float, own: float, pullup: float, series: float, farad: float) -> Span:
            return extremes(
                lambda threshold: opening_s(supply, own, pullup, series, farad, threshold),
                (avr_low_v(supply), avr_high_v(supply)),
            )

        def delay_closed(supply: float, own: float, series: float, farad: float) -> Span:
            return extremes(
                lambda threshold: closing_s(supply, own, series, farad, threshold),
                (avr_low_v(supply), avr_high_v(supply)),
            )

        # Least of the least and most of the most: each bound has its own worst corner.
        open_spans = self.spans("micro_5v", "avr_pullup", "R1", "R3", "C1")
        close_spans = self.spans("micro_5v", "avr_pullup", "R3", "C1")
        return (
            (
                extremes(lambda *at: delay_open(*at)[0], *open_spans)[0],
                extremes(lambda *at: delay_open(*at)[1], *open_spans)[1],
            ),
            (
                extremes(lambda *at: delay_closed(*at)[0], *close_spans)[0],
                extremes(lambda *at: delay_closed(*at)[1], *close_spans)[1],
            ),
        )

    def checks(self) -> list[Check]:
        """Check every level and current that the wiring was chosen by."""
        return self._switch_at_micro() + self._switch_at_teensy() + self._other_lines()

    def _switch_at_micro(self) -> list[Check]:
        limit = self._wiring.limit
        supply = self.span("micro_5v")
        # The limit moves with the supply, so the margin is what is spanned.
        closed = extremes(
            lambda v, own, series: avr_low_v(v) - closed_v(v, own, series),
            *self.spans("micro_5v", "avr_pullup", "R3"),
        )
        clone = extremes(
            lambda v, pullup, series, led, drop: divider_v(v, drop, pullup + series, led) - avr_high_v(v),
            *self.spans("micro_5v", "R2", "R4", "clone_led", "led_drop"),
        )
        opening, _ = self.edge_delays_s()
        return [
            Check(
                "current through a closed contact",
                "5V over R1",
                extremes(lambda v, ohm: v / ohm * 1e3, supply, self.span("R1")),
                "mA",
                "at least",
                limit["contact_a"] * 1e3,
                "omron",
            ),
            Check(
                "D4, D13 closed: margin below the low threshold",
                "pin's pull-up against R3",
                closed,
                "V",
                "at least",
                0.0,
                "avr",
            ),
            Check(
                "D13 open, LED without a buffer: margin above the high threshold",
                "R2 and R4 against the LED and its 1 kΩ",
                clone,
                "V",
                "at least",
                0.0,
                "avr",
            ),
            Check(
                "D13 driven high by the bootloader, contact closed",
                "5V over R4",
                extremes(lambda v, ohm: v / ohm * 1e3, supply, self.span("R4")),
                "mA",
                "at most",
                limit["avr_pin_a"] * 1e3,
                "caterina",
            ),
            Check(
                "date of an opening: late by",
                "C1 through R1, R3 and the pin's pull-up",
                (opening[0] * 1e6, opening[1] * 1e6),
                "µs",
                "at most",
                limit["date_s"] * 1e6,
                "avr",
            ),
        ]

    def _switch_at_teensy(self) -> list[Check]:
        limit = self._wiring.limit
        closed = extremes(
            # The i.MX RT reads low up to 0.3 of its supply, high from 0.7.
            lambda supply, drop, own, series: 0.3 * supply - divider_v(supply, drop, own, series),
            *self.spans("teensy_3v3", "diode_drop", "teensy_pullup", "R18"),
        )
        open_v = extremes(lambda ohm, leak: ohm * leak, *self.spans("teensy_pullup", "diode_leakage"))
        # The pin follows the node by the diode's drop while the bootloader holds D13 low.
        held_low = extremes(
            lambda v, pullup, series, drop, supply: divider_v(v, 0.0, pullup, series) + drop - 0.7 * supply,
            *self.spans("micro_5v", "R2", "R4", "diode_drop", "teensy_3v3"),
        )
        return [
            Check(
                "Teensy 2, 3 closed: margin below the low threshold",
                "drop of CR1, pin's pull-up against R18",
                closed,
                "V",
                "at least",
                0.0,
                "imxrt",
            ),
            Check(
                "Teensy 2, 3 open: above its own supply by",
                "leakage of CR1 in the pin's pull-up",
                open_v,
                "V",
                "at most",
                limit["teensy_over_supply_v"],
                "imxrt",
            ),
            Check(
                "Teensy 3 open, D13 driven low by the bootloader: margin above the high threshold",
                "R2 against R4, drop of CR2",
                held_low,
                "V",
                "at least",
                0.0,
                "caterina",
            ),
        ]

    def _other_lines(self) -> list[Check]:
        limit = self._wiring.limit
        stroke_top = extremes(
            # In reset the Teensy has no pull-down yet: the most that its pin sees.
            lambda v, top, bottom: divider_v(v, 0.0, top, bottom),
            *self.spans("micro_5v", "R11", "R12"),
        )
        stroke = extremes(
            lambda v, top, bottom, down, supply: (
                divider_v(v, 0.0, top, parallel(bottom, down)) - 0.7 * supply
            ),
            *self.spans("micro_5v", "R11", "R12", "teensy_pulldown", "teensy_3v3"),
        )
        return [
            Check(
                "Teensy 4, stroke line high, Teensy in reset",
                "R11, R12",
                stroke_top,
                "V",
                "at most",
                limit["teensy_pin_v"],
                "card",
            ),
            Check(
                "Teensy 4, stroke line high: margin above the high threshold",
                "R11, R12 beside the pin's pull-down",
                stroke,
                "V",
                "at least",
                0.0,
                "imxrt",
            ),
            Check(
                "servo line while the Micro is in reset",
                "the pin's leakage in R8",
                extremes(lambda amp, ohm: amp * ohm, *self.spans("avr_leakage", "R8")),
                "V",
                "at most",
                limit["servo_float_v"],
                "avr",
            ),
            Check(
                "the Micro's VIN",
                "battery less the drop of CR3",
                extremes(lambda v, drop: v - drop, *self.spans("battery", "vin_diode_drop")),
                "V",
                "at least",
                limit["vin_v"],
                "regulator",
            ),
            Check(
                "status LED",
                "5V less the LED over R13",
                extremes(
                    lambda v, drop, ohm: (v - drop) / ohm * 1e3, *self.spans("micro_5v", "led_drop", "R13")
                ),
                "mA",
                "at most",
                limit["avr_pin_a"] * 1e3,
                "avr",
            ),
        ]


@dataclass(frozen=True)
class BusPullup:
    """One bus with two modules: what all its pull-ups come to, and whether R14 to R17 are fitted."""

    module_ohm: float
    bare_ohm: float
    total_ohm: float
    fit: bool
    max_farad: float


def min_bus_ohm(wiring: Wiring) -> float:
    """Compute the pull-up below which more current flows than the bus's parts sink (UM10204 7.1, equation 2)."""
    limit = wiring.limit
    supply_v = wiring.ranges["teensy_3v3"].high
    return (supply_v - limit["i2c_low_v"]) / limit["i2c_sink_a"]


def bus_pullups(wiring: Wiring) -> list[BusPullup]:
    """Choose for each module that is sold: the external resistor is fitted where the bus would be too slow without."""
    rows = []
    for module_ohm in wiring.i2c["modules_ohm"]:
        # Two modules share a bus; some are sold without pull-ups (0).
        own = [wiring.i2c["teensy_ohm"]] + ([module_ohm] * 2 if module_ohm else [])
        bare = parallel(*own)
        fit = _max_farad(wiring, bare) < wiring.limit["i2c_cable_f"]
        total = parallel(bare, wiring.i2c["external_ohm"]) if fit else bare
        rows.append(BusPullup(module_ohm, bare, total, fit, _max_farad(wiring, total)))
    return rows


def _max_farad(wiring: Wiring, ohm: float) -> float:
    """Compute the greatest capacitance of a bus with this pull-up, F (UM10204 7.1, equation 1)."""
    # A rise is measured from 0.3 to 0.7 of the supply: ln(7/3) time constants.
    return wiring.limit["i2c_rise_s"] / (math.log(7 / 3) * ohm)
