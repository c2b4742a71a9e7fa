"""A page has its runs' figures; a wrong measurement leaves none."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.evaluation.drops import Drop, drop
from tests.paths import REPOSITORY
from tests.validation.campaign import Broken
from tests.validation.logger_proof.building import core_files
from tests.validation.logger_proof.campaign import RATES_HZ, SEEDS
from tests.validation.logger_proof.judge import Outcome
from tests.validation.logger_proof.m7 import Figure, Instructions
from tests.validation.logger_proof.measurements import Glitches, Offset, Spare, measure_offsets, run_glitches
from tests.validation.logger_proof.page import files
from tests.validation.logger_proof.truth import Kind

PAGE = REPOSITORY / "docs" / "logger-proof.md"
RUN = Outcome(
    **dict.fromkeys(Outcome._fields, 0)  # type: ignore[arg-type]
    | {"seed": 1, "verdict": "truncated", "decoded": 950, "torn": 2, "loss_us": 123_000, "number": 1}
)
RUNS = [
    RUN._replace(
        kind=kind,
        rate_hz=rate_hz,
        stalls=stalls,
        longest_stall_us=stalls * 450_000,
        ring_peak_blocks=77 * stalls,
        pulled=pulled,
        from_ram=kind is Kind.CARD_LOST,
    )
    for kind in Kind
    for rate_hz in RATES_HZ
    for stalls, pulled in ((0, False), (1, False), (0, True))
]
TIMES = (Figure(100, 4000, 12_000), Figure(100, 2000, 2040), 200, Figure(400, 250, 300), Figure(17, 300, 320))
COUNTED = [Instructions(rate_hz, *TIMES) for rate_hz in RATES_HZ]
FOUND: dict[str, Sequence[Any]] = {
    "runs": RUNS,
    "twins": [b"image", b"truth"],
    "instructions": COUNTED,
    "shared-processor": [Spare(1000, 23_000, 0, 816, 821), Spare(1000, 23_000, 100, 479, 544)],
    "failed-transfers": [Glitches("nack", 280, 200, 150, 1, 0)],
    "read-times": [Offset(100, 2, 1560, 1538.7)],
}


def test_the_hash_is_of_everything_that_knows_no_hardware() -> None:
    names = {path.name for path in core_files()}
    assert {"logger.cpp", "card_writer.cpp", "messages.h", "crc32.h", "release_detector.cpp"} <= names
    assert not any(path.parent.name == "drivers" for path in core_files())


def test_the_page_is_of_the_full_campaign() -> None:
    counts = re.search(r"(\d+) recordings, (\d+) of them cut off", PAGE.read_text().replace("\n", " "))
    assert counts is not None
    assert int(counts[1]) >= SEEDS
    assert int(counts[2]) >= 2000


def test_a_page_has_its_runs_figures_and_every_table() -> None:
    written = files(FOUND, [])
    text = written["logger-proof.md"]
    cuts = sum(run.kind is not Kind.CARD_LOST for run in RUNS)
    for figures in (
        f"{len(RUNS)} recordings, {cuts} of them cut off",
        "| takes what comes | 280 | 14 | 123 | 123 |",
        "| 1000 | 15 | 15 | 450 | 77 | 0 |",
        "| 1000 | 3800 | 11800 | 1800 | 300 | 250 | 0.64% |",
        f"| `{hashlib.sha256(b'imagetruth').hexdigest()}` |",
        "are the same 10 bytes",
        "at least 816 of the 896 blocks of RAM were free, 479 where",
        "within 21 µs",
    ):
        assert figures in text.replace("\n  ", " ").replace("\n", " ")
    for name, row in {
        "shared-processor": "1000,23000,100,479,544",
        "failed-transfers": "nack,280,200,150,1,0",
        "read-times": "100,2,1560,1538.7",
        "recordings": "the block under way is torn,1000,3,3,0,3,0,0,6,0",
    }.items():
        assert f"\n{row}\n" in written[f"logger-proof/{name}.csv"]
    for name in written:
        assert name.removeprefix("logger-proof/") in text or name == "logger-proof.md"
        assert (PAGE.parent / name).is_file()
    committed = PAGE.read_text().splitlines()
    for line in committed:
        assert len(line) <= 130 or line.startswith("|")
    assert len(committed) <= 120


def test_one_failed_transfer_costs_one_sample(tmp_path: Path) -> None:
    found = run_glitches(tmp_path, RATES_HZ)
    assert [(one.kind, one.lost) for one in found] == 2 * [("nack", 200), ("timeout", 200)]


def test_each_imu_is_read_when_the_log_says(tmp_path: Path) -> None:
    offsets = [(one.bus_khz, one.logged_us) for one in measure_offsets(tmp_path)]
    assert offsets == [
        *zip([400] * 4, 2 * (0, 390), strict=True),
        *zip([100] * 4, 2 * (0, 1560), strict=True),
    ]


def test_a_log_with_other_offsets_makes_no_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(*args: Any, **options: Any) -> Drop:
        one = drop(*args, **options)
        return replace(one, log=replace(one.log, header=replace(one.log.header, imu_offset_us=(0,) * 4)))

    monkeypatch.setattr("tests.validation.logger_proof.measurements.drop", wrong)
    with pytest.raises(Broken, match="IMU 2 is read 399 us"):
        measure_offsets(tmp_path, (400,))


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_the_share_of_the_processor_grows_with_the_rate(rate_hz: int) -> None:
    one = COUNTED[RATES_HZ.index(rate_hz)]
    assert one.share == pytest.approx((3800 + 0.17 * 300) * rate_hz / 600e6)
