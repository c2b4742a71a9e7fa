"""How release switches open and close: seeded chatter, in cycles."""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum

from tests.fixtures.sequencer.board import Board
from tests.validation.sequencer_proof.signals import CYCLES_PER_US

LATEST_SECOND_US = 8_000
"""The second switch opens this long after the first, at most."""
TOGETHER_US = 100
"""In half of all openings and closings, both move within this: a magnet lets go of both sides at once."""
MAX_BOUNCES = 10
UNDECIDED_CYCLES = CYCLES_PER_US
"""Two ticks. Of two edges within it, which was first is beyond the board's clock."""
SWUNG_US = 20_000
"""The robot hangs free so long before it is hung up."""


class Chatter(Enum):
    """How long each closing and each opening between lasts, at least and at most, us: of one kind or the other."""

    SLOW = ((20, 500),)
    """Ten of both make 10 ms."""
    FAST = ((2, 15),)
    """About as long as an interrupt takes, or shorter: no program follows each of these."""
    BOTH = (*SLOW, *FAST)


@dataclass(frozen=True, slots=True)
class Contact:
    """A switch changes."""

    cycle: int
    index: int
    closed: bool


def draw_opening(rng: random.Random, start: int, resolution: int, chatter: Chatter) -> list[Contact]:
    """Draw the chattering contacts of both switches as they open from `start` on.

    Either switch may be first; the contacts are in order of time.
    """
    return _both(rng, start, resolution, chatter, closed=False)


def open_switches(board: Board, contacts: list[Contact]) -> int:
    """Plays them; returns the release: the first edge at which both were open, by the rule's words."""
    play(board, contacts)
    closed = [True, True]
    for contact in contacts:
        closed[contact.index] = contact.closed
        if not any(closed):
            return contact.cycle
    raise ValueError("these contacts never open both switches")


def admissible(contacts: Sequence[Contact]) -> list[int]:
    """Cycles at which the rule may see both switches open for the first time; the last of them is not in doubt."""
    dates: list[int] = []
    closed = [True, True]
    closed_at: list[int | None] = [None, None]
    for number, contact in enumerate(contacts):
        other = 1 - contact.index
        closed[contact.index] = contact.closed
        if contact.closed:
            closed_at[contact.index] = contact.cycle
        elif not closed[other]:
            dates.append(contact.cycle)
            # A change within two ticks leaves this date in doubt; without one it is the last.
            following = contacts[number + 1 : number + 2]
            if not following or following[0].cycle - contact.cycle > UNDECIDED_CYCLES:
                return dates
        elif (moment := closed_at[other]) is not None and contact.cycle - moment <= UNDECIDED_CYCLES:
            # The other switch closed just before: the board may take either edge for the first.
            dates.append(contact.cycle)
    raise ValueError("these contacts never open both switches")


def hang_up(board: Board, rng: random.Random, chatter: Chatter) -> None:
    """Takes the robot off, if it was on, and hangs it up: both switches close with chatter."""
    for index in (0, 1):
        board.switch(index, closed=False)
    # Free for 20 ms before, so that the board sees an opening, not one long bounce.
    start = board.now_cycle + SWUNG_US * CYCLES_PER_US
    play(board, _both(rng, start, board.resolution, chatter, closed=True))


def play(board: Board, contacts: list[Contact]) -> None:
    """Lets them happen. Raises ValueError where one is past."""
    for contact in contacts:
        board.run_to_cycle(contact.cycle)
        board.switch(contact.index, closed=contact.closed)


def bounce(rng: random.Random, first: Contact, resolution: int, chatter: Chatter) -> list[Contact]:
    """Draw a contact change followed by its bounces, in order of time."""
    contacts = [first]
    for _ in range(rng.randint(0, MAX_BOUNCES)):
        # A kind of chatter is drawn for each bounce: both may occur in one opening.
        least_us, most_us = rng.choice(chatter.value)
        for closed in (not first.closed, first.closed):
            cycle = contacts[-1].cycle + draw(rng, least_us, most_us, resolution)
            contacts.append(Contact(cycle, first.index, closed))
    return contacts


def draw(rng: random.Random, least_us: int, most_us: int, resolution: int) -> int:
    """Some cycles, of those at which inputs can change."""
    # Inputs change at multiples of the board's resolution, not at any cycle.
    steps = CYCLES_PER_US // resolution
    return rng.randint(least_us * steps, most_us * steps) * resolution


def in_order(contacts: Iterable[Contact]) -> list[Contact]:
    """Sort the contacts by time."""
    return sorted(contacts, key=lambda contact: contact.cycle)


def _both(
    rng: random.Random, start: int, resolution: int, chatter: Chatter, *, closed: bool
) -> list[Contact]:
    first = rng.randrange(2)
    # In half of all openings both switches move within 100 us: a magnet lets go of both sides.
    latest_us = rng.choice((TOGETHER_US, LATEST_SECOND_US))
    begins = {first: start, 1 - first: start + draw(rng, 0, latest_us, resolution)}
    return in_order(
        contact
        for index, cycle in begins.items()
        for contact in bounce(rng, Contact(cycle, index, closed), resolution, chatter)
    )


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
    """Draw the contacts of a robot that leaves at cycle `released`.

    Inputs change at multiples of `resolution` cycles.

    Raises:
        ValueError: a jolt's contacts still move when those of the next jolt, or of the release, begin to.
    """
    contacts: list[Contact] = []
    # In the order of their times: the first jolt lies longest before the release.
    for jolt in sorted(jolts, key=lambda jolt: -jolt.before_us):
        begins = released - jolt.before_us * CYCLES_PER_US
        _check_over(contacts, begins)
        ends = begins + jolt.open_us * CYCLES_PER_US
        for index in jolt.switches:
            # Each jolt opens and closes with its own bounces.
            opened = bounce(rng, Contact(begins, index, False), resolution, chatter)
            closes = max(ends, opened[-1].cycle + CYCLES_PER_US)
            contacts += [*opened, *bounce(rng, Contact(closes, index, True), resolution, chatter)]
    # All contacts must be over when the release begins, or the truth would be ambiguous.
    _check_over(contacts, released)
    first = rng.randrange(2)
    second = released + draw(rng, 0, apart_us, resolution)
    for index, cycle in ((first, released), (1 - first, second)):
        contacts += bounce(rng, Contact(cycle, index, False), resolution, chatter)
    return Fall(in_order(contacts), released)


def _check_over(contacts: Sequence[Contact], cycle: int) -> None:
    if any(contact.cycle >= cycle for contact in contacts):
        raise ValueError(f"a jolt is not over at cycle {cycle}")
