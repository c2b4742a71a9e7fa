"""Short form of the campaign with held pins, and defects that it must find."""

from __future__ import annotations

import pytest

from tests.emulator_avr.avr_board import PinHold
from tests.emulator_avr.building import Edit
from tests.sequencer_proof.conftest import Plant
from tests.sequencer_proof.held_pins import LEVELS, SUBSETS, held_pins
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import Broken


@pytest.mark.parametrize("level", LEVELS)
def test_a_servo_is_told_after_a_reset_what_its_pin_had(bench: Bench, level: PinHold) -> None:
    found = [held_pins(bench, joints, level, count=2, seed=9) for joints in SUBSETS]
    assert sum(one.missed for one in found) > 0
    assert sum(one.on_time for one in found) > 0


@pytest.mark.prove
def test_a_board_that_books_without_looking_is_found(plant: Plant) -> None:
    looks = "if ((PINB & pin) == 0 && (whole & pin) != 0) c.train.was_whole(c.pulse);"
    bold = plant(Edit("src/drivers/timer1_servos.cpp", looks, "c.train.was_whole(c.pulse);"))
    with pytest.raises(Broken):
        held_pins(bold, (1, 2), PinHold.LOW, count=10, seed=9)
