"""The drop in RAM, where the card was lost for good: a second image, judged like a card's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.logger_proof.broken import Broken
from tests.logger_proof.contents import check_blocks, check_contents
from tests.logger_proof.truth import Truth
from tfsat_host.protocol.enums import LoggerState
from tfsat_host.sdlog import LogError, load

KEPT_US = {280: (-1_000_000, 4_000_000), 1000: (-900_000, 3_900_000)}
"""About the release, by rate: what RAM must hold. At 1 kHz the ring is as long as the drop."""

NOTICED_IN_TIME_US = 2_000_000
"""At 1 kHz, a card that is lost so late after the release has had its beginning, which RAM overwrites meanwhile."""


def check_ram(image: Path, truth: Truth, doubled: NDArray[np.bool_], on_card: NDArray[np.bool_]) -> None:
    """Raises Broken: the drop is neither twice on the card nor whole in RAM, or what RAM gave is wrong.

    Args:
        image: What a host fetched.
        doubled: (n,) bool by sample index: it is safe on the card, twice.
        on_card: Likewise: it was read from the card.
    """
    fall = fall_rows(truth, KEPT_US[truth.rate_hz])
    if int(truth.head["state"]) != LoggerState.FAILED:
        raise Broken("the card is gone for good, and the logger has not noticed")
    if not truth.head["ram_blocks"]:
        raise Broken("RAM gave nothing")
    try:
        log = load(image)
    except LogError as error:
        raise Broken(f"what RAM gave is refused: {error.what}") from None
    held = np.zeros(len(fall), np.bool_)
    held[check_contents(log, truth)] = True
    check_blocks(image, truth)
    if truth.rate_hz == 1000 and int(truth.troubles["from_us"][-1]) > truth.release_us + NOTICED_IN_TIME_US:
        held |= on_card
    if (fall & ~held).any() and not doubled[fall].all():
        raise Broken(
            f"RAM lacks {np.count_nonzero(fall & ~held)} of {np.count_nonzero(fall)} samples of the drop"
        )


def fall_rows(truth: Truth, span_us: tuple[int, int]) -> NDArray[np.bool_]:
    """(n,) bool by sample index: taken in that span about the release."""
    since_us = truth.samples["t_us"].astype(np.int64) - truth.release_us
    rows: NDArray[np.bool_] = (since_us > span_us[0]) & (since_us < span_us[1])
    return rows


def doubled_samples(truth: Truth) -> NDArray[np.bool_]:
    """(n,) bool by sample index: two blocks that hold it were synced."""
    synced = truth.writes[truth.writes["synced"] != 0]
    numbers, counts = np.unique(synced["number"], return_counts=True)
    return truth.samples_in(np.isin(truth.writes["number"], numbers[counts > 1]))
