"""Campaign 5: servo pins that are held, and let go at any moment or never, then a reset at any moment.

The truth is what was on the pins: a servo has been told the width of the last whole pulse on its pin.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from tests.fixtures.sequencer.board import AvrBoard, PinHold, ResetCause
from tests.fixtures.sequencer.cable import connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench, arm, pin_edges
from tests.validation.sequencer_proof.releases import Plan
from tests.validation.sequencer_proof.signals import (
    CYCLES_PER_TICK,
    CYCLES_PER_US,
    STROKE_LINE,
    PinEdge,
    Pulse,
    whole_pulses,
)
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import (
    JOINT_COUNT,
    SERVO_PULSE_MAX_US,
    STROKE_NOT_BEGUN_US,
    STROKE_TIME_UNKNOWN_US,
)
from tfsat_host.protocol.messages import RunReportReply, SequencerStatusReply

SUBSETS = ((1,), (2,), (3,), (1, 2), (1, 3), (2, 3), (1, 2, 3))
"""Joints whose pins are held."""
LEVELS = (PinHold.LOW, PinHold.HIGH)
AFTER_END_US = 400_000
"""A reset may come so long after the run's end."""
SETTLED_US = 100
"""From a pulse's fall until its interrupt has surely marked the stroke."""
NOTED_US = 3_000
"""From there until the main loop has surely noted the time."""
EARLY_US = 1_000
"""A pulse of a stroke is looked for from so long before its time on."""
UNSEEN_US = 100
"""An interrupt may come so late: what happens to a pulse for less than that, nobody sees."""
ON_TIME_US = 50
REPORT_TOLERANCE_US = 2
WATCHED_US = 160_000
"""The servos are watched for so long after a reset; all pins are let go in the first half."""
MARK_US = 200
"""The stroke line follows a rise within this: another servo's edge may come first, and while strokes are ahead its
interrupt takes up to 173 us (paths.csv)."""


class Change(NamedTuple):
    """A pin is held, or let go."""

    cycle: int
    joint: int
    hold: PinHold


class HeldPins(NamedTuple):
    """What came of some runs with the same pins held at the same level."""

    joints: tuple[int, ...]
    level: PinHold
    runs: int
    on_time: int
    """Strokes."""
    late: int
    missed: int
    """Their time had come before the reset."""
    extra_marks: int
    """Of the stroke line, for pulses that were cut short."""


def held_pins(bench: Bench, joints: tuple[int, ...], level: PinHold, count: int, seed: int) -> HeldPins:
    """Runs in which these pins are held from before or from some moment on. Raises Broken."""
    rng = random.Random(seed)
    board = bench.board()
    # The plan as the board has it stored.
    plan = Plan.on(connect(board))
    on_time = late = missed = extra_marks = 0
    for _ in range(count):
        # A drawn run may be doubtful: it is drawn again, so that the number of runs stays.
        while (run := _fly(board, plan, joints, level, rng)) is None:
            pass
        on_time += sum(start_us is not None and not run.is_late(i) for i, start_us in enumerate(run.begun_us))
        late += sum(run.is_late(i) for i in range(len(run.begun_us)))
        missed += sum(
            begun_us is None and start_us < run.ended_us
            for begun_us, (_, _, start_us) in zip(run.begun_us, plan.strokes, strict=True)
        )
        extra_marks += run.extra_marks
        _reset_and_judge(board, run, rng)
    board.close()
    return HeldPins(joints, level, count, on_time, late, missed, extra_marks)


@dataclass(frozen=True, slots=True)
class _Run:
    """One run, until the moment of the reset, by what was on the pins."""

    plan: Plan
    begun_us: tuple[float | None, ...]
    """When each stroke's first whole pulse rose, after the release; None where it has not."""
    ended_us: float
    extra_marks: int

    def is_late(self, stroke: int) -> bool:
        begun_us = self.begun_us[stroke]
        return begun_us is not None and begun_us > self.plan.strokes[stroke][2] + ON_TIME_US

    @property
    def angles_cdeg(self) -> tuple[int, ...]:
        """That each servo has been told."""
        commanded_cdeg, angles = [0] * JOINT_COUNT, [0] * JOINT_COUNT
        for begun_us, (joint, change_cdeg, _) in zip(self.begun_us, self.plan.strokes, strict=True):
            angles[joint - 1] += change_cdeg
            if begun_us is not None:
                commanded_cdeg[joint - 1] = angles[joint - 1]
        return tuple(commanded_cdeg)

    @property
    def is_over(self) -> bool:
        """The board has come to the run's end, or has not; a reset in between is left out."""
        return self.ended_us > self.plan.end_us + SERVO_PULSE_MAX_US + 2 * NOTED_US


