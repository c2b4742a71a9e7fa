"""Contradictions inside a recording: each makes it doubtful, whatever else is there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from tfsat_host.arrays import BoolArray, IntArray
from tfsat_host.protocol.imus import IMU_PARTS
from tfsat_host.protocol.messages import LogHeader

from .block_decoder import Footers
from .events import DropEvent, Exchange
from .ledger import Gap, Ledger
from .release import Release
from .release_rule import recorded_releases

_ROWS_AT_A_TIME = 1 << 15
# As the footer's late_ticks: half-way between a nominal period and the two of one missed tick.
_MISSED_FROM_PERIODS = 1.5


def steps_of_time(t_us: IntArray, index: IntArray, rate_hz: float) -> tuple[int, IntArray]:
    """Find the steps that are no step forward, and those that are too long; no column of them is ever held.

    Args:
        t_us: (n,) sample times.
        index: (n,) sample numbers.
        rate_hz: The sampling rate that was commanded.

    Returns:
        How often time stands still or goes back; (m,) rows of samples that came more than one and a half periods
        after the one before although none was lost between: the sampling timer's ticks passed without a sample.
    """
    longest_us = _MISSED_FROM_PERIODS * 1e6 / rate_hz
    not_advancing = 0
    late = [np.empty(0, np.int64)]
    for begin in range(0, len(t_us) - 1, _ROWS_AT_A_TIME):
        # Chunks overlap by a row, so that the step across their border is seen too.
        step_us = np.diff(t_us[begin : begin + _ROWS_AT_A_TIME + 1])
        not_advancing += int(np.count_nonzero(step_us <= 0))
        rows = np.flatnonzero(step_us > longest_us) + begin + 1
        # A long step counts only between consecutive sample numbers: a gap explains its own.
        if len(rows):
            late.append(rows[index[rows] == index[rows - 1] + 1])
    return not_advancing, np.concatenate(late)


def block_doubts(
    header_copies: int, conflicting: int, not_advancing: int, ledger: Ledger, footers: Footers
) -> Iterator[str]:
    """Yield a sentence for each contradiction between blocks.

    `header_copies` differ from the header that is used; `conflicting` blocks have the number of another;
    `not_advancing` are samples at which time stands still or goes back.
    """
    if header_copies:
        yield f"{header_copies} copies of the header disagree with the one that was used"
    if conflicting:
        yield f"{conflicting} blocks carry the number of another, different block"
    if not_advancing:
        yield f"time does not advance at {not_advancing} samples"
    if ledger.overlaps:
        yield f"{ledger.overlaps} blocks repeat sample numbers of the block before"
    if ledger.drops_taken_back:
        yield "the count of dropped samples goes down"
    if footers.not_understood:
        yield f"{footers.not_understood} ends of the recording hold impossible values and are not used"
    # A missing footer is no contradiction: power was cut or the copy is partial, a truncation.
    if footers.last is None:
        return
    if footers.differ:
        yield "the recording has several different ends"
    footer, number = footers.last, footers.last_number
    if number != ledger.last_number:
        yield "blocks follow the end of the recording"
    if footer.blocks != number + 1:
        yield f"the end of the recording counts {footer.blocks} blocks and is number {number}"
    # A footer that counts more samples shows a gap at the end; one that counts fewer cannot be.
    if footer.samples < ledger.samples_end:
        yield f"the end of the recording counts {footer.samples} samples; there are {ledger.samples_end}"
    if footer.samples_dropped < ledger.samples_dropped:
        yield "the end of the recording counts fewer dropped samples than a block before it"


def exchange_doubts(header: LogHeader, exchanges: Iterable[Exchange]) -> Iterator[str]:
    """Yield a sentence for each IMU that came back as another part: what, what it means, and what to do."""
    for exchange in exchanges:
        yield (
            f"IMU {exchange.index + 1} came back as another part at {exchange.back_us / 1e6:.6f} s of "
            "the logger's clock: "
            f"{_name(exchange.who_am_i)}, and the header has {_name(header.who_am_i[exchange.index])}. "
            "Its readings from the "
            "fault on are taken for invalid, for neither the header's scales nor the calibration are that part's. "
            "Calibrate with the part that is to stay, and record again"
        )


def _name(who_am_i: int) -> str:
    part = IMU_PARTS.get(who_am_i)
    return f"{'an unknown part' if part is None else part.name} (WHO_AM_I 0x{who_am_i:02x})"


def two_releases(release: Release | None) -> str | None:
    """Return a sentence if the switches' edges fit two releases: nothing is lost, but t = 0 is uncertain."""
    if release is None or release.left_us[0] == release.left_us[1]:
        return None
    # The interval on both sides of t = 0 that holds either release.
    before_ms = (release.t_us - release.left_us[0]) / 1e3
    after_ms = (release.left_us[1] - release.t_us) / 1e3
    return (
        "The release switches' edges fit two releases (a blow and then the release, or worn contacts): the robot left "
        f"between {before_ms:.3f} ms before t = 0 and {after_ms:.3f} ms after it."
    )


def release_doubts(
    release: Release | None, events: Sequence[DropEvent], gaps: Sequence[Gap], switch_open: BoolArray
) -> Iterator[str]:
    """Yield a sentence if the release is not certain to the microsecond, or missing where one must be."""
    if release is None:
        # Without a release times count from the first sample: doubt that where there must have been one.
        recorded, _ = recorded_releases(events)
        if recorded:
            yield (
                f"the logger recorded a release at {recorded[-1] / 1e6:.6f} s of its clock that its switch edges "
                "do not show, or not where it can be the drop's: times count from the first sample"
            )
        elif gaps and any(event.name == "stroke" for event in events):
            yield "strokes were recorded and no release: times count from the first sample"
        elif gaps and gaps[0].start_us is None and switch_open[:1].all():
            yield "the start is lost and both switches are open after it: the release may lie in it"
        return
    if release.contradicts_us is not None:
        yield (
            f"the logger recorded a release at {release.contradicts_us / 1e6:.6f} s of its clock; its switch edges "
            f"show none there but one at {release.t_us / 1e6:.6f} s, which t = 0 is"
        )
    if release.earliest_us < release.latest_us:
        before_ms = (release.t_us - release.earliest_us) / 1e3
        after_ms = (release.latest_us - release.t_us) / 1e3
        yield (
            "edges of the release switches are lost: the release may have been up to "
            f"{before_ms:.3f} ms before t = 0 or {after_ms:.3f} ms after it"
        )
