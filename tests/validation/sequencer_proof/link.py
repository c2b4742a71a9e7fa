"""Campaign 3: what a host can do to the link during a run, and noise in every state, beginning at any moment."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum
from functools import cache
from typing import NamedTuple

from tests.fixtures.sequencer.board import AvrBoard
from tests.fixtures.sequencer.cable import connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench, arm, pin_edges, seat, stack_never_used
from tests.validation.sequencer_proof.releases import AFTER_RUN_US, Plan, measure
from tests.validation.sequencer_proof.signals import CYCLES_PER_TICK, CYCLES_PER_US, read_signal
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol import messages
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.limits import JOG_CONFIRM, MAX_PAYLOAD_BYTES
from tfsat_host.protocol.messages import (
    ArmRequest,
    DisarmRequest,
    ErrorReply,
    JogRequest,
    JointReportRequest,
    ManeuverBeginRequest,
    SequencerStatusRequest,
)
from tfsat_host.protocol.record import Payload

STEP_US = 10_000
LAST_BEGIN_US = 2_500_000
TALK_US = 10_000
"""Until the abuse begins, the host asks for STATUS this often and reads the answer."""
FLOOD_STEP_US = 1000
FLOOD_BYTES = 512
"""Each step; more than full-speed USB carries to this board."""
QUESTION = encode_frame(Frame(SequencerStatusRequest.TYPE, 7, b""))
FILLING_US = 450_000
"""As long as it takes to fill the host's buffer of 4096 bytes with answers to questions each 2 ms."""


class Abuse(Enum):
    """What the host does from some moment on."""

    PULLED = "cable pulled"
    REQUESTS = "flood of valid requests, answers never read"
    GARBAGE = "flood of random bytes, answers never read"
    SILENT = "port open, IN endpoint not read, requests pending"


class Abused(NamedTuple):
    """Outcomes of the runs with one kind of abuse."""

    abuse: Abuse
    runs: int
    moved: int
    """Runs in which a stroke did not begin exactly as in the undisturbed run."""
    never_used: int


def begins_us() -> list[int]:
    """Return the start times of the abuse: every 10 ms of a run, in us."""
    return list(range(0, LAST_BEGIN_US + 1, STEP_US))


class Undisturbed(NamedTuple):
    """A run without a cable. `errors`: each stroke's onset error, cycles.

    `phase`: cycles after a whole microsecond at which the release comes. It lies within a tick of the timer, not
    at its edge: the emulator changes an input between two instructions, up to 3 cycles late, and that must
    not look like a stroke that moved by a tick.
    """

    phase: int
    errors: tuple[int, ...]


@cache
def run_undisturbed(bench: Bench) -> Undisturbed:
    """Fly the undisturbed run with which every abused run is compared."""
    board = bench.board()
    client = connect(board)
    plan = Plan.on(client)
    first_us = plan.strokes[0][2]
    onsets = []
    for phase in range(CYCLES_PER_TICK):
        arm(board, client)
        released = release(board, phase)
        board.run(first_us + AFTER_RUN_US)
        onsets.append(read_signal(pin_edges(board)).onsets[0].cycle - released)
    latest = onsets.index(max(onsets))  # the earliest release of a tick
    phase = (latest + 1) % CYCLES_PER_TICK
    arm(board, client)
    board.cable(False)
    board.run(TALK_US)
    released = release(board, phase)
    board.run(plan.end_us + AFTER_RUN_US)
    errors = measure(pin_edges(board), plan, released).errors
    board.close()
    return Undisturbed(phase, errors)


