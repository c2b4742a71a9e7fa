"""Contact trains whose mechanical release is known."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest

from tests.sequencer_proof.contacts import TOGETHER_US, Chatter
from tests.sequencer_proof.mechanical import Fall, Jolt, fall
from tests.sequencer_proof.signals import CYCLES_PER_US

RELEASED = 1_000_000 * CYCLES_PER_US


def made(seed: int, *jolts: Jolt) -> Fall:
    return fall(random.Random(seed), RELEASED, 1, Chatter.FAST, jolts=jolts)


@pytest.mark.parametrize("seed", range(20))
def test_contacts_alternate_and_end_open_after_the_release(seed: int) -> None:
    found = made(
        seed, Jolt(before_us=50_000, open_us=6_000), Jolt(before_us=9_000, open_us=100, switches=(1,))
    )
    for index in (0, 1):
        states = [contact.closed for contact in found.contacts if contact.index == index]
        assert states[0] is False and states[-1] is False
        assert all(before != after for before, after in pairwise(states))
    after = [contact for contact in found.contacts if contact.cycle >= found.released]
    begins = [next(contact.cycle for contact in after if contact.index == index) for index in (0, 1)]
    assert min(begins) == found.released
    assert max(begins) <= found.released + TOGETHER_US * CYCLES_PER_US
    before = [contact for contact in found.contacts if contact.cycle < found.released]
    assert {contact.index: contact.closed for contact in before} == {0: True, 1: True}


def test_a_jolt_into_the_release_is_an_error() -> None:
    with pytest.raises(ValueError, match="a jolt is not over"):
        made(1, Jolt(before_us=100, open_us=200))
