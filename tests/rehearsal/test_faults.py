"""Every fault: the preflight sees it, the robot does what is designed and keeps its record, and it is noticed."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.rehearsal import days
from tests.rehearsal.days import SCHEDULE, SEED, Days, fly_day, turned_deg
from tests.rehearsal.faults_page import MISMATCHES, PAGE, diagnosis, row
from tests.run.bundle.commands import command, result
from tfsat_host.emulated.build import sequencer_hex
from tfsat_host.emulated.emulated_robot import US_PER_S
from tfsat_host.errors import UsageError
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.rehearsal import series
from tfsat_host.rehearsal.faults import fault_catalog
from tfsat_host.rehearsal.faults.card_faults import cut_power
from tfsat_host.rehearsal.faults.fault import (
    AT,
    GUARD_US,
    Fault,
    Moment,
    Outcome,
    at_any_moment,
    between,
    words_of,
)
from tfsat_host.rehearsal.faults.fault_catalog import FAULTS, GROUPS, fault_named
from tfsat_host.rehearsal.judgement import outcome_reached
from tfsat_host.rehearsal.rehearsed_drop import rehearse
from tfsat_host.rehearsal.series import decode_drop
from tfsat_host.rehearsal.truth import drawn_truth
from tfsat_host.robot import load_robot

# The same day without a fault: what is reported there is not the fault's.
SOUND = Fault("none", "Nothing goes wrong.", Moment.POWERED, at_any_moment(Outcome.FLIES), preflight=())
FAULT_IDS: Any = {
    "ids": lambda parameter: parameter.name if isinstance(parameter, Fault) else parameter.typed
}
SLOW = "calibration-of-another-robot"
"""Its fit takes long to settle."""


RELEASE_FAULTS, BOARD_FAULTS = GROUPS["release"], GROUPS["board"]
POWER_CUTS = [fault for fault in FAULTS if fault.part == "power of both boards"]
# One wrong in the model and one in a sensor; `make prove` takes the others.
QUICK_MISMATCHES = {"wrong-masses", "gyro-bias-step"}


def each(faults: Sequence[Fault], *sample: str) -> pytest.MarkDecorator:
    """Parametrize a test by these faults, running only a sample outside `make prove`.

    The sample is by default all but the slow one and most mismatches.
    """
    late = {SLOW, *(fault.name for fault in MISMATCHES)} - QUICK_MISMATCHES
    chosen = sample or [fault.name for fault in faults if fault.name not in late]
    marks = [() if fault.name in chosen else pytest.mark.prove for fault in faults]
    params = [pytest.param(fault, marks=mark) for fault, mark in zip(faults, marks, strict=True)]
    return pytest.mark.parametrize("fault", params, **FAULT_IDS)


EACH = each(FAULTS)
PAIRS = [(fault, moment) for fault in FAULTS for moment in Moment]
POSSIBLE = [
    (fault, moment) for fault, moment in PAIRS if moment in fault.outcomes and moment is not fault.moment
]
"""Each fault's own moment is rehearsed in any case."""
OTHER_MOMENTS = 8
STEPS_US = range(-100_000, 101_000, 40_000)
BACKLASH_DEG = 1.0
"""Within it a joint comes to rest on either side, as the last microsecond of a pulse has it."""
LATE_S = 0.2
"""Of the samples before a power cut so much may still be on its way to the card."""
NoGoOf = Callable[[Fault], tuple[str, ...]]


@each([fault for fault in FAULTS if fault.preflight is not None])
def test_what_the_preflight_finds(no_go: NoGoOf, fault: Fault) -> None:
    assert no_go(fault) == fault.preflight


def test_the_preflight_finds_the_calibration_of_another_robot() -> None:
    fault = fault_named(SLOW)
    assert days.no_go(fault) == fault.preflight


@EACH
def test_what_the_robot_then_does(day_of: Days, fault: Fault) -> None:
    day = day_of(fault)
    assert day.refused == (fault.outcome is Outcome.NOT_DROPPED)
    assert (day.moved_deg > 15.0) == (fault.outcome in (Outcome.FLIES, Outcome.STOPS))
    others = set(day.came) - {fault.outcome}
    # One that stops may have flown what came before.
    assert fault.outcome in day.came
    assert others <= {Outcome.FLIES} and (not others or fault.outcome is Outcome.STOPS)


