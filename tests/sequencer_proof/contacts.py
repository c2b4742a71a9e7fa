"""How release switches open: seeded chatter, in cycles."""

from __future__ import annotations

import random
from dataclasses import dataclass

from tests.sequencer_proof.rigs import Rig
from tests.sequencer_proof.signals import CYCLES_PER_US

LATEST_SECOND_US = 8_000
"""The second switch opens this long after the first, at most."""
MOST_BOUNCES = 10
SHORTEST_US, LONGEST_US = 20, 500
"""Of each closing and each opening between; ten of both make 10 ms."""


@dataclass(frozen=True, slots=True)
class Contact:
    """A switch changes."""

    cycle: int
    index: int
    closed: bool


def opening(rng: random.Random, start: int, resolution: int) -> list[Contact]:
    """Both switches open with chatter, either one first, from `start` on; in order of time."""
    first = rng.randrange(2)
    contacts = []
    for index in (first, 1 - first):
        cycle = start if index == first else start + _draw(rng, 1, LATEST_SECOND_US, resolution)
        contacts.append(Contact(cycle, index, closed=False))
        for _ in range(rng.randint(0, MOST_BOUNCES)):
            cycle += _draw(rng, SHORTEST_US, LONGEST_US, resolution)
            contacts.append(Contact(cycle, index, closed=True))
            cycle += _draw(rng, SHORTEST_US, LONGEST_US, resolution)
            contacts.append(Contact(cycle, index, closed=False))
    return sorted(contacts, key=lambda contact: contact.cycle)


def open_switches(rig: Rig, contacts: list[Contact]) -> int:
    """Plays them; returns the release: the first edge at which both were open, by the rule's words."""
    closed = [True, True]
    released: int | None = None
    for contact in contacts:
        rig.run_to(contact.cycle)
        rig.set_switch(contact.index, closed=contact.closed)
        closed[contact.index] = contact.closed
        if released is None and not any(closed):
            released = contact.cycle
    if released is None:
        raise ValueError("these contacts never open both switches")
    return released


def _draw(rng: random.Random, least_us: int, most_us: int, resolution: int) -> int:
    steps = CYCLES_PER_US // resolution
    return rng.randint(least_us * steps, most_us * steps) * resolution