def _fly(
    board: AvrBoard, plan: Plan, joints: tuple[int, ...], level: PinHold, rng: random.Random
) -> _Run | None:
    """Fly up to the reset.

    Returns None where a pulse's width came out so near to a stroke's that they cannot be told apart.
    """
    # All pins free first: what the last run held must not hold over.
    for joint in range(1, JOINT_COUNT + 1):
        board.hold_pin(joint, PinHold.FREE)
    # Six in ten pins are held from before the run.
    before = [joint for joint in joints if rng.random() < 0.6]
    for joint in before:
        board.hold_pin(joint, level)
    # No cable in flight.
    board.cable(False)
    arm(board, connect(board))
    board.cable(False)
    board.run(rng.randint(20_000, 60_000))
    for index in (0, 1):
        board.switch(index, closed=False)
    released = board.now_cycle
    ends = released + _end_us(plan, rng) * CYCLES_PER_US
    _play(board, _changes(rng, plan, joints, before, level, released), ends)
    _settle(board, edges := pin_edges(board))
    if _is_doubtful(edges, plan):
        return None
    begun = _onsets(edges, plan, released)
    last = released + (plan.end_us + SERVO_PULSE_MAX_US + NOTED_US) * CYCLES_PER_US
    # A stroke back to where its joint never left has the width that the servo is told anyway.
    at_rest = _back_to_where_it_stands(plan, begun)
    if any(rise is not None and rise > last and not at_rest[i] for i, rise in enumerate(begun)):
        raise Broken(f"a stroke began after the run's end: {begun}")
    begun = [None if rise is not None and rise > last else rise for rise in begun]
    marks = [pulse.rise for pulse in whole_pulses(edges, STROKE_LINE)]
    _check_marks(marks, begun, board.now_cycle)
    return _Run(
        plan,
        tuple(None if rise is None else (rise - released) / CYCLES_PER_US for rise in begun),
        (board.now_cycle - released) / CYCLES_PER_US,
        max(0, len(marks) - sum(rise is not None for rise in begun)),
    )


def _end_us(plan: Plan, rng: random.Random) -> int:
    """Draw a time for the reset, in us after the release.

    It is not near the run's end, when the board may or may not be RUNNING still.
    """
    end_us = rng.randint(20_000, plan.end_us + AFTER_END_US)
    if plan.end_us - NOTED_US < end_us < plan.end_us + SERVO_PULSE_MAX_US + 3 * NOTED_US:
        end_us = plan.end_us + SERVO_PULSE_MAX_US + 3 * NOTED_US
    return end_us


def _changes(
    rng: random.Random,
    plan: Plan,
    joints: Iterable[int],
    held_joints: Sequence[int],
    level: PinHold,
    released: int,
) -> list[Change]:
    """Draw the changes of the held pins, in order of time.

    A free pin is held from some time on; many of the pins are let go later.
    """
    changes = []
    for joint in joints:
        first = 0 if joint in held_joints else _moment(rng, plan)
        if joint not in held_joints:
            changes.append(Change(released + first, joint, level))
        # Most held pins are let go again before the reset.
        if rng.random() < 0.6:
            freed = max(first + UNSEEN_US * CYCLES_PER_US, _moment(rng, plan))
            changes.append(Change(released + freed, joint, PinHold.FREE))
    return sorted(changes)


