"""Campaigns 1 and 1b: releases with bounce. When does each stroke's first pulse rise, and how is the release dated?

A date needs no flight to its end, so that there are tens of thousands of them: what a race of two interrupts does
shows once in some thousands.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import NamedTuple

from tests.fixtures.sequencer.board import Board, load_library
from tests.fixtures.sequencer.cable import OLD, connect, native_board
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import SETTLE_US, Bench, arm, pin_edges, stack_never_used
from tests.validation.sequencer_proof.contacts import (
    Chatter,
    Contact,
    admissible,
    draw_opening,
    hang_up,
    open_switches,
)
from tests.validation.sequencer_proof.signals import (
    CYCLES_PER_MS,
    CYCLES_PER_TICK,
    CYCLES_PER_US,
    Extremes,
    Onset,
    PinEdge,
    read_signal,
)
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.servo_settings import ServoSettings, pulse_ns

WORST_ERROR_US = 50
"""Allowed."""
MAX_WAIT_US = 400_000
"""A release comes this long after arming, at most: any phase of the 20 ms frames."""
AFTER_RUN_US = 60_000
NS_PER_TICK = 500
ONE_BEYOND_IN = {Chatter.SLOW: 10_000, Chatter.BOTH: 2_000, Chatter.FAST: 2_000}
"""No more often may a date be off by more than is allowed; see `judge_dates`."""

Strokes = tuple[tuple[int, int, int], ...]
"""joint, angle_cdeg (change), start_us of each."""


class Release(NamedTuple):
    """One run. `errors`: onset of each stroke less release and scheduled time, cycles."""

    errors: tuple[int, ...]
    widths: Extremes
    gaps: Extremes
    contact_edges: int


class Plan(NamedTuple):
    """What the board has been told to fly, and with which servos."""

    strokes: Strokes
    end_us: int
    settings: ServoSettings

    @classmethod
    def on(cls, client: SequencerClient) -> Plan:
        stored = client.read_back()
        return cls(stored.strokes, stored.end_us, client.settings().settings)

    def widths(self) -> list[list[int]]:
        """Return each joint's pulse widths in order, in ticks."""
        angle_cdeg = [0] * JOINT_COUNT
        widths = [[self.ticks(joint, 0)] for joint in range(1, JOINT_COUNT + 1)]
        for joint, change_cdeg, _ in self.strokes:
            angle_cdeg[joint - 1] += change_cdeg
            widths[joint - 1].append(self.ticks(joint, angle_cdeg[joint - 1]))
        return widths

    def ticks(self, joint: int, angle_cdeg: int) -> int:
        """Return the pulse width that holds an angle, in ticks."""
        return round(pulse_ns(self.settings.of(joint), angle_cdeg) / NS_PER_TICK)


def fly(board: Board, client: SequencerClient, plan: Plan, rng: random.Random, chatter: Chatter) -> Release:
    """Hangs up, arms, releases after a random wait, all with chatter; measures the run. Raises Broken.

    Where edges of both switches lie so close together that the rule has two answers, the nearer one counts.
    """
    client.disarm()
    hang_up(board, rng, chatter)
    arm(board, client)
    steps = CYCLES_PER_US // board.resolution
    start = board.now_cycle + rng.randint(1000 * steps, MAX_WAIT_US * steps) * board.resolution
    contacts = draw_opening(rng, start, board.resolution, chatter)
    open_switches(board, contacts)
    board.run(plan.end_us + AFTER_RUN_US)
    edges = pin_edges(board)
    answers = [measure(edges, plan, date, contact_edges=len(contacts)) for date in admissible(contacts)]
    release = min(answers, key=lambda answer: abs(answer.errors[0]))
    check_own_report(client, plan, release, chatter)
    return release


def measure(edges: Sequence[PinEdge], plan: Plan, released: int, *, contact_edges: int = 2) -> Release:
    """Measure a completed run from the pins.

    Raises Broken where it is not the plan's, whatever its times.
    """
    signal = read_signal(edges)
    signal.check_widths()
    for train, expected in zip(signal.trains, plan.widths(), strict=True):
        # Each pulse counts: one that was cut short would stand between two of its neighbours' width.
        widths = [width for width, _ in groupby(pulse.width for pulse in train)]
        if widths != [ticks * CYCLES_PER_TICK for ticks in expected]:
            raise Broken(f"pulse widths in order, cycles: {widths}; ticks planned: {expected}")
    return Release(_errors(signal.onsets, plan.strokes, released), signal.widths, signal.gaps, contact_edges)


