"""Campaign 1, continued: hours of waiting, turns of the 32-bit tick clock, knocks that start nothing."""

from __future__ import annotations

import random
from typing import NamedTuple

from tests.fixtures.sequencer.board import Board
from tests.fixtures.sequencer.cable import connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench, arm, pin_edges
from tests.validation.sequencer_proof.contacts import (
    LATEST_SECOND_US,
    Chatter,
    Contact,
    bounce,
    draw,
    draw_opening,
    in_order,
    open_switches,
    play,
)
from tests.validation.sequencer_proof.releases import (
    AFTER_RUN_US,
    Plan,
    check_own_report,
    errors_us,
    fly,
    judge,
    measure,
)
from tests.validation.sequencer_proof.signals import (
    CYCLES_PER_TICK,
    CYCLES_PER_US,
    Extremes,
    PinEdge,
    read_signal,
)
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import RELEASE_DEBOUNCE_US

TURN_US = 2**32 * CYCLES_PER_TICK // CYCLES_PER_US
"""The tick clock is at 0 again: every 35.8 minutes."""
LONG_WAIT_US = 75 * 60 * 1_000_000
ACROSS_TURN_US = TURN_US - 1_250_000
"""Armed this long after power-up, a release has its strokes on both sides of the turn."""
LOOK_US = 20_000_000
ONE_SWITCH_US = 20_000
"""How long one switch opens in the crane's lift."""
KNOCK_PAUSE_US = 20_000


class Wait(NamedTuple):
    """An armed wait that ended in a release.

    Attributes:
        turns: Of the tick clock until then.
        turns_later: Until the last stroke.
        pulses: That held the servos meanwhile.
    """

    waited_min: float
    turns: int
    turns_later: int
    pulses: int
    errors_us: Extremes


def long_wait(bench: Bench, seed: int, waited_us: int) -> Wait:
    """Armed soon after power-up, the cable pulled; released this long after power-up. Raises Broken."""
    board = bench.board()
    client = connect(board)
    plan, rng = Plan.on(client), random.Random(seed)
    arm(board, client)
    board.cable(False)
    edges: list[PinEdge] = []
    pulses = 0
    while board.now_cycle < (waited_us - LOOK_US) * CYCLES_PER_US:
        board.run(LOOK_US)
        edges = [*edges, *pin_edges(board)]
        signal = read_signal(edges)
        if signal.onsets:
            raise Broken(f"a servo moved after {board.now_cycle // CYCLES_PER_US} us armed")
        pulses += sum(map(len, signal.trains))
        # Each pin's last rise without its fall stays for the next look.
        last = {edge.pin: edge for edge in edges}
        edges = [edge for edge in last.values() if edge.high]
    board.run_to_cycle(waited_us * CYCLES_PER_US)
    contacts = draw_opening(rng, board.now_cycle, board.resolution, Chatter.SLOW)
    released = open_switches(board, contacts)
    board.run(plan.end_us + AFTER_RUN_US)
    release = measure([*edges, *pin_edges(board)], plan, released, contact_edges=len(contacts))
    check_own_report(connect(board), plan, release)
    board.close()
    judge([release])
    turns, turns_later = ((waited_us + us) // TURN_US for us in (0, plan.strokes[-1][2]))
    return Wait(round(waited_us / 60e6, 1), turns, turns_later, pulses, errors_us([release]))


class Knocks(NamedTuple):
    """Knocks that started nothing, and the release after them."""

    one_switch: int
    both_switches: int
    errors_us: Extremes


def knocks(bench: Bench, seed: int, count: int) -> Knocks:
    """Knocks of both kinds with fast chatter in the image, then such a release.

    Raises Broken where a knock is not counted, or moves a servo.
    """
    board = bench.board()
    client = connect(board)
    plan, rng = Plan.on(client), random.Random(seed)
    arm(board, client)
    both_switches = 0
    for number in range(1, count + 1):
        both = rng.random() < 0.5
        both_switches += both
        knock(board, rng, both=both)
        status = client.status()
        if (status.state, status.knocks) != (SequencerState.ARMED, number):
            raise Broken(f"after {number} knocks: {status.state.name}, {status.knocks} counted")
    signal = read_signal(pin_edges(board))
    signal.check_widths()
    if signal.onsets:
        raise Broken("a knock moved a servo")
    release = fly(board, client, plan, rng, Chatter.FAST)
    board.close()
    judge([release])
    return Knocks(count - both_switches, both_switches, errors_us([release]))


def knock(board: Board, rng: random.Random, *, both: bool) -> None:
    """Open one switch for 20 ms, or both together for less than the debounce, and close again.

    Both open one after the other.
    """
    resolution, first = board.resolution, rng.randrange(2)

    def change(index: int, cycle: int, *, closed: bool) -> list[Contact]:
        return bounce(rng, Contact(cycle, index, closed), resolution, Chatter.FAST)

    contacts = change(first, board.now_cycle, closed=False)
    if both:
        second = board.now_cycle + draw(rng, 1, LATEST_SECOND_US, resolution)
        contacts = in_order([*contacts, *change(1 - first, second, closed=False)])
        back = second + draw(rng, 1, RELEASE_DEBOUNCE_US - 10, resolution)
        ends = max(back, contacts[-1].cycle + CYCLES_PER_US)
        play(board, in_order([*contacts, *change(0, ends, closed=True), *change(1, ends, closed=True)]))
    else:
        ends = board.now_cycle + ONE_SWITCH_US * CYCLES_PER_US
        play(board, [*contacts, *change(first, ends, closed=True)])
    board.run(KNOCK_PAUSE_US)
