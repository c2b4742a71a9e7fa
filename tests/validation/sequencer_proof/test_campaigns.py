"""Short forms of all campaigns: the image that would be flashed, and the same core for this computer."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from tests.fixtures.sequencer.board import EEPROM_BYTES, PinHold, ResetCause
from tests.fixtures.sequencer.building import build_changed_sequencer, build_native_library
from tests.fixtures.sequencer.cable import TOGETHER, connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench
from tests.validation.sequencer_proof.blocking import (
    BLOCKED_BEFORE_RELEASE_MAX_US,
    BLOCKED_MAX_US,
    FOLLOWING_US,
    blocked_paths,
)
from tests.validation.sequencer_proof.contacts import (
    TOGETHER_US,
    Chatter,
    Contact,
    Fall,
    Jolt,
    admissible,
    fall,
)
from tests.validation.sequencer_proof.damage import TOLD, Case, Place, damage_image, damage_native
from tests.validation.sequencer_proof.half_transfers import HOSTS_US, disturbed_releases, judge_disturbed
from tests.validation.sequencer_proof.held_pins import LEVELS, SUBSETS, held_pins
from tests.validation.sequencer_proof.jog_lives import jog_lives
from tests.validation.sequencer_proof.jolts import closed_again, jolted_releases
from tests.validation.sequencer_proof.link import (
    LAST_BEGIN_US,
    STATES,
    Abuse,
    Noise,
    abuse_link,
    begins_us,
    make_noise,
)
from tests.validation.sequencer_proof.one_closed import one_closed_again
from tests.validation.sequencer_proof.power_cuts import (
    History,
    Record,
    Tear,
    Write,
    check_writes,
    cut_points,
    second_upload_writes,
)
from tests.validation.sequencer_proof.releases import (
    Plan,
    avr_releases,
    dated_releases,
    errors_us,
    fly,
    judge_dates,
    native_releases,
)
from tests.validation.sequencer_proof.resets import HANG, Moment, hang_board, reset_board
from tests.validation.sequencer_proof.signals import CYCLES_PER_US
from tests.validation.sequencer_proof.waiting import knocks, long_wait
from tfsat_host.devices.board_errors import BoardRefusal
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, SequencerState

TICK_US = 0.5
DATED_SEED, DATED = 1, 2_500
"""Two switches that move within one interrupt are among these."""
MAX_SILENCE_MS = 40
"""Start-up and two frames."""
SERVO_EDGES = [4 * vector for vector in (17, 18, 19)]
SWITCHES = [4 * vector for vector in (16, 31)]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_native_library(tmp_path_factory.mktemp("native"))


@pytest.fixture(scope="module")
def hanging_bench(bench: Bench, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    image = build_changed_sequencer([HANG], tmp_path_factory.mktemp("hanging"), bench.image)
    return replace(bench, image=image)


# ------------------------------------------------------------------ releases


def test_native_releases_are_on_time(library: Path) -> None:
    releases = native_releases(library, seed=1, count=60).releases
    assert max(map(abs, errors_us(releases))) <= TICK_US
    assert max(release.contact_edges for release in releases) > 30


def test_releases_of_the_image_are_on_time(bench: Bench) -> None:
    flights = avr_releases(bench, Chatter.SLOW, seed=1, count=5)
    errors = [error for release in flights.releases for error in release.errors]
    assert max(map(abs, errors_us(flights.releases))) <= TICK_US
    assert len(set(errors)) > 2  # the release falls anywhere in the timer's tick
    schedule = schedule_maneuver(four_stroke(59, 70))
    assert flights.plan.strokes == tuple((s.joint, s.angle_cdeg, s.t_us) for s in schedule.strokes)
    avr_releases(bench, Chatter.BOTH, seed=1, count=5)


@pytest.mark.parametrize(
    ("chatter", "count"),
    [
        *((kind, 100) for kind in Chatter),
        *(pytest.param(kind, DATED, marks=pytest.mark.prove) for kind in Chatter),
    ],
)
def test_releases_are_dated_by_the_first_edge_at_which_both_were_open(
    bench: Bench, chatter: Chatter, count: int
) -> None:
    """Fast chatter, which no interrupt can follow, may put a date off; that is rare."""
    dated = dated_releases(bench, chatter, seed=DATED_SEED, count=count)
    judge_dates(dated, chatter)
    if chatter is Chatter.SLOW:
        assert sum(abs(release.error_us) <= 1.0 for release in dated) > 0.999 * len(dated)


def test_edges_within_a_microsecond_leave_two_dates() -> None:
    swap = [Contact(0, 0, False), Contact(1000, 0, True), Contact(1008, 1, False), Contact(5000, 0, False)]
    assert admissible(swap) == [1008, 5000]
    blip = [Contact(0, 0, False), Contact(1000, 1, False), Contact(1015, 0, True), Contact(5000, 0, False)]
    assert admissible(blip) == [1000, 5000]
    apart = [Contact(0, 0, False), Contact(1000, 0, True), Contact(1017, 1, False), Contact(5000, 0, False)]
    assert admissible(apart) == [5000]


def test_waiting_and_knocks_change_nothing(bench: Bench) -> None:
    assert long_wait(bench, seed=1, waited_us=45_000_000).pulses >= 3 * 50 * 20
    knocked = knocks(bench, seed=2, count=16)
    assert min(knocked.one_switch, knocked.both_switches) > 3


# ------------------------------------------------------------------ jolts


RELEASED = 1_000_000 * CYCLES_PER_US


def fallen(seed: int, *jolts: Jolt) -> Fall:
    return fall(random.Random(seed), RELEASED, 1, Chatter.FAST, jolts=jolts)


@pytest.mark.parametrize("seed", range(20))
def test_contacts_alternate_and_end_open_after_the_release(seed: int) -> None:
    jolted_fall = fallen(
        seed, Jolt(before_us=50_000, open_us=6_000), Jolt(before_us=9_000, open_us=100, switches=(1,))
    )
    for index in (0, 1):
        states = [contact.closed for contact in jolted_fall.contacts if contact.index == index]
        assert states[0] is False and states[-1] is False
        assert all(before != after for before, after in pairwise(states))
    after = [contact for contact in jolted_fall.contacts if contact.cycle >= jolted_fall.released]
    begins = [next(contact.cycle for contact in after if contact.index == index) for index in (0, 1)]
    assert min(begins) == jolted_fall.released
    assert max(begins) <= jolted_fall.released + TOGETHER_US * CYCLES_PER_US
    before = [contact for contact in jolted_fall.contacts if contact.cycle < jolted_fall.released]
    assert {contact.index: contact.closed for contact in before} == {0: True, 1: True}


def test_a_jolt_into_the_release_is_an_error() -> None:
    with pytest.raises(ValueError, match="a jolt is not over"):
        fallen(1, Jolt(before_us=100, open_us=200))


def test_what_is_told_of_a_release_after_jolts_holds_when_the_robot_left(bench: Bench) -> None:
    jolted = jolted_releases(bench, seed=59, count=150)
    assert sum(release.interval_us > 0 for release in jolted) > 30
    assert sum(not release.jolts for release in jolted) > 5


def test_a_host_that_ends_no_transfer_moves_no_date(bench: Bench) -> None:
    releases = [
        release for every_us in HOSTS_US for release in disturbed_releases(bench, every_us, seed=59, count=60)
    ]
    judge_disturbed(releases)
    # The board knows that it was blind: contacts chattered for longer than an interrupt may follow.
    assert all(release.later_us > 0 for release in releases)


def test_one_switch_that_closes_again_is_reported_as_the_page_says(bench: Bench) -> None:
    assert len(one_closed_again(bench, seed=59, count=90)) == 90


def test_closed_again_starts_nothing_or_ends_the_run(bench: Bench) -> None:
    assert len(closed_again(bench, seed=59, count=4).releases) == 4


# ------------------------------------------------------------------ interrupts


def assert_paths_are_short(bench: Bench) -> None:
    elf = bench.image.with_suffix(".elf")
    before = blocked_paths(elf, scheduled=False)
    assert before[0].cycles <= BLOCKED_BEFORE_RELEASE_MAX_US * CYCLES_PER_US
    assert blocked_paths(elf)[0].cycles <= BLOCKED_MAX_US * CYCLES_PER_US
    assert {path.address for path in before} >= {*SERVO_EDGES, *SWITCHES}


def test_the_time_without_interrupts_is_bounded_by_what_is_computed(bench: Bench) -> None:
    assert_paths_are_short(bench)
    board = bench.board()
    client = connect(board)
    board.watch_blocking()
    rng = random.Random(1)
    plan = Plan.on(client)
    for chatter in (Chatter.FAST, Chatter.SLOW):
        fly(board, client, plan, rng, chatter)
    measured = board.blocked_cycles()
    board.close()
    computed = {path.address: path.cycles for path in blocked_paths(bench.image.with_suffix(".elf"))}
    assert set(measured) <= set(computed)
    for address, cycles in measured.items():
        following = FOLLOWING_US * CYCLES_PER_US if address in SWITCHES else 0
        assert cycles <= computed[address] + following, hex(address)
    assert len(measured) > 15
    assert min(measured[address] for address in SERVO_EDGES) > computed[SERVO_EDGES[0]] // 4


# ------------------------------------------------------------------ power cuts and damage


@pytest.mark.parametrize(
    ("record", "history"),
    [
        (Record.MANEUVER, History.ONE_SLOT),
        (Record.SETTINGS, History.BOTH_SLOTS),
        *(pytest.param(record, History.ERASED, marks=pytest.mark.prove) for record in Record),
    ],
)
def test_a_cut_leaves_the_old_record_or_the_new_one_or_is_told(
    bench: Bench, record: Record, history: History
) -> None:
    cuts = cut_points(bench, record, history, seed=1, sample=2)
    assert cuts.points == cuts.stored_afterwards == 4
    assert cuts.writes > 20
    # The first write begins nothing yet; the last commits, so an earlier one never does.
    for tear in Tear:
        assert cuts.old[tear] >= 1
        assert cuts.new[tear] == (tear is Tear.NEW)
    assert cuts.told[Tear.OLD] >= 1


@pytest.mark.parametrize("record", Record)
def test_a_second_upload_writes_no_more_than_its_begin_and_end(bench: Bench, record: Record) -> None:
    assert second_upload_writes(bench, record) == (8 if record is Record.MANEUVER else 0)


def test_a_byte_of_the_other_store_is_found() -> None:
    with pytest.raises(Broken, match="not in the store of the maneuver"):
        check_writes([Write(800, 0xFF, 1)], Record.MANEUVER)


@pytest.mark.parametrize("case", Case)
def test_no_byte_makes_the_board_arm_with_anything_else(library: Path, case: Case) -> None:
    damaged = damage_native(library, case, seed=1, sample=1)
    assert damaged.values.total() == 1024 + 16 * 7
    if not case.may_arm:
        assert not damaged.armed
    else:
        assert 0 < damaged.armed[Place.MARKER] < damaged.values[Place.MARKER]
    if case in (Case.BOTH, Case.TWO):  # settings that were never stored may be those of the old layout
        assert damaged.armed[Place.OTHER] == damaged.values[Place.OTHER]
    assert {code for _, code in damaged.refused} <= set(TOLD)


def test_the_image_answers_to_damage_as_the_native_core_does(bench: Bench, library: Path) -> None:
    assert damage_image(bench, library, Case.TWO, seed=1, count=8).tried == 8


# ------------------------------------------------------------------ the link


@pytest.mark.parametrize("abuse", Abuse)
def test_no_abuse_moves_a_stroke(bench: Bench, abuse: Abuse) -> None:
    begins = [0, LAST_BEGIN_US, *random.Random(1).sample(begins_us(), 1)]
    result = abuse_link(bench, abuse, begins, seed=1)
    assert (result.runs, result.moved) == (3, 0)


@pytest.mark.parametrize(("noise", "amount"), [(Noise.BYTES, 12_000), (Noise.FRAMES, 1_500)])
def test_noise_moves_nothing_and_stores_nothing(bench: Bench, noise: Noise, amount: int) -> None:
    result = make_noise(bench, noise, amount, drops=2, seed=3)
    assert [result.sent[state] for state in STATES] == [amount // 3] * 3
    if noise is Noise.BYTES:
        assert result.rejected > 20
    else:
        assert result.refusals > amount // 2 < result.answers
        assert result.arms_refused[ErrorCode.STALE_TOKEN] > 10


@pytest.mark.prove
def test_noise_at_a_board_that_cannot_be_armed_proves_nothing(bench: Bench) -> None:
    new = replace(bench, eeprom=b"\xff" * EEPROM_BYTES)
    with pytest.raises(BoardRefusal, match="maneuver"):
        make_noise(new, Noise.FRAMES, 600, drops=1, seed=3)


# ------------------------------------------------------------------ resets


@pytest.mark.parametrize("cause", [ResetCause.WATCHDOG, ResetCause.BROWN_OUT])
@pytest.mark.parametrize("moment", Moment)
def test_a_reset_goes_on_or_holds_still(bench: Bench, moment: Moment, cause: ResetCause) -> None:
    resets = reset_board(bench, moment, cause, count=3, seed=4)
    assert resets.silence_ms.greatest <= MAX_SILENCE_MS
    assert bool(resets.errors_us) == (moment is Moment.ARMED)
    assert all(abs(float(error)) <= TICK_US for error in resets.errors_us)


@pytest.mark.parametrize("state", STATES)
def test_the_watchdog_ends_a_hang(hanging_bench: Bench, state: SequencerState) -> None:
    hangs = hang_board(hanging_bench, state, count=2, seed=5)
    assert 900 < hangs.reset_after_ms.least <= hangs.reset_after_ms.greatest < 1_200


@pytest.mark.parametrize("level", LEVELS)
def test_a_servo_is_driven_after_a_reset_as_its_pin_was(bench: Bench, level: PinHold) -> None:
    pin_results = [held_pins(bench, joints, level, count=2, seed=9) for joints in SUBSETS]
    assert sum(result.missed for result in pin_results) > 0
    assert sum(result.on_time for result in pin_results) > 0


# ------------------------------------------------------------------ strokes of joints that move together


@pytest.fixture(scope="module")
def together(bench: Bench) -> Bench:
    return bench.flying(TOGETHER)


def test_strokes_that_begin_together_rise_on_one_tick(together: Bench) -> None:
    releases = avr_releases(together, Chatter.SLOW, seed=1, count=3).releases
    assert max(map(abs, errors_us(releases))) <= TICK_US
    for release in releases:
        assert release.errors[0] == release.errors[1]
        assert len(set(release.errors[3:])) == 1


def test_joints_that_move_together_are_as_safe_as_one_after_the_other(together: Bench) -> None:
    closed_again(together, seed=1, count=1)
    assert abuse_link(together, Abuse.PULLED, [700_000], seed=1).moved == 0
    for moment in (Moment.ARMED, Moment.RUNNING):
        assert reset_board(together, moment, ResetCause.WATCHDOG, count=2, seed=4).resets == 2
    assert held_pins(together, (1, 2, 3), PinHold.LOW, count=3, seed=9).missed > 0


# ------------------------------------------------------------------ jog


@pytest.mark.parametrize("seed", [0, 12])
def test_a_joint_moves_only_while_somebody_asks(bench: Bench, seed: int) -> None:
    lives = jog_lives(bench, seed, count=12)
    assert lives.ends > 12 and lives.jogs > 36 and lives.pulses > 1_000
