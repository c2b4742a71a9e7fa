"""The report: docs/logger-proof.md. Every figure in it comes from a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Self

from tests.logger_proof.building import core_sha256
from tests.logger_proof.campaign import FIRST_SEED, RATES_HZ
from tests.logger_proof.judge import LOOP_US, PARTIAL_AND_SYNC_US, Outcome
from tests.logger_proof.m7 import MACHINE, Instructions, Twins, instructions_page, twins_page
from tests.logger_proof.measurements import Glitches, Offset, Spare, glitches_page, offsets_page, spares_page
from tests.logger_proof.truth import Kind
from tests.proof.campaign import output, paragraph, table
from tfsat_host.protocol.limits import FIRMWARE_VERSION

TEXT = {
    Kind.BETWEEN: "between two blocks; the card keeps what it took",
    Kind.TORN: "the block under way is torn",
    Kind.CACHE_LOST: "the card's RAM is lost, up to 64 blocks",
    Kind.OUT_OF_ORDER: "its RAM was programmed in any order, one block torn",
    Kind.STALE: "likewise, in a file full of an older recording",
    Kind.STALLS: "likewise, 1 % of the writes stall",
    Kind.SECOND_COPY: "while the fall is written again",
    Kind.CLOSE: "while the file is closed, over an older recording",
    Kind.PULLED: "after the card was out of its contacts, once or twice",
    Kind.DEAD_SENSORS: "one to three IMUs, a bus or an angle sensor fail",
    Kind.SMALL_RING: "2 % of the writes stall, with a ring of 10 to 63 blocks",
    Kind.FALSE_RELEASE: "after both switches opened and closed again before the release",
    Kind.RECLOSED: "after both switches closed for good behind the landing",
    Kind.CARD_LOST: "the card is gone for good before, in or after the fall",
    Kind.NEXT_FILE: "the file is full before the release, another follows",
    Kind.SPOILED: "after the end; 5 % of the blocks written twice and the header spoiled",
}
VERDICTS = ("complete", "truncated", "damaged", "nothing yet")
JUDGED = """\
Judged after each run, sample by sample:

- Nothing is lost that the card had: every sample that a sync had made safe, or whose block stands whole on the
  medium, is read.
- Nothing is wrong: no time, reading, angle, switch, flag or edge is other than the sensors said; no sample is read that
  no whole block holds; no IMU is called valid that gave nothing, and none invalid because another failed; what a frozen
  one repeated is taken back to where it stood still; each header has the rate and the time of day.
- Every event is there whose block must be: edges, strokes and how many came too fast, releases and those that were
  none, the landing, stalls, losses of the card, late ticks; each once, at its time, with its value. There is no other.
  The footer's times between samples (of ticks that jitter and that are missed), jitter, stalls and copies are right.
- Nothing is hidden: a recording that lacks anything is never called complete, what the logger dropped stands in the
  log, and a recording that was closed lacks nothing else.
- Where the card is gone for good, RAM, fetched over the cable, gives the drop from 1 s before the release to 4 s after
  it (at 1 kHz, which the ring just holds: 0.9 s and 3.9 s), unless the card has it twice; judged as a card is.
- Where the recording ended by itself on a quiet card, the fall from 0.9 s before the release to 3.9 s after it is on
  it twice.

This many recordings, and what the decoder called them:"""
NOT_MODELLED = """\
- **A real card's mistakes.** The card here loses, tears and reorders what it had not programmed. It does not damage
  blocks that were safe, but for the last kind of run, and does not lie about a sync.
- **SdFat and the file system.** The file is a run of blocks; that its preparation and its end survive a cut is the
  business of `drivers/sd_block_sink.cpp`, which is compiled, not run.
- **The buses' time.** Transfers answer at once here; their deadlines are tested in `tests/logger`.
- **The M7's pipeline.** QEMU counts instructions. How many cycles they take depends on memory and pairing: 0.5 to 2
  each on the chip.
- **Interrupts between any two instructions.** A tick comes wherever the main loop waits: in every call of the card,
  and between two passes. The ring's own hand-over is one index, tested in `tests/logger`."""


@dataclass(frozen=True, slots=True)
class Tools:
    """Versions of what the figures depend on."""

    arm_gcc: str
    qemu: str

    @classmethod
    def found(cls) -> Self:
        qemu = output("qemu-system-arm", "--version").splitlines()[0]
        return cls(output("arm-none-eabi-g++", "-dumpversion"), qemu.split("version ")[1].split(" ")[0])


@dataclass(frozen=True, slots=True)
class Proof:
    """What everything came to."""

    outcomes: list[Outcome]
    same: Twins
    counted: list[Instructions]
    spares: list[Spare]
    glitches: list[Glitches]
    offsets: list[Offset]


def render(proof: Proof, tools: Tools) -> str:
    """The whole page, Markdown."""
    sections = [
        _head(proof.outcomes, tools),
        _campaign(proof.outcomes),
        _losses(proof.outcomes),
        _stalls(proof.outcomes),
        twins_page(proof.same),
        instructions_page(proof.counted),
        spares_page(proof.spares),
        glitches_page(proof.glitches),
        offsets_page(proof.offsets),
        f"## What this leaves out\n\n{NOT_MODELLED}",
    ]
    return "\n\n".join(sections) + "\n"


