"""Holds what the decoder made of a card against what really happened."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.logger_proof.truth import Kind, Truth
from tfsat_host.protocol.enums import BlockKind, LoggerState, StopReason
from tfsat_host.sdlog import DropLog, LogError, load

PARTIAL_AND_SYNC_US = 100_000 + 250_000
"""A block waits so long to be filled, and then so long for the card's sync."""
LOOP_US = 100_000
"""Syncs and writes themselves, and for each trouble the retry after a loss of contact."""
STATE_LAG_US = 50_000
"""The interrupt may end a recording before the main loop knows."""
ROWS_OF_A_FALL_US = (-900_000, 3_900_000)
"""About the release: what the second copy must hold, a little less than 1 s before it to 4 s after it."""


class Broken(Exception):
    """A promise that the logger or the decoder did not keep."""


@dataclass(frozen=True, slots=True)
class Outcome:
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


def judge(image: Path, truth: Truth) -> Outcome:
    """Raises Broken, with the seed in its text."""
    try:
        return _judge(image, truth)
    except Broken as broken:
        head = truth.head
        raise Broken(f"seed {head['seed']} ({truth.kind.name}, {head['rate_hz']} Hz): {broken}") from None


def _judge(image: Path, truth: Truth) -> Outcome:
    if int(truth.head["state"]) == LoggerState.FAILED:
        raise Broken("the card was given up although it came back in time")
    log = _decoded(image, truth)
    samples = truth.ticks[truth.first_tick :]
    held = np.zeros(len(samples), np.bool_)
    if log is not None:
        rows = _rows(log, samples)
        held[rows] = True
        _check_values(log, samples[rows], truth)
        _check_events(log, truth)
    on_medium = truth.writes["on_medium"] != 0
    headerless = log is None and bool(truth.samples_in(on_medium).any())
    if not headerless:
        _check_kept(held, truth.samples_in(on_medium)[: len(held)], "stood on the card")
    _check_kept(held, truth.samples_in(truth.writes["synced"] != 0)[: len(held)], "had been synced")
    if (held & ~truth.samples_in(on_medium)[: len(held)]).any():
        raise Broken("a sample was read that no whole block on the card holds")
    dropped = truth.dropped()[: len(held)]
    taken = _taken(truth, samples)
    _check_drops(log, dropped)
    lost = taken & ~held & ~dropped
    loss_us, trouble_us = _loss(lost, samples, truth)
    if log is not None:
        _check_verdict(log, lost, dropped, truth)
    rewritten = _check_second_copy(truth, samples)
    return _outcome(log, truth, taken, held, dropped, loss_us, trouble_us, rewritten, headerless)


def _outcome(
    log: DropLog | None,
    truth: Truth,
    taken: NDArray[np.bool_],
    held: NDArray[np.bool_],
    dropped: NDArray[np.bool_],
    loss_us: int,
    trouble_us: int,
    rewritten: bool,
    headerless: bool,
) -> Outcome:
    aside = log.set_aside if log else None
    stalls = truth.troubles["to_us"] - truth.troubles["from_us"]
    return Outcome(
        seed=int(truth.head["seed"]),
        kind=truth.kind,
        rate_hz=int(truth.head["rate_hz"]),
        verdict=log.verdict if log else "nothing yet",
        closed=bool(truth.head["closed"]),
        file_full=log is not None
        and log.footer is not None
        and log.footer.stop_reason == StopReason.FILE_FULL,
        stalls=len(stalls) if truth.head["stall_one_in"] else 0,
        longest_stall_us=int(stalls.max(initial=0)) if truth.kind is not Kind.PULLED else 0,
        pulled=bool(truth.head["pulled"]),
        samples=int(np.count_nonzero(taken)),
        decoded=int(np.count_nonzero(held)),
        dropped=int(np.count_nonzero(dropped)),
        torn=aside.torn if aside else 0,
        stale=aside.stale if aside else 0,
        duplicate=aside.duplicate if aside else 0,
        loss_us=loss_us,
        trouble_us=trouble_us,
        rewritten=rewritten,
        spoiled=int(truth.head["spoiled_blocks"]),
        headerless=headerless,
        ring_peak_blocks=log.footer.ring_peak_blocks if log and log.footer else 0,
    )


