"""Campaign 1: releases with bounce. When does the first pulse of each new width rise?"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from tests.emulator_avr.board_link import UPLOADED
from tests.proof.campaign import Broken, table
from tests.sequencer_proof.contacts import (
    LATEST_SECOND_US,
    MOST_BOUNCES,
    TOGETHER_US,
    Chatter,
    admissible,
    hang_up,
    open_switches,
    opening,
)
from tests.sequencer_proof.figures import (
    Spread,
    bar,
    histogram,
    range_ms,
    range_us,
    signed_range_us,
    signed_us,
    us,
)
from tests.sequencer_proof.rigs import Bench, Rig, arm, native_rig, run_us, stack_never_used
from tests.sequencer_proof.signals import (
    CYCLES_PER_TICK,
    CYCLES_PER_US,
    Extremes,
    Onset,
    PinEdge,
    read_signal,
)
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import JOINT_COUNT, SERVO_PULSE_MAX_US, SERVO_PULSE_MIN_US
from tfsat_host.servo_settings import ServoSettings, pulse_ns

WORST_ERROR_US = 50
"""What the task allows."""
LONGEST_WAIT_US = 400_000
"""A release comes this long after arming, at most: any phase of the 20 ms frames."""
AFTER_RUN_US = 60_000
NS_PER_TICK = 500
BIN_CYCLES = 2

Strokes = tuple[tuple[int, int, int], ...]
"""joint, angle_cdeg (change), start_us of each."""


@dataclass(frozen=True, slots=True)
class Release:
    """One run. `errors`: onset of each stroke less release and scheduled time, cycles."""

    errors: tuple[int, ...]
    widths: Extremes
    gaps: Extremes
    contact_edges: int


@dataclass(frozen=True, slots=True)
class Plan:
    """What the board has been told to fly, and with which servos."""

    strokes: Strokes
    end_us: int
    settings: ServoSettings

    @classmethod
    def on(cls, client: SequencerClient) -> Plan:
        stored = client.read_back()
        return cls(stored.strokes, stored.end_us, client.settings().settings)

    def widths(self) -> list[list[int]]:
        """Each joint's pulse widths in order, ticks."""
        angle_cdeg = [0] * JOINT_COUNT
        widths = [[self.ticks(joint, 0)] for joint in range(1, JOINT_COUNT + 1)]
        for joint, change_cdeg, _ in self.strokes:
            angle_cdeg[joint - 1] += change_cdeg
            widths[joint - 1].append(self.ticks(joint, angle_cdeg[joint - 1]))
        return widths

    def ticks(self, joint: int, angle_cdeg: int) -> int:
        """The pulse's width that holds an angle."""
        return round(pulse_ns(self.settings.of(joint), angle_cdeg) / NS_PER_TICK)


def fly(rig: Rig, client: SequencerClient, plan: Plan, rng: random.Random, chatter: Chatter) -> Release:
    """Hangs up, arms, releases after a random wait, all with chatter; measures the run. Raises Broken.

    Where edges of both switches lie so close together that the rule has two answers, the nearer one counts.
    """
    client.disarm()
    hang_up(rig, rng, chatter)
    arm(rig, client)
    steps = CYCLES_PER_US // rig.resolution
    start = rig.now + rng.randint(1000 * steps, LONGEST_WAIT_US * steps) * rig.resolution
    contacts = opening(rng, start, rig.resolution, chatter)
    open_switches(rig, contacts)
    run_us(rig, plan.end_us + AFTER_RUN_US)
    edges = rig.edges()
    answers = [measure(edges, plan, date, contact_edges=len(contacts)) for date in admissible(contacts)]
    release = min(answers, key=lambda answer: abs(answer.errors[0]))
    check_own_report(client, plan, release, chatter)
    return release


def measure(edges: Sequence[PinEdge], plan: Plan, released: int, *, contact_edges: int = 2) -> Release:
    """The run that is over, by the pins. Raises Broken where it is not the plan's, whatever its times."""
    signal = read_signal(edges)
    signal.check_widths()
    for train, expected in zip(signal.trains, plan.widths(), strict=True):
        # Each pulse counts: one that was cut short would stand between two of its neighbours' width.
        found = [width for width, _ in groupby(pulse.width for pulse in train)]
        if found != [ticks * CYCLES_PER_TICK for ticks in expected]:
            raise Broken(f"pulse widths in order, cycles: {found}; ticks planned: {expected}")
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
    """The board is DONE, and its own onsets are those of the pins, within a tick. Raises Broken.

    RUN_REPORT tells the timer's compare matches at which the pin was seen high, rounded down to a microsecond.
    They count from the board's own release, which chatter that is faster than an interrupt puts some
    microseconds off: then the onsets are compared from the first one on.
    """
    status, run = client.status(), client.run_report()
    if status.state != SequencerState.DONE or status.strokes_started != len(plan.strokes) or status.knocks:
        raise Broken(
            f"after the run: {status.state.name}, {status.strokes_started} strokes, {status.knocks} knocks"
        )
    told = run.start_us[: run.stroke_count]
    late = 0 if chatter is Chatter.SLOW else release.errors[0]
    for own_us, error, (_, _, start_us) in zip(told, release.errors, plan.strokes, strict=True):
        pin = start_us * CYCLES_PER_US + error - late
        least = own_us * CYCLES_PER_US
        if not least - CYCLES_PER_TICK <= pin <= least + 2 * CYCLES_PER_TICK:
            raise Broken(f"RUN_REPORT says {own_us} us, the pin {pin / CYCLES_PER_US} us")


