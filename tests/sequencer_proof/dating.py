"""Campaign 1b: very many releases, for the one number that all strokes count from: the release's date.

Nothing is flown to its end, so that there are forty thousand of them in the time of a few hundred runs: what a race of
two interrupts does is seen once in some thousands.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

from tests.proof.campaign import Broken, table
from tests.sequencer_proof.contacts import Chatter, Contact, admissible, open_switches, opening
from tests.sequencer_proof.releases import WORST_ERROR_US
from tests.sequencer_proof.rigs import SETTLE_US, Bench, Rig, arm, run_us
from tests.sequencer_proof.signals import CYCLES_PER_US
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import SequencerState

ONE_BEYOND_IN = {Chatter.SLOW: 10_000, Chatter.BOTH: 2_000, Chatter.FAST: 2_000}
"""No more often may a date be off by more than is allowed; see `judge_dates`."""


@dataclass(frozen=True, slots=True)
class Dated:
    """One release. `error_us`: its date by the board less the switches' own, to a whole microsecond."""

    error_us: float
    undecided: bool
    """Edges of both switches so close together that the rule has two answers; the nearer one counts."""


def dated_releases(bench: Bench, chatter: Chatter, seed: int, count: int) -> list[Dated]:
    """On one powered board with its cable in: USB's interrupts run, too."""
    rig = bench.rig()
    client = rig.connect()
    rng = random.Random(seed)
    start = _armed(rig, client, rng)
    first = open_switches(rig, [Contact(start, 0, False), Contact(start + 1000 * CYCLES_PER_US, 1, False)])
    zero_us = _told_us(rig, client) - first / CYCLES_PER_US
    found = [_dated(rig, client, rng, chatter, zero_us) for _ in range(count)]
    rig.close()
    return found


def judge_dates(dated: Sequence[Dated], chatter: Chatter) -> None:
    """Raises Broken where dates are off.

    Where both switches move while interrupts are off (see `blocking`) and one of them moves back before they are on
    again, the board may miss that they were open together, until they are again: that rare it must be.
    """
    beyond = [one.error_us for one in dated if abs(one.error_us) > WORST_ERROR_US]
    if len(beyond) > len(dated) / ONE_BEYOND_IN[chatter]:
        raise Broken(
            f"{len(beyond)} of {len(dated)} releases were dated wrong, by {max(map(abs, beyond))} us"
        )


def _dated(rig: Rig, client: SequencerClient, rng: random.Random, chatter: Chatter, zero_us: float) -> Dated:
    contacts = opening(rng, _armed(rig, client, rng), rig.resolution, chatter)
    open_switches(rig, contacts)
    told_us = _told_us(rig, client) - zero_us
    errors = [told_us - cycle / CYCLES_PER_US for cycle in admissible(contacts)]
    return Dated(min(errors, key=abs), len(errors) > 1)


def _armed(rig: Rig, client: SequencerClient, rng: random.Random) -> int:
    """Then the cycle at which the release is to begin."""
    arm(rig, client)
    return rig.now + rng.randint(1_000, 4_000) * CYCLES_PER_US + rng.randrange(CYCLES_PER_US)


def _told_us(rig: Rig, client: SequencerClient) -> float:
    run_us(rig, SETTLE_US)
    report, status = client.run_report(), client.status()
    if status.state != SequencerState.RUNNING or status.knocks:
        raise Broken(f"after a release: {status.state.name}, {status.knocks} knocks")
    return report.release_ms * 1000.0 + report.release_us


def page(kinds: Sequence[Sequence[Dated]]) -> str:
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
