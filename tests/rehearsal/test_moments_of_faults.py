"""Each fault can be at some moments of the day and not at others; and at each it does what is said of it."""

from __future__ import annotations

import random

import pytest

from tests.cli.process import RunCli
from tests.rehearsal.faults_seen import flown
from tfsat_host.errors import UsageError
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.rehearsal.faults.fault import AT, Fault, Outcome
from tfsat_host.rehearsal.faults.known import FAULTS, fault_named
from tfsat_host.rehearsal.moment import Moment, between, words_of
from tfsat_host.rehearsal.outcome import came_of

FLOWN = 10
PAIRS = [(fault, moment) for fault in FAULTS for moment in Moment]
POSSIBLE = [
    (fault, moment) for fault, moment in PAIRS if moment in fault.outcomes and moment is not fault.moment
]
"""The own moments are flown by test_faults.py."""


def test_what_cannot_be_is_a_usage_error_that_names_what_can() -> None:
    for fault, moment in PAIRS:
        typed = f"{fault.name}{AT}{moment.typed}"
        if moment in fault.outcomes:
            assert fault_named(typed).moment is moment
            continue
        with pytest.raises(UsageError) as refused:
            fault_named(typed)
        assert fault.what in str(refused.value)
        named = refused.value.next_step.replace(fault.name, "").replace(",", " ").replace(".", " ").split()
        assert {one.typed for one in Moment} & set(named) == {one.typed for one in fault.outcomes}


@pytest.mark.parametrize(
    ("fault", "moment"),
    random.Random(7).sample(POSSIBLE, FLOWN),
    ids=lambda one: one.name if isinstance(one, Fault) else one.typed,
)
def test_a_day_with_a_fault_at_another_moment(fault: Fault, moment: Moment) -> None:
    drop = flown(fault.at(moment), despite=True)
    outcome = fault.outcomes[moment]
    assert (drop.refused is not None) == (outcome is Outcome.NOT_DROPPED)
    if outcome is Outcome.FLIES:
        assert drop.sequencer is not None
        assert drop.sequencer.state is SequencerState.DONE
    if outcome is not Outcome.NOT_DROPPED:
        assert came_of(outcome, drop) is True


@pytest.mark.parametrize("more", [(), ("--runs", "2")])
def test_the_command_refuses_before_anything_is_flown(tfsat_host: RunCli, more: tuple[str, ...]) -> None:
    refused = tfsat_host("rehearse", "59", "70", "--fault", "host-crash-in-upload@falling", *more, expect=2)
    assert "host-crash-in-upload cannot strike at falling (halfway through the fall)" in refused.stderr
    assert "it strikes at powered" in refused.stderr
    assert not (tfsat_host.folder / "run").exists()


def test_the_list_says_when(tfsat_host: RunCli) -> None:
    listed = {one["name"]: one for one in tfsat_host.json("rehearse", "--list-faults")["faults"]}
    assert listed["gyro-dead"]["moments"] == {moment.typed: "flies the maneuver" for moment in Moment}
    assert listed["host-crash-in-upload"]["moments"] == {"powered": "flies the maneuver"}
    for name in (
        "sequencer-clock-fast",
        "logger-clock-fast",
        "servo-dead",
    ):  # after the landing nobody reads them
        assert not {"landing", "landed"} & set(listed[name]["moments"])
    assert listed["switch-stuck-open"]["moments"]["recording"] == "is not dropped"
    assert listed["switch-stuck-open"]["moments"]["armed"] == "flies the maneuver"
    assert words_of(tuple(Moment)) == "any moment"
    assert words_of(between(Moment.POWERED, Moment.RECORDING)) == "powered to recording"
    assert words_of((Moment.LANDED, Moment.ARMED)) == "armed, landed"