def _decoded(image: Path, truth: Truth) -> DropLog | None:
    """The recording of this run; None where there cannot be one yet.

    A card that programs its RAM in any order may hold samples and no header, but not after a sync.
    """
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
    if len(truth.writes) and log.session == int(truth.writes["session"][0]):
        return log
    if readable:
        raise Broken("an older recording is taken for this one")
    return None


def _taken(truth: Truth, samples: NDArray[np.void]) -> NDArray[np.bool_]:
    """(n,) bool: the logger recorded it, as its state told, or handed it to the card."""
    handed = truth.samples_in(np.ones(len(truth.writes), np.bool_))[: len(samples)]
    taken: NDArray[np.bool_] = handed | (samples["captured"] != 0)
    footers = truth.writes[truth.writes["kind"] == BlockKind.FOOTER]
    if len(footers):
        end = int(footers["first_sample"][0])
        after = samples["t_us"][end:][taken[end:]]
        if len(after) and int(after[-1] - after[0]) > STATE_LAG_US:
            raise Broken("no sample is taken although the state says that it records")
        taken[end:] = False
    return taken


def _rows(log: DropLog, samples: NDArray[np.void]) -> NDArray[np.int64]:
    """Which sample each decoded one claims to be."""
    if len(np.unique(log.sample_index)) != len(log) or log.sample_index[-1] >= len(samples):
        raise Broken("samples that were never taken")
    if not np.array_equal(samples["t_us"][log.sample_index], log.t_us.astype(np.uint64)):
        raise Broken("a time is wrong")
    return log.sample_index


def _check_values(log: DropLog, truth: NDArray[np.void], run: Truth) -> None:
    served = _bits(truth["served"], 4)
    if (log.imu_valid & ~served).any():
        raise Broken("an IMU is called valid that gave nothing")
    if (log.imu_counts != truth["imu"])[log.imu_valid].any():
        raise Broken("an IMU's value is wrong")
    faulty = _bits(run.head["faulty"][None], 4)[0]
    if not log.imu_valid[:, ~faulty].all():
        raise Broken("a fault of one IMU costs another its values")
    ends = np.isin(truth["imu"][:, :, [0, 1, 2, 4, 5, 6]], (-32768, 32767)).any(axis=2)
    if (log.clipped != ends)[log.imu_valid].any():
        raise Broken("a clipped value is not flagged, or another is")
    if not np.array_equal(log.angle_valid, _bits(truth["angles"], 6)):
        raise Broken("an angle sensor is called valid that is not, or the other way")
    if not np.array_equal(log.angle_counts, truth["angle"]):
        raise Broken("an angle is wrong")
    if not np.array_equal(log.switch_open, _bits(truth["switches_open"], 2)):
        raise Broken("a release switch is wrong")


def _bits(values: NDArray[np.uint8], count: int) -> NDArray[np.bool_]:
    bits: NDArray[np.bool_] = (values[:, None] >> np.arange(count)) & 1 != 0
    return bits


def _check_events(log: DropLog, truth: Truth) -> None:
    edges = {tuple(edge) for edge in truth.edges[["t_us", "source", "index", "open"]].tolist()}
    strokes = sorted(edge[0] for edge in edges if edge[1])
    for event in log.events:
        if event.name == "switch_edge" and (event.t_us, 0, event.index, event.arg) not in edges:
            raise Broken("a switch edge that was none")
        if event.name == "stroke" and (event.index >= len(strokes) or strokes[event.index] != event.t_us):
            raise Broken("a stroke that was none")
    if log.release is not None and not log.gaps and abs(log.release.t_us - _release_us(truth)) > 1:
        raise Broken(f"the release is {log.release.t_us - _release_us(truth)} us off")


