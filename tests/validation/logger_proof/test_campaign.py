"""Short form of the fault campaign, on the PC with the sanitizers on and on a Cortex-M7; defects that it must find."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.fixtures.planting import Edit
from tests.validation.campaign import Broken, run_campaigns
from tests.validation.logger_proof.building import INSTRUCTIONS, build_for_m7, build_for_pc
from tests.validation.logger_proof.campaign import RATES_HZ, run_each, runs, seeds_of
from tests.validation.logger_proof.m7 import compare, count_instructions
from tests.validation.logger_proof.truth import Kind
from tfsat_host.sdlog import blocks

WRITER = "core/card_writer.cpp"
BUILDER = "core/block_builder.cpp"
RECORDER = "core/recorder.cpp"
LOGGER = "core/logger.cpp"
WATCH = "core/drop_watch.cpp"

SHORT_SEEDS = 48
"""At least one of each kind at each rate."""
M7_SEEDS = (1, 14, 15, 28)

# What the defect is, where it is planted, the runs that find it, and what they say.
DEFECTS = {
    "the card is never synced": (
        Edit(WRITER, "if (position_ == safe_position_) return false;", "return false;"),
        (Kind.CACHE_LOST, 6),
        "before the cut is lost|had been synced|dropped|lost although",
    ),
    "what a card without contact forgot is not written again": (
        Edit(WRITER, "    position_ = safe_position_;", "    ring_.release(unsynced_), position_ = safe_position_;"),
        (Kind.PULLED, 24),
        "before the cut is lost|lost although",
    ),
    "all sessions have the same id": (
        Edit("core/logger.cpp", "= entropy_.next();", "= entropy_.next() & 0;"),
        (Kind.STALE, 4),
        "a time is wrong|never taken",
    ),
    "block numbers come again": (
        Edit(BUILDER, "head.block_number = blocks();", "head.block_number = blocks() % 128;"),
        (Kind.BETWEEN, 4),
        "lost that stood on the card|is refused",
    ),
    "the footer comes before the last block": (
        Edit(RECORDER, "    builder_.flush();\n    capture_ =", "    capture_ ="),
        (Kind.SPOILED, 4),
        "were dropped, the log tells of 0",
    ),
    "the file is closed before everything is in it": (
        Edit(RECORDER, "if (!footer_added_ || !writer_.drained(t_us)) return;", "if (!footer_added_) return;"),
        (Kind.SPOILED, 4),
        "lost although|has no end",
    ),
    "the second copy is of other blocks": (
        Edit(WRITER, "ring_.copy(rewrite_next_, copy_)", "ring_.copy(rewrite_end_ - 1, copy_)"),
        (Kind.SPOILED, 4),
        "of the fall were not written twice",
    ),
    "drops are not counted": (
        Edit(BUILDER, "  increment(dropped_);\n", ""),
        (Kind.SMALL_RING, 4),
        "samples were dropped, the log tells of",
    ),
    "the header is not repeated": (
        Edit(BUILDER, "blocks() == kEarlyHeaderBlock || blocks() % protocol::kHeaderRepeatBlocks", "blocks()"),
        (Kind.SPOILED, 1),
        "no header stands on the card",
    ),
    "a dead sensor keeps its last reading": (
        Edit("core/sampler.cpp", "    if (!imu(i).fresh()) continue;\n", ""),
        (Kind.DEAD_SENSORS, 24),
        "an IMU is called valid that gave nothing",
    ),
    "every second stroke is not logged": (
        Edit(LOGGER, "  if (is_stroke) ++strokes_;\n", "  if (is_stroke && strokes_++ % 2) return;\n"),
        (Kind.SPOILED, 1),
        "no stroke is in the log",
    ),
    "edges that were not kept are not told": (
        Edit(LOGGER, "  edges_not_kept_ += edge.lost;\n", ""),
        (Kind.SPOILED, 4),
        "no stroke is in the log",
    ),
    "the release is logged 250 ms late": (
        Edit(WATCH, "(released_us_, EventCode::kRelease, 1,", "(released_us_ + 250000, EventCode::kRelease, 1,"),
        (Kind.SPOILED, 1),
        "no release is in the log",
    ),
    "a release that was none is not taken back": (
        Edit(WATCH, "note(released_us_, EventCode::kRelease, 0, 0);", ""),
        (Kind.FALSE_RELEASE, 4),
        "no release is in the log",
    ),
    "the landing is not logged": (
        Edit(WATCH, "note(t_us, EventCode::kLanding,", "if (false) note(t_us, EventCode::kLanding,"),
        (Kind.SPOILED, 1),
        "no landing is in the log",
    ),
    "stalls are not logged": (
        Edit(WRITER, "    note(last_free_us_, EventCode::kCardStall, 0, took_ms);\n", ""),
        (Kind.STALLS, 4),
        "no card_stall is in the log",
    ),
    "the time of day lacks the uptime": (
        Edit(BUILDER, "unix_at_zero_us_ == 0 ? 0 : unix_at_zero_us_ + t_us", "unix_at_zero_us_"),
        (Kind.SPOILED, 1),
        "time of day is wrong",
    ),
    "the jitter is not told": (
        Edit(BUILDER, "  footer.jitter_rms_us = intervals_.rms_us();\n", ""),
        (Kind.SPOILED, 4),
        "the jitter is",
    ),
    "what a frozen sensor repeated is not taken back": (
        Edit("core/sampler.cpp", "frozen ? sensor.still_us() : 0;", "frozen ? 0 : 0;"),
        (Kind.DEAD_SENSORS, 24),
        "a frozen IMU has stood still for",
    ),
    "events without room are forgotten": (
        Edit(RECORDER, "if (!builder_.add_event(*event)) break;", "builder_.add_event(*event);"),
        (Kind.SMALL_RING, 8),
        "is in the log",
    ),
    "RAM is overwritten after the landing": (
        Edit(RECORDER, "if (fall_kept_ && state_ == LoggerState::kFailed) {", "if (false) {"),
        (Kind.CARD_LOST, 24),
        "RAM lacks|RAM gave nothing",
    ),
    "a drop that only RAM has is not kept": (
        Edit(RECORDER, "!on_card_twice && !card_takes;", "!on_card_twice && !card_takes && false;"),
        (Kind.CARD_LOST, 8),
        "RAM lacks",
    ),
}  # fmt: skip


def test_no_fault_costs_what_the_card_had_or_makes_a_wrong_value(pc: Path) -> None:
    outcomes = run_campaigns([runs(pc, SHORT_SEEDS)])["runs"]
    assert {(outcome.kind, outcome.rate_hz) for outcome in outcomes} == {
        (kind, rate_hz) for kind in Kind for rate_hz in RATES_HZ
    }
    # The short form must show every mechanism, or it proves less than it says.
    for what in ("torn", "stale", "dropped", "duplicate", "pulled", "stalls", "spoiled", "from_ram"):
        assert any(getattr(outcome, what) for outcome in outcomes), f"no run was {what}"
    assert any(outcome.number > 1 for outcome in outcomes)
    assert {outcome.verdict for outcome in outcomes} >= {"complete", "truncated", "damaged"}


@pytest.mark.prove
@pytest.mark.parametrize("defect", DEFECTS)
def test_a_planted_defect_is_found(tmp_path: Path, defect: str) -> None:
    # Each defect names the kind of run that finds it and the words of the judge.
    edit, (kind, count), found_by = DEFECTS[defect]
    with pytest.raises(Broken, match=found_by):
        run_each(build_for_pc(tmp_path, [edit]), seeds_of(kind, count))


@pytest.mark.prove
def test_a_decoder_that_believes_torn_blocks_is_found(pc: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def believe_blocks(data: memoryview) -> NDArray[np.bool_]:
        return np.ones(len(data) // 512, np.bool_)

    # Torn blocks count as intact: the judge must see the values behind them.
    monkeypatch.setattr(blocks, "_crc_is_right", believe_blocks)
    with pytest.raises(Broken, match=r"wrong|no whole block|never taken"):
        run_each(pc, seeds_of(Kind.TORN, 8))


# ------------------------------------------------------------------ on the Cortex-M7


def test_the_card_holds_the_same_bytes_as_after_the_pcs_run(pc: Path, m7: Path) -> None:
    # Seeds of four kinds; both machines write images and accounts bit by bit the same.
    same = [result for seed in M7_SEEDS for result in compare(pc, m7, seed)]
    assert sum(map(len, same)) > len(M7_SEEDS) * 1_000_000


@pytest.mark.prove
def test_a_core_that_depends_on_the_size_of_a_pointer_is_found(pc: Path, tmp_path: Path) -> None:
    # sizeof(void*) is 8 here and 4 there: a dependence on the host shows as a byte.
    edit = Edit(
        "core/request_server.cpp", "header.dlpf_cfg = settings.dlpf_cfg;", "header.dlpf_cfg = sizeof(void*);"
    )
    with pytest.raises(Broken, match="another than the PC's"):
        compare(pc, build_for_m7(tmp_path, edits=[edit]), M7_SEEDS[0])


def test_sampling_leaves_the_processor_to_the_card(tmp_path: Path) -> None:
    # 10,000 samples at 1 kHz: ten seconds of recording.
    counted = count_instructions(build_for_m7(tmp_path, INSTRUCTIONS), 1000)
    assert counted.sample.times == 10_000
    # Not an empty loop, and no more than a quarter of the 0.2 ms that timing.h leaves next to the buses.
    assert 1_000 < counted.core.mean < counted.core.most < 30_000
    # 2 % of the processor, far below the 10 % that the page promises.
    assert counted.share < 0.02
