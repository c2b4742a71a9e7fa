"""Tables have their runs' figures, some of them found again; a wrong measurement leaves none."""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.fixtures.emulated_drop import Drop, drop
from tests.paths import DOCS
from tests.validation.campaign import Broken
from tests.validation.logger_proof.building import core_files
from tests.validation.logger_proof.campaign import RATES_HZ, SEEDS
from tests.validation.logger_proof.judge import Outcome
from tests.validation.logger_proof.m7 import Figure, Instructions
from tests.validation.logger_proof.measurements import (
    Glitches,
    Offset,
    SlowBus,
    Spare,
    measure_offsets,
    run_glitches,
    run_slow_buses,
)
from tests.validation.logger_proof.results import describe_machines, make_tables
from tests.validation.logger_proof.truth import Kind
from tests.validation.provenance import read_provenance
from tests.validation.tables import read_rows, results_csv

FOLDER = DOCS / "logger-proof"
RUN = Outcome(
    # The fields' defaults are zeros: only what a table shows is set.
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
    "failed-transfers": [Glitches("nack", rate_hz, 200, 150, 1, 0) for rate_hz in RATES_HZ],
    "slow-buses": [SlowBus(230, 1000, 10_000, 0, 985)],
    "read-times": [Offset(100, 2, 1560, 1538.7)],
}


def test_the_hash_is_of_everything_that_knows_no_hardware() -> None:
    # The hash covers the core, the protocol and the release rule; drivers are of the hardware.
    names = {path.name for path in core_files()}
    assert {"logger.cpp", "card_writer.cpp", "messages.h", "crc32.h", "release_detector.cpp"} <= names
    assert not any(path.parent.name == "drivers" for path in core_files())


def test_the_page_is_of_the_full_campaign() -> None:
    # The committed page is of the full campaign, not of this short form.
    figures = dict(read_rows(FOLDER / "figures.csv", "faults")[1:])
    assert int(figures["recordings"]) >= SEEDS
    assert int(figures["cut off by the power"]) >= 2000


def test_tables_have_their_runs_figures() -> None:
    written = make_tables(FOUND, [])
    # A CARD_LOST run has no cut by power.
    cuts = sum(run.kind is not Kind.CARD_LOST for run in RUNS)
    for name, row in {
        "figures": f"faults,cut off by the power,{cuts}",
        "losses": "takes what comes,280,14,123,123",
        "stalls": "1000,15,15,450,77,0",
        "instructions": "1000,3800,11800,1800,300,250,0.64",
        "shared-processor": "1000,23000,100,479,544",
        "failed-transfers": "nack,280,200,150,1,0",
        "slow-buses": "230,1000,10000,0,985",
        "read-times": "100,2,1560,1538.7",
        "recordings": "the block under way is torn,1000,3,3,0,3,0,0,6,0",
        "targets": "\"a sensor's time in the log's header, off by\",21.3,,100,µs,yes",
    }.items():
        assert f"\n{row.replace(chr(34), '')}\n" in written[f"{name}.csv"].replace(chr(34), ""), name
    for figure in ("machine,runs on both,1", 'machine,"bytes, the same",10'):
        assert figure in written["figures.csv"]
    assert '"fewest free blocks of RAM, processor shared",816\n' in written["figures.csv"]
    assert '"likewise, one write in 100 stalls",479\n' in written["figures.csv"]
    for name, text in written.items():
        assert text.splitlines()[0] == (FOLDER / name).read_text().splitlines()[0], name
    assert _labels((FOLDER / "figures.csv").read_text()) == _labels(written["figures.csv"])
    assert _labels((FOLDER / "targets.csv").read_text(), 1) == _labels(written["targets.csv"], 1)


def _labels(table: str, columns: int = 2) -> list[list[str]]:
    return [row[:columns] for row in csv.reader(table.splitlines())]


def test_what_both_machines_wrote_stands_with_the_campaign() -> None:
    described = describe_machines(FOUND)
    twins = described["SHA-256 of what PC and Cortex-M7 wrote"]
    assert twins == hashlib.sha256(b"imagetruth").hexdigest()
    assert set(described) < set(read_provenance(FOLDER))


def test_one_failed_transfer_costs_one_sample_or_two_at_1_khz(tmp_path: Path) -> None:
    glitches = run_glitches(tmp_path, RATES_HZ)
    # 200 glitches of each kind at each rate, each costing the sample that it hit, at 1 kHz a timeout the next, too.
    lost = [("nack", 200), ("timeout", 200), ("nack", 200), ("timeout", 400)]
    assert [(glitch.kind, glitch.lost) for glitch in glitches] == lost
    assert results_csv(glitches) == (FOLDER / "failed-transfers.csv").read_text()


def test_a_permitted_bus_loses_no_sample(tmp_path: Path) -> None:
    buses = run_slow_buses(tmp_path, RATES_HZ)
    assert results_csv(buses) == (FOLDER / "slow-buses.csv").read_text()
    # The rise that an earlier page permitted: beyond the deadline, and not missed here.
    assert all(bus.lost == 4 * bus.samples for bus in buses if bus.rise_ns == 426)


def test_each_imu_is_read_when_the_log_says(tmp_path: Path) -> None:
    measured = measure_offsets(tmp_path)
    committed = [float(row[3]) for row in read_rows(FOLDER / "read-times.csv")[1:]]
    # The measured delay must stay what the page says, to half a microsecond.
    assert [offset.measured_us for offset in measured] == pytest.approx(committed, abs=0.5)
    offsets = [(offset.bus_khz, offset.logged_us) for offset in measured]
    assert offsets == [
        # The second IMU of a bus is read later than the first by 0.39 ms at 400 kHz, four times that at 100 kHz.
        *zip([400] * 4, 2 * (0, 390), strict=True),
        *zip([100] * 4, 2 * (0, 1560), strict=True),
    ]


def test_a_log_with_other_offsets_makes_no_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A header that claims no offset: the measurement must contradict it.
    def wrong(*args: Any, **options: Any) -> Drop:
        emulated_drop = drop(*args, **options)
        return replace(
            emulated_drop,
            log=replace(emulated_drop.log, header=replace(emulated_drop.log.header, imu_offset_us=(0,) * 4)),
        )

    monkeypatch.setattr("tests.validation.logger_proof.measurements.drop", wrong)
    with pytest.raises(Broken, match="IMU 2 is read 399 us"):
        measure_offsets(tmp_path, (400,))


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_the_share_of_the_processor_grows_with_the_rate(rate_hz: int) -> None:
    instructions = COUNTED[RATES_HZ.index(rate_hz)]
    # 3800 instructions a sample, plus 17 % of a block of 300.
    assert instructions.share == pytest.approx((3800 + 0.17 * 300) * rate_hz / 600e6)