def _release_us(truth: Truth) -> int:
    """Both switches open: the second one's edge."""
    return int(truth.edges["t_us"][(truth.edges["source"] == 0) & (truth.edges["index"] == 1)][0])


def _check_kept(held: NDArray[np.bool_], due: NDArray[np.bool_], what: str) -> None:
    if (due & ~held).any():
        raise Broken(f"{np.count_nonzero(due & ~held)} samples are lost that {what}")


def _check_drops(log: DropLog | None, dropped: NDArray[np.bool_]) -> None:
    """Those before the end of the log must be in its gaps, as dropped."""
    if log is None:
        return
    # A footer speaks for those after the last sample too.
    end = len(dropped) if log.footer else int(log.sample_index[-1]) + 1
    before_end = int(np.count_nonzero(dropped[:end]))
    told = sum(gap.samples_dropped for gap in log.gaps if log.footer or gap.end_us is not None)
    if told != before_end:
        raise Broken(f"{before_end} samples were dropped, the log tells of {told}")
    if before_end and log.verdict == "complete":
        raise Broken("samples were dropped, and the recording is called complete")


def _loss(lost: NDArray[np.bool_], samples: NDArray[np.void], truth: Truth) -> tuple[int, int]:
    """How old the oldest lost sample was at the cut, and for how much of that the card took nothing."""
    if not lost.any():
        return 0, 0
    oldest_us = int(samples["t_us"][np.argmax(lost)])
    end_us = truth.end_us
    # Before that, a backlog may have been left by earlier trouble.
    window_us = oldest_us - 2_000_000
    begins = np.clip(truth.troubles["from_us"].astype(np.int64), window_us, end_us)
    ends = np.clip(truth.troubles["to_us"].astype(np.int64), window_us, end_us)
    trouble_us = int((ends - begins).sum())
    troubles = int(np.count_nonzero(ends > begins))
    most_us = PARTIAL_AND_SYNC_US + LOOP_US * (1 + 2 * troubles) + trouble_us
    if end_us - oldest_us > most_us:
        raise Broken(f"a sample taken {(end_us - oldest_us) / 1e3:.0f} ms before the cut is lost")
    return end_us - oldest_us, trouble_us


def _check_verdict(log: DropLog, lost: NDArray[np.bool_], dropped: NDArray[np.bool_], truth: Truth) -> None:
    if truth.head["closed"] and lost.any():
        raise Broken(f"{np.count_nonzero(lost)} samples are lost although the recording was closed")
    if truth.head["closed"] and log.footer is None:
        raise Broken("the recording was closed, and has no end")
    if log.verdict == "complete" and (lost.any() or dropped.any()):
        raise Broken("a recording that lacks samples is called complete")
    unspoiled = truth.head["closed"] and not dropped.any() and not truth.head["spoiled_blocks"]
    if unspoiled and log.verdict != "complete":
        raise Broken(f"a whole recording is called {log.verdict}: {log.doubts}")


def _check_second_copy(truth: Truth, samples: NDArray[np.void]) -> bool:
    """Whether the fall was written twice; it must be where the card was quiet and the recording closed."""
    synced = truth.writes[truth.writes["synced"] != 0]
    twice = np.zeros(len(truth.writes), np.bool_)
    numbers, counts = np.unique(synced["number"], return_counts=True)
    twice[:] = np.isin(truth.writes["number"], numbers[counts > 1])
    doubled = truth.samples_in(twice)[: len(samples)]
    since_us = samples["t_us"].astype(np.int64) - _release_us(truth)
    fall = (since_us > ROWS_OF_A_FALL_US[0]) & (since_us < ROWS_OF_A_FALL_US[1])
    quiet = not len(truth.troubles) and truth.kind is not Kind.SMALL_RING
    ended_by_itself = (
        truth.head["closed"] and int(samples["t_us"][-1]) > int(truth.head["landing_us"]) + 4_500_000
    )
    if quiet and ended_by_itself and not doubled[fall].all():
        raise Broken(f"{np.count_nonzero(fall & ~doubled)} samples of the fall were not written twice")
    return bool(doubled.any())
