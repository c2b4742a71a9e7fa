"""What the log's events and the logger's states are in words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.devices.log_transfer.bench import Bench
from tfsat_host.devices.log_transfer import RAM
from tfsat_host.devices.logger import drop_in_danger, state_words
from tfsat_host.present.logger_state import LOGGER_FACTS, LOGGER_JSON, LoggerReport
from tfsat_host.present.recording_text import event_words
from tfsat_host.protocol.enums import CardState, ErrorCode, LoggerState
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.quantity import Quantity, record
from tfsat_host.run.recording_copy import Copy
from tfsat_host.sdlog import DropEvent


@pytest.mark.parametrize(
    ("arg", "words"),
    [(1, "more than a quarter of"), (2, "more than half of"), (3, "more than 3 quarters of"), (4, "all of")],
)
def test_how_full_the_ring_is(arg: int, words: str) -> None:
    event = DropEvent(t_us=0, name="ring_high_water", index=0, arg=arg, value=893)
    assert event_words(event) == f"893 blocks wait for the card: {words} the ring"


@pytest.mark.parametrize("number", [1, RAM])
def test_a_copy_without_samples_leads_to_ram(bench: Bench, number: int) -> None:
    bench.record(0.2)
    path = bench.folder / "header.bin"
    # The header block alone, without a sample.
    path.write_bytes(bench.fetch(bench.entry(1))[:BLOCK_BYTES])
    copy = Copy(bench.entry(number), path)
    copy.judge(bench.logger.listing())
    warning_text = " ".join(copy.warnings)
    assert "was copied whole, but it cannot be decoded" in warning_text and "has no samples" in warning_text
    assert ("tfsat-host log fetch ram" in warning_text) is (number != RAM)


def test_nobody_is_told_to_stop_in_the_fall(bench: Bench) -> None:
    bench.logger.start_recording()
    bench.logger.wait_for_card()
    bench.robot.drop()
    bench.wait(0.3)
    bench.robot.card_slot.remove()
    bench.wait(0.3)
    falling = drop_in_danger(bench.logger.status())
    assert falling is not None and falling.next_step.startswith("Wait for the landing")
    bench.wait(5.0)
    landed = drop_in_danger(bench.logger.status())
    assert landed is not None and "Wait" not in landed.next_step


def test_a_file_that_was_full_is_no_full_card(bench: Bench) -> None:
    # A full file is not a full card.
    status = replace(bench.logger.status(), state=LoggerState.STOPPED, error=ErrorCode.CARD_FULL)
    assert status.card == CardState.READY
    assert state_words(status) == "stopped: its file was full"
    failed = replace(status, state=LoggerState.FAILED)
    assert state_words(failed) == "failed: card full"
    report = LoggerReport.ask(bench.logger)
    state = record(LOGGER_JSON, report)
    assert (state["file_full"], state["attention"]) == (False, [])
    assert "idle, release switches: 1 closed, 2 closed" in fact_texts(report)


@pytest.mark.parametrize(
    ("who_am_i", "imu_text"),
    [
        (0x68, "2 NOT MEASURING (MPU-6050)"),
        (0x70, "2 NOT MEASURING (MPU-6500)"),
        (0x12, "2 FOREIGN (WHO_AM_I 0x12: no part that the logger knows)"),
        (0, "2 MISSING"),
    ],
)
def test_an_imu_that_answers_and_does_not_measure_is_not_missing(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, who_am_i: int, imu_text: str
) -> None:
    status = replace(bench.logger.status(), imu_present=0b1101, who_am_i=bytes([0x68, who_am_i, 0x68, 0x98]))
    monkeypatch.setattr(bench.logger, "status", lambda: status)
    assert f"1 MPU-6050, {imu_text}, 3 MPU-6050, 4 ICM-20689" in fact_texts(LoggerReport.ask(bench.logger))


def fact_texts(report: LoggerReport) -> list[Quantity | str]:
    return [column.cell(report) for column in LOGGER_FACTS]
