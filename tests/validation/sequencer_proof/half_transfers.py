"""Campaign 1e: a host that begins control transfers and ends none, while contacts chatter for milliseconds."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import NamedTuple

from tests.fixtures.sequencer.cable import connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import SETTLE_US, Bench, arm
from tests.validation.sequencer_proof.contacts import (
    TOGETHER_US,
    Chatter,
    Contact,
    draw,
    in_order,
    open_switches,
)
from tests.validation.sequencer_proof.releases import WORST_ERROR_US
from tests.validation.sequencer_proof.signals import CYCLES_PER_MS, CYCLES_PER_US
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import SequencerState

EVERY_US = 2_000
CHATTER_US = 4_000
LATEST_SECOND_US = 3_000
"""In half of all releases the second switch opens so late at most, while the first still chatters."""
UNENDED_US = 20_000
"""The host has begun to leave its transfers when the robot leaves."""
HOSTS_US = (0, EVERY_US)
ONE_BEYOND_IN = 200
"""Where both switches open within 100 us: no more often may a date be off by more than is allowed."""


class Disturbed(NamedTuple):
    """One release with long fast chatter.

    Attributes:
        every_us: The host begins a control transfer this often and ends none; 0: it is a sound one.
        together: Both switches opened within 100 us.
        error_us: The date less the first edge at which both were open.
        earlier_us, later_us: The reported interval, from the date.
    """

    every_us: int
    together: bool
    error_us: float
    earlier_us: int
    later_us: int

    @property
    def holds_truth(self) -> bool:
        """Tell whether the interval, widened by what a date may be off, holds the release."""
        return -self.later_us - WORST_ERROR_US <= self.error_us <= self.earlier_us + WORST_ERROR_US

    @property
    def beyond(self) -> bool:
        return abs(self.error_us) > WORST_ERROR_US


def disturbed_releases(bench: Bench, every_us: int, seed: int, count: int) -> list[Disturbed]:
    """Fly `count` releases.

    Raises Broken where one is not seen, or what is reported of it does not hold the truth.
    """
    board = bench.board()
    client = connect(board)
    rng = random.Random(seed)
    arm(board, client)
    start = board.now_cycle + CYCLES_PER_MS
    # A first release without chatter tells how the board's clock lies to the emulator's.
    first = open_switches(board, [Contact(start, 0, False), Contact(start + CYCLES_PER_MS, 1, False)])
    board.run(SETTLE_US)
    zero_us = _read_date(client)[0] - first / CYCLES_PER_US
    releases = []
    for number in range(count):
        together = number % 2 == 0
        arm(board, client)
        board.usb_half_transfers(every_us)
        begins = board.now_cycle + (UNENDED_US + rng.randint(0, 5_000)) * CYCLES_PER_US + rng.randrange(16)
        released = open_switches(board, _draw_chatter(rng, begins, board.resolution, together))
        board.run(SETTLE_US)
        board.usb_half_transfers(0)
        # The next SETUP ends the transfer that was left.
        board.run(SETTLE_US)
        date_us, earlier_us, later_us = _read_date(client)
        error_us = date_us - zero_us - released / CYCLES_PER_US
        releases.append(Disturbed(every_us, together, error_us, earlier_us, later_us))
    board.close()
    return releases


def _draw_chatter(rng: random.Random, begins: int, resolution: int, together: bool) -> list[Contact]:
    first = rng.randrange(2)
    latest_us = TOGETHER_US if together else LATEST_SECOND_US
    starts = {first: begins, 1 - first: begins + draw(rng, 0, latest_us, resolution)}
    contacts = []
    for index, cycle in starts.items():
        ends = cycle + CHATTER_US * CYCLES_PER_US
        closed = False
        while cycle < ends or closed:
            contacts.append(Contact(cycle, index, closed))
            cycle += draw(rng, *Chatter.FAST.value[0], resolution)
            closed = not closed
        contacts.append(Contact(cycle, index, False))
    return in_order(contacts)


def _read_date(client: SequencerClient) -> tuple[float, int, int]:
    report, status = client.run_report(), client.status()
    if status.state != SequencerState.RUNNING:
        raise Broken(f"after a release: {status.state.name}")
    return report.release_ms * 1000.0 + report.release_us, report.earlier_us, report.later_us


def judge_disturbed(releases: Sequence[Disturbed]) -> None:
    """Raises Broken where what is reported misses the truth, or dates are off more often than they may be."""
    for release in releases:
        if not release.holds_truth:
            raise Broken(f"the truth is outside of what is reported: {release}")
    for every_us in HOSTS_US:
        together = _part(releases, every_us, together=True)
        beyond = sum(release.beyond for release in together)
        if beyond > len(together) / ONE_BEYOND_IN:
            raise Broken(f"{beyond} of {len(together)} dates are off by more than {WORST_ERROR_US} us")


def _part(releases: Sequence[Disturbed], every_us: int, *, together: bool) -> list[Disturbed]:
    return [release for release in releases if (release.every_us, release.together) == (every_us, together)]


def disturbed_rows(releases: Sequence[Disturbed]) -> list[tuple[object, ...]]:
    """Return releases by host and by how the switches opened: dates off by how much, and intervals."""
    rows: list[tuple[object, ...]] = []
    for every_us in HOSTS_US:
        for together in (True, False):
            part = _part(releases, every_us, together=together)
            rows.append(
                (
                    f"begins one each {every_us // 1000} ms, ends none" if every_us else "sound",
                    f"{TOGETHER_US / 1000} ms" if together else f"{LATEST_SECOND_US // 1000} ms",
                    len(part),
                    sum(not release.beyond for release in part),
                    sum(release.beyond for release in part),
                    f"{max(abs(release.error_us) for release in part) / 1000:.3f}",
                    sum(release.earlier_us + release.later_us > 0 for release in part),
                    sum(not release.holds_truth for release in part),
                )
            )
    return rows
