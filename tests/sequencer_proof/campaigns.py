"""All campaigns together: what runs, how much of it, on all cores."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from tests.emulator_avr.avr_board import ResetCause
from tests.proof.campaign import Broken, Job
from tests.sequencer_proof.contacts import Chatter
from tests.sequencer_proof.damage import Case, Damaged, DamagedImage, damage_image, damage_native
from tests.sequencer_proof.dating import Dated, dated_releases, judge_dates
from tests.sequencer_proof.held_pins import LEVELS, SUBSETS, HeldPins, held_pins
from tests.sequencer_proof.jolts import ClosedAgain, Jolted, closed_again, jolted_releases, judge_jolted
from tests.sequencer_proof.link_abuse import Abuse, Abused, abuse_link, begins_us
from tests.sequencer_proof.noise import STATES, Noise, Noisy, make_noise
from tests.sequencer_proof.one_rule import Agreement, one_rule
from tests.sequencer_proof.power_cuts import Cuts, History, Record, cut_points, second_upload_writes
from tests.sequencer_proof.releases import AvrReleases, Release, avr_releases, judge, native_releases
from tests.sequencer_proof.resets import Hangs, Moment, Resets, hang_board, reset_board
from tests.sequencer_proof.rigs import Bench, image_report
from tests.sequencer_proof.waiting import ACROSS_TURN_US, LONG_WAIT_US, Knocks, Wait, knocks, long_wait

NATIVE_JOBS, NATIVE_RELEASES = 20, 500
AVR_JOBS, AVR_RELEASES = 10, 10
DATED_JOBS, FAST_DATED_JOBS, DATED_RELEASES = 16, 8, 2_500
JOLT_JOBS, JOLTED = 8, 1_500
CLOSED_JOBS, CLOSED = 4, 25
RULE_JOBS, TRAINS = 20, 50_000
KNOCK_JOBS, KNOCKS = 4, 50
FAST_BEYOND = 1
"""Of all these releases, so many may be off by more than is allowed."""
IMAGE_DAMAGES = 100
ABUSE_JOBS = 6
BYTE_JOBS, BYTES, BYTE_DROPS = 10, 10_002, 10
FRAME_JOBS, FRAMES, FRAME_DROPS = 6, 3_000, 6
RESETS = 25
HANGS = 10
HELD_RUNS = 100
REWRITES = (8, 0)
"""Byte writes of an upload of what is stored, by Record: a begun maneuver's marker, and its end."""
CAUSES = (ResetCause.WATCHDOG, ResetCause.BROWN_OUT)
SEED_OF = {
    "waits": 1,
    "native": 1000,
    "avr": 2000,
    "fast": 2500,
    "dated": 2700,
    "fast_dated": 2800,
    "fastest_dated": 2900,
    "knocks": 3000,
    "cuts": 4000,
    "damaged": 4100,
    "damaged_image": 4200,
    "abused": 5000,
    "noisy": 6000,
    "resets": 7000,
    "hangs": 8000,
    "held": 9000,
    "jolted": 10_000,
    "closed": 10_100,
    "rule": 10_200,
}
"""Seed of a campaign's first job; the next job has the next."""


@dataclass(frozen=True, slots=True)
class Proof:
    """What all campaigns found."""

    waits: list[Wait]
    native: list[list[Release]]
    avr: list[AvrReleases]
    fast: list[AvrReleases]
    """Likewise, with chatter that is faster than an interrupt: mixed with slow, and alone, in turn."""
    dated: list[list[Dated]]
    fast_dated: list[list[Dated]]
    fastest_dated: list[list[Dated]]
    """By the fast kind alone."""
    jolted: list[list[Jolted]]
    closed: list[ClosedAgain]
    rule: list[Agreement]
    knocks: list[Knocks]
    cuts: list[Cuts]
    damaged: list[Damaged]
    damaged_image: list[DamagedImage]
    rewrites: list[int]
    abused: list[Abused]
    noisy: list[Noisy]
    resets: list[Resets]
    hangs: list[Hangs]
    held: list[HeldPins]

    @property
    def never_used(self) -> int:
        """Bytes of stack that nothing has touched in any campaign."""
        parts: list[AvrReleases | Cuts | Abused | Noisy] = [
            *self.avr,
            *self.fast,
            *self.cuts,
            *self.abused,
            *self.noisy,
        ]
        return min(part.never_used for part in parts)


