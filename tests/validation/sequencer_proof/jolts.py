"""Campaign 1d: jolts before the release. The truth is when the robot left, not what its contacts did."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import NamedTuple

from tests.fixtures.sequencer.board import Board
from tests.fixtures.sequencer.cable import connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import SETTLE_US, Bench, arm, pin_edges
from tests.validation.sequencer_proof.contacts import Chatter, Contact, Fall, Jolt, fall, open_switches, play
from tests.validation.sequencer_proof.releases import MAX_WAIT_US, Plan, Release, fly, judge
from tests.validation.sequencer_proof.signals import CYCLES_PER_MS, CYCLES_PER_US, read_signal
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import (
    RELEASE_BOUNCE_US,
    RELEASE_DEBOUNCE_US,
    RELEASE_SEATED_US,
)

MAX_JOLTS = 11
TOLERANCE_US = 1_100
"""Where contacts chatter on for long, the image loses edges until the main loop comes round, 1.02 ms at the most."""


class Jolted(NamedTuple):
    """One release after jolts.

    Attributes:
        jolts: How many opened both switches.
        error_us: The date less the moment at which the robot left.
        interval_us: Reported, width; 0: the edges fit one release.
    """

    jolts: int
    error_us: float
    interval_us: int


def jolted_releases(bench: Bench, seed: int, count: int) -> list[Jolted]:
    """Releases with up to eleven jolts before them. Raises Broken where the truth is not in what is reported."""
    board = bench.board()
    client = connect(board)
    rng = random.Random(seed)
    arm(board, client)
    start = board.now_cycle + CYCLES_PER_MS
    # A first release without chatter tells how the board's clock lies to the emulator's.
    first = open_switches(board, [Contact(start, 0, False), Contact(start + CYCLES_PER_MS, 1, False)])
    zero_us = _read_date(board, client)[0] - first / CYCLES_PER_US
    releases = [_jolt_board(board, client, rng, zero_us) for _ in range(count)]
    board.close()
    alone = max((abs(release.error_us) for release in releases if not release.jolts), default=0)
    if alone > 1_000:
        raise Broken(f"a release without a jolt is dated {alone} us wrong")
    return releases


def _jolt_board(board: Board, client: SequencerClient, rng: random.Random, zero_us: float) -> Jolted:
    arm(board, client)
    fallen, jolts = _draw_fall(rng, board)
    play(board, fallen.contacts)
    at_us, earlier_us, later_us = _read_date(board, client)
    error_us = at_us - zero_us - fallen.released / CYCLES_PER_US
    # The reported interval must hold the true moment; without jolts a single date must.
    if not -earlier_us - TOLERANCE_US <= -error_us <= later_us + TOLERANCE_US and earlier_us + later_us:
        raise Broken(f"the robot left {-error_us} us after the date, told -{earlier_us} to +{later_us} us")
    if not earlier_us + later_us and abs(error_us) > RELEASE_BOUNCE_US + TOLERANCE_US:
        raise Broken(f"a release is dated {error_us} us wrong, and nothing is said of it")
    both = sum(len(jolt.switches) == 2 for jolt in jolts)
    return Jolted(both, error_us, earlier_us + later_us)


def _draw_fall(rng: random.Random, board: Board) -> tuple[Fall, list[Jolt]]:
    """Jolts of 0.3 to 50 ms, 0.3 to 40 ms apart, most of them short, and contacts that bounce for up to 5 ms."""
    while True:
        jolts: list[Jolt] = []
        before_us = 0
        for _ in range(rng.randint(0, MAX_JOLTS)):
            most_us = rng.choice((3_000, 3_000, 40_000))
            before_us += rng.randint(300, most_us)
            # One of the lengths is just too short for a release.
            open_us = rng.randint(300, rng.choice((2_000, 2_000, RELEASE_DEBOUNCE_US - 200, 50_000)))
            before_us += open_us
            jolts.append(Jolt(before_us, open_us, rng.choice(((0, 1), (0, 1), (0, 1), (0,), (1,)))))
        released = board.now_cycle + (before_us + rng.randint(2_000, 30_000)) * CYCLES_PER_US
        chatter = rng.choice((Chatter.FAST, Chatter.FAST, Chatter.SLOW))
        try:
            fallen = fall(rng, released, board.resolution, chatter, jolts=jolts)
        # A jolt that is not over when the next begins cannot be judged: drawn again.
        except ValueError:
            continue
        # The release's own bounces end within 5 ms.
        if fallen.contacts[-1].cycle - released < 5 * CYCLES_PER_MS:
            return fallen, jolts


def _read_date(board: Board, client: SequencerClient) -> tuple[float, int, int]:
    board.run(SETTLE_US)
    report, status = client.run_report(), client.status()
    # Only a running board has dated its release.
    if status.state != SequencerState.RUNNING:
        raise Broken(f"after a release: {status.state.name}")
    return report.release_ms * 1000.0 + report.release_us, report.earlier_us, report.later_us


class ClosedAgain(NamedTuple):
    """Both switches closed again for good.

    Attributes:
        before: Runs in which that was before the first stroke: armed again, nothing moved.
        after: Runs in which it was after a stroke: the servos held, FAULT.
        releases: The drops after the first kind.
    """

    before: int
    after: int
    releases: list[Release]


def closed_again(bench: Bench, seed: int, count: int) -> ClosedAgain:
    """Jolts as long as a release, then the drop; and a robot that is caught in its run. Raises Broken."""
    board = bench.board()
    client = connect(board)
    plan, rng = Plan.on(client), random.Random(seed)
    first_us, last_us = plan.strokes[0][2], plan.strokes[-1][2]
    releases = []
    for _ in range(count):
        arm(board, client)
        # Open for longer than the debounce, closed before the first stroke: a release that was none.
        _close_again(board, rng, rng.randint(RELEASE_DEBOUNCE_US + 200, first_us - RELEASE_SEATED_US - 5_000))
        status = client.status()
        # One false release is counted, and the state is armed again.
        if (status.state, status.false_releases) != (SequencerState.ARMED, 1):
            raise Broken(f"closed again: {status.state.name}, {status.false_releases} false releases")
        board.run(rng.randint(1_000, MAX_WAIT_US))
        # No pin may move while the robot still hangs.
        if (signal := read_signal(pin_edges(board))).onsets:
            raise Broken(f"a servo moved on the crane: {signal.onsets}")
        releases.append(fly(board, client, plan, rng, Chatter.SLOW))
        arm(board, client)
        # Closed between the first stroke and the last: the robot was caught in its run.
        _close_again(board, rng, rng.randint(first_us + 5_000, last_us))
        _check_caught(board, client, plan)
    board.close()
    judge(releases)
    return ClosedAgain(count, count, releases)


def _close_again(board: Board, rng: random.Random, open_us: int) -> None:
    chatter = rng.choice((Chatter.FAST, Chatter.SLOW))
    jolt = Jolt(open_us, open_us)
    begins = board.now_cycle + rng.randint(1_000, 40_000) * CYCLES_PER_US
    # Only the jolt: what `fall` appends, the release itself, is left out.
    late = begins + (open_us + 20_000) * CYCLES_PER_US
    fallen = fall(rng, late, board.resolution, chatter, jolts=[Jolt(open_us + 20_000, jolt.open_us)])
    play(board, [contact for contact in fallen.contacts if contact.cycle < late])
    board.run(RELEASE_SEATED_US + 20_000)


def _check_caught(board: Board, client: SequencerClient, plan: Plan) -> None:
    """Check that the commanded angles stay after the fault and that no further stroke begins."""
    status = client.status()
    if (status.state, status.fault) != (SequencerState.FAULT, ErrorCode.CLOSED_WHILE_RUNNING):
        raise Broken(f"caught in its run: {status.state.name}, {status.fault.name}")
    board.run(plan.end_us)
    begun = len(read_signal(pin_edges(board)).onsets)
    # Strokes begun by the pins and by the board's own count.
    if begun != status.strokes_started:
        raise Broken(f"{begun} strokes began, {status.strokes_started} when the board stopped")
    commanded_cdeg = [0] * len(status.joint_angle_cdeg)
    for joint, change_cdeg, _ in plan.strokes[:begun]:
        # Held where the strokes so far commanded it.
        commanded_cdeg[joint - 1] += change_cdeg
    if list(status.joint_angle_cdeg) != commanded_cdeg:
        raise Broken(f"held at {status.joint_angle_cdeg}, commanded {commanded_cdeg}")


def jolt_rows(jolted: Sequence[Jolted]) -> list[tuple[object, ...]]:
    """Releases, the worst and the median error of their dates, the widest interval, ms."""
    kinds = {
        "none": [release for release in jolted if not release.jolts],
        "1 or more, the edges fit one release": [
            release for release in jolted if release.jolts and not release.interval_us
        ],
        "1 or more, the edges fit two: an interval is reported": [
            release for release in jolted if release.interval_us
        ],
    }
    rows = []
    for name, kind in kinds.items():
        errors = sorted(abs(release.error_us) for release in kind)
        widest = max(release.interval_us for release in kind)
        figures = (f"{us / 1000:.3f}" for us in (errors[-1], errors[len(errors) // 2]))
        rows.append((name, len(kind), *figures, f"{widest / 1000:.1f}" if widest else ""))
    return rows
