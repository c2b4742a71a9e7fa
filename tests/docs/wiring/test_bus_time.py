"""The I2C buses that docs/wiring.md permits carry a burst within the logger's deadline."""

from __future__ import annotations

import math
import re

from tests.docs.wiring.firmware_pins import source
from tests.docs.wiring.wirings import load_committed
from wiring_generator.levels import burst_deadline_us, bus_pullups, parallel

# LPI2C master at 400 kHz (WireIMXRT.cpp): 60 cycles of 24 MHz, and those that the clock line takes to rise.
CYCLE_S = 1 / 24e6
BIT_CYCLES = 60
BURST_BITS = 156
THRESHOLD = 0.7
TOLERANCE = 1.05
TEENSY_MAX_OHM = 28.6e3


def constant(name: str) -> int:
    match = re.search(rf"constexpr uint32_t {name} = (\d+);", source("teensy_logger/src/core/timing.h"))
    assert match, name
    return int(match[1])


def deadline_us() -> int:
    """Compute the deadline of a 14-byte burst at 400 kHz as core/timing.h does."""
    bit_ns = constant("kI2cRiseNs") + constant("kI2cMarginNs")
    return 390 + constant("kI2cIdleUs") + -(-BURST_BITS * bit_ns // 1000)


def test_page_and_logger_have_one_calculation() -> None:
    limit = load_committed().limit
    assert constant("kI2cRiseNs") == round(limit["i2c_bit_rise_s"] * 1e9)
    assert constant("kI2cMarginNs") == round(limit["i2c_margin_s"] * 1e9)
    assert deadline_us() == burst_deadline_us(load_committed())


def test_a_burst_on_every_permitted_bus_ends_before_its_deadline() -> None:
    wiring = load_committed()
    for row in bus_pullups(wiring):
        pullups = [row.external_ohm * TOLERANCE] * (row.external_ohm > 0)
        pullups += [row.module_ohm * TOLERANCE] * 2 * (row.module_ohm > 0)
        ohm = parallel(TEENSY_MAX_OHM, *pullups)
        rise_s = ohm * row.max_farad * math.log(1 / (1 - THRESHOLD))
        burst_s = BURST_BITS * (BIT_CYCLES + math.ceil(rise_s / CYCLE_S)) * CYCLE_S
        # The master waits 8 us for an idle bus before.
        assert (burst_s + 8e-6) * 1e6 <= deadline_us(), row
