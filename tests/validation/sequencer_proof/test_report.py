"""Tables have their campaigns' figures; the stack keeps its spare."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.fixtures.sequencer.board import PinHold, ResetCause
from tests.paths import DOCS
from tests.validation.campaign import Broken, Campaign, run_campaigns
from tests.validation.provenance import SHA256_ROW, hash_image, read_provenance
from tests.validation.sequencer_proof.bench import Bench
from tests.validation.sequencer_proof.blocking import path_rows
from tests.validation.sequencer_proof.campaigns import FAST_BEYOND, campaigns, judge_stack
from tests.validation.sequencer_proof.contacts import Chatter
from tests.validation.sequencer_proof.damage import Case, Damaged, DamagedImage, Place
from tests.validation.sequencer_proof.half_transfers import HOSTS_US, Disturbed, judge_disturbed
from tests.validation.sequencer_proof.held_pins import HeldPins
from tests.validation.sequencer_proof.jog_lives import Lives
from tests.validation.sequencer_proof.jolts import ClosedAgain, Jolted
from tests.validation.sequencer_proof.link import Abuse, Abused, Noise, Noisy
from tests.validation.sequencer_proof.one_closed import OneClosed
from tests.validation.sequencer_proof.one_rule import Agreement
from tests.validation.sequencer_proof.power_cuts import Cuts, History, Record, second_upload_writes
from tests.validation.sequencer_proof.releases import Dated, Flights, Plan, Release, avr_releases, judge
from tests.validation.sequencer_proof.resets import Hangs, Moment, Resets
from tests.validation.sequencer_proof.results import describe_image, make_tables
from tests.validation.sequencer_proof.signals import Extremes
from tests.validation.sequencer_proof.waiting import Knocks, Wait
from tests.validation.tables import read_rows, results_csv
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.servo_settings import FACTORY

FOLDER = DOCS / "sequencer-proof"
RELEASE = Release((-3, 0, 5, 16), Extremes(16_000, 28_448), Extremes(315_000, 322_000), 12)
LATE = RELEASE._replace(errors=(0, 0, 0, 801))
STROKES = ((1, 5900, 700_000), (2, 7000, 1_050_000), (1, -5900, 1_470_000), (2, -7000, 1_820_000))
TOGETHER_STROKES = (*STROKES[:3], (2, -7000, STROKES[2][2]))
FLIGHTS = Flights(Plan(STROKES, 2_231_765, FACTORY), [RELEASE, RELEASE], 600)
OFF_US = Extremes(-0.125, 0.25)
FOUND: dict[str, Sequence[Any]] = {
    "waits": [Wait(75.0, 2, 2, 675_000, OFF_US)],
    "native": [FLIGHTS],
    "avr": [FLIGHTS],
    "fast": [FLIGHTS._replace(never_used=590)],
    "dated": [Dated(0.5, False), Dated(-1.5, True), Dated(42.0, False)],
    "fast_dated": [Dated(0.5, False), Dated(0.0, False)],
    "fastest_dated": [Dated(0.5, False), Dated(21.0, True)],
    "jolted": [Jolted(0, 12.0, 0), Jolted(1, 40.0, 0), Jolted(2, -3_500.0, 4_100)],
    "disturbed": [
        Disturbed(every_us, together, error_us, 500, 4_000)
        for every_us in HOSTS_US
        for together, error_us in ((True, 0.5), (False, 312.0))
    ],
    "one_closed": [
        OneClosed(0, 500, 400, 0.5, 0, 0),
        OneClosed(1, 500, 20_000, 20_500, 20_500, 0),
        OneClosed(2, 500, 90_000, 90_500, 0, 0),
    ],
    "closed": [ClosedAgain(25, 25, [RELEASE])],
    "rule": [Agreement(1_000, 600, 300, 50)],
    "knocks": [Knocks(3, 4, OFF_US)],
    "cuts": [Cuts(Record.MANEUVER, History.ERASED, 22, 22, stored_afterwards=22, never_used=590)],
    "damaged": [Damaged(Case.ONE, Counter({Place.MARKER: 7}), Counter({Place.MARKER: 6}))],
    "damaged_image": [DamagedImage(Case.ONE, 11)],
    "rewrites": [8, 0],
    "abused": [Abused(Abuse.PULLED, 251, 0, 580)],
    "noisy": [Noisy(Noise.BYTES, drops=1, never_used=570)],
    "resets": [Resets(Moment.ARMED, ResetCause.BROWN_OUT, 25, ErrorCode.NONE, Extremes(11, 24.5), OFF_US)],
    "held": [HeldPins((1, 3), PinHold.LOW, 20, on_time=30, late=3, missed=7, extra_marks=2)],
    "together": [FLIGHTS._replace(plan=Plan(TOGETHER_STROKES, 2_231_765, FACTORY))],
    "together_closed": [ClosedAgain(25, 25, [RELEASE])],
    "together_abused": [Abused(Abuse.PULLED, 42, 0, 580)],
    "together_resets": [
        Resets(Moment.ARMED, ResetCause.BROWN_OUT, 25, ErrorCode.NONE, Extremes(11, 24.5), OFF_US)
    ],
    "together_held": [HeldPins((1, 3), PinHold.LOW, 20, on_time=30, late=3, missed=7, extra_marks=2)],
    "jogs": [Lives(50, 1_500, 150, 300, 15_000), Lives(50, 1_400, 140, 290, 14_000)],
    "hangs": [Hangs(SequencerState.SAFE, 10, Extremes(1_020, 1_024))],
}


def test_tables_have_their_campaigns_figures(bench: Bench) -> None:
    declared = campaigns(bench, bench.image, Path("native"), Path("rule"))
    assert {campaign.name for campaign in declared} == set(FOUND)
    written = make_tables(FOUND, declared, bench.image)
    for name, row in {
        "signals": "slow,2,-0.1875 to 1,1000 to 1778,19.69 to 20.12",
        "dates": "slow,3,1,2,0,one in 10000,42.0,1",
        "targets": "stack never touched,570,512,,bytes,yes",
        "figures": "releases,false ones,50",
        "strokes": "slow,4,2,-70,1820000,1820001,1820001,1820001,1",
        "paths": "an edge of servo 1,__vector_17",
        "waits": "75,2,2,675000,-0.125 to 0.25",
        "damage": '"a maneuver, factory settings",a marker,7,6,0,0,0',
        "resets": '"armed, both switches closed",brown_out,25,none,11 to 24.5,-0.125 to 0.25',
        "held-pins": "1 3,low,20,30,3,7,2",
        "jolts": '"1 or more, the edges fit two: an interval is reported",1,3.500,3.500,4.1',
        "jog": "100,2900,290,590,29000",
        "one-closed": "61 to 400 ms,1,90.5,0,1",
        "half-transfers": "sound,3 ms,1,0,1,0.312,1,0",
        "link": "cable pulled,251,0",
        "campaigns": "held,14,9000,1",
    }.items():
        assert f"\n{row}" in written[f"{name}.csv"]
    for name, text in written.items():
        assert text.splitlines()[0] == (FOLDER / name).read_text().splitlines()[0], name
    for name, columns in (("figures.csv", 2), ("targets.csv", 1)):
        committed = csv.reader((FOLDER / name).read_text().splitlines())
        computed = csv.reader(written[name].splitlines())
        assert [row[:columns] for row in committed] == [row[:columns] for row in computed]


def test_what_the_image_is_stands_with_the_campaign(bench: Bench) -> None:
    described = describe_image(bench.image)
    assert re.fullmatch("[0-9a-f]{8}", str(described["CRC-32 of the image, in HELLO and STATUS"]))
    assert set(described) < set(read_provenance(FOLDER))


def test_rows_of_the_tables_are_found_again(bench: Bench) -> None:
    """Reproduce the rows of the tables in the image that was measured.

    Any other image keeps the bounds that test_campaigns.py holds it to.
    """
    paths, writes = (
        path_rows(bench.image.with_suffix(".elf")),
        [second_upload_writes(bench, record) for record in Record],
    )
    assert len(paths) > 10 and len(writes) == 2
    if read_provenance(FOLDER)[SHA256_ROW] == hash_image():
        assert results_csv(paths) == (FOLDER / "paths.csv").read_text()
        printed_counts = [
            value for figure, value in read_rows(FOLDER / "figures.csv", "power cuts") if "upload" in figure
        ]
        assert printed_counts == [str(count) for count in writes]


def test_a_late_stroke_is_found_in_each_flight_and_among_all_of_them(bench: Bench) -> None:
    judge([RELEASE])
    with pytest.raises(Broken, match=r"50\.0625 us off"):
        judge([LATE])
    two_late = [FLIGHTS._replace(releases=[LATE])] * (FAST_BEYOND + 1)
    declared = campaigns(bench, bench.image, Path("native"), Path("rule"))
    fast = next(campaign for campaign in declared if campaign.name == "fast")
    fast.judge(two_late[1:])
    with pytest.raises(Broken, match="off its time"):
        fast.judge(two_late)


def test_a_date_outside_of_its_interval_and_dates_off_too_often_are_found() -> None:
    dated = Disturbed(HOSTS_US[1], together=True, error_us=5.0, earlier_us=0, later_us=0)
    judge_disturbed([dated] * 400 + [dated._replace(error_us=60.0, earlier_us=20)])
    with pytest.raises(Broken, match="outside of what is reported"):
        judge_disturbed([dated._replace(error_us=60.0)])
    with pytest.raises(Broken, match="3 of 403 dates"):
        judge_disturbed([dated] * 400 + [dated._replace(error_us=60.0, earlier_us=20)] * 3)


def _seed_of(seed: int) -> list[int]:
    return [seed]


def test_a_campaign_runs_each_job_with_its_seed_and_judges_all_results() -> None:
    def judge_sum(results: Sequence[int]) -> None:
        if sum(results) != 15 + 18 + 21:
            raise Broken(f"{results}")

    campaign = Campaign("seeds", "their sum", [_seed_of] * 3, 15, 3, judge_sum)
    assert run_campaigns([campaign]) == {"seeds": [15, 18, 21]}
    with pytest.raises(Broken):
        run_campaigns([Campaign("seeds", "their sum", [_seed_of] * 2, 15, 3, judge_sum)])


def test_the_stack_leaves_its_spare(bench: Bench) -> None:
    never_used = avr_releases(bench, Chatter.SLOW, seed=9, count=1).never_used
    assert never_used is not None
    judge_stack(never_used, bench.image)
    with pytest.raises(Broken, match="only 511 bytes of stack"):
        judge_stack(511, bench.image)