def all_jobs(bench: Bench, hanging_image: Path, native: Path, rule: Path) -> dict[str, list[Job]]:
    """The full campaigns; the longest jobs first."""
    hanging = replace(bench, image=hanging_image)
    begins = begins_us()
    jobs: dict[str, list[Callable[..., Any]]] = {
        "waits": [partial(long_wait, bench, waited_us=us) for us in (LONG_WAIT_US, ACROSS_TURN_US)],
        "native": [partial(native_releases, native, count=NATIVE_RELEASES)] * NATIVE_JOBS,
        "avr": [partial(avr_releases, bench, Chatter.SLOW, count=AVR_RELEASES)] * AVR_JOBS,
        "fast": [
            partial(avr_releases, bench, (Chatter.BOTH, Chatter.FAST)[number % 2], count=AVR_RELEASES)
            for number in range(AVR_JOBS)
        ],
        "dated": [partial(dated_releases, bench, Chatter.SLOW, count=DATED_RELEASES)] * DATED_JOBS,
        "fast_dated": [partial(dated_releases, bench, Chatter.BOTH, count=DATED_RELEASES)] * FAST_DATED_JOBS,
        "fastest_dated": [partial(dated_releases, bench, Chatter.FAST, count=DATED_RELEASES)]
        * FAST_DATED_JOBS,
        "jolted": [partial(jolted_releases, bench, count=JOLTED)] * JOLT_JOBS,
        "closed": [partial(closed_again, bench, count=CLOSED)] * CLOSED_JOBS,
        "rule": [partial(one_rule, library=rule, trains=TRAINS)] * RULE_JOBS,
        "knocks": [partial(knocks, bench, count=KNOCKS)] * KNOCK_JOBS,
        "cuts": [partial(cut_points, bench, record, history) for record in Record for history in History],
        "damaged": [partial(damage_native, native, case) for case in Case],
        "damaged_image": [partial(damage_image, bench, native, case, count=IMAGE_DAMAGES) for case in Case],
        "abused": [
            partial(abuse_link, bench, abuse, begins[part::ABUSE_JOBS])
            for abuse in Abuse
            for part in range(ABUSE_JOBS)
        ],
        "noisy": [
            *[partial(make_noise, bench, Noise.BYTES, BYTES, BYTE_DROPS)] * BYTE_JOBS,
            *[partial(make_noise, bench, Noise.FRAMES, FRAMES, FRAME_DROPS)] * FRAME_JOBS,
        ],
        "resets": [
            partial(reset_board, bench, moment, cause, RESETS) for moment in Moment for cause in CAUSES
        ],
        "hangs": [partial(hang_board, hanging, state, HANGS) for state in STATES],
        "held": [
            partial(held_pins, bench, joints, level, HELD_RUNS) for level in LEVELS for joints in SUBSETS
        ],
    }
    seeded: dict[str, list[Job]] = {
        name: [partial(job, seed=SEED_OF[name] + number) for number, job in enumerate(part)]
        for name, part in jobs.items()
    }
    seeded["rewrites"] = [partial(second_upload_writes, bench, record) for record in Record]
    return seeded


def judge_all(proof: Proof, image: Path) -> None:
    """What a single job cannot judge. Raises Broken."""
    for part in proof.native:
        judge(part)
    judge([release for part in proof.avr for release in part.releases])
    judge([release for part in proof.fast for release in part.releases], FAST_BEYOND)
    judge_dates([one for part in proof.dated for one in part], Chatter.SLOW)
    judge_dates([one for part in proof.fast_dated for one in part], Chatter.BOTH)
    judge_dates([one for part in proof.fastest_dated for one in part], Chatter.FAST)
    for jolted in proof.jolted:
        judge_jolted(jolted)
    for closed in proof.closed:
        judge(closed.releases)
    judge([wait.release for wait in proof.waits] + [part.release for part in proof.knocks])
    if any(writes > most for writes, most in zip(proof.rewrites, REWRITES, strict=True)):
        raise Broken(f"an upload of what is stored wrote {proof.rewrites} bytes, not {REWRITES}")
    judge_stack(proof.never_used, image)


def judge_stack(never_used: int, image: Path) -> None:
    """Raises Broken where the stack came too near to the variables."""
    spare = int(image_report(image)["stack_spare_bytes"])
    if never_used < spare:
        raise Broken(f"only {never_used} bytes of stack were never touched, {spare} must be")
