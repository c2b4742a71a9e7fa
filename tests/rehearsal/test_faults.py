"""Every fault there is: the robot does what is said of it, keeps what it recorded, and the fault is noticed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.rehearsal.faults_page import PAGE, page
from tests.rehearsal.faults_seen import seen
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.rehearsal.faults.fault import Fault, Outcome
from tfsat_host.rehearsal.faults.known import FAULTS, fault_named

EACH = pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)


@EACH
def test_what_the_robot_then_does(fault: Fault) -> None:
    found = seen(fault)
    assert (found.drop.refused is not None) == (fault.outcome is Outcome.NOT_DROPPED)
    if fault.outcome is Outcome.FLIES:
        assert found.moved_deg > 15.0
    elif fault.outcome is Outcome.STOPS:
        assert found.drop.sequencer is not None
        assert found.drop.sequencer.state is SequencerState.FAULT
        assert found.moved_deg > 15.0
        assert not found.moves_at_the_end
    else:
        assert found.moved_deg < 1.0


@EACH
def test_what_it_keeps_and_who_notices(fault: Fault) -> None:
    found = seen(fault)
    if found.log is not None:
        assert found.log.samples_lost == 0
        assert (found.log.verdict != "truncated") == fault.complete
    words = " ".join(found.said.values())
    assert fault.noticed in words
    if not fault.noticed:
        assert "Nothing speaks against it" in words


def test_the_page_is_of_these_faults() -> None:
    assert page() == PAGE.read_text(), "python -m tests.rehearsal.faults_page"


def test_they_are_listed(tfsat_host: RunCli) -> None:
    listed = tfsat_host.json("rehearse", "--list-faults")["faults"]
    assert [one["name"] for one in listed] == [fault.name for fault in FAULTS]
    shown = tfsat_host("rehearse", "--list-faults").stdout
    assert all(fault.name in shown for fault in FAULTS)


def test_a_fault_that_does_not_exist(tfsat_host: RunCli) -> None:
    refused = tfsat_host("rehearse", "59", "70", "--fault", "gremlins", expect=2)
    assert "There is no fault 'gremlins'" in refused.stderr
    assert "--list-faults" in refused.stderr
    assert not (tfsat_host.folder / "run").exists()


def test_a_fault_in_the_command(tfsat_host: RunCli) -> None:
    flown = tfsat_host.json("rehearse", "59", "70", "--fault", "servo-dead", expect=3)
    assert flown["faults"] == ["servo-dead"]
    assert any("did not move" in reason for reason in flown["evaluation"]["reasons"])
    stood = tfsat_host("rehearse", "59", "70", "--fault", "card-missing", "--out", "none", expect=3)
    assert "Nothing was dropped:" in stood.stdout
    assert not (tfsat_host.folder / "none" / "SD.bin").exists()


@pytest.mark.parametrize("name", ["watchdog-while-armed", "watchdog-while-falling", "brown-out-at-release"])
def test_resets_of_the_flashed_image(name: str, tmp_path: Path) -> None:
    from tests.rehearsal.faults_seen import SCHEDULE, SEED
    from tfsat_host.emulated.sequencer_image import sequencer_hex
    from tfsat_host.rehearsal.day import rehearse
    from tfsat_host.rehearsal.truth import drawn_truth
    from tfsat_host.robot import load_robot

    fault, filed = fault_named(name), load_robot()
    drop = rehearse(SCHEDULE, filed, drawn_truth(filed, SEED), hex_path=sequencer_hex(print), faults=(fault,))
    assert drop.sequencer is not None
    states = {Outcome.FLIES: SequencerState.DONE}
    assert drop.sequencer.state is states.get(fault.outcome, SequencerState.FAULT)
