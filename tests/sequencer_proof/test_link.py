"""Short forms of the link campaigns, and defects that they must find."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest

from tests.emulator_avr.avr_board import EEPROM_BYTES
from tests.emulator_avr.building import Edit
from tests.sequencer_proof.conftest import Plant
from tests.sequencer_proof.link_abuse import LAST_BEGIN_US, Abuse, abuse_link, begins_us
from tests.sequencer_proof.noise import STATES, Noise, make_noise
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import Broken
from tfsat_host.devices.client import BoardRefusal
from tfsat_host.protocol.enums import ErrorCode


@pytest.mark.parametrize("abuse", Abuse)
def test_no_abuse_moves_a_stroke(bench: Bench, abuse: Abuse) -> None:
    begins = [0, LAST_BEGIN_US, *random.Random(1).sample(begins_us(), 5)]
    found = abuse_link(bench, abuse, begins, seed=1)
    assert (found.runs, found.moved) == (7, 0)


@pytest.mark.parametrize(("noise", "amount"), [(Noise.BYTES, 12_000), (Noise.FRAMES, 1_500)])
def test_noise_moves_nothing_and_stores_nothing(bench: Bench, noise: Noise, amount: int) -> None:
    found = make_noise(bench, noise, amount, drops=2, seed=3)
    assert [found.sent[state] for state in STATES] == [amount // 3] * 3
    if noise is Noise.BYTES:
        assert found.rejected > 20
    else:
        assert found.refusals > amount // 2 < found.answers
        assert found.arms_refused[ErrorCode.STALE_TOKEN] > 10


@pytest.mark.prove
@pytest.mark.parametrize("abuse", [Abuse.GARBAGE, Abuse.SILENT])
def test_a_link_that_holds_off_interrupts_is_found(plant: Plant, abuse: Abuse) -> None:
    slow = plant(
        Edit(
            "arduino_sequencer.ino",
            "  host_link.poll();\n",
            "  noInterrupts();\n  host_link.poll();\n  if (Serial.available() > 8) "
            "for (uint8_t i = 0; i < 3; ++i) delayMicroseconds(16000);\n  interrupts();\n",
        )
    )
    with pytest.raises(Broken):
        abuse_link(slow, abuse, [300_000, 307_000, 313_000], seed=1)


@pytest.mark.prove
def test_an_arm_with_any_token_is_found(plant: Plant) -> None:
    trusting = plant(
        Edit("src/core/sequencer.cpp", "if (token != retained_.token) return", "if (token == 0xFFFF) return")
    )
    with pytest.raises(Broken, match="ARMED after noise in SAFE"):
        make_noise(trusting, Noise.FRAMES, 600, drops=1, seed=3)


@pytest.mark.prove
def test_noise_at_a_board_that_cannot_be_armed_proves_nothing(bench: Bench) -> None:
    new = replace(bench, eeprom=b"\xff" * EEPROM_BYTES)
    with pytest.raises(BoardRefusal, match="maneuver"):
        make_noise(new, Noise.FRAMES, 600, drops=1, seed=3)


@pytest.mark.prove
def test_settings_that_are_stored_unchecked_are_found(plant: Plant) -> None:
    header = "int8_t Settings::find_defect() const {\n"
    trusting = plant(Edit("src/core/settings.cpp", header, header + "  if (frame_us > 0) return -1;\n"))
    with pytest.raises(Broken, match="in SAFE changed the EEPROM"):
        make_noise(trusting, Noise.FRAMES, 600, drops=1, seed=3)
