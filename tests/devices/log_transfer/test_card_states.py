"""What is wrong with a card shows before the drop, and costs no drop."""

from __future__ import annotations

import pytest

from tests.devices.log_transfer.bench import Bench
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.log_transfer import RAM
from tfsat_host.devices.logger import CardError, LoggerClient, ram_seconds
from tfsat_host.emulated.fault_injection import CardDefect
from tfsat_host.errors import RefusedError
from tfsat_host.protocol.enums import CardState, DropPhase, ErrorCode, LoggerState
from tfsat_host.protocol.limits import RING_BLOCKS, SAMPLE_RATE_HZ
from tfsat_host.sdlog import load

DEFECTS = {
    "missing": (CardState.MISSING, ErrorCode.NO_CARD),
    "full": (CardState.FULL, ErrorCode.CARD_FULL),
    "write-protected": (CardState.WRITE_PROTECTED, ErrorCode.CARD_WRITE_PROTECTED),
    "unreadable": (CardState.UNREADABLE, ErrorCode.CARD_UNREADABLE),
    "failing": (CardState.FAILING, ErrorCode.CARD_WRITE_FAILED),
}


def _spoil(bench: Bench, defect: str) -> None:
    slot = bench.robot.card_slot
    if defect == "missing":
        slot.remove()
    elif defect == "full":
        slot.fill(1000)
    else:
        slot.spoil(CardDefect[defect.upper().replace("-", "_")])


@pytest.fixture(params=DEFECTS)
def defect(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


def test_status_says_it_while_nothing_is_recorded(bench: Bench, defect: str) -> None:
    assert bench.logger.status().card == CardState.READY
    assert bench.logger.status().card_free_mib == 2048
    _spoil(bench, defect)
    bench.wait(2.5)
    assert bench.logger.status().card == DEFECTS[defect][0]
    # A good card again: the state recovers by itself.
    bench.robot.card_slot.insert()
    bench.wait(2.5)
    assert bench.logger.status().card == CardState.READY


def test_a_recording_on_it_fails_and_says_what_ram_keeps(bench: Bench, defect: str) -> None:
    _spoil(bench, defect)
    bench.logger.start_recording()
    with pytest.raises(CardError) as failed:
        bench.logger.wait_for_card()
    assert failed.value.code == DEFECTS[defect][1]
    assert failed.value.exit_code == 1
    assert failed.value.meaning.startswith("Do not drop")
    # 19 s at 280 Hz: what the ring holds.
    assert "RAM keeps the newest 19 s" in failed.value.meaning
    assert bench.logger.status().state == LoggerState.FAILED
    # A new card makes the next recording work again.
    bench.robot.card_slot.insert()
    bench.record(0.2)


def test_a_drop_after_it_is_fetched_from_ram(bench: Bench, defect: str) -> None:
    _spoil(bench, defect)
    bench.logger.start_recording()
    bench.wait(3.0)
    # The fall is recorded in RAM although nothing reached the card.
    _insist_on_drop_from_ram(bench)


def test_a_card_that_is_pulled_in_flight_costs_no_sample(bench: Bench) -> None:
    bench.logger.start_recording()
    bench.logger.wait_for_card()
    bench.wait(3.0)
    bench.robot.drop()
    bench.wait(0.5)
    # Half a second into the fall the card goes.
    bench.robot.card_slot.remove()
    bench.wait(8.0)
    with pytest.raises(CardError) as failed:
        bench.logger.stop_recording()
    assert failed.value.code == ErrorCode.NO_CARD
    assert failed.value.next_step == "Keep the power on. tfsat-host log fetch ram"
    _insist_on_ram(bench)


def _insist_on_drop_from_ram(bench: Bench) -> None:
    bench.robot.drop()
    bench.wait(6.0)
    _insist_on_ram(bench)


def _insist_on_ram(bench: Bench) -> None:
    status = bench.logger.status()
    assert status.state == LoggerState.FAILED
    # A landed robot: what RAM holds is a whole drop.
    assert status.phase == DropPhase.LANDED
    assert status.ram_holds_drop
    with pytest.raises(BoardError) as refused:
        bench.logger.start_recording()
    assert refused.value.code == ErrorCode.RAM_HOLDS_DROP
    # Refused: a new recording would overwrite the drop.
    assert isinstance(refused.value, RefusedError)
    entry = bench.logger.logs()[0]
    assert entry.number == RAM
    assert entry.session == status.session
    path = bench.folder / "ram.bin"
    path.write_bytes(bench.fetch(entry))
    log = load(path)
    assert log.session == status.session
    assert log.release is not None
    # Not a sample is missing, although the card took none.
    assert log.samples_lost == 0
    # From more than a second before the release to after the landing.
    assert log.t_s[0] < -1.0
    assert log.t_s[-1] > 3.5
    bench.logger.erase_log(entry)
    assert not bench.logger.status().ram_holds_drop
    bench.robot.card_slot.insert()
    bench.robot.seat()
    bench.record(0.2)


def test_ram_keeps_the_newest_seconds_and_no_more(bench: Bench) -> None:
    bench.robot.card_slot.remove()
    bench.logger.start_recording()
    # 25 s: longer than the ring holds.
    bench.wait(25.0)
    bench.logger.end_capture()
    entry = bench.logger.wait_for_listing(1.0).entries[0]
    # The newest block is still being filled.
    assert entry.blocks == RING_BLOCKS - 1
    path = bench.folder / "ram.bin"
    path.write_bytes(bench.fetch(entry))
    assert load(path).duration_s == pytest.approx(ram_seconds(SAMPLE_RATE_HZ), rel=0.02)


def test_a_host_waits_for_a_card_that_is_being_counted(bench: Bench) -> None:
    busy: list[bool] = []
    logger = LoggerClient.connect(bench.cable, on_busy=lambda: busy.append(True))
    bench.robot.card_slot.remove()
    bench.wait(2.5)
    # Four seconds of counting: a large card at its first use.
    bench.robot.card_slot.insert(mount_us=4_000_000)
    began_s = bench.cable.now_s()
    assert logger.start_recording().state == LoggerState.RECORDING
    assert 4.0 <= bench.cable.now_s() - began_s < 4.5
    assert busy == [True]
    assert logger.wait_for_card().card == CardState.READY
