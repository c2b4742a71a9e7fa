"""Jolts and false releases in the flashed image: the short form of the report's campaigns."""

from __future__ import annotations

import pytest

from tests.emulator_avr.building import Edit
from tests.sequencer_proof.conftest import Plant
from tests.sequencer_proof.jolts import closed_again, jolted_releases, judge_jolted
from tests.sequencer_proof.releases import judge
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import Broken


def test_what_is_told_of_a_release_after_jolts_holds_when_the_robot_left(bench: Bench) -> None:
    jolted = jolted_releases(bench, seed=59, count=150)
    judge_jolted(jolted)
    assert sum(one.interval_us > 0 for one in jolted) > 30
    assert sum(not one.jolts for one in jolted) > 5


def test_closed_again_starts_nothing_or_ends_the_run(bench: Bench) -> None:
    judge(closed_again(bench, seed=59, count=4).releases)


@pytest.mark.prove
def test_a_board_that_says_nothing_of_two_releases_is_found(plant: Plant) -> None:
    silent = plant(Edit("src/core/release_detector.h", "return hung_ || last_", "return false && last_"))
    with pytest.raises(Broken, match="nothing is said of it"):
        jolted_releases(silent, seed=59, count=150)


@pytest.mark.prove
def test_a_board_that_flies_on_the_crane_is_found(plant: Plant) -> None:
    eager = plant(
        Edit("src/core/release_detector.cpp", "stood >= kSeatedTicks", "stood >= 100 * kSeatedTicks")
    )
    with pytest.raises(Broken, match="closed again: RUNNING"):
        closed_again(eager, seed=59, count=1)
