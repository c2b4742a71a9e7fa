"""The committed report is of the present core; it says what was found; a run that fails leaves none."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.emulator_avr.building import REPOSITORY
from tests.evaluation.drops import Drop, drop
from tests.logger_proof.building import core_files, core_sha256
from tests.logger_proof.campaign import RATES_HZ, SEEDS
from tests.logger_proof.judge import Outcome
from tests.logger_proof.m7 import Figure, Instructions, Twins
from tests.logger_proof.measurements import Glitches, Offset, Spare, measure_offsets, run_glitches
from tests.logger_proof.report import Proof, Tools, render
from tests.logger_proof.truth import Kind
from tests.proof.campaign import Broken

REPORT = REPOSITORY / "docs" / "logger-proof.md"
RUNS = [
    Outcome(
        seed=1,
        kind=kind,
        rate_hz=rate_hz,
        verdict="truncated",
        closed=False,
        file_full=False,
        stalls=stalls,
        longest_stall_us=stalls * 450_000,
        pulled=pulled,
        samples=1000,
        decoded=950,
        dropped=0,
        torn=2,
        stale=0,
        duplicate=0,
        loss_us=123_000,
        trouble_us=0,
        rewritten=False,
        spoiled=0,
        headerless=False,
        ring_peak_blocks=77 * stalls,
        number=1,
        from_ram=kind is Kind.CARD_LOST,
    )
    for kind in Kind
    for rate_hz in RATES_HZ
    for stalls, pulled in ((0, False), (1, False), (0, True))
]
COUNTED = [
    Instructions(
        rate_hz=rate_hz,
        sample=Figure(100, 4000, 12_000),
        idle_sample=Figure(100, 2000, 2040),
        ports=200,
        empty_pass=Figure(400, 250, 300),
        pass_with_block=Figure(17, 300, 320),
    )
    for rate_hz in RATES_HZ
]


def test_the_report_is_of_the_present_core() -> None:
    named = f"`{core_sha256()}`" in REPORT.read_text()
    assert named, "docs/logger-proof.md is of other sources. Run: make logger-report"


def test_the_hash_is_of_everything_that_knows_no_hardware() -> None:
    names = {path.name for path in core_files()}
    assert {"logger.cpp", "card_writer.cpp", "messages.h", "crc32.h", "release_detector.cpp"} <= names
    assert not any(path.parent.name == "drivers" for path in core_files())


def test_the_report_is_of_the_full_campaign() -> None:
    told = re.search(r"(\d+) recordings, (\d+) of them cut off", REPORT.read_text().replace("\n", " "))
    assert told is not None
    assert int(told[1]) >= SEEDS
    assert int(told[2]) >= 2000


def test_the_report_names_no_machine_and_its_lines_can_be_read() -> None:
    text = REPORT.read_text()
    assert str(Path.home()) not in text
    assert str(REPOSITORY) not in text
    assert "/tmp" not in text
    assert all(len(line) <= 120 for line in text.splitlines() if not line.startswith("|"))


def test_a_report_tells_its_runs_figures() -> None:
    spares = [Spare(1000, 23_000, 0, 816, 821), Spare(1000, 23_000, 100, 479, 544)]
    glitches = [Glitches("nack", 280, 200, 150, 1, 0)]
    offsets = [Offset(100, 2, 1560, 1538.7)]
    tools = Tools("12.2.1", "7.2.22")
    proof = Proof(RUNS, Twins(96, 123_456, "ab" * 32), COUNTED, spares, glitches, offsets)
    text = render(proof, tools)
    cuts = sum(run.kind is not Kind.CARD_LOST for run in RUNS)
    assert f"{len(RUNS)} recordings, {cuts} of them cut off" in text.replace("\n", " ")
    assert "| takes what comes | 280 | 14 | 123 | 123 |" in text
    assert "| 1000 | 15 | 15 | 450 | 77 | 0 |" in text
    assert "| 1000 | 23 | 816 | 821 | 479 | 544 |" in text
    assert "| 1000 | 3800 | 11800 | 1800 | 300 | 250 | 0.64% |" in text
    assert f"`{'ab' * 32}`" in text
    assert "| one NACK | 280 | 200 | 0.75 | 1 | 0 |" in text
    assert "| 100 | 2 | 1560 | 1539 |" in text


def test_one_failed_transfer_costs_one_sample(tmp_path: Path) -> None:
    found = run_glitches(tmp_path, RATES_HZ)
    assert [(one.kind, one.lost) for one in found] == 2 * [("nack", 200), ("timeout", 200)]


def test_each_imu_is_read_when_the_log_says(tmp_path: Path) -> None:
    told = [(one.bus_khz, one.imu, one.told) for one in measure_offsets(tmp_path)]
    assert told == [
        (400, 1, 0),
        (400, 2, 390),
        (400, 3, 0),
        (400, 4, 390),
        (100, 1, 0),
        (100, 2, 1560),
        (100, 3, 0),
        (100, 4, 1560),
    ]


def test_a_log_that_tells_other_offsets_makes_no_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def mistold(*args: Any, **options: Any) -> Drop:
        one = drop(*args, **options)
        return replace(one, log=replace(one.log, header=replace(one.log.header, imu_offset_us=(0,) * 4)))

    monkeypatch.setattr("tests.logger_proof.measurements.drop", mistold)
    with pytest.raises(Broken, match="IMU 2 is read 399 us"):
        measure_offsets(tmp_path, (400,))


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_the_share_of_the_processor_grows_with_the_rate(rate_hz: int) -> None:
    one = COUNTED[RATES_HZ.index(rate_hz)]
    assert one.share == pytest.approx((3800 + 0.17 * 300) * rate_hz / 600e6)
