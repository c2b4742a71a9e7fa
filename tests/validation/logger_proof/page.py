"""docs/logger-proof.md and its tables. Every figure in them comes from a run."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from tests.validation.campaign import Campaign, Found, csv_text, declared, output, results_csv, table
from tests.validation.logger_proof.building import core_sha256
from tests.validation.logger_proof.campaign import RATES_HZ
from tests.validation.logger_proof.judge import LOOP_US, PARTIAL_AND_SYNC_US, Outcome
from tests.validation.logger_proof.m7 import MACHINE
from tests.validation.logger_proof.truth import Kind
from tfsat_host.protocol.limits import FILE_FACTORY_MIB, FIRMWARE_VERSION, RING_BLOCKS

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


def files(found: Found, campaigns: Sequence[Campaign]) -> dict[str, str]:
    """The page and its tables, by their paths in docs/."""
    outcomes: Sequence[Outcome] = found["runs"]
    counts = ("recordings", "cuts", *VERDICTS, "torn blocks", "stale blocks")
    tables = {
        "campaigns": declared(campaigns),
        "recordings": csv_text(("when the power goes", "Hz", *counts), map(_recordings, *_parts(outcomes))),
        **{name: results_csv(found[name]) for name in ("shared-processor", "failed-transfers", "read-times")},
    }
    page = Path(__file__).with_name("page.in.md").read_text(encoding="utf-8")
    return {
        "logger-proof.md": page.format(**_head(), **_runs(outcomes), **_machine(found)),
        **{f"logger-proof/{name}.csv": text for name, text in tables.items()},
    }


def _head() -> dict[str, object]:
    qemu = output("qemu-system-arm", "--version").splitlines()[0].split("version ")[1].split(" ")[0]
    return {
        "version": ".".join(map(str, FIRMWARE_VERSION)),
        "sha256": core_sha256(),
        "gcc": output("arm-none-eabi-g++", "-dumpversion"),
        "qemu": f"{qemu}, machine {MACHINE}",
        "ring": RING_BLOCKS,
        "file_mib": FILE_FACTORY_MIB,
        "to_sync_ms": PARTIAL_AND_SYNC_US // 1000,
        "sync_ms": LOOP_US // 1000,
    }


def _parts(outcomes: Sequence[Outcome]) -> tuple[list[Kind], list[int], list[list[Outcome]]]:
    """By kind and rate."""
    pairs = [(kind, rate_hz) for kind in Kind for rate_hz in RATES_HZ]
    parts = [[one for one in outcomes if (one.kind, one.rate_hz) == pair] for pair in pairs]
    return [kind for kind, _ in pairs], [rate_hz for _, rate_hz in pairs], parts


def _recordings(kind: Kind, rate_hz: int, part: Sequence[Outcome]) -> tuple[object, ...]:
    verdicts = Counter(one.verdict for one in part)
    sums = (sum(getattr(one, name) for one in part) for name in ("torn", "stale"))
    cuts = sum(one.cut for one in part)
    return TEXT[kind], rate_hz, len(part), cuts, *(verdicts[name] for name in VERDICTS), *sums


def _runs(outcomes: Sequence[Outcome]) -> dict[str, object]:
    dropped = [one.dropped for one in outcomes if one.dropped]
    stalls = [(rate_hz, _stalled(outcomes, rate_hz)) for rate_hz in RATES_HZ]
    return {
        "recordings": len(outcomes),
        "cuts": sum(one.cut for one in outcomes),
        "last_seed": max(one.seed for one in outcomes),
        "decoded": sum(one.decoded for one in outcomes),
        "dropped": sum(dropped),
        "dropped_runs": len(dropped),
        "headerless": sum(one.headerless for one in outcomes),
        "later": sum(one.number > 1 for one in outcomes),
        "from_ram": sum(one.from_ram for one in outcomes),
        "full": sum(one.file_full for one in outcomes),
        "losses": table(("the card", "Hz", "cuts", "median, ms", "worst, ms"), _losses(outcomes)),
        "stalls": table(
            ("Hz", "runs", "stalls", "longest, ms", "most blocks waiting", "samples dropped"),
            [
                (
                    *(rate_hz, len(part), sum(one.stalls for one in part)),
                    f"{max(one.longest_stall_us for one in part) / 1e3:.0f}",
                    *(max(one.ring_peak_blocks for one in part), sum(one.dropped for one in part)),
                )
                for rate_hz, part in stalls
            ],
        ),
    }


def _losses(outcomes: Sequence[Outcome]) -> list[tuple[object, ...]]:
    """The age of the oldest sample that a cut took."""
    rows: list[tuple[object, ...]] = []
    for rate_hz in RATES_HZ:
        cut = [one for one in outcomes if one.rate_hz == rate_hz and one.cut and one.kind != Kind.SMALL_RING]
        for name, stalled, pulled in (
            ("takes what comes", False, False),
            ("stalls, 1 % of the writes", True, False),
            ("was pulled", None, True),
        ):
            chosen = (one for one in cut if one.pulled == pulled and stalled in (None, one.stalls > 0))
            losses = [one.loss_us / 1e3 for one in chosen]
            rows.append((name, rate_hz, len(losses), f"{median(losses):.0f}", f"{max(losses):.0f}"))
    return rows


def _stalled(outcomes: Sequence[Outcome], rate_hz: int) -> list[Outcome]:
    """With the firmware's own ring, to the end of a file that had room."""
    own = (one for one in outcomes if one.rate_hz == rate_hz and one.kind is not Kind.SMALL_RING)
    return [one for one in own if one.stalls and not one.pulled and not one.file_full]


def _machine(found: Found) -> dict[str, object]:
    twins: Sequence[bytes] = found["twins"]
    counted = [
        (
            *(one.rate_hz, one.core.mean, one.core.most, one.idle_sample.mean - one.ports),
            *(one.pass_with_block.mean, one.empty_pass.mean, f"{one.share:.2%}"),
        )
        for one in found["instructions"]
    ]
    spares, glitches, offsets = (
        found[name] for name in ("shared-processor", "failed-transfers", "read-times")
    )
    return {
        "twins": len(twins) // 2,
        "twin_bytes": sum(map(len, twins)),
        "twin_sha256": hashlib.sha256(b"".join(twins)).hexdigest(),
        "instructions": table(
            (
                "Hz",
                "a sample: mean",
                "most",
                "mean when idle",
                "a pass with a block",
                "an empty pass",
                "of 600 MHz",
            ),
            counted,
        ),
        "spare": min(min(one.at_start, one.at_change) for one in spares if not one.stall_one_in),
        "spare_stalled": min(min(one.at_start, one.at_change) for one in spares if one.stall_one_in),
        "transfers": sum(one.times for one in glitches),
        "transfers_lost": sum(one.lost for one in glitches),
        "offset_us": f"{max(abs(one.logged_us - one.measured_us) for one in offsets):.0f}",
    }
