"""Contacts of a robot whose mechanical release is known, with jolts before it.

The pins' first meeting is what the board can see; when the robot left is another matter. What is assumed here, since
the sheets of the switches tell nothing of bounce at opening:

- At the release the plungers of both switches move away for good. Each contact first opens then, or up to `apart_us`
  later, and chatters from its first opening on: closings and openings in turn, of one of the kinds of `Chatter`.
- A jolt on the crane opens one switch or both for a while; they chatter likewise when they open and when they close.
- After the release nothing presses a plunger again: contacts end open, and a jolt has ended before the release begins.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

from tests.sequencer_proof.contacts import TOGETHER_US, Chatter, Contact, bounce, draw, in_order
from tests.sequencer_proof.signals import CYCLES_PER_US


@dataclass(frozen=True, slots=True)
class Jolt:
    """One or both switches open for a while, and close again. Before the release, microseconds."""

    before_us: int
    """From the switches' opening to the release."""
    open_us: int
    switches: tuple[int, ...] = (0, 1)


@dataclass(frozen=True, slots=True)
class Fall:
    """The contacts in order of time, and when the robot left: the truth that a date is held against, cycle."""

    contacts: list[Contact]
    released: int


def fall(
    rng: random.Random,
    released: int,
    resolution: int,
    chatter: Chatter,
    *,
    jolts: Sequence[Jolt] = (),
    apart_us: int = TOGETHER_US,
) -> Fall:
    """A robot that leaves at cycle `released`; inputs change at multiples of `resolution` cycles.

    Raises:
        ValueError: a jolt's contacts still move when those of the next jolt, or of the release, begin to.
    """
    contacts: list[Contact] = []
    for jolt in sorted(jolts, key=lambda one: -one.before_us):
        begins = released - jolt.before_us * CYCLES_PER_US
        _check_over(contacts, begins)
        ends = begins + jolt.open_us * CYCLES_PER_US
        for index in jolt.switches:
            opened = bounce(rng, Contact(begins, index, False), resolution, chatter)
            closes = max(ends, opened[-1].cycle + CYCLES_PER_US)
            contacts += [*opened, *bounce(rng, Contact(closes, index, True), resolution, chatter)]
    _check_over(contacts, released)
    first = rng.randrange(2)
    second = released + draw(rng, 0, apart_us, resolution)
    for index, cycle in ((first, released), (1 - first, second)):
        contacts += bounce(rng, Contact(cycle, index, False), resolution, chatter)
    return Fall(in_order(contacts), released)


def _check_over(contacts: Sequence[Contact], cycle: int) -> None:
    if any(contact.cycle >= cycle for contact in contacts):
        raise ValueError(f"a jolt is not over at cycle {cycle}")
