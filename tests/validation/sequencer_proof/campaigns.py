"""The full campaigns: what runs, how much of it, from which seeds on, and what only all of it together shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from tests.fixtures.sequencer.board import ResetCause
from tests.fixtures.sequencer.cable import TOGETHER
from tests.validation.campaign import Broken, Campaign, Found
from tests.validation.sequencer_proof.bench import Bench, image_report
from tests.validation.sequencer_proof.contacts import Chatter
from tests.validation.sequencer_proof.damage import Case, damage_image, damage_native
from tests.validation.sequencer_proof.half_transfers import HOSTS_US, disturbed_releases, judge_disturbed
from tests.validation.sequencer_proof.held_pins import LEVELS, SUBSETS, held_pins
from tests.validation.sequencer_proof.jog_lives import jog_lives
from tests.validation.sequencer_proof.jolts import closed_again, jolted_releases
from tests.validation.sequencer_proof.link import STATES, Abuse, Noise, abuse_link, begins_us, make_noise
from tests.validation.sequencer_proof.one_closed import one_closed_again
from tests.validation.sequencer_proof.one_rule import one_rule
from tests.validation.sequencer_proof.power_cuts import History, Record, cut_points, second_upload_writes
from tests.validation.sequencer_proof.releases import (
    Flights,
    all_releases,
    avr_releases,
    dated_releases,
    judge,
    judge_dates,
    native_releases,
)
from tests.validation.sequencer_proof.resets import Moment, hang_board, reset_board
from tests.validation.sequencer_proof.waiting import ACROSS_TURN_US, LONG_WAIT_US, knocks, long_wait

FAST_BEYOND = 1
"""Of all releases with fast chatter, so many may be off by more than is allowed."""
ABUSE_JOBS = 6
CAUSES = (ResetCause.WATCHDOG, ResetCause.BROWN_OUT)
ON_TIME = "each stroke begins within 50 µs of its time, by the pins and by RUN_REPORT"
DATES = {
    Chatter.SLOW: ("dated", 2700, 16),
    Chatter.BOTH: ("fast_dated", 2800, 8),
    Chatter.FAST: ("fastest_dated", 2900, 8),
}
"""Name, seed and jobs of the campaign with each chatter."""


def campaigns(bench: Bench, hanging_image: Path, native: Path, rule: Path) -> list[Campaign]:
    """Declare the campaigns, the longest jobs first.

    `native` and `rule` are libraries; `hanging_image` contains `resets.HANG`.
    """
    hanging, begins = replace(bench, image=hanging_image), begins_us()
    together = bench.flying(TOGETHER)
    # Both chatters alternate: half of the runs with the fast one alone.
    fast = [(Chatter.BOTH, Chatter.FAST)[number % 2] for number in range(10)]
    return [
        Campaign("waits", f"armed for long, then: {ON_TIME}",
                 [partial(long_wait, bench, waited_us=us) for us in (LONG_WAIT_US, ACROSS_TURN_US)], 1),
        Campaign("native", f"in the native core {ON_TIME}", [partial(native_releases, native, count=500)] * 20, 1000),
        Campaign("avr", ON_TIME, [partial(avr_releases, bench, Chatter.SLOW, count=10)] * 10, 2000),
        Campaign("fast", f"{ON_TIME}; {FAST_BEYOND} release may miss it",
                 [partial(avr_releases, bench, kind, count=10, most_beyond=FAST_BEYOND) for kind in fast], 2500,
                 judge=_judge_fast),
        *(Campaign(name, "the date is within 50 µs of the first edge at which both switches were open",
                   [partial(dated_releases, bench, chatter, count=2_500)] * jobs, seed,
                   judge=partial(judge_dates, chatter=chatter))
          for chatter, (name, seed, jobs) in DATES.items()),
        Campaign("jolted", "the reported interval holds the moment at which the robot left",
                 [partial(jolted_releases, bench, count=1_500)] * 8, 10_000),
        Campaign("disturbed", "what is reported holds the release; dates as with a sound host",
                 [partial(disturbed_releases, bench, every_us, count=1_000) for every_us in HOSTS_US * 2], 10_050,
                 judge=judge_disturbed),
        Campaign("one_closed", "an interval holds the release, or after 60 ms the last opening is the date",
                 [partial(one_closed_again, bench, count=300)] * 4, 10_070),
        Campaign("closed", "closed again: armed before the first stroke, FAULT and servos held after it",
                 [partial(closed_again, bench, count=25)] * 4, 10_100),
        Campaign("rule", "sequencer, logger and decoder find the same releases",
                 [partial(one_rule, library=rule, trains=50_000)] * 20, 10_200),
        Campaign("knocks", f"counted, nothing moves, and then {ON_TIME}", [partial(knocks, bench, count=50)] * 4, 3000),
        Campaign("cuts", "old record or new one, whole; ARM refused where an upload was begun; the other store intact",
                 [partial(cut_points, bench, record, history) for record in Record for history in History], 4000),
        Campaign("damaged", "armed with what was committed last, or refused for a reason of the store",
                 [partial(damage_native, native, case) for case in Case], 4100),
        # The image itself over fewer cases: it must answer as the native core does.
        Campaign("damaged_image", "the image holds and answers what the native core does",
                 [partial(damage_image, bench, native, case, count=100) for case in Case], 4200),
        Campaign("abused", "each stroke begins on the cycle of the undisturbed run",
                 [partial(abuse_link, bench, abuse, begins[part::ABUSE_JOBS])
                  for abuse in Abuse for part in range(ABUSE_JOBS)], 5000),
        Campaign("noisy", "no change of state, EEPROM, servo; strokes on the cycles of the undisturbed run",
                 [partial(make_noise, bench, Noise.BYTES, 10_002, 10)] * 10
                 + [partial(make_noise, bench, Noise.FRAMES, 3_000, 6)] * 6, 6000),
        Campaign("resets", "state, fault, knocks, run report and pulse widths are those of before",
                 [partial(reset_board, bench, moment, cause, 25) for moment in Moment for cause in CAUSES], 7000),
        Campaign("hangs", "the watchdog resets within 1.3 s; then as after a reset",
                 [partial(hang_board, hanging, state, 10) for state in STATES], 8000),
        Campaign("held", "servos keep their pins' last whole width; STATUS and RUN_REPORT agree with the pins",
                 [partial(held_pins, bench, joints, level, 100) for level in LEVELS for joints in SUBSETS], 9000),
        Campaign("jogs", "a joint moves while somebody asks, within its limits, at its speed, and is let go in time",
                 [partial(jog_lives, bench, count=50)] * 20, 11_000, 50),
        Campaign("together", f"strokes of joints that move together: {ON_TIME}",
                 [partial(avr_releases, together, Chatter.SLOW, count=10)] * 10, 12_000),
        Campaign("together_closed", "such strokes, closed again: as for 59/70",
                 [partial(closed_again, together, count=25)] * 2, 12_100),
        Campaign("together_abused", "such strokes, abused: each begins on the cycle of the undisturbed run",
                 [partial(abuse_link, together, abuse, begins[part::ABUSE_JOBS])
                  for abuse in Abuse for part in range(2)], 12_200),
        Campaign("together_resets", "such strokes, resets: as for 59/70",
                 [partial(reset_board, together, moment, cause, 25) for moment in Moment for cause in CAUSES], 12_300),
        Campaign("together_held", "such strokes, pins held: as for 59/70",
                 [partial(held_pins, together, joints, level, 50) for level in LEVELS for joints in SUBSETS], 12_400),
        Campaign("rewrites", "an upload of what is stored writes a begun marker and its end at most",
                 [partial(second_upload_writes, bench, record) for record in Record]),
    ]  # fmt: skip


def _judge_fast(flights: Sequence[Flights]) -> None:
    # Of all releases together, not of one job: a rare miss is allowed once.
    judge(all_releases(flights), FAST_BEYOND)


def least_never_used(results: Found) -> int:
    """Bytes of stack that nothing has touched in any campaign."""
    return min(
        int(part.never_used) for name in ("avr", "fast", "cuts", "abused", "noisy") for part in results[name]
    )


def judge_stack(never_used: int, image: Path) -> None:
    """Raises Broken where the stack came too near to the variables."""
    spare = int(image_report(image)["stack_spare_bytes"])
    # The build's own spare bytes are the limit, not a guess.
    if never_used < spare:
        raise Broken(f"only {never_used} bytes of stack were never touched, {spare} must be")
