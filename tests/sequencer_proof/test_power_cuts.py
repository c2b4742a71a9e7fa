"""Short form of the power-cut campaign: first, last and some cut points; and defects that it must find."""

from __future__ import annotations

import pytest

from tests.emulator_avr.building import Edit
from tests.sequencer_proof.conftest import Plant
from tests.sequencer_proof.power_cuts import (
    History,
    Record,
    Tear,
    Write,
    check_writes,
    cut_points,
    second_upload_writes,
)
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import Broken

SLOT_PAIR = "src/core/slot_pair.cpp"
BEGUN_BYTE = "complete_byte(position_) ^ kFlipToBegun"


@pytest.mark.parametrize("history", History)
@pytest.mark.parametrize("record", Record)
def test_a_cut_leaves_the_old_record_or_the_new_one_or_is_told(
    bench: Bench, record: Record, history: History
) -> None:
    cuts = cut_points(bench, record, history, seed=1, sample=2)
    assert cuts.points == cuts.stored_afterwards == 4
    assert cuts.writes > 20
    # The first write begins nothing yet; the last commits, so an earlier one never does.
    for tear in Tear:
        assert cuts.old[tear] >= 1
        assert cuts.new[tear] == (tear is Tear.NEW)
    assert cuts.told[Tear.OLD] >= 1


@pytest.mark.parametrize("record", Record)
def test_a_second_upload_writes_no_more_than_its_begin_and_end(bench: Bench, record: Record) -> None:
    assert second_upload_writes(bench, record) == (8 if record is Record.MANEUVER else 0)


@pytest.mark.prove
def test_a_store_that_overwrites_its_only_record_is_found(plant: Plant) -> None:
    careless = plant(Edit("src/core/slot_pair.h", "return static_cast<uint8_t>(1 - slot_);", "return slot_;"))
    with pytest.raises(Broken, match="neither the old nor the new"):
        cut_points(careless, Record.SETTINGS, History.ONE_SLOT, seed=1, sample=2)


@pytest.mark.prove
def test_a_store_that_marks_first_and_trusts_its_mark_is_found(plant: Plant) -> None:
    hasty = plant(
        Edit(SLOT_PAIR, BEGUN_BYTE, "complete_byte(position_)"),
        Edit(SLOT_PAIR, "&crc, kCrcBytes) != 0", "&crc, kCrcBytes) == 999"),
    )
    with pytest.raises(Broken, match="neither the old nor the new"):
        cut_points(hasty, Record.SETTINGS, History.BOTH_SLOTS, seed=1, sample=6)


@pytest.mark.prove
def test_a_store_that_takes_an_upload_cut_short_for_damage_is_found(plant: Plant) -> None:
    early = plant(Edit(SLOT_PAIR, BEGUN_BYTE, "complete_byte(position_)"))
    with pytest.raises(Broken, match=r"STORE_DAMAGED"):
        cut_points(early, Record.SETTINGS, History.ONE_SLOT, seed=1, sample=2)


@pytest.mark.prove
def test_a_store_that_keeps_quiet_about_an_upload_cut_short_is_found(plant: Plant) -> None:
    quiet = plant(Edit(SLOT_PAIR, "begun > 0 ? Slot::kBegun : Slot::kDamaged", "Slot::kUnused"))
    with pytest.raises(Broken, match=r"ARM says NONE"):
        cut_points(quiet, Record.MANEUVER, History.ONE_SLOT, seed=1, sample=2)


@pytest.mark.prove
def test_a_byte_that_is_written_with_what_it_holds_is_found(plant: Plant) -> None:
    wasteful = plant(Edit(SLOT_PAIR, "if (memory_.read(address) != value) memory_.write", "memory_.write"))
    with pytest.raises(Broken, match="was written with what it held"):
        cut_points(wasteful, Record.SETTINGS, History.BOTH_SLOTS, seed=1, sample=0)


@pytest.mark.prove
def test_a_byte_of_the_other_store_is_found() -> None:
    with pytest.raises(Broken, match="not in the store of the maneuver"):
        check_writes([Write(800, 0xFF, 1)], Record.MANEUVER)
