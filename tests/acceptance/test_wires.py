"""The pins that findings name are those of both firmwares."""

from __future__ import annotations

from tests.docs.wiring.firmware_pins import logger_pins, sequencer_pins
from tfsat_host.acceptance import wires


def test_pins_are_those_of_the_firmware() -> None:
    micro, teensy = sequencer_pins(), logger_pins()
    for joint, pin in enumerate(wires.SERVO_PINS, 1):
        assert micro[str(pin)] == f"servo, joint {joint}"
    for number, (at_micro, at_teensy) in enumerate(zip(*wires.SWITCH_PINS.values(), strict=True), 1):
        assert micro[str(at_micro)] == teensy[str(at_teensy)] == f"release switch {number}"
    pin_out, pin_in = wires.STROKE_LINE_PINS
    assert (micro[str(pin_out)], teensy[str(pin_in)]) == ("stroke line, out", "stroke line, in")
    for name, angle_pin in zip(wires.ANGLE_SENSORS, wires.ANGLE_PINS, strict=True):
        assert teensy[str(angle_pin)] == f"angle sensor {name}"
    for pins, imus in zip(wires.BUS_PINS, ("1 and 2", "3 and 4"), strict=True):
        for wire in pins.split(", "):
            bus_pin, signal = wire.removesuffix(")").split(" (")
            assert teensy[bus_pin] == f"{signal}, IMU {imus}"
