"""Campaign 1f: both switches open, then one closes again for a while, outside of what contacts are assumed to do."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import NamedTuple

from tests.fixtures.sequencer.cable import connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import SETTLE_US, Bench, arm
from tests.validation.sequencer_proof.contacts import Contact, open_switches, play
from tests.validation.sequencer_proof.signals import CYCLES_PER_MS, CYCLES_PER_US
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import RELEASE_BOUNCE_US, RELEASE_CHATTER_US, RELEASE_DEBOUNCE_US

CLOSED_US = ((100, RELEASE_BOUNCE_US - 100), (RELEASE_BOUNCE_US + 100, RELEASE_CHATTER_US - 6_000),
             (RELEASE_CHATTER_US + 1_000, 400_000))  # fmt: skip
"""Kinds of how long it is closed, at least and at most: as sound contacts bounce, as worn ones do, longer."""
MARGIN_US = 100
TOLERANCE_US = 2


class OneClosed(NamedTuple):
    """One release after which one switch closed again.

    Attributes:
        kind: Index of CLOSED_US.
        opened_us: From the release to the closing.
        closed_us: From there until it opened for good.
        late_us: The date less the release.
        earlier_us, later_us: The reported interval, from the date.
    """

    kind: int
    opened_us: float
    closed_us: float
    late_us: float
    earlier_us: int
    later_us: int

    @property
    def holds_truth(self) -> bool:
        return -self.later_us - TOLERANCE_US <= self.late_us <= self.earlier_us + TOLERANCE_US


def one_closed_again(bench: Bench, seed: int, count: int) -> list[OneClosed]:
    """Fly `count` releases, alternating between all kinds.

    Raises Broken where one is reported otherwise than docs/sequencer.md says.
    """
    board = bench.board()
    client = connect(board)
    rng = random.Random(seed)
    releases = []
    zero_us = None
    for number in range(-1, count):
        arm(board, client)
        start = board.now_cycle + CYCLES_PER_MS
        released = open_switches(board, [Contact(start, 0, False), Contact(start + CYCLES_PER_MS, 1, False)])
        kind, index = number % len(CLOSED_US), rng.randrange(2)
        opened_us = rng.randint(MARGIN_US, RELEASE_DEBOUNCE_US - MARGIN_US)
        closed_us = rng.randint(*CLOSED_US[kind])
        # The first is a plain release: it tells how the board's clock lies to the emulator's.
        if zero_us is not None:
            closes = released + opened_us * CYCLES_PER_US
            play(
                board,
                [Contact(closes, index, True), Contact(closes + closed_us * CYCLES_PER_US, index, False)],
            )
        board.run(RELEASE_CHATTER_US + SETTLE_US)
        report, status = client.run_report(), client.status()
        if status.state != SequencerState.RUNNING:
            raise Broken(
                f"closed again {opened_us} us after the release for {closed_us} us: {status.state.name}"
            )
        date_us = report.release_ms * 1000.0 + report.release_us - released / CYCLES_PER_US
        if zero_us is None:
            zero_us = date_us
        else:
            late_us = date_us - zero_us
            releases.append(
                OneClosed(kind, opened_us, closed_us, late_us, report.earlier_us, report.later_us)
            )
    board.close()
    for release in releases:
        _check_as_documented(release)
    return releases


def _check_as_documented(release: OneClosed) -> None:
    longest = len(CLOSED_US) - 1
    if release.kind < longest and not release.holds_truth:
        raise Broken(f"the release is outside of what is reported: {release}")
    reopened_us = release.opened_us + release.closed_us
    as_told = abs(release.late_us - reopened_us) <= TOLERANCE_US and not release.earlier_us + release.later_us
    if release.kind == longest and not as_told:
        raise Broken(f"not dated by the last opening: {release}")


def one_closed_rows(releases: Sequence[OneClosed]) -> list[tuple[object, ...]]:
    """Return, by how long the switch was closed, how late the dates are and whether an interval holds the release."""
    rows: list[tuple[object, ...]] = []
    for kind, (least_us, most_us) in enumerate(CLOSED_US):
        part = [release for release in releases if release.kind == kind]
        rows.append(
            (
                f"{least_us / 1000:g} to {most_us / 1000:g} ms",
                len(part),
                f"{max(release.late_us for release in part) / 1000:.1f}",
                sum(release.earlier_us + release.later_us > 0 for release in part),
                sum(not release.holds_truth for release in part),
            )
        )
    return rows
