"""Four logs of the emulated robot's drop 59/70, as cards bring them home."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.rehearsal.days import rehearse_drop
from tests.sdlog.encoder import renumbered
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.log_layout import HEADER_BYTES
from tfsat_host.protocol.messages import BlockHeader
from tfsat_host.sdlog import load
from tfsat_host.sdlog.header import WALL_CLOCK

SEEDS = (1, 2)
CUT_AT_S = 1.5
NOISE_SEED = 5
NOISE_SHARE = 0.05
FIRST_START_US = 1_790_000_000_000_000
"""Unix time at which the earlier drop of the raw image was recorded; the other is an hour later."""
LATER_US = 3_600_000_000
_WALL_CLOCK_OFFSET = HEADER_BYTES + WALL_CLOCK.start


@dataclass(frozen=True)
class Scenario:
    """One file to decode.

    Attributes:
        path: Where it is.
        what: What was done to it.
        card: The recording that it was made of, whole.
    """

    path: Path
    what: str
    card: Path


def fly(folder: Path, seed: int) -> Path:
    """Rehearse one drop, write the card's file and return its path."""
    folder.mkdir()
    path = folder / "SD.bin"
    path.write_bytes(rehearse_drop(schedule_maneuver(four_stroke(59.0, 70.0)), seed=seed).card)
    return path


def make(folder: Path) -> list[Scenario]:
    """Flies twice and makes the four files in `folder`."""
    first, second = (fly(folder / f"drop{seed}", seed) for seed in SEEDS)
    clean, cut, noisy, raw = (folder / name for name in ("clean.bin", "cut.bin", "noisy.bin", "card.img"))
    clean.write_bytes(first.read_bytes())
    cut.write_bytes(cut_in_the_drop(first))
    noisy.write_bytes(overwritten(first.read_bytes()))
    # The logger's own clock starts at zero: only the wall clock tells which recording is the newer one.
    older, newer = (
        date_recording(card.read_bytes(), FIRST_START_US + k * LATER_US)
        for k, card in enumerate((first, second))
    )
    # Gaps of zeros in front, between and behind: a card's raw image, not a file.
    raw.write_bytes(bytes(1 << 20) + older + bytes(1 << 18) + newer + bytes(1 << 16))
    return [
        Scenario(clean, "as the card brings it", first),
        Scenario(cut, f"the power is cut {CUT_AT_S:g} s after the release, while a block is written", first),
        Scenario(noisy, f"{NOISE_SHARE:.0%} of its blocks overwritten by noise (seed {NOISE_SEED})", first),
        Scenario(raw, "a raw image of a card with two recordings, the newer one behind the older", second),
    ]


def cut_in_the_drop(card: Path) -> bytes:
    """Up to the middle of the block with the sample CUT_AT_S after the release; zeros behind it."""
    log, data = load(card), card.read_bytes()
    cut_us = log.origin_us + CUT_AT_S * 1e6
    for at in range(0, len(data), BLOCK_BYTES):
        head = BlockHeader.decode(data[at : at + BlockHeader.SIZE])
        if head.kind == BlockKind.DATA and head.time_us > cut_us:
            break
    # Half a block is written when the power goes; the rest of the preallocated file is zeros.
    kept_bytes = at + BLOCK_BYTES // 2
    return data[:kept_bytes] + bytes(len(data) - kept_bytes)


def overwritten(data: bytes) -> bytes:
    """Noise in place of some blocks, the same ones every time."""
    blocks = np.frombuffer(data, np.uint8).reshape(-1, BLOCK_BYTES).copy()
    chance = np.random.default_rng(NOISE_SEED)
    # Blocks are drawn without replacement: exactly the stated share is hit.
    hit = chance.choice(len(blocks), round(NOISE_SHARE * len(blocks)), replace=False)
    blocks[hit] = chance.integers(0, 256, (len(hit), BLOCK_BYTES), np.uint8)
    return blocks.tobytes()


def date_recording(data: bytes, unix_us: int) -> bytes:
    """Return the recording as if the host had set the time of day at its beginning."""
    dated_blocks = []
    offset_us = unix_us - BlockHeader.decode(data[: BlockHeader.SIZE]).time_us
    for at in range(0, len(data), BLOCK_BYTES):
        block = bytearray(data[at : at + BLOCK_BYTES])
        head = BlockHeader.decode(bytes(block[: BlockHeader.SIZE]))
        # Only header blocks have the wall clock; their CRC is renewed.
        if head.kind == BlockKind.HEADER:
            struct.pack_into("<Q", block, _WALL_CLOCK_OFFSET, head.time_us + offset_us)
            block = bytearray(renumbered(bytes(block)))
        dated_blocks.append(bytes(block))
    return b"".join(dated_blocks)