def abuse_link(bench: Bench, abuse: Abuse, begins: Iterable[int], seed: int) -> Abused:
    """Run the abuse once for each start time.

    Raises Broken unless all strokes begin on exactly the cycles of the undisturbed run.
    """
    expected = run_undisturbed(bench)
    board = bench.board()
    client = connect(board)
    plan, rng = Plan.on(client), random.Random(seed)
    runs = moved = 0
    for begin_us in begins:
        arm(board, client)
        if abuse is Abuse.SILENT:
            _fill_the_host(board)
        released = release(board, expected.phase)
        _host(board, abuse, released // CYCLES_PER_US, begin_us, plan.end_us + AFTER_RUN_US, rng)
        errors = measure(pin_edges(board), plan, released).errors
        runs += 1
        moved += errors != expected.errors
        client = _reconnect(board)
        status = client.status()
        if status.state != SequencerState.DONE or status.resets_while_armed:
            raise Broken(f"{abuse.value} from {begin_us} us on: {status.state.name} after the run")
    if moved:
        raise Broken(f"{abuse.value}: strokes moved in {moved} of {runs} runs")
    never_used = stack_never_used(board, client, bench)
    board.close()
    return Abused(abuse, runs, moved, never_used)


def release(board: AvrBoard, phase: int) -> int:
    """Open both switches without bounce and return the cycle at which both are open.

    It comes `phase` cycles after a whole microsecond.
    """
    board.switch(0, closed=False)
    board.run(100)
    board.run_to_cycle(board.now_cycle + phase)
    board.switch(1, closed=False)
    return board.now_cycle


def _host(
    board: AvrBoard, abuse: Abuse, released_us: int, begin_us: int, run_length_us: int, rng: random.Random
) -> None:
    while board.now_us < released_us + begin_us:
        if abuse is not Abuse.SILENT:
            board.read()
            board.write(QUESTION)
        board.run(min(TALK_US, released_us + begin_us - board.now_us))
    if abuse is Abuse.PULLED:
        board.write(QUESTION)
        board.cable(False)
    end_us = released_us + max(run_length_us, begin_us + STEP_US)
    while board.now_us < end_us:
        if abuse in (Abuse.REQUESTS, Abuse.SILENT):
            board.write(QUESTION * (FLOOD_BYTES // len(QUESTION)))
        elif abuse is Abuse.GARBAGE:
            board.write(rng.randbytes(FLOOD_BYTES))
        board.run(FLOOD_STEP_US)


def _fill_the_host(board: AvrBoard) -> None:
    for _ in range(FILLING_US // 2000):
        board.write(QUESTION)
        board.run(2000)


def _reconnect(board: AvrBoard) -> SequencerClient:
    board.cable(False)
    board.run(5000)
    return connect(board)


# ------------------------------------------------------------------ noise

MAX_BURST = 64
QUIET_US = 50_000
"""After the last byte: all has been answered."""
PHASE_US = {SequencerState.SAFE: 300_000, SequencerState.ARMED: 500_000, SequencerState.RUNNING: 2_100_000}
STATES = tuple(PHASE_US)
KEPT_OUT = (DisarmRequest, JointReportRequest, ManeuverBeginRequest)
"""DISARM always works. A report of another pose, and an upload that is begun, forbid ARM and would hide an ARM that its
token must stop."""
REQUESTS: tuple[type[Payload], ...] = tuple(
    kind for name, kind in sorted(vars(messages).items()) if name.endswith("Request") and kind not in KEPT_OUT
)
TYPES = sorted(set(range(256)) - {kind.TYPE for kind in KEPT_OUT})


class Noise(Enum):
    """What is sent."""

    BYTES = "random bytes"
    FRAMES = "frames with a right CRC and random contents"

    def piece(self, rng: random.Random, remaining_count: int, token: int) -> tuple[int, bytes]:
        """Draw a burst of bytes or one frame, and return its count of bytes or frames with the bytes."""
        if self is Noise.FRAMES:
            return 1, _random_frame(rng, token)
        data = rng.randbytes(min(remaining_count, rng.randint(1, MAX_BURST)))
        return len(data), data


@dataclass(slots=True)
class Noisy:
    """What was sent in each state, bytes or frames, and what came of it."""

    noise: Noise
    sent: Counter[SequencerState] = field(default_factory=Counter)
    drops: int = 0
    answers: int = 0
    refusals: int = 0
    arms_refused: Counter[ErrorCode] = field(default_factory=Counter)
    """ARM frames in SAFE, by the reason: nothing but the token, or a wrong length, may be one."""
    rejected: int = 0
    never_used: int = 0


def make_noise(bench: Bench, noise: Noise, amount: int, drops: int, seed: int) -> Noisy:
    """`amount` bytes or frames, as many in SAFE, ARMED and RUNNING, over some drops of one board.

    In SAFE the board is ready to be armed: only its token protects it from an ARM frame. Raises Broken where a
    stroke moves by a cycle, the board leaves its state, a servo moves, a byte of the EEPROM changes, or ARM is
    refused in SAFE for anything but its token.
    """
    rng = random.Random(seed)
    expected = run_undisturbed(bench)
    board = bench.board()
    client = connect(board)
    plan = Plan.on(client)
    result = Noisy(noise, drops=drops)
    for number in range(drops):
        client.disarm()
        seat(board)
        board.run(QUIET_US)
        pin_edges(board)
        share = amount // 3 * (number + 1) // drops - amount // 3 * number // drops
        _disturb(board, client, result, SequencerState.SAFE, share, rng)
        if pin_edges(board):
            raise Broken("a servo got pulses while SAFE")
        if client.arm() != SequencerState.ARMED:
            raise Broken("the board was not ready to be armed while SAFE")
        _disturb(board, client, result, SequencerState.ARMED, share, rng)
        released = release(board, expected.phase)
        _disturb(board, client, result, SequencerState.RUNNING, share, rng)
        board.run_to_cycle(max(board.now_cycle, released + (plan.end_us + AFTER_RUN_US) * CYCLES_PER_US))
        errors = measure(pin_edges(board), plan, released).errors
        if errors != expected.errors:
            raise Broken(
                f"{noise.value}: strokes began at {errors} instead of {expected.errors} cycles off their times"
            )
        _expect(client, SequencerState.DONE)
    result.rejected = client.status().frames_rejected
    result.never_used = stack_never_used(board, client, bench)
    board.close()
    return result


def _disturb(
    board: AvrBoard,
    client: SequencerClient,
    result: Noisy,
    state: SequencerState,
    remaining_count: int,
    rng: random.Random,
) -> None:
    """Sends a share at random moments of the phase; the board must still be in that state."""
    token, eeprom = client.status().arm_token, board.eeprom()
    end_us = board.now_us + PHASE_US[state] - QUIET_US
    receiver = FrameReceiver()
    while remaining_count > 0:
        piece_count, data = result.noise.piece(rng, remaining_count, token)
        board.write(data)
        remaining_count -= piece_count
        result.sent[state] += piece_count
        mean_us = max(1, (end_us - board.now_us) * piece_count // max(1, remaining_count))
        board.run(rng.randint(0, 2 * mean_us))
        _count(receiver, board.read(), result, state)
    board.write(b"\0")  # ends what the noise began
    board.run(QUIET_US)
    _count(receiver, board.read(), result, state)
    if board.eeprom() != eeprom:
        raise Broken(f"{result.noise.value} in {state.name} changed the EEPROM")
    _expect(client, state, *((SequencerState.DONE,) if state == SequencerState.RUNNING else ()))
    if others := set(result.arms_refused) - {ErrorCode.STALE_TOKEN, ErrorCode.BAD_LENGTH}:
        raise Broken(f"ARM with a wrong token was refused in SAFE for {others}")


def _count(receiver: FrameReceiver, data: bytes, result: Noisy, state: SequencerState) -> None:
    for frame in receiver.feed(data):
        result.answers += 1
        if frame.type != ErrorReply.TYPE:
            continue
        result.refusals += 1
        refusal = ErrorReply.decode(frame.payload)
        if state == SequencerState.SAFE and refusal.request == ArmRequest.TYPE:
            result.arms_refused[refusal.code] += 1


def _expect(client: SequencerClient, *states: SequencerState) -> None:
    state = client.status().state
    if state not in states:
        raise Broken(f"{state.name} after noise in {states[0].name}")


def _random_frame(rng: random.Random, token: int) -> bytes:
    """Draw a frame: usually a request of the right length, sometimes of any type or any length."""
    kind = rng.choice(REQUESTS)
    number = kind.TYPE if rng.random() < 0.9 else rng.choice(TYPES)
    size = kind.SIZE if rng.random() < 0.9 else rng.randint(0, MAX_PAYLOAD_BYTES)
    payload = rng.randbytes(size)
    while _is_an_order(number, payload, token):
        payload = rng.randbytes(size)
    return encode_frame(Frame(number, rng.randrange(256), payload))


def _is_an_order(number: int, payload: bytes, token: int) -> bool:
    """It happens to be an ARM with the right token, or a JOG with the flag: a host's wish, no noise."""
    if number == ArmRequest.TYPE and len(payload) == ArmRequest.SIZE:
        return ArmRequest.decode(payload).arm_token == token
    if number == JogRequest.TYPE and len(payload) == JogRequest.SIZE:
        return JogRequest.decode(payload).confirm == JOG_CONFIRM
    return False