@EACH
def test_what_it_keeps_and_who_notices(day_of: Days, fault: Fault) -> None:
    day = day_of(fault)
    if day.log is not None:
        assert day.log.samples_lost == 0
        assert (day.log.verdict != "truncated") == fault.complete
    words = " ".join(day.screens.values())
    assert fault.noticed in words
    # A fault that nothing reports must leave a result that is right.
    if not fault.noticed:
        assert "checks passed, no samples lost" in words
        assert not day.no_go


def test_words_of_a_fault_are_not_given_without_it(day_of: Days) -> None:
    words = " ".join(day_of(SOUND).screens.values())
    assert "checks passed, no samples lost" in words
    # Words that also stand on a sound day's screens would prove nothing.
    assert [fault.name for fault in FAULTS if fault.noticed and fault.noticed in words] == []
    assert day_of(SOUND).no_go == ()


@pytest.mark.parametrize(
    "name", ["sequencer-clock-fast", "watchdog-while-falling", "servo-dead", "servo-slow"]
)
def test_what_servos_and_clocks_do_is_no_other_maneuver(day_of: Days, name: str) -> None:
    checks = day_of(fault_named(name)).checks
    assert [checks[check_name]["verdict"] for check_name in ("maneuver as filed", "start pose")] == [
        "passed",
        "passed",
    ]


def test_a_start_pose_that_is_wrong_is_named(day_of: Days) -> None:
    """Name a wrong start pose in the verdict.

    A reversed servo holds its joint on the other side of the pulse's middle before the first stroke.
    """
    day = day_of(fault_named("servo-reversed"))
    (reason,) = [sentence for sentence in day.reasons if "Wrong start pose" in sentence]
    assert "joint 1 stood at +" in reason and "instead of 0 ± 10 deg" in reason
    pose = day.checks["start pose"]
    assert pose["verdict"] == "failed" and pose["value"] > pose["threshold"] == 10.0
    assert pose["cause"].startswith("servo of joint 1: it turns the other way")
    assert day.checks["maneuver as filed"]["verdict"] == "passed"


@pytest.mark.parametrize(
    "offset_us",
    [
        step_us if step_us in (-60_000, 20_000) else pytest.param(step_us, marks=pytest.mark.prove)
        for step_us in STEPS_US
    ],
)
def test_power_cuts_around_the_landing(day_of: Days, offset_us: int) -> None:
    """Power cuts around the landing leave the samples already on the card readable.

    They equal those of the same drop without a cut.
    """
    full_log = day_of(SOUND).log
    drop = fly_day(
        replace(POWER_CUTS[0], action=partial(cut_power, after_us=GUARD_US + offset_us)), despite=False
    )
    log = decode_drop(drop)
    assert full_log is not None and full_log.release_us is not None and log.release_us is not None
    assert drop.landed_s is not None and drop.released_s is not None
    assert log.samples_lost == 0
    # Sample by sample: the cut must not change one that reached the card.
    assert np.array_equal(log.t_us - log.release_us, (full_log.t_us - full_log.release_us)[: len(log)])
    assert np.array_equal(log.imu_counts, full_log.imu_counts[: len(log)])
    cut_s = drop.landed_s - drop.released_s + offset_us / US_PER_S
    assert cut_s - LATE_S < log.seconds(int(log.t_us[-1])) <= cut_s


@each(
    [*RELEASE_FAULTS, *BOARD_FAULTS, *POWER_CUTS],
    "switch-stuck-open",
    "crane-jolt",
    "watchdog-while-falling",
    "brown-out-at-release",
)
def test_the_flashed_image_does_the_same(day_of: Days, fault: Fault) -> None:
    """Flashed image behaves the same as the native core.

    It is the AVR's own code, watchdog, brown-out and EEPROM, in an emulated ATmega32U4.
    """
    day, filed = day_of(fault), load_robot()
    drop = rehearse(SCHEDULE, filed, drawn_truth(filed, SEED), hex_path=sequencer_hex(), faults=(fault,))
    assert (drop.refused is not None) == (fault.outcome is Outcome.NOT_DROPPED)
    if drop.refused is None:
        assert (None if drop.sequencer is None else drop.sequencer.state) is day.state
        assert turned_deg(drop) == pytest.approx(day.turned_deg, abs=BACKLASH_DEG)


