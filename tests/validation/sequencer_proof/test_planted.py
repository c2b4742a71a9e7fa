"""Defects planted in the sequencer's sources, and the campaign that must find each in the image."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.fixtures.planting import Edit
from tests.fixtures.sequencer.board import PinHold, ResetCause
from tests.fixtures.sequencer.building import BuildError, build_native_library
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench
from tests.validation.sequencer_proof.blocking import UnboundedError
from tests.validation.sequencer_proof.conftest import Plant
from tests.validation.sequencer_proof.contacts import Chatter
from tests.validation.sequencer_proof.damage import Case, damage_image
from tests.validation.sequencer_proof.half_transfers import EVERY_US, disturbed_releases, judge_disturbed
from tests.validation.sequencer_proof.held_pins import held_pins
from tests.validation.sequencer_proof.jog_lives import jog_lives
from tests.validation.sequencer_proof.jolts import closed_again, jolted_releases
from tests.validation.sequencer_proof.link import Abuse, Noise, abuse_link, make_noise
from tests.validation.sequencer_proof.power_cuts import History, Record, cut_points
from tests.validation.sequencer_proof.releases import avr_releases, dated_releases, judge_dates
from tests.validation.sequencer_proof.resets import HANG, Moment, hang_board, reset_board
from tests.validation.sequencer_proof.test_campaigns import DATED, DATED_SEED, assert_paths_are_short
from tests.validation.sequencer_proof.waiting import knocks
from tfsat_host.protocol.enums import SequencerState

pytestmark = pytest.mark.prove

SKETCH = "arduino_sequencer.ino"
SEQUENCER, SETTINGS = "src/core/sequencer.cpp", "src/core/settings.cpp"
DETECTOR, CAPTURE = "src/core/release_detector.cpp", "src/drivers/release_capture.cpp"
SERVOS, SLOTS = "src/drivers/timer1_servos.cpp", "src/core/slot_pair.cpp"
SCHEDULED = "released_at + ticks_from_us(stroke.start_us)"
BEGUN_BYTE = "complete_byte(position_) ^ kFlipToBegun"
TOLD_BEGUN = "begun > 0 ? Slot::kBegun : Slot::kDamaged"
RESTART = "  detector_.reset(now, retained_.knocks);\n  resume_after"
FIND_DEFECT = "int8_t Settings::find_defect() const {\n"
POLL = "  if (ready) host_link.poll();\n"
ONSET = "us_from_ticks(servos_.change_began_at(i) - released_at_{})"
FALL = "set_edge(channel, c.pulse.rise + c.pulse.width_ticks{}, false)"
HOLDS_OFF = (
    f"  noInterrupts();\n{POLL}  if (Serial.available() > 8) "
    "for (uint8_t i = 0; i < 3; ++i) delayMicroseconds(16000);\n  interrupts();\n"
)

Campaign = Callable[[Bench], object]


def check_dates(bench: Bench) -> None:
    judge_dates(dated_releases(bench, Chatter.SLOW, seed=DATED_SEED, count=DATED), Chatter.SLOW)


def release_campaign(chatter: Chatter = Chatter.SLOW, count: int = 1) -> Campaign:
    return lambda bench: avr_releases(bench, chatter, seed=1, count=count)


def cut(record: Record, history: History, sample: int) -> Campaign:
    return lambda bench: cut_points(bench, record, history, seed=1, sample=sample)


def reset(moment: Moment, cause: ResetCause, count: int = 1) -> Campaign:
    return lambda bench: reset_board(bench, moment, cause, count, seed=4)


def check_disturbed_dates(bench: Bench) -> None:
    judge_disturbed(disturbed_releases(bench, EVERY_US, seed=59, count=60))


def live_jogs(bench: Bench) -> None:
    jog_lives(bench, seed=0, count=24)


def noisy(bench: Bench) -> None:
    make_noise(bench, Noise.FRAMES, 600, drops=1, seed=3)


def abuse_campaign(abuse: Abuse) -> Campaign:
    return lambda bench: abuse_link(bench, abuse, [300_000, 307_000, 313_000], seed=1)


DEFECTS: dict[str, tuple[list[Edit], Campaign, str]] = {
    "a switch that fast chatter blinds": (
        [Edit(CAPTURE, "seen = open_now();", "seen = levels;")],
        release_campaign(Chatter.FAST, count=20),
        r"us off its time|knocks",
    ),
    "own onsets that are not the pins'": (
        [Edit(SEQUENCER, ONSET.format(""), ONSET.format(" + 3"))],
        release_campaign(),
        "RUN_REPORT says",
    ),
    "a schedule 60 us late": (
        [Edit(SEQUENCER, SCHEDULED, "released_at + ticks_from_us(stroke.start_us + 60)")],
        release_campaign(),
        r"a stroke began 60(\.\d+)? us off|59\.\d+ us off",
    ),
    "a pulse cut short": (
        [Edit(SERVOS, FALL.format(""), FALL.format(" - (c.pulse.change != nullptr ? 2 : 0)"))],
        release_campaign(),
        "pulse widths in order",
    ),
    "a release by one switch": (
        [Edit(DETECTOR, "if (open_ == kBoth) return judge_open", "if (open_ != 0) return judge_open")],
        lambda bench: knocks(bench, seed=2, count=3),
        "knocks",
    ),
    "edges in the order of their interrupts": (
        [Edit(CAPTURE, "static_cast<int16_t>(second - first) < 0", "false")],
        check_dates,
        "dated wrong",
    ),
    "a board that hides the second of two releases": (
        [Edit("src/core/release_detector.h", "return hung_ || last_", "return false && last_")],
        lambda bench: jolted_releases(bench, seed=59, count=150),
        "nothing is said of it",
    ),
    "a wait for the host that no edge ends": (
        [
            Edit(CAPTURE, "if (GPIOR1 != 0) OCR3B = present + kEndWaitTicks;", "(void)kEndWaitTicks;"),
            Edit(SKETCH, "return may_hurry && ReleaseCapture::gave_up();", "return false;"),
        ],
        check_disturbed_dates,
        "dates are off|outside of what is reported",
    ),
    "edges that are lost in silence": (
        [Edit(CAPTURE, "levels | kLost | (", "levels | (")],
        check_disturbed_dates,
        "outside of what is reported",
    ),
    "a jog that nobody need ask for": (
        [Edit("src/core/jog.h", ">= protocol::kJogIdleMs", ">= 3 * protocol::kJogIdleMs")],
        live_jogs,
        "nobody asks",
    ),
    "a jog that outlives its port": (
        [Edit(SEQUENCER, "if (state_ == SequencerState::kJogging) disarm();", "")],
        live_jogs,
        "nobody asks",
    ),
    "a jog that hurries": (
        [Edit("src/core/jog.h", "rest_ + protocol::kJogSpeedCdegS", "rest_ + 8 * protocol::kJogSpeedCdegS")],
        live_jogs,
        "moves",
    ),
    "a board that flies on the crane": (
        [Edit(DETECTOR, "stood >= kSeatedTicks", "stood >= 100 * kSeatedTicks")],
        lambda bench: closed_again(bench, seed=59, count=1),
        "closed again: RUNNING",
    ),
    "a store that overwrites its only record": (
        [Edit("src/core/slot_pair.h", "return static_cast<uint8_t>(1 - slot_);", "return slot_;")],
        cut(Record.SETTINGS, History.ONE_SLOT, 2),
        "neither the old nor the new",
    ),
    "a store that marks first and trusts its mark": (
        [
            Edit(SLOTS, BEGUN_BYTE, "complete_byte(position_)"),
            Edit(SLOTS, "&crc, kCrcBytes) != 0", "&crc, kCrcBytes) == 999"),
        ],
        cut(Record.SETTINGS, History.BOTH_SLOTS, 6),
        "neither the old nor the new",
    ),
    "an upload cut short that is taken for damage": (
        [Edit(SLOTS, BEGUN_BYTE, "complete_byte(position_)")],
        cut(Record.SETTINGS, History.ONE_SLOT, 2),
        r"STORE_DAMAGED",
    ),
    "an upload cut short that is kept quiet": (
        [Edit(SLOTS, TOLD_BEGUN, "Slot::kUnused")],
        cut(Record.MANEUVER, History.ONE_SLOT, 2),
        r"ARM says NONE",
    ),
    "a byte that is written with what it holds": (
        [Edit(SLOTS, "if (memory_.read(address) != value) memory_.write", "memory_.write")],
        cut(Record.SETTINGS, History.BOTH_SLOTS, 0),
        "was written with what it held",
    ),
    "a link that holds off interrupts, garbage": (
        [Edit(SKETCH, POLL, HOLDS_OFF)],
        abuse_campaign(Abuse.GARBAGE),
        "",
    ),
    "a link that holds off interrupts, silence": (
        [Edit(SKETCH, POLL, HOLDS_OFF)],
        abuse_campaign(Abuse.SILENT),
        "",
    ),
    "an arm with any token": (
        [Edit(SEQUENCER, "if (token != retained_.token) return", "if (token == 0xFFFF) return")],
        noisy,
        "ARMED after noise in SAFE",
    ),
    "settings that are stored unchecked": (
        [Edit(SETTINGS, FIND_DEFECT, FIND_DEFECT + "  if (frame_us > 0) return -1;\n")],
        noisy,
        "in SAFE changed the EEPROM",
    ),
    "a board that arms with an open switch": (
        [
            Edit(SEQUENCER, "bool opened = switches_.levels() != 0;", "bool opened = false;"),
            Edit(SEQUENCER, "opened = opened || edge.open || !edge.lost;", "opened = false;"),
        ],
        reset(Moment.ARMED_SECOND_OPEN, ResetCause.WATCHDOG),
        "",
    ),
    "a board that forgets its widths": (
        [Edit(SEQUENCER, "if (!powered || !retained_.intact())", "if (true)")],
        reset(Moment.RUNNING, ResetCause.BROWN_OUT),
        "no pulses",
    ),
    "a board that forgets its knocks": (
        [Edit(SEQUENCER, RESTART, RESTART.replace("retained_.knocks", "0"))],
        reset(Moment.ARMED_FIRST_OPEN, ResetCause.BROWN_OUT, 4),
        "knocks are counted after the reset",
    ),
    "a board that forgets its run": (
        [Edit(SEQUENCER, "if (!powered || !retained_.run.intact())", "if (true)")],
        reset(Moment.RUNNING, ResetCause.WATCHDOG),
        "RUN_REPORT",
    ),
    "a board without its watchdog": (
        [
            HANG,
            Edit("src/drivers/reset_cause.cpp", "wdt_enable(WDTO_1S)", "wdt_disable()"),
            Edit(SKETCH, "  Watchdog::feed(sequencer.may_upload());\n", ""),
        ],
        lambda bench: hang_board(bench, SequencerState.ARMED, count=1, seed=5),
        "no reset within",
    ),
    "a stroke that is booked unseen": (
        [
            Edit(
                SERVOS,
                "if ((PINB & pin) == 0 && (whole & pin) != 0) c.train.was_whole(c.pulse);",
                "c.train.was_whole(c.pulse);",
            )
        ],
        lambda bench: held_pins(bench, (1, 2), PinHold.LOW, count=10, seed=9),
        "",
    ),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_planted_defect_is_found(plant: Plant, defect: str) -> None:
    edits, campaign, found_by = DEFECTS[defect]
    with pytest.raises(Broken, match=found_by or None):
        campaign(plant(*edits))


def test_an_image_that_differs_from_the_native_core_is_found(plant: Plant, tmp_path: Path) -> None:
    """Detect an image that differs from the native core.

    In the image, a slot with a missing or one-byte marker counts as never written.
    """
    native = tmp_path / "native"
    native.mkdir()
    with pytest.raises(Broken, match=r"begun.*the image .*NONE.*native .*UPLOAD_INTERRUPTED"):
        damage_image(
            plant(Edit(SLOTS, TOLD_BEGUN, "Slot::kUnused")),
            build_native_library(native),
            Case.BEGUN,
            seed=1,
            count=2,
        )


def test_a_path_without_interrupts_that_grew_is_found(plant: Plant) -> None:
    overflow = "static void on_overflow() { "
    slow = Edit("src/drivers/tick_clock.h", overflow, f"{overflow}__builtin_avr_delay_cycles(2000); ")
    with pytest.raises((AssertionError, UnboundedError)):
        assert_paths_are_short(plant(slow))


def test_a_variable_too_many_fails_the_build(plant: Plant) -> None:
    setup = "void setup() {\n"
    hog = Edit(SKETCH, setup, f"volatile uint8_t hog[700];\n{setup}  hog[TCNT0] = 1;\n")
    with pytest.raises(BuildError, match=r"static RAM, \d+ more than its budget"):
        plant(hog)


def test_the_same_seed_gives_the_same_figures(bench: Bench) -> None:
    first, second = (avr_releases(bench, Chatter.SLOW, seed=2, count=2) for _ in range(2))
    assert first == second