def _errors(onsets: list[Onset], strokes: Strokes, released: int) -> tuple[int, ...]:
    if [onset.joint for onset in onsets] != [joint for joint, _, _ in strokes]:
        raise Broken(f"joints in order: {[onset.joint for onset in onsets]}")
    return tuple(
        onset.cycle - released - start_us * CYCLES_PER_US
        for onset, (_, _, start_us) in zip(onsets, strokes, strict=True)
    )


def check_own_report(
    client: SequencerClient, plan: Plan, release: Release, chatter: Chatter = Chatter.SLOW
) -> None:
    """Check that the board is DONE and its reported onsets agree with the pins within a tick.

    Raises Broken.

    RUN_REPORT tells the timer's compare matches at which the pin was seen high, rounded down to a microsecond.
    They count from the board's own release. Chatter faster than an interrupt puts that release some
    microseconds off: then the onsets are compared from the first one on.
    """
    status, run = client.status(), client.run_report()
    if status.state != SequencerState.DONE or status.strokes_started != len(plan.strokes) or status.knocks:
        raise Broken(
            f"after the run: {status.state.name}, {status.strokes_started} strokes, {status.knocks} knocks"
        )
    reported_us = run.start_us[: run.stroke_count]
    late = 0 if chatter is Chatter.SLOW else release.errors[0]
    for own_us, error, (_, _, start_us) in zip(reported_us, release.errors, plan.strokes, strict=True):
        pin = start_us * CYCLES_PER_US + error - late
        least = own_us * CYCLES_PER_US
        if not least - CYCLES_PER_TICK <= pin <= least + 2 * CYCLES_PER_TICK:
            raise Broken(f"RUN_REPORT says {own_us} us, the pin {pin / CYCLES_PER_US} us")


def judge(releases: Sequence[Release], most_beyond: int = 0) -> None:
    """Raises Broken where strokes of more than `most_beyond` releases were not on time; see `judge_dates`."""
    worst = [max(map(abs, release.errors)) for release in releases]
    beyond = [cycles for cycles in worst if cycles > WORST_ERROR_US * CYCLES_PER_US]
    if len(beyond) > most_beyond:
        raise Broken(f"a stroke began {max(beyond) / CYCLES_PER_US} us off its time")


class Flights(NamedTuple):
    """Some releases of one powered board, and the stack they left alone, bytes."""

    plan: Plan
    releases: list[Release]
    never_used: int | None = None


def native_releases(library: Path, seed: int, count: int) -> Flights:
    """Many on one powered board, so that its clock turns over between them."""
    board = native_board(load_library(library))
    client = connect(board)
    client.upload(OLD)
    plan, rng = Plan.on(client), random.Random(seed)
    flights = Flights(plan, [fly(board, client, plan, rng, Chatter.BOTH) for _ in range(count)])
    judge(flights.releases)
    return flights


def avr_releases(bench: Bench, chatter: Chatter, seed: int, count: int, most_beyond: int = 0) -> Flights:
    """Fly `count` releases on the image; the cable stays in between runs.

    Raises Broken.
    """
    board = bench.board()
    client = connect(board)
    plan, rng = Plan.on(client), random.Random(seed)
    releases = [fly(board, client, plan, rng, chatter) for _ in range(count)]
    never_used = stack_never_used(board, client, bench)
    board.close()
    judge(releases, most_beyond)
    return Flights(plan, releases, never_used)


def all_releases(flights: Sequence[Flights]) -> list[Release]:
    return [release for part in flights for release in part.releases]


def errors_us(releases: Sequence[Release]) -> Extremes:
    """Return the extreme errors of all strokes, in us."""
    return Extremes.of((error for release in releases for error in release.errors), CYCLES_PER_US)


class StrokeRow(NamedTuple):
    """When one stroke of 59/70 began, over all releases of a kind; after the release."""

    contacts: str
    stroke: int
    joint: int
    change_deg: float
    scheduled_us: int
    least_us: float
    median_us: float
    greatest_us: float
    worst_error_us: float


