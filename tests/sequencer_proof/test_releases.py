"""Short forms of the release campaigns, and defects that they must find."""

from __future__ import annotations

import pytest

from tests.emulator_avr.building import Edit
from tests.sequencer.board import build_board_library
from tests.sequencer_proof.conftest import Plant
from tests.sequencer_proof.contacts import Chatter, Contact, admissible
from tests.sequencer_proof.dating import dated_releases, judge_dates
from tests.sequencer_proof.releases import avr_releases, judge, native_releases
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import CYCLES_PER_TICK, Broken
from tests.sequencer_proof.waiting import knocks, long_wait
from tfsat_host.maneuver import four_stroke, schedule_maneuver

DATED_SEED, DATED = 1, 2_500
"""Two switches that move within one interrupt are among these."""
SCHEDULED = "released_at + ticks_from_us(stroke.start_us)"


def test_native_releases_are_on_time(tmp_path_factory: pytest.TempPathFactory) -> None:
    library = build_board_library(tmp_path_factory.mktemp("native"))
    releases = native_releases(library, seed=1, count=300)
    judge(releases)
    assert max(abs(error) for release in releases for error in release.errors) <= CYCLES_PER_TICK
    assert max(release.contact_edges for release in releases) > 30


def test_releases_of_the_image_are_on_time(bench: Bench) -> None:
    found = avr_releases(bench, Chatter.SLOW, seed=1, count=10)
    judge(found.releases)
    errors = [error for release in found.releases for error in release.errors]
    assert max(map(abs, errors)) <= CYCLES_PER_TICK
    assert len(set(errors)) > 2  # the release falls anywhere in the timer's tick
    wanted = schedule_maneuver(four_stroke(59, 70))
    assert found.plan.strokes == tuple((s.joint, s.angle_cdeg, s.t_us) for s in wanted.strokes)


def test_releases_with_fast_chatter_are_on_time(bench: Bench) -> None:
    judge(avr_releases(bench, Chatter.BOTH, seed=1, count=40).releases)


@pytest.mark.parametrize("chatter", [Chatter.BOTH, Chatter.FAST])
def test_releases_with_fast_chatter_are_dated_wrong_but_rarely(bench: Bench, chatter: Chatter) -> None:
    judge_dates(dated_releases(bench, chatter, seed=DATED_SEED, count=DATED), chatter)


@pytest.mark.prove
def test_a_switch_that_fast_chatter_blinds_is_found(plant: Plant) -> None:
    capture = "src/drivers/release_capture.cpp"
    blind = plant(Edit(capture, "seen = open_now();", "seen = levels;"))
    with pytest.raises(Broken, match=r"us off its time|knocks"):
        judge(avr_releases(blind, Chatter.FAST, seed=1, count=20).releases)


@pytest.mark.prove
def test_own_onsets_that_are_not_the_pins_are_found(plant: Plant) -> None:
    hopeful = plant(
        Edit(
            "src/core/sequencer.cpp",
            "us_from_ticks(servos_.change_began_at(i) - released_at_)",
            "us_from_ticks(servos_.change_began_at(i) - released_at_ + 3)",
        )
    )
    with pytest.raises(Broken, match="RUN_REPORT says"):
        avr_releases(hopeful, Chatter.SLOW, seed=1, count=1)


@pytest.mark.prove
def test_the_same_seed_gives_the_same_figures(bench: Bench) -> None:
    assert avr_releases(bench, Chatter.SLOW, seed=2, count=2) == avr_releases(
        bench, Chatter.SLOW, seed=2, count=2
    )


@pytest.mark.prove
def test_a_schedule_60_us_late_is_found(plant: Plant) -> None:
    late = plant(
        Edit("src/core/sequencer.cpp", SCHEDULED, "released_at + ticks_from_us(stroke.start_us + 60)")
    )
    with pytest.raises(Broken, match=r"a stroke began 60(\.\d+)? us off|59\.\d+ us off"):
        judge(avr_releases(late, Chatter.SLOW, seed=1, count=1).releases)


@pytest.mark.prove
def test_a_pulse_cut_short_is_found(plant: Plant) -> None:
    short = plant(
        Edit(
            "src/drivers/timer1_servos.cpp",
            "set_edge(channel, c.pulse.rise + c.pulse.width_ticks, false)",
            "set_edge(channel, c.pulse.rise + c.pulse.width_ticks - (c.pulse.change != nullptr ? 2 : 0), false)",
        )
    )
    with pytest.raises(Broken, match="pulse widths in order"):
        avr_releases(short, Chatter.SLOW, seed=1, count=1)


def test_waiting_changes_nothing(bench: Bench) -> None:
    wait = long_wait(bench, seed=1, waited_us=45_000_000)
    judge([wait.release])
    assert wait.pulses >= 3 * 50 * 20


def test_knocks_start_nothing(bench: Bench) -> None:
    found = knocks(bench, seed=2, count=16)
    assert min(found.one_switch, found.both_switches) > 3
    judge([found.release])


@pytest.mark.prove
def test_a_release_by_one_switch_is_found(plant: Plant) -> None:
    eager = plant(
        Edit(
            "src/core/release_detector.cpp",
            "if (open_ == kBoth) return judge_open",
            "if (open_ != 0) return judge_open",
        )
    )
    with pytest.raises(Broken, match="knocks"):
        knocks(eager, seed=2, count=3)


def test_releases_are_dated_by_the_first_edge_at_which_both_were_open(bench: Bench) -> None:
    dated = dated_releases(bench, Chatter.SLOW, seed=DATED_SEED, count=DATED)
    judge_dates(dated, Chatter.SLOW)
    assert sum(abs(one.error_us) <= 1.0 for one in dated) > 0.999 * len(dated)
    assert all(abs(one.error_us) <= 50.0 for one in dated)


@pytest.mark.prove
def test_edges_in_the_order_of_their_interrupts_are_found(plant: Plant) -> None:
    unsorted = plant(
        Edit(
            "src/drivers/release_capture.cpp",
            "static_cast<int16_t>(second - first) < 0",
            "false",
        )
    )
    with pytest.raises(Broken, match="dated wrong"):
        judge_dates(dated_releases(unsorted, Chatter.SLOW, seed=DATED_SEED, count=DATED), Chatter.SLOW)


def test_edges_within_a_microsecond_leave_two_dates() -> None:
    swap = [Contact(0, 0, False), Contact(1000, 0, True), Contact(1008, 1, False), Contact(5000, 0, False)]
    assert admissible(swap) == [1008, 5000]
    blip = [Contact(0, 0, False), Contact(1000, 1, False), Contact(1015, 0, True), Contact(5000, 0, False)]
    assert admissible(blip) == [1000, 5000]
    apart = [Contact(0, 0, False), Contact(1000, 0, True), Contact(1017, 1, False), Contact(5000, 0, False)]
    assert admissible(apart) == [5000]
