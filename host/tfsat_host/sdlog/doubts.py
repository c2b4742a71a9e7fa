"""Contradictions inside a recording: each makes it doubtful, whatever else is there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from .assembly import SetAside
from .events import DropEvent
from .footers import Footers
from .gaps import Gap
from .header import FoundHeader
from .ledger import Account
from .noted import read_noted
from .release import Release
from .timing import Steps


def find_doubts(
    found: FoundHeader, footers: Footers, account: Account, steps: Steps, set_aside: SetAside
) -> Iterator[str]:
    """Yield a sentence for each contradiction."""
    if found.disagreements:
        yield f"{found.disagreements} copies of the header disagree with the one that was used"
    if set_aside.conflicting:
        yield f"{set_aside.conflicting} blocks carry the number of another, different block"
    if steps.not_advancing:
        yield f"time does not advance at {steps.not_advancing} samples"
    if account.overlaps:
        yield f"{account.overlaps} blocks repeat sample numbers of the block before"
    if account.drops_taken_back:
        yield "the count of dropped samples goes down"
    yield from _footer_doubts(footers, account)


def _footer_doubts(footers: Footers, account: Account) -> Iterator[str]:
    if footers.not_understood:
        yield f"{footers.not_understood} ends of the recording hold impossible values and are not used"
    if footers.last is None:
        return
    if footers.differ:
        yield "the recording has several different ends"
    footer, number = footers.last, footers.last_number
    if number != account.last_number:
        yield "blocks follow the end of the recording"
    if footer.blocks != number + 1:
        yield f"the end of the recording counts {footer.blocks} blocks and is number {number}"
    if footer.samples < account.samples_end:
        yield f"the end of the recording counts {footer.samples} samples; there are {account.samples_end}"
    if footer.samples_dropped < account.samples_dropped:
        yield "the end of the recording counts fewer dropped samples than a block before it"


def event_doubts(impossible: int) -> Iterator[str]:
    """Yield a sentence if events have times that no clock can show; nothing is concluded from them."""
    if impossible:
        yield f"{impossible} events have impossible times"


def two_releases(release: Release | None) -> str | None:
    """A sentence if the switches' edges fit two releases: nothing is lost, but t = 0 is not certain."""
    if release is None or release.left_us[0] == release.left_us[1]:
        return None
    before_ms = (release.t_us - release.left_us[0]) / 1e3
    after_ms = (release.left_us[1] - release.t_us) / 1e3
    return (
        "The release switches' edges fit two releases (a blow and then the release, or worn contacts): the robot left "
        f"between {before_ms:.3f} ms before t = 0 and {after_ms:.3f} ms after it."
    )


def release_doubts(
    release: Release | None,
    events: Sequence[DropEvent],
    gaps: Sequence[Gap],
    switch_open: NDArray[np.bool_],
) -> Iterator[str]:
    """Yield a sentence if the release is not certain to the microsecond, or missing where one must be."""
    if release is None:
        noted = read_noted(events).believed_us
        if noted:
            yield (
                f"the logger noted a release at {noted[-1] / 1e6:.6f} s of its clock that its switch edges "
                "do not tell, or not where it can be the drop's: times count from the first sample"
            )
        elif gaps and any(event.name == "stroke" for event in events):
            yield "strokes were recorded and no release: times count from the first sample"
        elif gaps and gaps[0].start_us is None and switch_open[:1].all():
            yield "the start is lost and both switches are open after it: the release may lie in it"
        return
    if release.contradicts_us is not None:
        yield (
            f"the logger noted a release at {release.contradicts_us / 1e6:.6f} s of its clock; its switch edges "
            f"tell none there but one at {release.t_us / 1e6:.6f} s, which t = 0 is"
        )
    if release.earliest_us < release.latest_us:
        before_ms = (release.t_us - release.earliest_us) / 1e3
        after_ms = (release.latest_us - release.t_us) / 1e3
        yield (
            "edges of the release switches are lost: the release may have been up to "
            f"{before_ms:.3f} ms before t = 0 or {after_ms:.3f} ms after it"
        )
