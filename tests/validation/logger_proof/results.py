"""The tables of docs/logger-proof.md. Every figure in them comes from a run."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Sequence
from statistics import median

from tests.validation.campaign import Campaign, Found, campaigns_csv, output
from tests.validation.logger_proof.campaign import RATES_HZ
from tests.validation.logger_proof.judge import LOOP_US, PARTIAL_AND_SYNC_US, Outcome
from tests.validation.logger_proof.m7 import MACHINE, SHARE_MAX, Instructions
from tests.validation.logger_proof.measurements import PERMITTED_RISE_NS, READ_TIME_MAX_US, Spare
from tests.validation.logger_proof.truth import Kind
from tests.validation.tables import csv_text, results_csv
from tests.validation.targets import Target, targets_csv
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


def make_tables(results: Found, campaigns: Sequence[Campaign]) -> dict[str, str]:
    """Return the text of each CSV file by its name."""
    outcomes: Sequence[Outcome] = results["runs"]
    counts = ("recordings", "cuts", *VERDICTS, "torn blocks", "stale blocks")
    stalls = ("Hz", "runs", "stalls", "longest, ms", "most blocks waiting", "samples dropped")
    machine = (
        "Hz",
        "a sample: mean",
        "most",
        "mean when idle",
        "a pass with a block",
        "an empty pass",
        "% of 600 MHz",
    )
    tables = {
        "campaigns": campaigns_csv(campaigns),
        "targets": targets_csv(find_targets(results)),
        "figures": csv_text(("of", "figure", "value"), list_figures(results)),
        "recordings": csv_text(("when the power goes", "Hz", *counts), map(_recordings, *_parts(outcomes))),
        "losses": csv_text(("the card", "Hz", "cuts", "median, ms", "worst, ms"), _losses(outcomes)),
        "stalls": csv_text(stalls, [_stall_row(outcomes, rate_hz) for rate_hz in RATES_HZ]),
        "instructions": csv_text(machine, map(_instruction_row, results["instructions"])),
        **{
            name: results_csv(results[name])
            for name in ("shared-processor", "failed-transfers", "slow-buses", "read-times")
        },
    }
    return {f"{name}.csv": text for name, text in tables.items()}


def describe_machines(results: Found) -> dict[str, object]:
    """Return what the campaigns were run with besides the core."""
    qemu = output("qemu-system-arm", "--version").splitlines()[0].split("version ")[1].split(" ")[0]
    return {
        "firmware": ".".join(map(str, FIRMWARE_VERSION)),
        "compiler for the Cortex-M7": f"arm-none-eabi-gcc {output('arm-none-eabi-g++', '-dumpversion')}",
        "emulator": f"QEMU {qemu}, machine {MACHINE}",
        "SHA-256 of what PC and Cortex-M7 wrote": hashlib.sha256(b"".join(results["twins"])).hexdigest(),
    }


def find_targets(results: Found) -> list[Target]:
    """Return what the core is held to, with its bounds."""
    outcomes: Sequence[Outcome] = results["runs"]
    stalled = [outcome for rate_hz in RATES_HZ for outcome in _stalled_outcomes(outcomes, rate_hz)]
    quiet = [outcome for outcome in outcomes if outcome.cut and not outcome.stalls and not outcome.pulled]
    glitches, offsets = results["failed-transfers"], results["read-times"]
    most_lost = {
        rate_hz: max(glitch.most for glitch in glitches if glitch.rate_hz == rate_hz) for rate_hz in RATES_HZ
    }
    permitted = [bus for bus in results["slow-buses"] if bus.rise_ns <= PERMITTED_RISE_NS]
    return [
        Target(
            "samples dropped, with the firmware's own ring",
            sum(outcome.dropped for outcome in stalled),
            high=0,
        ),
        # Quiet card and the firmware's own ring: only the block under way and its sync can be lost.
        Target(
            "oldest sample lost to a power cut, on a card that takes what comes",
            max(outcome.loss_us for outcome in quiet if outcome.kind is not Kind.SMALL_RING) / 1e3,
            high=(PARTIAL_AND_SYNC_US + LOOP_US) / 1e3,
            unit="ms",
        ),
        Target(
            "share of the processor",
            max(100 * instructions.share for instructions in results["instructions"]),
            high=100 * SHARE_MAX,
            unit="%",
        ),
        Target("samples lost by one failed transfer, 280 Hz", most_lost[280], high=1),
        Target("samples lost by one failed transfer, 1 kHz", most_lost[1000], high=2),
        Target("samples lost on a permitted bus", sum(bus.lost for bus in permitted), high=0),
        Target("samples of other IMUs lost by it", sum(glitch.others for glitch in glitches), high=0),
        Target(
            "a sensor's time in the log's header, off by",
            max(abs(offset.logged_us - offset.measured_us) for offset in offsets),
            high=READ_TIME_MAX_US,
            unit="µs",
        ),
    ]


def list_figures(results: Found) -> list[tuple[str, str, object]]:
    """Return what the page's sections rest on: section, figure, value."""
    outcomes: Sequence[Outcome] = results["runs"]
    twins, spares, glitches = results["twins"], results["shared-processor"], results["failed-transfers"]
    dropped = [outcome.dropped for outcome in outcomes if outcome.dropped]
    figures: dict[str, dict[str, object]] = {
        "faults": {
            "recordings": len(outcomes),
            "cut off by the power": sum(outcome.cut for outcome in outcomes),
            "last seed": max(outcome.seed for outcome in outcomes),
            "samples read back and compared": sum(outcome.decoded for outcome in outcomes),
            "samples that found no room": sum(dropped),
            "in so many runs": len(dropped),
            "runs whose power went before the first sync": sum(outcome.headerless for outcome in outcomes),
            "recordings that followed another in their run": sum(outcome.number > 1 for outcome in outcomes),
            "drops fetched from RAM": sum(outcome.from_ram for outcome in outcomes),
            "recordings whose file was full before the end": sum(outcome.file_full for outcome in outcomes),
        },
        "machine": {
            "runs on both": len(twins) // 2,
            "bytes, the same": sum(map(len, twins)),
        },
        "buses": {
            "fewest free blocks of RAM, processor shared": _fewest_free(spares, stalled=False),
            "likewise, one write in 100 stalls": _fewest_free(spares, stalled=True),
            "failed transfers": sum(glitch.times for glitch in glitches),
            "samples that they cost": sum(glitch.lost for glitch in glitches),
        },
    }
    return [(section, what, value) for section, rows in figures.items() for what, value in rows.items()]