def stroke_rows(contacts: str, flights: Sequence[Flights]) -> list[StrokeRow]:
    rows = []
    for i, (joint, change_cdeg, start_us) in enumerate(flights[0].plan.strokes):
        errors = [release.errors[i] / CYCLES_PER_US for release in all_releases(flights)]
        least_us, median_us, greatest_us = (start_us + find(errors) for find in (min, median, max))
        stroke = (contacts, i + 1, joint, change_cdeg / 100, start_us)
        rows.append(StrokeRow(*stroke, least_us, median_us, greatest_us, max(errors, key=abs)))
    return rows


def signal_row(contacts: str, flights: Sequence[Flights]) -> tuple[object, ...]:
    """Releases, errors of their strokes, pulse widths and frames."""
    releases = all_releases(flights)
    widths = Extremes.of((us for release in releases for us in release.widths), CYCLES_PER_US)
    gaps = Extremes.of((ms for release in releases for ms in release.gaps), CYCLES_PER_MS)
    frames = f"{gaps.least:.2f} to {gaps.greatest:.2f}"
    return contacts, len(releases), errors_us(releases), widths, frames


# ------------------------------------------------------------------ dates


class Dated(NamedTuple):
    """One release. `error_us`: its date by the board less the switches' own, to a whole microsecond."""

    error_us: float
    undecided: bool
    """Edges of both switches so close together that the rule has two answers; the nearer one counts."""


def dated_releases(bench: Bench, chatter: Chatter, seed: int, count: int) -> list[Dated]:
    """Fly releases on one powered board with its cable in, so that USB interrupts run too."""
    board = bench.board()
    client = connect(board)
    rng = random.Random(seed)
    start = _arm_board(board, client, rng)
    first = open_switches(board, [Contact(start, 0, False), Contact(start + CYCLES_PER_MS, 1, False)])
    zero_us = _reported_us(board, client) - first / CYCLES_PER_US
    releases = [_date_release(board, client, rng, chatter, zero_us) for _ in range(count)]
    board.close()
    return releases


def judge_dates(dated: Sequence[Dated], chatter: Chatter) -> None:
    """Raises Broken where dates are off.

    Where both switches move while interrupts are off (see `blocking`) and one of them moves back before they are on
    again, the board may miss that they were open together, until they are again: that rare it must be.
    """
    beyond = [release.error_us for release in dated if abs(release.error_us) > WORST_ERROR_US]
    if len(beyond) > len(dated) / ONE_BEYOND_IN[chatter]:
        worst_us = max(map(abs, beyond))
        raise Broken(f"{len(beyond)} of {len(dated)} releases were dated wrong, by {worst_us} us")


def _date_release(
    board: Board, client: SequencerClient, rng: random.Random, chatter: Chatter, zero_us: float
) -> Dated:
    contacts = draw_opening(rng, _arm_board(board, client, rng), board.resolution, chatter)
    open_switches(board, contacts)
    date_us = _reported_us(board, client) - zero_us
    errors = [date_us - cycle / CYCLES_PER_US for cycle in admissible(contacts)]
    return Dated(min(errors, key=abs), len(errors) > 1)


def _arm_board(board: Board, client: SequencerClient, rng: random.Random) -> int:
    """Then the cycle at which the release is to begin."""
    arm(board, client)
    return board.now_cycle + rng.randint(1_000, 4_000) * CYCLES_PER_US + rng.randrange(CYCLES_PER_US)


def _reported_us(board: Board, client: SequencerClient) -> float:
    board.run(SETTLE_US)
    report, status = client.run_report(), client.status()
    if status.state != SequencerState.RUNNING or status.knocks:
        raise Broken(f"after a release: {status.state.name}, {status.knocks} knocks")
    return report.release_ms * 1000.0 + report.release_us


def date_row(chatter: Chatter, dated: Sequence[Dated]) -> tuple[object, ...]:
    """Format a row with the number of dates off by how much, and the worst error."""
    off = [abs(release.error_us) for release in dated]
    near, far = (sum(error <= limit for error in off) for limit in (1.0, WORST_ERROR_US))
    undecided = sum(release.undecided for release in dated)
    allowed = f"one in {ONE_BEYOND_IN[chatter]}"
    return chatter, len(off), near, far - near, len(off) - far, allowed, f"{max(off):.1f}", undecided