@EACH
def test_the_page_has_the_fault_as_it_was_rehearsed(day_of: Days, no_go: NoGoOf, fault: Fault) -> None:
    assert row(fault, day_of(fault), no_go) in PAGE.read_text(), "python -m tests.rehearsal.faults_page"


@pytest.mark.parametrize("fault", MISMATCHES, **FAULT_IDS)
def test_the_page_has_what_an_evaluation_makes_of_it(day_of: Days, fault: Fault) -> None:
    assert diagnosis(fault, day_of(fault)) in PAGE.read_text(), "python -m tests.rehearsal.faults_page"


def test_the_page_has_these_faults() -> None:
    names = [line.split("`")[1] for line in PAGE.read_text().splitlines() if line.startswith("| `")]
    assert names == [fault.name for fault in (*FAULTS, *MISMATCHES)]


def test_what_cannot_be_is_a_usage_error_that_names_what_can() -> None:
    for fault, moment in PAIRS:
        fault_text = f"{fault.name}{AT}{moment.typed}"
        if moment in fault.outcomes:
            assert fault_named(fault_text).moment is moment
            continue
        with pytest.raises(UsageError) as refused:
            fault_named(fault_text)
        assert fault.what in str(refused.value)
        words = refused.value.next_step.replace(fault.name, "").replace(",", " ").replace(".", " ").split()
        assert {moment.typed for moment in Moment} & set(words) == {moment.typed for moment in fault.outcomes}


@pytest.mark.parametrize(
    ("fault", "moment"),
    [
        # Drawn with a fixed seed: the same days for everybody.
        pytest.param(*pair, marks=() if number < 3 else pytest.mark.prove)
        for number, pair in enumerate(random.Random(7).sample(POSSIBLE, OTHER_MOMENTS))
    ],
    **FAULT_IDS,
)
def test_a_day_with_a_fault_at_another_moment(fault: Fault, moment: Moment) -> None:
    drop = fly_day(fault.at(moment), despite=True)
    outcome = fault.outcomes[moment]
    assert (drop.refused is not None) == (outcome is Outcome.NOT_DROPPED)
    if outcome is Outcome.FLIES:
        assert drop.sequencer is not None and drop.sequencer.state is SequencerState.DONE
    if outcome is not Outcome.NOT_DROPPED:
        assert outcome_reached(outcome, drop) is True


def test_the_list_has_moments_outcomes_and_sizes(tfsat_host: RunCli) -> None:
    listed = {fault["name"]: fault for fault in tfsat_host.json("rehearse", "--list-faults")["faults"]}
    assert list(listed) == [fault.name for fault in FAULTS]
    text = tfsat_host("rehearse", "--list-faults").stdout
    assert all(fault.name in text for fault in FAULTS)
    assert listed["gyro-dead"]["moments"] == {moment.typed: "flies the maneuver" for moment in Moment}
    assert listed["host-crash-in-upload"]["moments"] == {"powered": "flies the maneuver"}
    for name in ("sequencer-clock-fast", "logger-clock-fast", "servo-dead"):  # of no matter after the landing
        assert not {"landing", "landed"} & set(listed[name]["moments"])
    assert listed["switch-stuck-open"]["moments"]["recording"] == "is not dropped"
    assert listed["switch-stuck-open"]["moments"]["armed"] == "flies the maneuver"
    assert (listed["gyro-dead"]["size"], listed["gyro-dead"]["unit"]) == (None, None)
    assert (listed["imu-late"]["size"], listed["imu-late"]["unit"]) == (2.0, "ms") and " 2 ms " in text


def test_moments_in_words() -> None:
    assert words_of(tuple(Moment)) == "any moment"
    assert words_of(between(Moment.POWERED, Moment.RECORDING)) == "powered to recording"
    assert words_of((Moment.LANDED, Moment.ARMED)) == "armed, landed"


