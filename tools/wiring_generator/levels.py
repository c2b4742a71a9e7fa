"""What the wiring does to levels, currents and edges, at the worst corner of every tolerance."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

from .spec import Wiring, WiringError

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
        return self._switch_at_micro() + self._switch_at_teensy() + self._other_lines() + self._buses()

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

    def _buses(self) -> list[Check]:
        limit, i2c = self._wiring.limit, self._wiring.i2c
        rises_s = [row.rise_s(limit["i2c_cable_f"]) for row in bus_pullups(self._wiring)]
        burst = [i2c["idle_s"] + i2c["burst_bits"] * (i2c["bit_s"] + rise_s) for rise_s in rises_s]
        return [
            Check(
                "clock of an I2C bus: rise to the high threshold of the Teensy",
                "each row of the pull-ups, 150 pF",
                (min(rises_s) * 1e9, max(rises_s) * 1e9),
                "ns",
                "at most",
                limit["i2c_bit_rise_s"] * 1e9,
                "imxrt",
            ),
            Check(
                "an IMU's burst at 400 kHz, before the logger gives it up",
                "156 bits of 2.5 µs and that rise, 8 µs before",
                (min(burst) * 1e6, max(burst) * 1e6),
                "µs",
                "at most",
                burst_deadline_us(self._wiring),
                "robot",
            ),
        ]


def burst_deadline_us(wiring: Wiring) -> int:
    """Compute when the logger gives up a burst at 400 kHz, µs: slower than any permitted bus, by the margin."""
    limit, i2c = wiring.limit, wiring.i2c
    bit_s: float = i2c["bit_s"] + limit["i2c_bit_rise_s"] + limit["i2c_margin_s"]
    burst_s: float = i2c["idle_s"] + i2c["burst_bits"] * bit_s
    # Rounded to the nanosecond first: 440.9 us of floats must not become 442.
    return math.ceil(round(burst_s * 1e6, 3))


@dataclass(frozen=True)
class BusPullup:
    """One bus with two modules: what all its pull-ups come to, ohm.

    Attributes:
        module_ohm: On each module; 0: none.
        bare_ohm: They and the Teensy's.
        external_ohm: R14 to R17; 0: left out.
        total_ohm: All together.
        max_ohm: The same at the worst of all tolerances.
        max_farad: The greatest capacitance of cable and parts.
        threshold: Of the supply, where the Teensy reads high for certain.
    """

    module_ohm: float
    bare_ohm: float
    external_ohm: float
    total_ohm: float
    max_ohm: float
    max_farad: float
    threshold: float

    def rise_s(self, farad: float) -> float:
        """Compute the longest rise from ground to the threshold, s."""
        return _rise_time_constants(self.threshold) * self.max_ohm * farad


def _rise_time_constants(threshold: float) -> float:
    return math.log(1 / (1 - threshold))


def min_bus_ohm(wiring: Wiring) -> float:
    """Compute the pull-up below which more current flows than the bus's parts sink (UM10204 7.1, equation 2)."""
    limit = wiring.limit
    supply_v = wiring.ranges["teensy_3v3"].high
    return (supply_v - limit["i2c_low_v"]) / limit["i2c_sink_a"]


def bus_pullups(wiring: Wiring) -> list[BusPullup]:
    """Choose for each module that is sold the greatest external resistor that is fast enough, or none."""
    return [_choose_pullup(wiring, module_ohm) for module_ohm in wiring.i2c["modules_ohm"]]


def _choose_pullup(wiring: Wiring, module_ohm: float) -> BusPullup:
    # From none to the smallest: the first that is fast enough loads the chips least.
    rows = [_bus_pullup(wiring, module_ohm, ohm) for ohm in (0, *wiring.i2c["external_ohm"])]
    fast = [row for row in rows if row.max_farad >= wiring.limit["i2c_cable_f"]]
    if not fast or fast[0].total_ohm < min_bus_ohm(wiring):
        raise WiringError(f"modules of {module_ohm:g} ohm: no R14 to R17 is fast enough and within 3 mA")
    return fast[0]


def _bus_pullup(wiring: Wiring, module_ohm: float, external_ohm: float) -> BusPullup:
    """Put two modules, the Teensy and an external resistor (0: none) beside each other."""

    def total(teensy_ohm: float, factor: float) -> float:
        fitted = [module_ohm, module_ohm, external_ohm]
        return parallel(teensy_ohm, *(ohm * factor for ohm in fitted if ohm))

    bare_ohm = (
        parallel(wiring.i2c["teensy_ohm"], *[module_ohm] * 2) if module_ohm else wiring.i2c["teensy_ohm"]
    )
    max_ohm = total(wiring.ranges["teensy_pullup"].high, 1 + wiring.tolerance["resistor"])
    threshold = wiring.i2c["threshold"]
    max_farad = wiring.limit["i2c_bit_rise_s"] / (_rise_time_constants(threshold) * max_ohm)
    total_ohm = total(wiring.i2c["teensy_ohm"], 1)
    return BusPullup(module_ohm, bare_ohm, external_ohm, total_ohm, max_ohm, max_farad, threshold)


def max_bus_ohm(wiring: Wiring) -> float:
    """Compute the nominal pull-up with which cable and parts of 150 pF are still fast enough, ohm."""
    rise_s = wiring.limit["i2c_bit_rise_s"]
    max_ohm = rise_s / (_rise_time_constants(wiring.i2c["threshold"]) * wiring.limit["i2c_cable_f"])
    return max_ohm / (1 + wiring.tolerance["resistor"])
