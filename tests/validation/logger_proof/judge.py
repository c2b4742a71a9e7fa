"""Holds what the decoder made of a card against what really happened."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tests.validation.campaign import Broken
from tests.validation.logger_proof.contents import (
    check_blocks,
    check_contents,
    check_ram,
    doubled_samples,
    fall_rows,
)
from tests.validation.logger_proof.truth import Kind, Truth
from tfsat_host.protocol.enums import BlockKind, LoggerState, StopReason
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.sdlog import DropLog, LogError, load

PARTIAL_AND_SYNC_US = 100_000 + 250_000
"""A block waits so long to be filled, and then so long for the card's sync."""
LOOP_US = 100_000
"""Syncs and writes themselves, and for each trouble the retry after a loss of contact."""
STATE_LAG_US = 50_000
"""The interrupt may end a recording before the main loop knows."""
ROWS_OF_A_FALL_US = (-900_000, 3_900_000)
"""About the release: what the second copy must hold, a little less than 1 s before it to 4 s after it."""


class Outcome(NamedTuple):
    """What came of one run.

    Attributes:
        verdict: The decoder's; `nothing yet` where no block of the recording was on the card.
        samples: Taken before the power went.
        decoded: Of those, read back.
        file_full: The recording ended where its file did.
        dropped: Of the samples, without room in the ring or the file, and counted in the log.
        loss_us: From the oldest sample that is in neither to the power cut; 0 when there is none.
        trouble_us: In that time and the 2 s before it, when the card took nothing.
        ring_peak_blocks: Most blocks that ever waited, as the footer tells; 0 without one.
        headerless: Samples stood on the card before its first sync, and no header.
        number: Of the recording in its run, from 1.
        from_ram: The drop was fetched from RAM.
    """

    seed: int
    kind: Kind
    rate_hz: int
    verdict: str
    closed: bool
    file_full: bool
    stalls: int
    longest_stall_us: int
    pulled: bool
    samples: int
    decoded: int
    dropped: int
    torn: int
    stale: int
    duplicate: int
    loss_us: int
    trouble_us: int
    rewritten: bool
    spoiled: int
    headerless: bool
    ring_peak_blocks: int
    number: int
    from_ram: bool

    @property
    def cut(self) -> bool:
        """The power went before the end."""
        return not self.closed and self.kind is not Kind.CARD_LOST


@dataclass(frozen=True, eq=False)
class _Reading:
    """What a recording's samples came to; all (n,) bool by sample index.

    Attributes:
        log: None where the card holds no readable recording yet.
        taken: The logger recorded it.
        held: It is read from the card.
        dropped: It found no room.
        on_card: A whole block on the medium holds it.
    """

    log: DropLog | None
    taken: NDArray[np.bool_]
    held: NDArray[np.bool_]
    dropped: NDArray[np.bool_]
    on_card: NDArray[np.bool_]

    @property
    def lost(self) -> NDArray[np.bool_]:
        lost: NDArray[np.bool_] = self.taken & ~self.held & ~self.dropped
        return lost

    @property
    def headerless(self) -> bool:
        return self.log is None and bool(self.on_card.any())


def judge(folder: Path, truth: Truth) -> Outcome:
    """Judge one recording of a run from SEED.bin and SEED.ram.

    Raises Broken, with the seed in its text.
    """
    head = truth.head
    try:
        return _judge(folder, truth)
    except Broken as broken:
        raise Broken(f"seed {head['seed']} ({truth.kind.name}, {head['rate_hz']} Hz): {broken}") from None


def _judge(folder: Path, truth: Truth) -> Outcome:
    failed = truth.is_last and int(truth.head["state"]) == LoggerState.FAILED
    # Given up only where the card really did not come back.
    if failed and not truth.head["lost_for_good"]:
        raise Broken("the card was given up although it came back in time")
    reading = _read(_own_file(folder, truth), truth)
    log = reading.log
    # Without a header nothing can be decoded; the samples on the card then count for nothing.
    if not reading.headerless:
        _check_kept(reading.held, reading.on_card, "stood on the card")
    # A sync is the promise that a host relies on: what was synced must be there.
    _check_kept(reading.held, truth.samples_in(truth.writes["synced"] != 0), "had been synced")
    # The other way round: nothing may be read that no whole block holds.
    if (reading.held & ~reading.on_card).any():
        raise Broken("a sample was read that no whole block on the card holds")
    _check_drops(log, reading.dropped)
    loss_us, trouble_us = _loss(reading.lost, truth)
    if log is not None:
        _check_verdict(log, reading, truth)
    doubled = doubled_samples(truth)
    _check_second_copy(truth, doubled)
    # The card is gone: the drop must be in RAM or twice on the card.
    if truth.is_last and truth.head["lost_for_good"]:
        check_ram(folder / f"{truth.head['seed']}.ram", truth, doubled, reading.held)
    return _outcome(truth, reading, loss_us, trouble_us, bool(doubled.any()))


