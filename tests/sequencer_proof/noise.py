"""Campaign 3, continued: random bytes, and well-formed frames with random contents, in every state."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

from tests.proof.campaign import Broken, table
from tests.sequencer_proof.link_abuse import release, undisturbed
from tests.sequencer_proof.releases import AFTER_RUN_US, Plan, measure
from tests.sequencer_proof.rigs import AvrRig, Bench, run_us, seat, stack_never_used
from tests.sequencer_proof.signals import CYCLES_PER_US
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
)
from tfsat_host.protocol.record import Payload

LONGEST_BURST = 64
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

    def piece(self, rng: random.Random, left: int, token: int) -> tuple[int, bytes]:
        """A burst of bytes or one frame: how many of those it is, and the bytes."""
        if self is Noise.FRAMES:
            return 1, _random_frame(rng, token)
        data = rng.randbytes(min(left, rng.randint(1, LONGEST_BURST)))
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
    expected = undisturbed(bench)
    rig = bench.rig()
    client = rig.connect()
    plan = Plan.on(client)
    result = Noisy(noise, drops=drops)
    for number in range(drops):
        client.disarm()
        seat(rig)
        run_us(rig, QUIET_US)
        rig.edges()
        share = amount // 3 * (number + 1) // drops - amount // 3 * number // drops
        _disturb(rig, client, result, SequencerState.SAFE, share, rng)
        if rig.edges():
            raise Broken("a servo got pulses while SAFE")
        if client.arm() != SequencerState.ARMED:
            raise Broken("the board was not ready to be armed while SAFE")
        _disturb(rig, client, result, SequencerState.ARMED, share, rng)
        released = release(rig, expected.phase)
        _disturb(rig, client, result, SequencerState.RUNNING, share, rng)
        rig.run_to(max(rig.now, released + (plan.end_us + AFTER_RUN_US) * CYCLES_PER_US))
        errors = measure(rig.edges(), plan, released).errors
        if errors != expected.errors:
            raise Broken(
                f"{noise.value}: strokes began at {errors} instead of {expected.errors} cycles off their times"
            )
        _expect(client, SequencerState.DONE)
    result.rejected = client.status().frames_rejected
    result.never_used = stack_never_used(rig, client, bench)
    rig.close()
    return result


def _disturb(
    rig: AvrRig,
    client: SequencerClient,
    result: Noisy,
    state: SequencerState,
    left: int,
    rng: random.Random,
) -> None:
    """Sends a share at random moments of the phase; the board must still be in that state."""
    token, eeprom = client.status().arm_token, rig.board.eeprom()
    end_us = rig.board.now_us + PHASE_US[state] - QUIET_US
    receiver = FrameReceiver()
    while left > 0:
        taken, data = result.noise.piece(rng, left, token)
        rig.board.send(data)
        left -= taken
        result.sent[state] += taken
        mean_us = max(1, (end_us - rig.board.now_us) * taken // max(1, left))
        run_us(rig, rng.randint(0, 2 * mean_us))
        _count(receiver, rig.board.receive(), result, state)
    rig.board.send(b"\0")  # ends what the noise began
    run_us(rig, QUIET_US)
    _count(receiver, rig.board.receive(), result, state)
    if rig.board.eeprom() != eeprom:
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
    found = client.status().state
    if found not in states:
        raise Broken(f"{found.name} after noise in {states[0].name}")


def _random_frame(rng: random.Random, token: int) -> bytes:
    """Most are requests of the right length; some have any type or any length."""
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


def page(found: Sequence[Noisy]) -> str:
    rows = []
    for noise in Noise:
        parts = [part for part in found if part.noise is noise]
        sent = [sum(part.sent[state] for part in parts) for state in STATES]
        counts = [
            sum(part.rejected for part in parts),
            sum(part.answers for part in parts),
            sum(part.refusals for part in parts),
            sum(part.arms_refused[ErrorCode.STALE_TOKEN] for part in parts),
            sum(part.drops for part in parts),
        ]
        rows.append((noise.value, sum(sent), *sent, *counts))
    names = [state.name for state in STATES]
    header = (
        "sent",
        "in all",
        *names,
        "frames found damaged",
        "answers",
        "of them refusals",
        "of them ARM in SAFE, for its token",
        "drops flown on time",
    )
    return (
        "Noise at random moments. It never armed the board, disarmed it, moved a servo or a stroke "
        "by a cycle, or changed "
        "one bit of the EEPROM. In SAFE the board\nlacked nothing but the right token to be armed: what ARM "
        "frames it refused, it refused for that.\nThe frames are of every type but DISARM, which always works, and "
        "JOINT_REPORT and MANEUVER_BEGIN, which forbid ARM; ARM has any token but the "
        "right one, JOG any flag but the right one.\n\n" + table(header, rows)
    )
