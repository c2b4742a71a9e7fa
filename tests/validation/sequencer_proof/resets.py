"""Campaign 4: resets while armed and while running, and a main loop that hangs in every state."""

from __future__ import annotations

import random
from enum import Enum
from typing import NamedTuple

from tests.fixtures.planting import Edit
from tests.fixtures.sequencer.board import AvrBoard, ResetCause
from tests.fixtures.sequencer.cable import connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench, arm, pin_edges, seat
from tests.validation.sequencer_proof.releases import AFTER_RUN_US, MAX_WAIT_US, Plan, measure
from tests.validation.sequencer_proof.signals import (
    CYCLES_PER_MS,
    CYCLES_PER_TICK,
    CYCLES_PER_US,
    Extremes,
    PinEdge,
    Signal,
    read_signal,
)
from tests.validation.sequencer_proof.waiting import knock
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import SERVO_PULSE_MAX_US, STROKE_NOT_BEGUN_US
from tfsat_host.protocol.messages import RunReportReply, SequencerStatusReply

MAX_KNOCKS = 3
"""Between arming and what comes next."""
WATCH_US = 100_000
"""The servos are watched for so long after a reset."""
BAD_FRAME = b"\x05\xff\xff\xff\xff\x00"
"""Well-formed COBS with a wrong CRC."""
BAD_FRAMES = 3
HANG = Edit(
    "arduino_sequencer.ino",
    "  if (ready) host_link.poll();\n",
    f"  if (ready) host_link.poll();\n  while (host_link.rejected_frames() >= {BAD_FRAMES}) {{\n  }}\n",
)
"""The change that makes the firmware hang on order: after three damaged frames, in any state. A reset forgets them."""
HANG_LIMIT_US = 1_300_000
"""The watchdog's second, and the 10 % that its oscillator may be off, and time to look."""
LOOK_US = 1000


class Moment(Enum):
    """What the board was doing, and where its switches were after the reset."""

    ARMED = "armed, both switches closed"
    ARMED_FIRST_OPEN = "armed, switch 1 open"
    ARMED_SECOND_OPEN = "armed, switch 2 open"
    ARMED_BOTH_OPEN = "armed, both switches open"
    RUNNING = "running"

    @property
    def opened(self) -> tuple[int, ...]:
        return {
            Moment.ARMED_FIRST_OPEN: (0,),
            Moment.ARMED_SECOND_OPEN: (1,),
            Moment.ARMED_BOTH_OPEN: (0, 1),
        }.get(self, ())

    @property
    def fault(self) -> ErrorCode:
        if self is Moment.ARMED:
            return ErrorCode.NONE
        return ErrorCode.RESET_WHILE_RUNNING if self is Moment.RUNNING else ErrorCode.RESET_WHILE_ARMED


class Resets(NamedTuple):
    """Outcomes of one kind of reset at random moments.

    Attributes:
        fault: Latched afterwards; `none`: ARMED again.
        silence_ms: From the reset to the first pulse of each servo.
        errors_us: Of the strokes after the release that followed, where one did.
    """

    moment: Moment
    cause: ResetCause
    resets: int
    fault: ErrorCode
    silence_ms: Extremes
    errors_us: Extremes | str


def reset_board(bench: Bench, moment: Moment, cause: ResetCause, count: int, seed: int) -> Resets:
    """Resets one board again and again. Raises Broken where it does not come back as it must."""
    rng = random.Random(seed)
    board = bench.board()
    client = connect(board)
    plan = Plan.on(client)
    silences: list[int] = []
    errors: list[int] = []
    for _ in range(count):
        last = client.run_report()
        before = _bring_to(board, client, moment, plan, rng)
        at = board.now_cycle
        for index in moment.opened:
            board.switch(index, closed=False)
        board.reset(cause)
        signal = watch_after_reset(board, at)
        silences += [train[0].rise - at for train in signal.trains]
        check_held_widths(signal, before.widths)
        client = connect(board)
        check_state(client.status(), moment, cause.name, before.knocks)
        check_report(client.run_report(), before.begun_us, last)
        if moment is Moment.ARMED:
            errors += _fly_on(board, plan)
            client = connect(board)
        client.disarm()
        _check_safe(board, client)
    board.close()
    errors_us = Extremes.of(errors, CYCLES_PER_US) if errors else ""
    return Resets(moment, cause, count, moment.fault, Extremes.of(silences, CYCLES_PER_MS), errors_us)