@pytest.mark.parametrize(
    ("fault_names", "words"),
    [
        (["gremlins"], ["There is no fault 'gremlins'", "--list-faults"]),
        (["gyro-dead@dawn"], ["There is no moment 'dawn'", "gyro-dead@ and one of powered, uploaded"]),
        (
            ["host-crash-in-upload@falling"],
            ["cannot be injected at falling (halfway through the fall)", "it is injected at powered"],
        ),
        (["servo-dead", "servo-reversed"], ["both are of the same part, servo of joint 1."]),
        (["card-full@checked", "card-missing@checked"], ["card-missing@checked cannot both", "part, card."]),
        (["gyro-dead", "gyro-dead@falling"], ["both are of the same part, IMU of body 4."]),
        (["power-cut-at-landing", "power-cut-after-landing"], ["same part, power of both boards."]),
        (["switch-bounce", "switch-bounce@armed"], ["the same fault at two moments"]),
        (["gyro-dead", "gyro-dead"], ["named twice"]),
        (["gyro-dead=2"], ["gyro-dead has no size: The IMU of body 4", "Write gyro-dead alone"]),
        (
            ["wrong-masses=-1"],
            ["'-1' is no size of wrong-masses: a number from 0 to 50, in %", "wrong-masses=2"],
        ),
        (["imu-late=99"], ["from 0 to 10, in ms", "imu-late=2"]),
        (["wrong-masses", "wrong-masses=1"], ["the same fault at two moments or of two sizes"]),
        (["certificate-wrong", SLOW], ["both are of the same part, calibration"]),
    ],
)
@pytest.mark.parametrize("extra_options", [(), ("--runs", "2")])
def test_faults_that_cannot_be_are_refused_before_anything_is_flown(
    tfsat_host: RunCli, fault_names: list[str], words: list[str], extra_options: tuple[str, ...]
) -> None:
    options = [word for name in fault_names for word in ("--fault", name)]
    refused = tfsat_host("rehearse", "59", "70", *options, *extra_options, expect=2).stderr
    assert all(word in refused for word in words)
    assert not (tfsat_host.folder / "run").exists()


@pytest.fixture
def wrong_catalog(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Change the catalog to demand, wrongly, that a jolt keeps the robot from flying."""
    # A jolt must not keep the robot from flying: this demand is missed on purpose.
    demands = at_any_moment(Outcome.STANDS_STILL)
    wrong = [replace(fault, outcomes=demands) if fault.name == "crane-jolt" else fault for fault in FAULTS]
    monkeypatch.setattr(fault_catalog, "FAULTS", tuple(wrong))
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("wrong_catalog")
def test_a_robot_that_does_not_do_what_it_must_is_called_so() -> None:
    text = command("rehearse", "59", "70", "--fault", "crane-jolt", "--out", "run", expect=3).out
    words = " ".join(text.split())
    assert "moves no joint Actual outcome: NOT as expected: largest motion joint 1 59." in words
    # The drop itself is good: what is wrong is the robot's behaviour, said last.
    assert words.startswith("GOOD:") and words.endswith("Outcome with these faults: NOT as expected")


@pytest.mark.usefixtures("wrong_catalog")
def test_a_series_names_the_drops_that_do_not_do_what_they_must(monkeypatch: pytest.MonkeyPatch) -> None:
    def here(many: series.Series, runs: int, **_: Any) -> tuple[series.RehearsedDrop, ...]:
        """Fly the series in this process: worker processes do not see the patched fault."""
        return tuple(series.fly(many, number) for number in range(1, runs + 1))

    monkeypatch.setattr(series, "fly_many", here)
    output = command(
        "rehearse", "59", "70", "--fault", "crane-jolt", "--runs", "2", "--out", "many", expect=3
    )
    assert "2 good" in output.out
    assert "NOT as expected with these faults (truth): drop 1, 2" in output.out


def test_a_preflight_that_gives_no_go(run: Path) -> None:
    """Nothing is dropped then; what an older rehearsal left in the folder goes; and it can be dropped all the same."""
    arguments = ("rehearse", "59", "70", "--fault", "gyro-dead@powered", "--out", "run")
    refused = command(*arguments, expect=4).out
    assert "NO-GO: gyros-present (" in refused
    assert "Actual outcome:   not dropped" in refused and "--despite-preflight" in refused
    # A recording of the rehearsal before would pass for this one's.
    assert not {path.name for path in run.iterdir()} & {"SD.bin", "SD.csv", "truth.csv", "report.html"}
    dropped = result(*arguments, "--despite-preflight", expect=3)
    assert dropped["no_go"] == ["gyros-present"]
    assert (run / "SD.bin").exists()