def _moment(rng: random.Random, plan: Plan) -> int:
    """Draw a time after the release, in cycles.

    It is often around the first pulse of a stroke, where it matters most.
    """
    if rng.random() < 0.5:
        return rng.randint(20_000, plan.end_us + AFTER_END_US) * CYCLES_PER_US
    _, _, start_us = rng.choice(plan.strokes)
    return (start_us - 500) * CYCLES_PER_US + rng.randint(0, 3_000 * CYCLES_PER_US)


def _play(board: AvrBoard, changes: Iterable[Change], ends: int) -> None:
    """Play the changes up to cycle `ends`; later ones are left out."""
    for cycle, joint, hold in changes:
        if cycle >= ends:
            break
        # A change that lies in the past is applied at once.
        board.run_to_cycle(max(cycle, board.now_cycle))
        board.hold_pin(joint, hold)
    board.run_to_cycle(max(ends, board.now_cycle))


def _settle(board: AvrBoard, edges: list[PinEdge]) -> None:
    """Run until no servo's pulse has just ended.

    Otherwise its interrupt may or may not have marked the stroke.
    """
    while any(
        edge.pin < JOINT_COUNT and not edge.high and board.now_cycle - edge.cycle < SETTLED_US * CYCLES_PER_US
        for edge in edges
    ):
        board.run(SETTLED_US)
        edges += pin_edges(board)


def _is_doubtful(edges: Sequence[PinEdge], plan: Plan) -> bool:
    """Return whether a pulse cannot be told from a stroke's.

    It is a little longer or shorter than a stroke's, or is hardly over when its pin goes high.
    """
    by_pin = ([edge for edge in edges if edge.pin == pin] for pin in range(JOINT_COUNT))
    if any(
        after.high and after.cycle - before.cycle < UNSEEN_US * CYCLES_PER_US
        for of_pin in by_pin
        for before, after in pairwise(of_pin)
    ):
        return True
    return any(
        0 < abs(pulse.width - width * CYCLES_PER_TICK) < UNSEEN_US * CYCLES_PER_US
        for pin, widths in enumerate(plan.widths())
        for pulse in whole_pulses(edges, pin)
        for width in widths
    )


def _onsets(edges: Sequence[PinEdge], plan: Plan, released: int) -> list[int | None]:
    """Return the rise of each stroke's first whole pulse, read from the pins alone."""
    trains = [whole_pulses(edges, pin) for pin in range(JOINT_COUNT)]
    widths = [iter(of_joint[1:]) for of_joint in plan.widths()]
    rises: list[int | None] = []
    for index, (joint, _, start_us) in enumerate(plan.strokes):
        width = next(widths[joint - 1]) * CYCLES_PER_TICK
        until_us = next(
            (us for other_joint, _, us in plan.strokes[index + 1 :] if other_joint == joint), 2 * plan.end_us
        )
        rises.append(
            next(
                (
                    pulse.rise
                    for pulse in trains[joint - 1]
                    if pulse.width == width
                    and start_us - EARLY_US <= (pulse.rise - released) / CYCLES_PER_US < until_us - EARLY_US
                ),
                None,
            )
        )
    return rises


def _back_to_where_it_stands(plan: Plan, begun: Sequence[int | None]) -> list[bool]:
    """Return for each stroke whether it ends where its joint already stands.

    The joint stands where the strokes before it that have begun left it.
    """
    stands, planned = [0] * JOINT_COUNT, [0] * JOINT_COUNT
    is_unmoved = []
    for rise, (joint, change_cdeg, _) in zip(begun, plan.strokes, strict=True):
        planned[joint - 1] += change_cdeg
        is_unmoved.append(planned[joint - 1] == stands[joint - 1])
        if rise is not None:
            stands[joint - 1] = planned[joint - 1]
    return is_unmoved


def _check_marks(marks: list[int], begun: list[int | None], now: int) -> None:
    for rise in begun:
        # The stroke line rises with the pulse, within MARK_US.
        near = [mark for mark in marks if rise is not None and rise < mark < rise + MARK_US * CYCLES_PER_US]
        shared = [mark for mark in marks if rise is not None and mark <= rise < mark + 1_300 * CYCLES_PER_US]
        # Just begun: the interrupt may not have marked it yet.
        over = rise is None or now - rise < 2_000 * CYCLES_PER_US
        if not (over or near or shared):
            raise Broken(f"a stroke began at cycle {rise}, the stroke line rose at {marks}")


