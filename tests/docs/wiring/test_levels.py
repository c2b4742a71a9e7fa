"""The calculations of the wiring, against the same circuits solved step by step."""

from __future__ import annotations

import itertools
import math

import pytest

from tests.docs.wiring.wirings import load_committed
from wiring_generator.levels import (
    Levels,
    avr_high_v,
    avr_low_v,
    bus_pullups,
    closed_v,
    closing_s,
    extremes,
    min_bus_ohm,
    opening_s,
    parallel,
)

LEVELS = Levels(load_committed())
# Far below the time constant of 2.7 kΩ and 4.7 nF, 13 us.
STEP_S = 20e-9


def _node_v(pin_v: float, supply_v: float, pullup_ohm: float, series_ohm: float, closed: bool) -> float:
    """Return the voltage of the node where switch, pull-up, R3 and the Teensy's diode meet.

    The Teensy pulls at the node through 22 kΩ.
    """
    # The contact is to ground.
    if closed:
        return 0.0
    node_v = (supply_v / pullup_ohm + pin_v / series_ohm) * parallel(pullup_ohm, series_ohm)
    # Below, the Schottky diode conducts and the Teensy's pull-up raises the node, too.
    if node_v < 3.3 - 0.25:
        top_v, ohm = 3.3 - 0.25, 22e3
        node_v = (supply_v / pullup_ohm + pin_v / series_ohm + top_v / ohm) * parallel(
            pullup_ohm, series_ohm, ohm
        )
    return node_v


def _crossing_s(
    start_v: float,
    threshold_v: float,
    closed: bool,
    supply_v: float,
    own_ohm: float,
    pullup_ohm: float,
    series_ohm: float,
    farad: float,
) -> float:
    """Integrate the capacitor's voltage step by step and return the time at which it passes the threshold."""
    pin_v, steps = start_v, 0
    while (pin_v > threshold_v) == (start_v > threshold_v):
        node_v = _node_v(pin_v, supply_v, pullup_ohm, series_ohm, closed)
        pin_v += STEP_S / farad * ((node_v - pin_v) / series_ohm + (supply_v - pin_v) / own_ohm)
        steps += 1
    return steps * STEP_S


# Supply and pull-up at both ends; R1, R3 and C1 at their nominal values.
CORNERS = list(
    itertools.product(*LEVELS.spans("micro_5v", "avr_pullup"), *([span] for span in (2200.0, 2700.0, 4.7e-9)))
)


@pytest.mark.parametrize(("supply_v", "own_ohm", "pullup_ohm", "series_ohm", "farad"), CORNERS)
def test_edges_are_those_of_the_circuit_with_the_teensy_at_it(
    supply_v: float, own_ohm: float, pullup_ohm: float, series_ohm: float, farad: float
) -> None:
    circuit = supply_v, own_ohm, pullup_ohm, series_ohm, farad
    rest_v = closed_v(supply_v, own_ohm, series_ohm)
    opening, closing = LEVELS.edge_delays_s()
    for threshold_v in (avr_low_v(supply_v), avr_high_v(supply_v)):
        opened_s = _crossing_s(rest_v, threshold_v, False, *circuit)
        # 5 %: the formula leaves out the Teensy, which the steps have.
        assert opened_s == pytest.approx(opening_s(*circuit, threshold_v), rel=0.05, abs=2 * STEP_S)
        assert opening[0] <= opened_s <= opening[1]
        closed_s = _crossing_s(supply_v, threshold_v, True, *circuit)
        assert closed_s == pytest.approx(
            closing_s(supply_v, own_ohm, series_ohm, farad, threshold_v), rel=0.01, abs=2 * STEP_S
        )
        assert closing[0] <= closed_s <= closing[1]


def test_extremes_are_at_the_corners() -> None:
    assert extremes(lambda a, b: a - b, (1.0, 2.0), (10.0, 30.0)) == (-29.0, -8.0)


def test_every_limit_holds_and_names_its_source() -> None:
    wiring = load_committed()
    checks = LEVELS.checks()
    assert len(checks) == 15 and all(check.holds for check in checks)
    assert {check.source for check in checks} <= set(wiring.sources)


def test_two_modules_beside_another_2_2_kilohm_are_too_much_and_the_table_never_asks_for_that() -> None:
    # The bus must reach 0.4 V with the 3 mA that a chip sinks.
    assert parallel(2200, 2200, 2200) < min_bus_ohm(load_committed())
    rows = bus_pullups(load_committed())
    assert [(row.module_ohm, row.external_ohm) for row in rows] == [
        (0, 1200),
        (10000, 1500),
        (4700, 2200),
        (2200, 0),
    ]
    for row in rows:
        assert row.total_ohm >= min_bus_ohm(load_committed())
        # From 0.3 to 0.7 of the supply: ln(7/3) time constants, 300 ns in fast mode (UM10204 7.1).
        assert math.log(7 / 3) * row.max_ohm * row.max_farad <= 300e-9