def _head(outcomes: Sequence[Outcome], tools: Tools) -> str:
    identity = table(
        ("", ""),
        [
            ("firmware", ".".join(map(str, FIRMWARE_VERSION))),
            ("SHA-256 of the sources in core, protocol and release", f"`{core_sha256()}`"),
            ("compiler for the Cortex-M7", f"arm-none-eabi-gcc {tools.arm_gcc}"),
            ("emulator", f"QEMU {tools.qemu}, machine {MACHINE}"),
        ],
    )
    cuts = sum(outcome.cut for outcome in outcomes)
    last_seed = max(outcome.seed for outcome in outcomes)
    text = paragraph(
        "Written by `make logger-report`; do not edit. The logger's own core records drops of a synthetic robot on a "
        "card that fails in every way below, in virtual time; the decoder reads the card's image afterwards and is "
        f"held against what the sensors really said: {len(outcomes)} recordings, {cuts} of them cut off by the power, "
        f"seeds {FIRST_SEED} to {last_seed}. Everything below held in every run: a campaign that finds a single "
        "exception fails, and writes no report."
    )
    return f"# What the logger was measured to keep\n\n{text}\n\n{identity}"


def _campaign(outcomes: Sequence[Outcome]) -> str:
    rows = []
    for kind in Kind:
        for rate_hz in RATES_HZ:
            part = [one for one in outcomes if (one.kind, one.rate_hz) == (kind, rate_hz)]
            verdicts = Counter(one.verdict for one in part)
            cuts = sum(one.cut for one in part)
            torn, stale = sum(one.torn for one in part), sum(one.stale for one in part)
            rows.append(
                (TEXT[kind], rate_hz, len(part), cuts, *(verdicts[name] for name in VERDICTS), torn, stale)
            )
    header = ("when the power goes", "Hz", "recordings", "cuts", *VERDICTS, "torn blocks", "stale blocks")
    decoded = sum(one.decoded for one in outcomes)
    dropped = [one.dropped for one in outcomes if one.dropped]
    early = sum(one.headerless for one in outcomes)
    from_ram = sum(one.from_ram for one in outcomes)
    later = sum(one.number > 1 for one in outcomes)
    found = paragraph(
        f"{decoded} samples were read back and compared. {sum(dropped)} samples of {len(dropped)} runs found no room, "
        "in a ring that was too small on purpose, or in a file that was full before the main loop knew: the log "
        f"counts each of them as dropped. In {early} runs the power went before the first sync, when a card that "
        "programs in any order held samples and not yet the header: those cannot be read, and the decoder says so. "
        "A torn block is any split of new and old bytes, either part first, alternating stretches of 8 to 256 bytes, "
        "or noise behind the split. A recording without a cut ended by itself before its power went. "
        f"{later} recordings followed another one in "
        f"their run. From RAM, {from_ram} drops were fetched."
    )
    return f"## 1. Faults\n\n{JUDGED}\n\n{table(header, rows)}\n\n{found}"


def _losses(outcomes: Sequence[Outcome]) -> str:
    rows = []
    for rate_hz in RATES_HZ:
        cut = [
            one for one in outcomes if one.rate_hz == rate_hz and one.cut and one.kind is not Kind.SMALL_RING
        ]
        for name, chosen in (
            ("takes what comes", [one for one in cut if not one.stalls and not one.pulled]),
            ("stalls, 1 % of the writes", [one for one in cut if one.stalls and not one.pulled]),
            ("was pulled", [one for one in cut if one.pulled]),
        ):
            losses = [one.loss_us / 1e3 for one in chosen]
            rows.append((name, rate_hz, len(losses), f"{median(losses):.0f}", f"{max(losses):.0f}"))
    text = paragraph(
        "The age of the oldest sample that is not on the card when the power goes. What the card holds in its own RAM "
        "is lost whatever a logger does; what waits behind a stall is in the ring. Allowed: "
        f"{PARTIAL_AND_SYNC_US // 1000} ms to fill a block and sync it, {LOOP_US // 1000} ms for the sync itself, and "
        "the time in which the card took nothing."
    )
    header = ("the card", "Hz", "cuts", "median, ms", "worst, ms")
    return f"## 2. What a power cut takes\n\n{text}\n\n{table(header, rows)}"


def _stalls(outcomes: Sequence[Outcome]) -> str:
    rows = []
    for rate_hz in RATES_HZ:
        part = [
            one
            for one in outcomes
            if one.rate_hz == rate_hz
            and one.stalls
            and not one.pulled
            and not one.file_full
            and one.kind is not Kind.SMALL_RING
        ]
        longest_ms = max(one.longest_stall_us for one in part) / 1e3
        count, dropped = sum(one.stalls for one in part), sum(one.dropped for one in part)
        peak = max(one.ring_peak_blocks for one in part)
        rows.append((rate_hz, len(part), count, f"{longest_ms:.0f}", peak, dropped))
    header = ("Hz", "runs", "stalls", "longest, ms", "most blocks waiting", "samples dropped")
    full = sum(one.file_full for one in outcomes)
    rest = paragraph(
        f"Not among them: {full} recordings whose file was full before the end. What is sampled between the file's "
        "last block and the end of the recording, half a second behind a stall, counts as dropped."
    )
    title = "## 3. Stalls of 50 to 500 ms in 1 % of the writes, with the firmware's own ring"
    return f"{title}\n\n{table(header, rows)}\n\n{rest}"