def _own_file(folder: Path, truth: Truth) -> Path:
    image = folder / f"{truth.head['seed']}.bin"
    # A run of a single file needs no cut-out.
    if truth.head["file_count"] == 1:
        return image
    own = folder / f"{truth.head['seed']}.{truth.number}.bin"
    # The blocks of this file of the card's image.
    begin, end = truth.blocks.start * BLOCK_BYTES, truth.blocks.stop * BLOCK_BYTES
    own.write_bytes(image.read_bytes()[begin:end])
    return own


def _read(image: Path, truth: Truth) -> _Reading:
    log = _decode_image(image, truth)
    in_image = np.zeros(len(truth.samples), np.bool_)
    if log is not None:
        in_image[check_contents(log, truth)] = True
        check_blocks(image, truth)
    return _Reading(
        log=log,
        taken=_recorded_samples(truth),
        held=in_image,
        dropped=truth.dropped_samples(),
        on_card=truth.samples_in(truth.writes["on_medium"] != 0),
    )


def _outcome(truth: Truth, reading: _Reading, loss_us: int, trouble_us: int, rewritten: bool) -> Outcome:
    log = reading.log
    aside = log.set_aside if log else None
    stalls = truth.troubles[truth.troubles["pulled"] == 0]
    return Outcome(
        seed=int(truth.head["seed"]),
        kind=truth.kind,
        rate_hz=truth.rate_hz,
        verdict=log.verdict if log else "nothing yet",
        closed=truth.closed,
        file_full=bool(log and log.footer and log.footer.stop_reason == StopReason.FILE_FULL),
        stalls=len(stalls),
        longest_stall_us=int((stalls["to_us"] - stalls["from_us"]).max(initial=0)),
        pulled=bool(truth.head["pulled"]),
        samples=int(np.count_nonzero(reading.taken)),
        decoded=int(np.count_nonzero(reading.held)),
        dropped=int(np.count_nonzero(reading.dropped)),
        torn=aside.torn if aside else 0,
        stale=aside.stale if aside else 0,
        duplicate=aside.duplicate if aside else 0,
        loss_us=loss_us,
        trouble_us=trouble_us,
        rewritten=rewritten,
        spoiled=int(truth.head["spoiled_blocks"]),
        headerless=reading.headerless,
        ring_peak_blocks=log.footer.ring_peak_blocks if log and log.footer else 0,
        number=truth.number,
        from_ram=bool(truth.is_last and truth.head["ram_blocks"]),
    )


def _decode_image(image: Path, truth: Truth) -> DropLog | None:
    """Decode the recording of this run; return None where there cannot be one yet.

    A card that programs its RAM in any order may hold samples and no header, but not after a sync.
    """
    # Blocks that reached the medium, whatever the order in which the card programmed its RAM.
    standing = truth.writes[truth.writes["on_medium"] != 0]
    kinds = set(standing["kind"].tolist())
    if truth.writes["synced"].any() and BlockKind.HEADER not in kinds:
        raise Broken("no header stands on the card although it was synced")
    readable = {BlockKind.HEADER, BlockKind.DATA} <= kinds
    try:
        log = load(image)
    except LogError as error:
        if readable:
            raise Broken(f"the recording is refused: {error.what}") from None
        return None
    # A session of the remains of an older recording is not this one.
    if len(truth.writes) and log.session == int(truth.writes["session"][0]):
        return log
    if readable:
        raise Broken("an older recording is taken for this one")
    return None