class Before(NamedTuple):
    """What the board knew before its reset."""

    widths: list[int]
    """Of each servo's pulses, cycles."""
    knocks: int
    begun_us: tuple[int, ...] | None
    """When the strokes of the run began that had begun, after the release; None while ARMED."""


def _bring_to(
    board: AvrBoard, client: SequencerClient, moment: Moment, plan: Plan, rng: random.Random
) -> Before:
    """Bring the board to a random time of the state, after some knocks."""
    arm(board, client)
    knocks = rng.randint(0, MAX_KNOCKS)
    for _ in range(knocks):
        knock(board, rng, both=rng.random() < 0.5)
    board.run_to_cycle(board.now_cycle + rng.randint(50_000, MAX_WAIT_US) * CYCLES_PER_US)
    if moment is not Moment.RUNNING:
        return Before([widths[0] * CYCLES_PER_TICK for widths in plan.widths()], knocks, None)
    for index in (0, 1):
        board.switch(index, closed=False)
    # No pulse of a stroke is the first and under way, so that it is plain which width was the last.
    after_us = rng.randint(20_000, plan.end_us - 20_000)
    for _, _, start_us in plan.strokes:
        if -1000 < after_us - start_us < SERVO_PULSE_MAX_US + 1000:
            after_us = start_us + SERVO_PULSE_MAX_US + 1000
    board.run_to_cycle(board.now_cycle + after_us * CYCLES_PER_US)
    begun = tuple(start_us for _, _, start_us in plan.strokes if start_us <= after_us)
    return Before(widths_at(plan, after_us), knocks, begun)


def widths_at(plan: Plan, after_us: int) -> list[int]:
    """Return each servo's pulse width `after_us` after the release, in cycles."""
    begun = [0] * len(plan.widths())
    for joint, _, start_us in plan.strokes:
        begun[joint - 1] += start_us <= after_us
    return [widths[n] * CYCLES_PER_TICK for widths, n in zip(plan.widths(), begun, strict=True)]


def watch_after_reset(board: AvrBoard, at: int) -> Signal:
    """Read the servos' signals from the reset on.

    A pulse under way at the reset ends with it and does not count.
    """
    board.run(WATCH_US)
    risen: set[int] = set()
    edges: list[PinEdge] = []
    for edge in pin_edges(board):
        if edge.cycle > at and edge.high:
            risen.add(edge.pin)
        if edge.pin in risen:
            edges.append(edge)
    return read_signal(edges)


def check_held_widths(signal: Signal, expected: list[int]) -> None:
    """Raises Broken where a servo is told anything but what it was told before."""
    signal.check_widths()
    for joint, (train, width) in enumerate(zip(signal.trains, expected, strict=True), start=1):
        pulse_widths = {pulse.width for pulse in train}
        if pulse_widths != {width}:
            raise Broken(
                f"servo {joint} gets pulses of {sorted(pulse_widths)} cycles after the reset, {width} before"
            )


def check_state(status: SequencerStatusReply, moment: Moment, cause: str, knocks: int) -> None:
    """Raises Broken where the board did not come back in the right state, or hides what happened."""
    state = SequencerState.ARMED if moment is Moment.ARMED else SequencerState.FAULT
    if (status.state, status.fault, status.reset_cause.name) != (state, moment.fault, cause):
        raise Broken(
            f"reset while {moment.value}: {status.state.name}, fault {status.fault.name}, "
            f"cause {status.reset_cause.name}"
        )
    if moment is not Moment.RUNNING and status.resets_while_armed != 1:
        raise Broken(f"{status.resets_while_armed} resets while armed are counted, not 1")
    if status.knocks != knocks:
        raise Broken(f"{status.knocks} knocks are counted after the reset, {knocks} were before")