def judge(releases: Sequence[Release], most_beyond: int = 0) -> None:
    """Raises Broken where strokes of more than `most_beyond` releases were not on time; see `dating.judge_dates`."""
    worst = [max(map(abs, release.errors)) for release in releases]
    beyond = [cycles for cycles in worst if cycles > WORST_ERROR_US * CYCLES_PER_US]
    if len(beyond) > most_beyond:
        raise Broken(f"a stroke began {max(beyond) / CYCLES_PER_US} us off its time")


def native_releases(library: Path, seed: int, count: int) -> list[Release]:
    """Many on one powered board, so that its clock turns over between them."""
    rig = native_rig(library)
    client = rig.connect()
    client.upload(UPLOADED)
    plan, rng = Plan.on(client), random.Random(seed)
    return [fly(rig, client, plan, rng, Chatter.BOTH) for _ in range(count)]


@dataclass(frozen=True, slots=True)
class AvrReleases:
    """Some releases of one powered board, and the stack they left alone, bytes."""

    plan: Plan
    releases: list[Release]
    never_used: int


def avr_releases(bench: Bench, chatter: Chatter, seed: int, count: int) -> AvrReleases:
    """On the image; between runs the cable stays in."""
    rig = bench.rig()
    client = rig.connect()
    plan, rng = Plan.on(client), random.Random(seed)
    releases = [fly(rig, client, plan, rng, chatter) for _ in range(count)]
    never_used = stack_never_used(rig, client, bench)
    rig.close()
    return AvrReleases(plan, releases, never_used)


def conditions(releases: Sequence[Release]) -> str:
    most = max(release.contact_edges for release in releases)
    (slow,), (fast,) = Chatter.SLOW.value, Chatter.FAST.value
    return (
        "The robot is hung up, armed and released. When it is hung up, and again at the release, both switches "
        "change, either one first,\n"
        f"the second in one half of all cases up to {TOGETHER_US} µs later, in the other up to "
        f"{LATEST_SECOND_US / 1000:g} ms, each with up to {MOST_BOUNCES} bounces; up to "
        f"{most} edges in one release. Slow chatter: each closing and each\n"
        f"opening between lasts {slow[0]} to {slow[1]} µs; fast chatter: {fast[0]} to {fast[1]} µs, about what an "
        "interrupt takes. The release comes at a random\n"
        f"moment up to {LONGEST_WAIT_US / 1000:g} ms after arming.\n\n"
        "*Measured* is at the pins, by the emulator, in CPU cycles: the *onset* is the rise of the first pulse of "
        "the new width, and time\n"
        "counts from the first edge at which both switches were open, however short. Allowed: "
        f"{WORST_ERROR_US} µs. The onsets that the board reports itself\n"
        "(`tfsat-host status`) are its timer's compare matches at which it saw the pin high, in whole "
        "microseconds from the release as its\n"
        "timer stamped it. After each run they were held against the pins: equal within a tick (0.5 µs); under "
        "fast chatter, counted from\n"
        "the first stroke."
    )


def stroke_table(plan: Plan, releases: Sequence[Release]) -> str:
    rows = []
    for number, (joint, change_cdeg, start_us) in enumerate(plan.strokes):
        errors = [release.errors[number] for release in releases]
        spread = Spread.of(errors)
        scheduled = start_us * CYCLES_PER_US
        measured = [us(scheduled + value) for value in (spread.least, spread.median, spread.greatest)]
        worst = signed_us(max(errors, key=abs))
        rows.append((number + 1, joint, f"{change_cdeg / 100:+g} deg", start_us, *measured, worst))
    header = ("stroke", "joint", "change", "scheduled", "measured: min", "median", "max", "worst error")
    return table(header, rows)


def error_histogram(releases: Sequence[Release]) -> str:
    bins = histogram([error for release in releases for error in release.errors], BIN_CYCLES)
    most = max(count for _, count in bins)
    return "\n".join(
        f"{signed_us(low):>9} to {signed_us(low + BIN_CYCLES):>7} µs {count:5d}  {bar(count, most)}".rstrip()
        for low, count in bins
    )


def signal_table(avr: Sequence[Release], native: Sequence[Release]) -> str:
    rows = []
    for name, releases in (("flashed image", avr), ("*native*", native)):
        widths = Extremes.over(release.widths for release in releases)
        gaps = Extremes.over(release.gaps for release in releases)
        rows.append((name, len(releases), range_us(widths), range_ms(gaps)))
    return (
        "Every pulse was one of the widths that the plan needs, none cut short; allowed: "
        f"{SERVO_PULSE_MIN_US} to "
        f"{SERVO_PULSE_MAX_US} µs. Between rises of a servo, strokes included:\n\n"
        + table(("", "releases", "pulses", "frames"), rows)
    )


def error_range(releases: Sequence[Release]) -> str:
    return signed_range_us(Extremes.of(error for release in releases for error in release.errors))
