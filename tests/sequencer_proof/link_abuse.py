"""Campaign 3: what a host can do to the link during a run, beginning at any moment of it."""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache

from tests.proof.campaign import Broken, table
from tests.sequencer_proof.releases import AFTER_RUN_US, Plan, measure
from tests.sequencer_proof.rigs import AvrRig, Bench, arm, run_us, stack_never_used
from tests.sequencer_proof.signals import CYCLES_PER_TICK, CYCLES_PER_US, read_signal
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.framing import Frame, encode_frame
from tfsat_host.protocol.messages import SequencerStatusRequest

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


@dataclass(frozen=True, slots=True)
class Abused:
    """Outcomes of the runs with one kind of abuse."""

    abuse: Abuse
    runs: int
    moved: int
    """Runs in which a stroke did not begin exactly as in the undisturbed run."""
    never_used: int


def begins_us() -> list[int]:
    """Every 10 ms of a run."""
    return list(range(0, LAST_BEGIN_US + 1, STEP_US))


@dataclass(frozen=True, slots=True)
class Undisturbed:
    """A run without a cable. `errors`: each stroke's onset error, cycles.

    `phase`: cycles after a whole microsecond at which the release comes. It lies within a tick of the timer, not
    at its edge: the emulator changes an input between two instructions, up to 3 cycles late, and that must
    not look like a stroke that moved by a tick.
    """

    phase: int
    errors: tuple[int, ...]


@cache
def undisturbed(bench: Bench) -> Undisturbed:
    """What every run that is abused is compared with."""
    rig = bench.rig()
    client = rig.connect()
    plan = Plan.on(client)
    first_us = plan.strokes[0][2]
    onsets = []
    for phase in range(CYCLES_PER_TICK):
        arm(rig, client)
        released = release(rig, phase)
        run_us(rig, first_us + AFTER_RUN_US)
        onsets.append(read_signal(rig.edges()).onsets[0].cycle - released)
    latest = onsets.index(max(onsets))  # the earliest release of a tick
    phase = (latest + 1) % CYCLES_PER_TICK
    arm(rig, client)
    rig.board.cable(False)
    run_us(rig, TALK_US)
    released = release(rig, phase)
    run_us(rig, plan.end_us + AFTER_RUN_US)
    errors = measure(rig.edges(), plan, released).errors
    rig.close()
    return Undisturbed(phase, errors)


def abuse_link(bench: Bench, abuse: Abuse, begins: Iterable[int], seed: int) -> Abused:
    """One run for each moment. Raises Broken unless all strokes begin on the undisturbed run's very cycles."""
    expected = undisturbed(bench)
    rig = bench.rig()
    client = rig.connect()
    plan, rng = Plan.on(client), random.Random(seed)
    runs = moved = 0
    for begin_us in begins:
        arm(rig, client)
        if abuse is Abuse.SILENT:
            _fill_the_host(rig)
        released = release(rig, expected.phase)
        _host(rig, abuse, released // CYCLES_PER_US, begin_us, plan.end_us + AFTER_RUN_US, rng)
        errors = measure(rig.edges(), plan, released).errors
        runs += 1
        moved += errors != expected.errors
        client = _reconnect(rig)
        status = client.status()
        if status.state != SequencerState.DONE or status.resets_while_armed:
            raise Broken(f"{abuse.value} from {begin_us} us on: {status.state.name} after the run")
    if moved:
        raise Broken(f"{abuse.value}: strokes moved in {moved} of {runs} runs")
    never_used = stack_never_used(rig, client, bench)
    rig.close()
    return Abused(abuse, runs, moved, never_used)


def release(rig: AvrRig, phase: int) -> int:
    """Both switches open without bounce; returns when both were, so many cycles after a whole microsecond."""
    rig.set_switch(0, closed=False)
    run_us(rig, 100)
    rig.run_to(rig.now + phase)
    rig.set_switch(1, closed=False)
    return rig.now


def _host(
    rig: AvrRig, abuse: Abuse, released_us: int, begin_us: int, run_length_us: int, rng: random.Random
) -> None:
    while rig.board.now_us < released_us + begin_us:
        if abuse is not Abuse.SILENT:
            rig.board.receive()
            rig.board.send(QUESTION)
        run_us(rig, min(TALK_US, released_us + begin_us - rig.board.now_us))
    if abuse is Abuse.PULLED:
        rig.board.send(QUESTION)
        rig.board.cable(False)
    end_us = released_us + max(run_length_us, begin_us + STEP_US)
    while rig.board.now_us < end_us:
        if abuse in (Abuse.REQUESTS, Abuse.SILENT):
            rig.board.send(QUESTION * (FLOOD_BYTES // len(QUESTION)))
        elif abuse is Abuse.GARBAGE:
            rig.board.send(rng.randbytes(FLOOD_BYTES))
        run_us(rig, FLOOD_STEP_US)


def _fill_the_host(rig: AvrRig) -> None:
    for _ in range(FILLING_US // 2000):
        rig.board.send(QUESTION)
        run_us(rig, 2000)


def _reconnect(rig: AvrRig) -> SequencerClient:
    rig.board.cable(False)
    run_us(rig, 5000)
    return rig.connect()


def page(found: Sequence[Abused]) -> str:
    rows = []
    for abuse in Abuse:
        parts = [part for part in found if part.abuse is abuse]
        rows.append((abuse.value, sum(part.runs for part in parts), sum(part.moved for part in parts)))
    header = ("host", "runs", "runs in which a stroke began on another cycle than undisturbed")
    return (
        "## 3. Abuse of the link\n\n"
        f"Each kind begins at every {STEP_US // 1000} ms of a run, 0 to {LAST_BEGIN_US / 1e6:g} s "
        "after the release; "
        "before, the host asks for STATUS and reads the answers.\n"
        "The four onsets are compared with those of a run without a cable, cycle by cycle.\n\n"
        + table(header, rows)
    )