def check_report(report: RunReportReply, begun_us: tuple[int, ...] | None, last: RunReportReply) -> None:
    """Raises Broken where RUN_REPORT does not tell of the run that was reset; where there was none, of the last."""
    if begun_us is None:
        if report != last:
            raise Broken(f"the reset turned RUN_REPORT from {last} into {report}")
        return
    told_us = tuple(start_us for start_us in report.start_us if start_us != STROKE_NOT_BEGUN_US)
    if not report.released or told_us != begun_us or report.start_us[: len(begun_us)] != begun_us:
        raise Broken(f"RUN_REPORT tells of strokes at {report.start_us}, {begun_us} had begun")


def _fly_on(board: AvrBoard, plan: Plan) -> tuple[int, ...]:
    """Without a cable; the release must be flown as if nothing had happened."""
    board.cable(False)
    board.run(WATCH_US)
    board.switch(0, closed=False)
    board.run(100)
    board.switch(1, closed=False)
    released = board.now_cycle
    board.run(plan.end_us + AFTER_RUN_US)
    return measure(pin_edges(board), plan, released).errors


def _check_safe(board: AvrBoard, client: SequencerClient) -> None:
    """DISARM clears everything."""
    seat(board)
    status = client.status()
    if (status.state, status.fault) != (SequencerState.SAFE, ErrorCode.NONE):
        raise Broken(f"{status.state.name}, fault {status.fault.name} after DISARM")
    if status.resets_while_armed:
        raise Broken("DISARM left a reset counted")


class Hangs(NamedTuple):
    """Main loops that hung in one state; from the order to hang to the reset."""

    state: SequencerState
    hangs: int
    reset_after_ms: Extremes


def hang_board(bench: Bench, state: SequencerState, count: int, seed: int) -> Hangs:
    """Lets the main loop of an image with HANG hang at random moments of a state.

    Raises Broken where the watchdog does not bite, or the board comes back wrongly.
    """
    rng = random.Random(seed)
    board = bench.board()
    client = connect(board)
    plan = Plan.on(client)
    durations_us = []
    for _ in range(count):
        knocks = 0
        client.disarm()
        seat(board)
        if state == SequencerState.ARMED:
            arm(board, client)
        elif state == SequencerState.RUNNING:
            knocks = _bring_to(board, client, Moment.ARMED, plan, rng).knocks
            for index in (0, 1):
                board.switch(index, closed=False)
            board.run(10_000)
        board.run(rng.randint(0, 200_000))
        durations_us.append(_hang(board))
        client = connect(board)
        status = client.status()
        if state == SequencerState.SAFE:
            if (status.state, status.reset_cause.name) != (SequencerState.SAFE, ResetCause.WATCHDOG.name):
                raise Broken(f"{status.state.name} after a hang while SAFE, cause {status.reset_cause.name}")
        else:
            moment = Moment.ARMED if state == SequencerState.ARMED else Moment.RUNNING
            check_state(status, moment, ResetCause.WATCHDOG.name, knocks)
    board.close()
    return Hangs(state, count, Extremes.of(durations_us, 1000))


def _hang(board: AvrBoard) -> int:
    """Orders it; returns how long the reset took to come, us."""
    ordered_us = board.now_us
    board.write(b"\0" + BAD_FRAME * BAD_FRAMES)
    while board.link_ready:
        if board.now_us > ordered_us + HANG_LIMIT_US:
            raise Broken(f"no reset within {HANG_LIMIT_US} us of a main loop that hangs")
        board.run(LOOK_US)
    return board.now_us - ordered_us