def _fewest_free(spares: Sequence[Spare], stalled: bool) -> int:
    return min(
        min(spare.at_start, spare.at_change) for spare in spares if bool(spare.stall_one_in) == stalled
    )


def _parts(outcomes: Sequence[Outcome]) -> tuple[list[Kind], list[int], list[list[Outcome]]]:
    """Group the outcomes by kind and rate."""
    pairs = [(kind, rate_hz) for kind in Kind for rate_hz in RATES_HZ]
    parts = [[outcome for outcome in outcomes if (outcome.kind, outcome.rate_hz) == pair] for pair in pairs]
    return [kind for kind, _ in pairs], [rate_hz for _, rate_hz in pairs], parts


def _recordings(kind: Kind, rate_hz: int, part: Sequence[Outcome]) -> tuple[object, ...]:
    verdicts = Counter(outcome.verdict for outcome in part)
    sums = (sum(getattr(outcome, name) for outcome in part) for name in ("torn", "stale"))
    cuts = sum(outcome.cut for outcome in part)
    return TEXT[kind], rate_hz, len(part), cuts, *(verdicts[name] for name in VERDICTS), *sums


def _losses(outcomes: Sequence[Outcome]) -> list[tuple[object, ...]]:
    """Build the table rows with the age, in ms, of the oldest sample lost in a power cut."""
    rows: list[tuple[object, ...]] = []
    for rate_hz in RATES_HZ:
        cut = [
            outcome
            for outcome in outcomes
            if outcome.rate_hz == rate_hz and outcome.cut and outcome.kind != Kind.SMALL_RING
        ]
        for name, stalled, pulled in (
            ("takes what comes", False, False),
            ("stalls, 1 % of the writes", True, False),
            ("was pulled", None, True),
        ):
            chosen = (
                outcome
                # The pulled card counts by itself, whether it also stalled or not.
                for outcome in cut
                if outcome.pulled == pulled and stalled in (None, outcome.stalls > 0)
            )
            losses = [outcome.loss_us / 1e3 for outcome in chosen]
            rows.append((name, rate_hz, len(losses), f"{median(losses):.0f}", f"{max(losses):.0f}"))
    return rows


def _stalled_outcomes(outcomes: Sequence[Outcome], rate_hz: int) -> list[Outcome]:
    """Select the runs at one rate in which the card stalled but was not pulled.

    The ring is the firmware's own, and the file had room to the end.
    """
    own = (
        outcome for outcome in outcomes if outcome.rate_hz == rate_hz and outcome.kind is not Kind.SMALL_RING
    )
    # Runs whose file was full dropped samples for another reason than the stall.
    return [outcome for outcome in own if outcome.stalls and not outcome.pulled and not outcome.file_full]


def _stall_row(outcomes: Sequence[Outcome], rate_hz: int) -> tuple[object, ...]:
    part = _stalled_outcomes(outcomes, rate_hz)
    return (
        *(rate_hz, len(part), sum(outcome.stalls for outcome in part)),
        f"{max(outcome.longest_stall_us for outcome in part) / 1e3:.0f}",
        *(max(outcome.ring_peak_blocks for outcome in part), sum(outcome.dropped for outcome in part)),
    )


def _instruction_row(instructions: Instructions) -> tuple[object, ...]:
    return (
        *(
            instructions.rate_hz,
            instructions.core.mean,
            instructions.core.most,
            instructions.idle_sample.mean - instructions.ports,
        ),
        *(instructions.pass_with_block.mean, instructions.empty_pass.mean, f"{100 * instructions.share:.2f}"),
    )
