"""How long interrupts are off: the figures computed from the image bound what the emulator measures."""

from __future__ import annotations

import random

import pytest

from tests.emulator_avr.building import Edit
from tests.sequencer_proof.blocking import FOLLOWING_US, UnboundedError, blocked_paths
from tests.sequencer_proof.conftest import Plant
from tests.sequencer_proof.contacts import Chatter
from tests.sequencer_proof.releases import Plan, fly
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import CYCLES_PER_US

LONGEST_BEFORE_RELEASE_US = 78
"""Arming, which holds a servo's line; while armed, a servo's edge and the switches' interrupt are next."""
LONGEST_US = 188
SERVO_EDGES = [4 * vector for vector in (17, 18, 19)]
SWITCHES = [4 * vector for vector in (16, 31)]


def test_no_path_holds_interrupts_off_for_longer_than_is_told(bench: Bench) -> None:
    elf = bench.image.with_suffix(".elf")
    before = blocked_paths(elf, scheduled=False)
    assert before[0].cycles <= LONGEST_BEFORE_RELEASE_US * CYCLES_PER_US
    assert blocked_paths(elf)[0].cycles <= LONGEST_US * CYCLES_PER_US
    assert {path.address for path in before} >= {*SERVO_EDGES, *SWITCHES}


def test_what_is_computed_bounds_what_is_measured(bench: Bench) -> None:
    rig = bench.rig()
    client = rig.connect()
    rig.board.watch_blocking()
    rng = random.Random(1)
    plan = Plan.on(client)
    for chatter in (Chatter.FAST, Chatter.SLOW):
        fly(rig, client, plan, rng, chatter)
    measured = rig.board.blocked()
    rig.close()
    computed = {path.address: path.cycles for path in blocked_paths(bench.image.with_suffix(".elf"))}
    assert set(measured) <= set(computed)
    for address, cycles in measured.items():
        following = FOLLOWING_US * CYCLES_PER_US if address in SWITCHES else 0
        assert cycles <= computed[address] + following, hex(address)
    assert len(measured) > 15
    assert min(measured[address] for address in SERVO_EDGES) > computed[SERVO_EDGES[0]] // 4


@pytest.mark.prove
def test_a_path_that_grew_is_found(plant: Plant) -> None:
    slow = plant(
        Edit(
            "src/drivers/tick_clock.h",
            "static void on_overflow() { ",
            "static void on_overflow() { __builtin_avr_delay_cycles(2000); ",
        )
    )
    with pytest.raises((AssertionError, UnboundedError)):
        test_no_path_holds_interrupts_off_for_longer_than_is_told(slow)