def _recorded_samples(truth: Truth) -> NDArray[np.bool_]:
    """(n,) bool: the logger recorded it, as its state told, or handed it to the card."""
    # Handed to the card, or captured according to the state at the tick.
    handed = truth.samples_in(np.ones(len(truth.writes), np.bool_))
    is_recorded: NDArray[np.bool_] = handed | (truth.samples["captured"] != 0)
    footers = truth.writes[truth.writes["kind"] == BlockKind.FOOTER]
    # The state lags behind the interrupt: a few samples behind the footer are no loss.
    if len(footers):
        end = int(footers["first_sample"][0])
        after = truth.samples["t_us"][end:][is_recorded[end:]]
        if len(after) and int(after[-1] - after[0]) > STATE_LAG_US:
            raise Broken("no sample is taken although the state says that it records")
        is_recorded[end:] = False
    return is_recorded


def _check_kept(is_present: NDArray[np.bool_], due: NDArray[np.bool_], what: str) -> None:
    if (due & ~is_present).any():
        raise Broken(f"{np.count_nonzero(due & ~is_present)} samples are lost that {what}")


def _check_drops(log: DropLog | None, dropped: NDArray[np.bool_]) -> None:
    """Check that the log's gaps tell of all samples dropped before the end of the log."""
    if log is None:
        return
    # A footer speaks for those after the last sample too.
    end = len(dropped) if log.footer else int(log.sample_index[-1]) + 1
    before_end = int(np.count_nonzero(dropped[:end]))
    # A gap at the end of a log without a footer has no count yet.
    logged_drops = sum(gap.samples_dropped for gap in log.gaps if log.footer or gap.end_us is not None)
    if logged_drops != before_end:
        raise Broken(f"{before_end} samples were dropped, the log tells of {logged_drops}")
    if before_end and log.verdict == "complete":
        raise Broken("samples were dropped, and the recording is called complete")


def _loss(lost: NDArray[np.bool_], truth: Truth) -> tuple[int, int]:
    """Return the oldest lost sample's age at the cut and the time the card took nothing, in us.

    That time is counted from 2 s before the sample.
    """
    if not lost.any():
        return 0, 0
    # argmax of a mask: the first lost sample.
    oldest_us = int(truth.samples["t_us"][np.argmax(lost)])
    end_us = truth.end_us
    # Before that, a backlog may have been left by earlier trouble.
    window_us = oldest_us - 2_000_000
    begins = np.clip(truth.troubles["from_us"].astype(np.int64), window_us, end_us)
    ends = np.clip(truth.troubles["to_us"].astype(np.int64), window_us, end_us)
    trouble_us = int((ends - begins).sum())
    troubles = int(np.count_nonzero(ends > begins))
    # The worst case: a partly filled block, its sync, the loop, and all time in which the card took nothing.
    most_us = PARTIAL_AND_SYNC_US + LOOP_US * (1 + 2 * troubles) + trouble_us
    if end_us - oldest_us > most_us:
        raise Broken(f"a sample taken {(end_us - oldest_us) / 1e3:.0f} ms before the cut is lost")
    return end_us - oldest_us, trouble_us


def _check_verdict(log: DropLog, reading: _Reading, truth: Truth) -> None:
    lost, dropped = reading.lost, reading.dropped
    # Closed means drained: nothing may be missing.
    if truth.closed and lost.any():
        raise Broken(f"{np.count_nonzero(lost)} samples are lost although the recording was closed")
    if truth.closed and log.footer is None:
        raise Broken("the recording was closed, and has no end")
    if log.verdict == "complete" and (lost.any() or dropped.any()):
        raise Broken("a recording that lacks samples is called complete")
    # Nothing dropped and nothing spoiled on purpose: then the verdict must be complete.
    unspoiled = truth.closed and not dropped.any() and not truth.head["spoiled_blocks"]
    if unspoiled and log.verdict != "complete":
        raise Broken(f"a whole recording is called {log.verdict}: {log.doubts}")


def _check_second_copy(truth: Truth, doubled: NDArray[np.bool_]) -> None:
    """Check that the fall was written twice if the card was quiet and the recording ended by itself."""
    fall = fall_rows(truth, ROWS_OF_A_FALL_US)
    # With a small ring or a busy card the second copy may be left out.
    quiet = not len(truth.troubles) and truth.kind is not Kind.SMALL_RING
    # 4.5 s after landing: the second copy is written by then.
    ended_by_itself = truth.closed and truth.last_sample_us > int(truth.head["landing_us"]) + 4_500_000
    if quiet and ended_by_itself and truth.begin_us < truth.release_us and not doubled[fall].all():
        raise Broken(f"{np.count_nonzero(fall & ~doubled)} samples of the fall were not written twice")
