"""Short forms of the reset campaigns, and defects that they must find."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.emulator_avr.avr_board import ResetCause
from tests.emulator_avr.building import Edit, build_changed_sequencer
from tests.sequencer_proof.conftest import Plant
from tests.sequencer_proof.noise import STATES
from tests.sequencer_proof.resets import HANG, Moment, hang_board, reset_board
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import CYCLES_PER_TICK, CYCLES_PER_US, Broken
from tfsat_host.protocol.enums import SequencerState

LONGEST_SILENCE_US = 40_000
"""Start-up and two frames."""


@pytest.fixture(scope="module")
def hanging(bench: Bench, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    image = build_changed_sequencer([HANG], tmp_path_factory.mktemp("hanging"), bench.image)
    return replace(bench, image=image)


@pytest.mark.parametrize("cause", [ResetCause.WATCHDOG, ResetCause.BROWN_OUT])
@pytest.mark.parametrize("moment", Moment)
def test_a_reset_goes_on_or_holds_still(bench: Bench, moment: Moment, cause: ResetCause) -> None:
    found = reset_board(bench, moment, cause, count=3, seed=4)
    assert found.silence.greatest <= LONGEST_SILENCE_US * CYCLES_PER_US
    if moment is Moment.ARMED:
        assert found.errors is not None
        assert max(abs(found.errors.least), abs(found.errors.greatest)) <= CYCLES_PER_TICK
    else:
        assert found.errors is None


@pytest.mark.parametrize("state", STATES)
def test_the_watchdog_ends_a_hang(hanging: Bench, state: SequencerState) -> None:
    found = hang_board(hanging, state, count=2, seed=5)
    assert 900_000 < found.reset_after.least <= found.reset_after.greatest < 1_200_000


@pytest.mark.prove
def test_a_board_that_arms_with_an_open_switch_is_found(plant: Plant) -> None:
    bold = plant(
        Edit("src/core/sequencer.cpp", "bool opened = switches_.levels() != 0;", "bool opened = false;"),
        Edit("src/core/sequencer.cpp", "opened = opened || edge.open;", "opened = false;"),
    )
    with pytest.raises(Broken):
        reset_board(bold, Moment.ARMED_SECOND_OPEN, ResetCause.WATCHDOG, count=1, seed=4)


@pytest.mark.prove
def test_a_board_that_forgets_its_widths_is_found(plant: Plant) -> None:
    lost = "if (!powered || !retained_.intact())"
    limp = plant(Edit("src/core/sequencer.cpp", lost, "if (true)"))
    with pytest.raises(Broken, match="no pulses"):
        reset_board(limp, Moment.RUNNING, ResetCause.BROWN_OUT, count=1, seed=4)


@pytest.mark.prove
def test_a_board_that_forgets_its_knocks_is_found(plant: Plant) -> None:
    restart = "  detector_.reset(now, retained_.knocks);\n  resume_after"
    forgetful = plant(Edit("src/core/sequencer.cpp", restart, restart.replace("retained_.knocks", "0")))
    with pytest.raises(Broken, match="knocks are counted after the reset"):
        reset_board(forgetful, Moment.ARMED_FIRST_OPEN, ResetCause.BROWN_OUT, count=4, seed=4)


@pytest.mark.prove
def test_a_board_that_forgets_its_run_is_found(plant: Plant) -> None:
    lost = "if (!powered || !retained_.run.intact())"
    forgetful = plant(Edit("src/core/sequencer.cpp", lost, "if (true)"))
    with pytest.raises(Broken, match="RUN_REPORT"):
        reset_board(forgetful, Moment.RUNNING, ResetCause.WATCHDOG, count=1, seed=4)


@pytest.mark.prove
def test_a_board_without_its_watchdog_is_found(bench: Bench, tmp_path: Path) -> None:
    off = Edit("src/drivers/reset_cause.cpp", "wdt_enable(WDTO_1S)", "wdt_disable()")
    unfed = Edit("arduino_sequencer.ino", "  Watchdog::feed(sequencer.may_upload());\n", "")
    image = build_changed_sequencer([HANG, off, unfed], tmp_path, bench.image)
    with pytest.raises(Broken, match="no reset within"):
        hang_board(replace(bench, image=image), SequencerState.ARMED, count=1, seed=5)
