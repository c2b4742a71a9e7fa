"""Short form of the damage campaign: some values of every byte; and defects that it must find."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.emulator_avr.building import Edit
from tests.sequencer.board import build_board_library
from tests.sequencer_proof.conftest import Plant
from tests.sequencer_proof.damage import TOLD, Case, Place, damage_image, damage_native
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import Broken


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_board_library(tmp_path_factory.mktemp("native"))


@pytest.mark.parametrize("case", Case)
def test_no_byte_makes_the_board_arm_with_anything_else(library: Path, case: Case) -> None:
    damaged = damage_native(library, case, seed=1, sample=1)
    assert damaged.values.total() == 1024 + 16 * 7
    if not case.may_arm:
        assert not damaged.armed
    else:
        assert 0 < damaged.armed[Place.MARKER] < damaged.values[Place.MARKER]
    if case in (Case.BOTH, Case.TWO):  # settings that were never stored may be those of the old layout
        assert damaged.armed[Place.OTHER] == damaged.values[Place.OTHER]
    assert {code for _, code in damaged.refused} <= set(TOLD)


def test_the_image_says_the_same(bench: Bench, library: Path) -> None:
    assert damage_image(bench, library, Case.TWO, seed=1, count=8).tried == 8


@pytest.mark.prove
def test_a_slot_that_counts_as_never_written_without_its_marker_is_found(plant: Plant, library: Path) -> None:
    """As it was with a marker of one byte."""
    trusting = plant(
        Edit("src/core/slot_pair.cpp", "begun > 0 ? Slot::kBegun : Slot::kDamaged", "Slot::kUnused")
    )
    with pytest.raises(Broken, match=r"begun.*the image .*NONE.*native .*UPLOAD_INTERRUPTED"):
        damage_image(trusting, library, Case.BEGUN, seed=1, count=2)
