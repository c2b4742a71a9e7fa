"""Section 1 of the report: releases."""

from __future__ import annotations

from collections.abc import Sequence

from tests.sequencer_proof.campaigns import Proof
from tests.sequencer_proof.contacts import LATEST_SECOND_US, MOST_BOUNCES, TOGETHER_US, Chatter
from tests.sequencer_proof.dating import ONE_BEYOND_IN
from tests.sequencer_proof.releases import LONGEST_WAIT_US, WORST_ERROR_US, Release
from tests.sequencer_proof.report_text import (
    range_ms,
    range_us,
    signed_range_us,
    signed_us,
    table,
    us,
)
from tests.sequencer_proof.signals import CYCLES_PER_US, Extremes
from tests.sequencer_proof.spread import Spread, bar, histogram
from tests.sequencer_proof.waiting import TURN_US
from tfsat_host.protocol.limits import SERVO_PULSE_MAX_US, SERVO_PULSE_MIN_US

BIN_CYCLES = 2


def render(proof: Proof) -> str:
    avr = [release for part in proof.avr for release in part.releases]
    fast = [release for part in proof.fast for release in part.releases]
    native = [release for part in proof.native for release in part]
    return "\n\n".join(
        [
            f"## 1. Releases\n\n{_how(avr + fast, native)}",
            f"**Onset of each stroke of 59/70 in the flashed image, {len(avr)} releases with slow chatter**, "
            "µs after the release:",
            _strokes(proof, avr),
            f"Errors of these {4 * len(avr)} strokes:",
            f"```\n{_histogram(avr)}\n```",
            f"**The same with fast chatter**, {len(fast)} releases, in one half of them mixed with slow. Where edges "
            "of both switches lie within a\nmicrosecond the rule has two answers, and the nearer one counts:",
            _strokes(proof, fast),
            f"Slow and fast mixed over {len(native)} releases of the *native* core, whose edges are exact to the tick:",
            _strokes(proof, native),
            _dates(proof),
            _signals(avr + fast, native),
            _waits(proof),
        ]
    )


def _how(avr: list[Release], native: list[Release]) -> str:
    most = max(release.contact_edges for release in avr + native)
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


def _strokes(proof: Proof, releases: Sequence[Release]) -> str:
    rows = []
    for number, (joint, change_cdeg, start_us) in enumerate(proof.avr[0].plan.strokes):
        errors = [release.errors[number] for release in releases]
        spread = Spread.of(errors)
        scheduled = start_us * CYCLES_PER_US
        measured = [us(scheduled + value) for value in (spread.least, spread.median, spread.greatest)]
        worst = signed_us(max(errors, key=abs))
        rows.append((number + 1, joint, f"{change_cdeg / 100:+g} deg", start_us, *measured, worst))
    header = ("stroke", "joint", "change", "scheduled", "measured: min", "median", "max", "worst error")
    return table(header, rows)


def _dates(proof: Proof) -> str:
    kinds = [
        [one for part in parts for one in part]
        for parts in (proof.dated, proof.fast_dated, proof.fastest_dated)
    ]
    off = [[abs(one.error_us) for one in dated] for dated in kinds]
    rows = [
        ("releases", *map(len, kinds)),
        ("within 1 µs", *(sum(one <= 1.0 for one in errors) for errors in off)),
        (
            f"off by 1 to {WORST_ERROR_US} µs",
            *(sum(1.0 < one <= WORST_ERROR_US for one in errors) for errors in off),
        ),
        (
            f"off by more than {WORST_ERROR_US} µs",
            *(sum(one > WORST_ERROR_US for one in errors) for errors in off),
        ),
        ("of these allowed: one in", *ONE_BEYOND_IN.values()),
        ("worst", *(f"{max(errors):.1f} µs" for errors in off)),
        ("with edges of both within 1 µs", *(sum(one.undecided for one in dated) for dated in kinds)),
    ]
    return (
        "**The date of the release**, that all strokes count from, in more releases and with the cable in, by "
        "RUN_REPORT\nagainst the switches. Where edges of both switches lie within a microsecond the rule has two "
        "answers, and the nearer one counts.\nThe switches' interrupt follows both from their first edge on. Only "
        "where other interrupts keep it waiting, three edges can hide\nthat both were open; then the board dates the "
        "release by their next meeting. How long that is, path by path, stands below:\n\n"
        + table(("", "slow chatter", "slow and fast mixed", "fast chatter"), rows)
    )


def _histogram(releases: Sequence[Release]) -> str:
    bins = histogram([error for release in releases for error in release.errors], BIN_CYCLES)
    most = max(count for _, count in bins)
    return "\n".join(
        f"{signed_us(low):>9} to {signed_us(low + BIN_CYCLES):>7} µs {count:5d}  {bar(count, most)}".rstrip()
        for low, count in bins
    )


def _signals(avr: list[Release], native: list[Release]) -> str:
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


def _waits(proof: Proof) -> str:
    rows: list[tuple[object, ...]] = []
    for wait in proof.waits:
        waited = f"armed, cable pulled, {wait.waited_us / 60e6:.1f} min after power-up"
        begins, ends = (
            (wait.waited_us + start_us) // TURN_US
            for start_us in (0, proof.avr[0].plan.strokes[-1][2])
        )  # fmt: skip
        turns = f"{begins} turns of the clock" + (", and one between the strokes" if ends > begins else "")
        rows.append((waited, f"{turns}; {wait.pulses} pulses held", _errors([wait.release])))
    ones, boths = (
        sum(part.one_switch for part in proof.knocks),
        sum(part.both_switches for part in proof.knocks),
    )
    flown = [part.release for part in proof.knocks]
    rows.append(
        (
            f"{ones} knocks that opened one switch for 20 ms, with fast chatter",
            "none started anything, all counted",
            "",
        )
    )
    rows.append(
        (
            f"{boths} knocks that opened both for less than the debounce, with fast chatter",
            "none started anything, all counted",
            "",
        )
    )
    rows.append((f"{len(flown)} releases after them, with fast chatter", "on time", _errors(flown)))
    return (
        "Waiting and knocks, in the flashed image. The 32-bit tick clock turns over every "
        f"{TURN_US / 60e6:.1f} min:\n\n" + table(("", "outcome", "errors of the strokes"), rows)
    )


def _errors(releases: Sequence[Release]) -> str:
    return signed_range_us(Extremes.of(error for release in releases for error in release.errors))