def _reset_and_judge(board: AvrBoard, run: _Run, rng: random.Random) -> None:
    """Reset the board, then judge its pulses, STATUS and RUN_REPORT.

    Every pulse after the reset is one of before, or there are none; STATUS and RUN_REPORT tell what was.
    """
    cause = rng.choice((ResetCause.WATCHDOG, ResetCause.BROWN_OUT))
    board.reset(cause)
    at = board.now_cycle
    free_at = at + rng.randint(0, WATCHED_US // 2) * CYCLES_PER_US
    # Let go at a random moment in the first half of what is watched.
    _play(board, [Change(free_at, joint, PinHold.FREE) for joint in range(1, JOINT_COUNT + 1)], free_at + 1)
    board.run_to_cycle(at + WATCHED_US * CYCLES_PER_US)
    edges = pin_edges(board)
    connect(board)
    client = connect(board)
    status, report = client.status(), client.run_report()
    for joint in range(1, JOINT_COUNT + 1):
        after = [
            pulse
            for pulse in whole_pulses(edges, joint - 1)
            # A pulse across the moment of release cannot be judged.
            if pulse.rise > at and not pulse.rise - 1 <= free_at <= pulse.rise + pulse.width + 1
        ]
        _check_told(status, run, joint, after)
    _check_status(status, run, cause)
    _check_report(report, run)
    client.disarm()


def _check_told(status: SequencerStatusReply, run: _Run, joint: int, pulses: list[Pulse]) -> None:
    holding = status.state == SequencerState.FAULT and bool(status.servos_driven >> (joint - 1) & 1)
    width = run.plan.ticks(joint, run.angles_cdeg[joint - 1]) * CYCLES_PER_TICK
    pulse_widths = {pulse.width for pulse in pulses}
    # After the reset the servos hold the last width they were told, or none.
    if pulse_widths != ({width} if holding else set()):
        raise Broken(
            f"servo {joint} gets pulses of {sorted(pulse_widths)} cycles after the reset, {width} before "
            f"({'driven' if holding else 'limp'})"
        )


def _check_status(status: SequencerStatusReply, run: _Run, cause: ResetCause) -> None:
    begun = sum(begun_us is not None for begun_us in run.begun_us)
    # All strokes begun and the run over: the board is SAFE, else it is in FAULT.
    complete = begun == len(run.begun_us)
    fault = ErrorCode.STROKE_MISSED if run.is_over else ErrorCode.RESET_WHILE_RUNNING
    expected = (
        (SequencerState.SAFE, ErrorCode.NONE, 0, (0,) * JOINT_COUNT, 0)
        if run.is_over and complete
        else (SequencerState.FAULT, fault, begun, run.angles_cdeg, (1 << JOINT_COUNT) - 1)
    )
    actual_status = (
        status.state,
        status.fault,
        status.strokes_started,
        status.joint_angle_cdeg,
        status.servos_driven,
    )
    if actual_status != expected or status.reset_cause.name != cause.name:
        raise Broken(f"after a run with strokes at {run.begun_us}: {actual_status}, not {expected}")


def _check_report(report: RunReportReply, run: _Run) -> None:
    if not report.released or report.stroke_count != len(run.begun_us):
        raise Broken(f"RUN_REPORT forgot the run: {report}")
    for told_us, begun_us in zip(report.start_us, run.begun_us, strict=False):
        unknown = told_us == STROKE_TIME_UNKNOWN_US
        # A stroke just begun may not be in the report yet.
        just_begun = begun_us is not None and run.ended_us - begun_us < NOTED_US + SERVO_PULSE_MAX_US
        if unknown and just_begun:
            continue
        if begun_us is None:
            fits = told_us == STROKE_NOT_BEGUN_US
        else:
            fits = not unknown and abs(told_us - begun_us) <= REPORT_TOLERANCE_US
        if not fits:
            raise Broken(f"RUN_REPORT tells of {report.start_us}, the strokes began at {run.begun_us}")
