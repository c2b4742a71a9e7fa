"""Section 1 of the report: releases."""

from __future__ import annotations

from collections.abc import Sequence

from tests.sequencer_proof.campaigns import Proof
from tests.sequencer_proof.contacts import LATEST_SECOND_US, LONGEST_US, MOST_BOUNCES
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
    native = [release for part in proof.native for release in part]
    return "\n\n".join(
        [
            f"## 1. Releases\n\n{_how(avr, native)}",
            f"**Onset of each stroke of 59/70 in the flashed image, {len(avr)} releases with bounce**, µs "
            "after the release:",
            _strokes(proof, avr),
            f"The same over {len(native)} releases of the *native* core:",
            _strokes(proof, native),
            f"Errors of all {4 * len(avr)} strokes in the flashed image:",
            f"```\n{_histogram(avr)}\n```",
            _signals(avr, native),
            _waits(proof),
        ]
    )


def _how(avr: list[Release], native: list[Release]) -> str:
    most = max(release.contact_edges for release in avr + native)
    return (
        f"Both switches open, either one first, the second up to {LATEST_SECOND_US / 1000:g} ms "
        "later, each with up to "
        f"{MOST_BOUNCES} bounces of up to {LONGEST_US} µs\n"
        f"closed and as long open (up to {most} edges in one release), at a random moment up to "
        f"{LONGEST_WAIT_US / 1000:g} ms after arming. The *onset* is the rise of the first\n"
        "pulse of the new width; time counts from the first edge at which both switches were open. "
        "Allowed: "
        f"{WORST_ERROR_US} µs."
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
    rows.append((f"{ones} knocks that opened one switch for 20 ms", "none started anything, all counted", ""))
    rows.append(
        (
            f"{boths} knocks that opened both for less than the debounce",
            "none started anything, all counted",
            "",
        )
    )
    rows.append((f"{len(flown)} releases after them", "on time", _errors(flown)))
    return (
        "Waiting and knocks, in the flashed image. The 32-bit tick clock turns over every "
        f"{TURN_US / 60e6:.1f} min:\n\n" + table(("", "outcome", "errors of the strokes"), rows)
    )


def _errors(releases: Sequence[Release]) -> str:
    return signed_range_us(Extremes.of(error for release in releases for error in release.errors))
