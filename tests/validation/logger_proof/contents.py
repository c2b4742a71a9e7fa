"""What a decoded recording says, sample by sample, against what the sensors said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.validation.campaign import Broken
from tests.validation.logger_proof.events import check_events
from tests.validation.logger_proof.truth import Truth
from tfsat_host.protocol.enums import BlockKind, LoggerState
from tfsat_host.protocol.limits import BLOCK_BYTES, SAMPLES_PER_BLOCK
from tfsat_host.protocol.log_layout import DATA_BLOCK_DTYPE, HEADER_BYTES
from tfsat_host.protocol.messages import LogFooter, LogHeader
from tfsat_host.sdlog import DropLog, LogError, load
from tfsat_host.sdlog.blocks import look

STALL_SLACK_MS = 20
PREPARATION_US = 500_000
MAX_RMS_ERROR = 1e-3


def check_contents(log: DropLog, truth: Truth) -> NDArray[np.int64]:
    """Check the log's contents against the truth and return the indices of the samples read.

    Raises Broken if a value, an event or a figure is wrong, or an event is missing.
    """
    # Rows of the truth that the decoded samples claim to be: all comparisons go by them.
    rows = _rows(log, truth.samples)
    _check_values(log, truth.samples[rows], truth)
    check_events(log, truth)
    _check_release(log, truth)
    if log.footer is not None:
        _check_footer(log.footer, truth)
    return rows


def check_blocks(image: Path, truth: Truth) -> None:
    """Raises Broken: in a whole block of this recording, what the decoder does not show or mends is wrong.

    Rate and time of day of every header; IMUs that the logger itself called valid and that gave nothing.
    """
    data = memoryview(image.read_bytes())
    looked = look(data)
    # Blocks with a right CRC that belong to this recording, remains of older ones excluded.
    own = looked.usable & (looked.heads["session"] == truth.writes["session"][0])
    for row in np.flatnonzero(own & (looked.heads["kind"] == BlockKind.HEADER)).tolist():
        payload = data[row * BLOCK_BYTES + HEADER_BYTES :][: LogHeader.SIZE]
        header = LogHeader.decode(bytes(payload))
        if header.rate_hz != truth.rate_hz:
            raise Broken(f"a header has {header.rate_hz} Hz")
        # Time of day less the logger's clock must be the same in every header.
        unix_at_zero_us = header.wall_clock_us - int(looked.heads["time_us"][row])
        if unix_at_zero_us != int(truth.head["unix_at_zero_us"]):
            raise Broken(f"a header's time of day is wrong: {header.wall_clock_us}")
    blocks = np.frombuffer(data, np.dtype(DATA_BLOCK_DTYPE))[own & (looked.heads["kind"] == BlockKind.DATA)]
    for slot in range(SAMPLES_PER_BLOCK):
        # A block may hold fewer than its six samples: slots behind the last one are not looked at.
        filled_blocks = blocks[blocks["sample_count"] > slot]
        index = filled_blocks["first_sample"].astype(np.int64) + slot
        flags = filled_blocks["samples"]["flags"][:, slot]
        within = index < len(truth.samples)
        # The low four flag bits are the IMUs': none may be called valid that did not answer.
        if (flags[within] & 0xF & ~truth.samples["served"][index[within]]).any():
            raise Broken("an IMU is called valid that gave nothing")


def _rows(log: DropLog, samples: NDArray[np.void]) -> NDArray[np.int64]:
    """Return the index of the sample that each decoded sample claims to be."""
    # A sample twice or behind the last one was never taken.
    if len(np.unique(log.sample_index)) != len(log) or log.sample_index[-1] >= len(samples):
        raise Broken("samples that were never taken")
    if not np.array_equal(samples["t_us"][log.sample_index], log.t_us.astype(np.uint64)):
        raise Broken("a time is wrong")
    return log.sample_index


def _check_values(log: DropLog, truth: NDArray[np.void], run: Truth) -> None:
    served = _bits(truth["served"], 4)
    # Valid without an answer: a wrong value would be believed.
    if (log.imu_valid & ~served).any():
        raise Broken("an IMU is called valid that gave nothing")
    # Only where valid: an IMU that did not answer may leave anything in its place.
    if (log.imu_counts != truth["imu"])[log.imu_valid].any():
        raise Broken("an IMU's value is wrong")
    faulty = _bits(run.head["faulty"][None], 4)[0]
    # An IMU that has no fault in the run must be valid in every sample.
    if not log.imu_valid[:, ~faulty].all():
        raise Broken("a fault of one IMU costs another its values")
    # Word 3 is the temperature: only accelerometer and gyro can be clipped.
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


def _check_release(log: DropLog, truth: Truth) -> None:
    """Check the decoder's release where strokes tell which release was the robot's."""
    # A gap may hide an edge of the switches; strokes show which release started the maneuver.
    sure = not log.gaps and any(event.name == "stroke" for event in log.events)
    if sure and (log.release is None or abs(log.release.t_us - truth.release_us) > 1):
        raise Broken(f"the release is {log.release and log.release.t_us - truth.release_us} us off")


def _longest_ms(troubles: NDArray[np.void]) -> int:
    return int((troubles["to_us"] - troubles["from_us"]).max(initial=0)) // 1000


def _check_footer(footer: LogFooter, truth: Truth) -> None:
    """Times between samples, the longest stall, and what was written twice."""
    times = truth.samples["t_us"][: footer.samples].astype(np.int64)
    steps = np.diff(times)
    nominal_us = 1e6 / truth.rate_hz
    # More than one and a half intervals: at least one sample was not taken.
    late = steps > 1.5 * nominal_us
    rms_us = float(np.sqrt(np.mean((steps[~late] - nominal_us) ** 2)))
    # The footer's own statistics, from the same times.
    logged_intervals = (footer.interval_min_us, footer.interval_max_us, footer.late_ticks)
    if logged_intervals != (int(steps.min()), int(steps.max()), int(np.count_nonzero(late))):
        raise Broken(f"times between samples: the footer has {logged_intervals}")
    if abs(footer.jitter_rms_us - rms_us) > 0.01 + MAX_RMS_ERROR * rms_us:
        raise Broken(f"the jitter is {rms_us} us, the footer has {footer.jitter_rms_us}")
    if truth.head["pulled"]:
        return
    if not truth.is_last:
        return
    troubles = truth.troubles[truth.troubles["from_us"] > truth.begin_us]
    # While the file is prepared, and once the footer is made, a stall is not counted.
    counted = (troubles["from_us"] > times[0] + PREPARATION_US) & (troubles["to_us"] < times[-1])
    least_ms, most_ms = _longest_ms(troubles[counted]), _longest_ms(troubles)
    if not least_ms - 1 <= footer.card_stall_max_ms <= most_ms + STALL_SLACK_MS:
        raise Broken(
            f"the longest stall is {least_ms} to {most_ms} ms, the footer has {footer.card_stall_max_ms}"
        )
    # Blocks with a number that was written before.
    twice = len(truth.writes) - len(np.unique(truth.writes["number"]))
    if footer.blocks_rewritten != twice:
        raise Broken(f"{twice} blocks were written twice, the footer has {footer.blocks_rewritten}")


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
    # The samples about the release that RAM must hold when the card is gone.
    fall = fall_rows(truth, KEPT_US[truth.rate_hz])
    if int(truth.head["state"]) != LoggerState.FAILED:
        raise Broken("the card is gone for good, and the logger has not noticed")
    if not truth.head["ram_blocks"]:
        raise Broken("RAM gave nothing")
    try:
        log = load(image)
    except LogError as error:
        raise Broken(f"what RAM gave is refused: {error.what}") from None
    in_ram = np.zeros(len(fall), np.bool_)
    in_ram[check_contents(log, truth)] = True
    check_blocks(image, truth)
    # Late losses at 1 kHz: the ring has overwritten the beginning, which the card still has.
    if truth.rate_hz == 1000 and int(truth.troubles["from_us"][-1]) > truth.release_us + NOTICED_IN_TIME_US:
        in_ram |= on_card
    # Either whole in RAM or, every sample of the drop, twice on the card.
    if (fall & ~in_ram).any() and not doubled[fall].all():
        raise Broken(
            f"RAM lacks {np.count_nonzero(fall & ~in_ram)} of {np.count_nonzero(fall)} samples of the drop"
        )


def fall_rows(truth: Truth, span_us: tuple[int, int]) -> NDArray[np.bool_]:
    """(n,) bool by sample index: taken in that span about the release."""
    since_us = truth.samples["t_us"].astype(np.int64) - truth.release_us
    rows: NDArray[np.bool_] = (since_us > span_us[0]) & (since_us < span_us[1])
    return rows


def doubled_samples(truth: Truth) -> NDArray[np.bool_]:
    """(n,) bool by sample index: two blocks that hold it were synced."""
    # Only synced blocks are safe: an unsynced write may be lost with the power.
    synced = truth.writes[truth.writes["synced"] != 0]
    numbers, counts = np.unique(synced["number"], return_counts=True)
    return truth.samples_in(np.isin(truth.writes["number"], numbers[counts > 1]))
