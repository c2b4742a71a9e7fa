"""Every fault: the preflight sees it, the robot does what is said of it and keeps its record, and it is noticed."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.rehearsal.faults_page import PAGE, page
from tests.rehearsal.faults_seen import SCHEDULE, SEED, flown, no_go, seen
from tfsat_host.emulated.robot import US_PER_S
from tfsat_host.emulated.sequencer_image import sequencer_hex
from tfsat_host.rehearsal.faults.boards import BOARD_FAULTS
from tfsat_host.rehearsal.faults.card import POWER_CUTS, power_cut
from tfsat_host.rehearsal.faults.fault import Fault, Outcome, at_any_moment
from tfsat_host.rehearsal.faults.known import FAULTS
from tfsat_host.rehearsal.faults.release import RELEASE_FAULTS
from tfsat_host.rehearsal.moment import GUARD_US, Moment
from tfsat_host.rehearsal.outcome import came_of, moved_deg
from tfsat_host.rehearsal.rehearse import rehearse
from tfsat_host.rehearsal.truth import drawn_truth
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import load

SOUND = Fault(
    "none", "Nothing goes wrong.", Moment.POWERED, lambda _: None, at_any_moment(Outcome.FLIES), morning=()
)
EACH = pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
IN_THE_MORNING = pytest.mark.parametrize(
    "fault", [fault for fault in FAULTS if fault.morning is not None], ids=lambda fault: fault.name
)
ON_THE_IMAGE = pytest.mark.parametrize(
    "fault", [*RELEASE_FAULTS, *BOARD_FAULTS, *POWER_CUTS], ids=lambda fault: fault.name
)
STEPS_US = range(-100_000, 101_000, 20_000)
BACKLASH_DEG = 1.0
"""Within it a joint comes to rest on either side, as the last microsecond of a pulse has it."""
LATE_S = 0.2
"""Of the samples before a power cut so much may still be on its way to the card."""


@IN_THE_MORNING
def test_what_the_preflight_says(fault: Fault) -> None:
    assert no_go(fault) == fault.morning


@EACH
def test_what_the_robot_then_does(fault: Fault) -> None:
    found = seen(fault)
    assert (found.drop.refused is not None) == (fault.outcome is Outcome.NOT_DROPPED)
    assert came_of(fault.outcome, found.drop) is True
    assert (moved_deg(found.drop).max() > 15.0) == (fault.outcome in (Outcome.FLIES, Outcome.STOPS))
    others = {other for other in Outcome if came_of(other, found.drop)} - {fault.outcome}
    assert others <= {Outcome.FLIES} and (not others or fault.outcome is Outcome.STOPS)


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
        assert not found.no_go


def test_words_of_a_fault_are_not_said_without_it() -> None:
    said = " ".join(seen(SOUND).said.values())
    assert "Nothing speaks against it" in said
    assert [fault.name for fault in FAULTS if fault.noticed and fault.noticed in said] == []
    assert no_go(SOUND) == ()


@pytest.mark.parametrize("offset_us", STEPS_US)
def test_power_cuts_around_the_landing(offset_us: int, tmp_path: Path) -> None:
    """What had reached the card is read back, sample by sample as the same drop without a cut has it."""
    whole = seen(SOUND).log
    cut = replace(POWER_CUTS[0], strike_now=partial(power_cut, after_us=GUARD_US + offset_us))
    drop = flown(cut, despite=False)
    (tmp_path / "SD.bin").write_bytes(drop.card)
    log = load(tmp_path / "SD.bin")
    assert whole is not None
    assert whole.release_us is not None
    assert log.release_us is not None
    assert drop.landed_s is not None
    assert drop.released_s is not None
    assert log.samples_lost == 0
    assert np.array_equal(log.t_us - log.release_us, (whole.t_us - whole.release_us)[: len(log)])
    assert np.array_equal(log.imu_counts, whole.imu_counts[: len(log)])
    cut_s = drop.landed_s - drop.released_s + offset_us / US_PER_S
    assert cut_s - LATE_S < log.seconds(int(log.t_us[-1])) <= cut_s


@ON_THE_IMAGE
def test_the_flashed_image_does_the_same(fault: Fault) -> None:
    """The AVR's own code, watchdog, brown-out and EEPROM, in an emulated ATmega32U4."""
    found = seen(fault)
    hex_path = sequencer_hex(print)
    filed = load_robot()
    drop = rehearse(SCHEDULE, filed, drawn_truth(filed, SEED), hex_path=hex_path, faults=(fault,))
    assert (drop.refused is not None) == (fault.outcome is Outcome.NOT_DROPPED)
    if drop.refused is None:
        ended = [None if one.sequencer is None else one.sequencer.state for one in (found.drop, drop)]
        assert ended[0] is ended[1]
        angles = [np.rad2deg(one.truth[-1, 1:4] - one.truth[0, 1:4]) for one in (found.drop, drop)]
        assert angles[0] == pytest.approx(angles[1], abs=BACKLASH_DEG)


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


def test_a_moment_that_does_not_exist(tfsat_host: RunCli) -> None:
    refused = tfsat_host("rehearse", "59", "70", "--fault", "gyro-dead@dawn", expect=2)
    assert "There is no moment 'dawn'" in refused.stderr
    assert "gyro-dead@ and one of powered, uploaded" in refused.stderr


def test_a_fault_in_the_command(tfsat_host: RunCli) -> None:
    flown = tfsat_host.json("rehearse", "59", "70", "--fault", "servo-dead", expect=3)
    assert [fault["name"] for fault in flown["faults"]] == ["servo-dead"]
    assert flown["preflight"] == "go"
    assert any("did not move" in reason for reason in flown["evaluation"]["reasons"])


def test_a_robot_that_is_still_armed_is_called_so(tfsat_host: RunCli) -> None:
    shown = tfsat_host("rehearse", "59", "70", "--fault", "switch-stuck-closed", expect=3).stdout
    assert "The sequencer:        armed" in shown
    assert "STILL ARMED" in shown
    assert "tfsat-host disarm" in shown


def test_a_preflight_that_says_no(tfsat_host: RunCli) -> None:
    """Nobody drops then; what an older rehearsal left in the folder goes; and it can be dropped all the same."""
    tfsat_host("rehearse", "59", "70", "--out", "run")
    refused = tfsat_host("rehearse", "59", "70", "--fault", "gyro-dead@powered", "--out", "run", expect=4)
    assert "Preflight:            NO-GO: gyros-present." in refused.stdout
    assert "Nothing was dropped:" in refused.stdout
    assert "--despite-preflight" in refused.stdout
    folder = tfsat_host.folder / "run"
    assert not {path.name for path in folder.iterdir()} & {"SD.bin", "SD.csv", "truth.csv", "report.html"}
    written = json.loads((folder / "preflight.json").read_text())
    assert written["reasons"] == ["gyros-present"]
    # A card that somebody copied there afterwards is no rehearsal's.
    (folder / "SD.bin").write_bytes(b"of a real drop")
    again = tfsat_host("rehearse", "59", "70", "--out", "run", expect=2)
    assert "SD.bin is not as the rehearsal made it" in again.stderr
    assert (folder / "SD.bin").read_bytes() == b"of a real drop"
    (folder / "SD.bin").unlink()
    all_the_same = ("--fault", "gyro-dead@powered", "--despite-preflight", "--out", "run")
    dropped = tfsat_host.json("rehearse", "59", "70", *all_the_same, expect=3)
    assert dropped["no_go"] == ["gyros-present"]
    assert (folder / "SD.bin").exists()
