"""The committed report is of the image that is built; it says what was found; the budgets of size hold."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from tests.emulator_avr.avr_board import PinHold, ResetCause
from tests.emulator_avr.building import REPOSITORY
from tests.proof.campaign import Broken
from tests.sequencer_proof.campaigns import Proof, judge_all, judge_stack
from tests.sequencer_proof.contacts import Chatter
from tests.sequencer_proof.damage import Case, Damaged, DamagedImage, Place
from tests.sequencer_proof.dating import Dated
from tests.sequencer_proof.held_pins import HeldPins
from tests.sequencer_proof.jolts import ClosedAgain, Jolted
from tests.sequencer_proof.link_abuse import Abuse, Abused
from tests.sequencer_proof.noise import Noise, Noisy
from tests.sequencer_proof.one_rule import Agreement
from tests.sequencer_proof.power_cuts import Cuts, History, Record
from tests.sequencer_proof.releases import AvrReleases, Plan, Release, avr_releases
from tests.sequencer_proof.report import Tools, hex_sha256, render
from tests.sequencer_proof.resets import Hangs, Moment, Resets
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import Extremes
from tests.sequencer_proof.waiting import LONG_WAIT_US, Knocks, Wait
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.servo_settings import FACTORY

REPORT = REPOSITORY / "docs" / "sequencer-proof.md"
RELEASE = Release((-3, 0, 5, 16), Extremes(16_000, 28_448), Extremes(315_000, 322_000), 12)
FAST_RELEASE = replace(RELEASE, errors=(-64, 320, 320, 320))
STROKES = ((1, 5900, 700_000), (2, 7000, 1_050_000), (1, -5900, 1_470_000), (2, -7000, 1_820_000))
PROOF = Proof(
    waits=[Wait(LONG_WAIT_US, 675_000, RELEASE)],
    native=[[RELEASE]],
    avr=[AvrReleases(Plan(STROKES, 2_231_765, FACTORY), [RELEASE, RELEASE], 600)],
    fast=[AvrReleases(Plan(STROKES, 2_231_765, FACTORY), [FAST_RELEASE], 610)],
    dated=[[Dated(0.5, False), Dated(-1.5, True), Dated(42.0, False)]],
    fast_dated=[[Dated(0.5, False), Dated(0.0, False)]],
    fastest_dated=[[Dated(0.5, False), Dated(21.0, True)]],
    jolted=[[Jolted(0, 12.0, 0), Jolted(2, -3_500.0, 4_100)]],
    closed=[ClosedAgain(25, 25, [RELEASE])],
    rule=[Agreement(1_000, 600, 300, 50)],
    knocks=[Knocks(3, 4, FAST_RELEASE)],
    cuts=[Cuts(Record.MANEUVER, History.ERASED, 22, 22, stored_afterwards=22, never_used=590)],
    damaged=[Damaged(Case.ONE, Counter({Place.MARKER: 7}), Counter({Place.MARKER: 7}))],
    damaged_image=[DamagedImage(Case.ONE, 11)],
    rewrites=[8, 0],
    abused=[Abused(Abuse.PULLED, 251, 0, 580)],
    noisy=[Noisy(Noise.BYTES, drops=1, never_used=570)],
    resets=[Resets(Moment.ARMED, ResetCause.BROWN_OUT, 25, Extremes(100, 200), Extremes(-8, 4))],
    held=[HeldPins((1, 3), PinHold.LOW, 20, on_time=30, late=3, missed=7, extra_marks=2)],
    hangs=[Hangs(SequencerState.SAFE, 10, Extremes(1_020_000, 1_024_000))],
)


def test_the_report_is_of_the_image_that_is_built(bench: Bench) -> None:
    named = f"`{hex_sha256(bench.image)}`" in REPORT.read_text()
    assert named, "docs/sequencer-proof.md is of another image. Run: make sequencer-report"


def test_the_report_names_no_machine() -> None:
    text = REPORT.read_text()
    assert str(Path.home()) not in text
    assert "/tmp" not in text


def test_a_report_tells_its_campaigns_figures(bench: Bench) -> None:
    text = render(PROOF, bench.image, Tools("5.4.0", "1.6"))
    assert "| 4 | 2 | -70 deg | 1820000 | 1820001 | 1820001 | 1820001 | +1 |" in text
    assert "| off by 1 to 50 µs | 2 | 0 | 1 |" in text and "| worst | 42.0 µs | 0.5 µs | 21.0 µs |" in text
    assert "| an edge of servo 1 | `__vector_17` |" in text
    assert "| 1 or more, the edges fit two: an interval is told | 1 | 3.500 ms | 3.500 ms | 4.1 ms |" in text
    assert "| after a stroke | 25 | FAULT" in text and "the same 1000 random edge trains" in text
    assert "| stack never touched | 570 | at least 512 |" in text
    assert (
        "| armed, cable pulled, 75.0 min after power-up | 2 turns of the clock; 675000 pulses held |" in text
    )
    assert f"| {Abuse.PULLED.value} | 251 | 0 |" in text
    assert "| D9, D11 | low | 20 | 30 | 3 | 7 | 2 |" in text
    assert f"`{hex_sha256(bench.image)}`" in text
    assert f"| {Case.ONE.value} | {Place.MARKER.value} | 7 | 7 | 0 | 0 | 0 |" in text
    assert "the same answers to 11 of these" in text


def test_a_proof_with_a_late_stroke_or_a_rewritten_byte_is_none(bench: Bench) -> None:
    judge_all(PROOF, bench.image)
    late = replace(RELEASE, errors=(0, 0, 0, 801))
    with pytest.raises(Broken, match=r"50\.0625 us off"):
        judge_all(replace(PROOF, native=[[late]]), bench.image)
    with pytest.raises(Broken, match="wrote"):
        judge_all(replace(PROOF, rewrites=[8, 1]), bench.image)


def test_the_stack_leaves_its_spare(bench: Bench) -> None:
    judge_stack(avr_releases(bench, Chatter.SLOW, seed=9, count=1).never_used, bench.image)
    with pytest.raises(Broken, match="only 511 bytes of stack"):
        judge_stack(511, bench.image)
