"""Folders as a drop leaves them, made once a run of the tests and copied, and damage to what lies in them."""

from __future__ import annotations

import atexit
import shutil
import tempfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.evaluation.drops import MORNING, RATE_RAD_S, calibrated_from_truth, with_com_offsets
from tests.fixtures.emulated_drop import Drop, drop
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.maneuver import format_maneuver, four_stroke
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import BLOCK_BYTES, BLOCK_MAGIC
from tfsat_host.protocol.log_layout import BLOCK_HEADER_DTYPE, CRC_OFFSET, DATA_BLOCK_DTYPE, LOG_HEADER_DTYPE
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import load

ROBOT = 11
"""The seed of the one robot that all these drops are of."""
DROPPED = MORNING + timedelta(hours=1)
CERTIFICATE = "calibration-emulated.toml"
Blocks = NDArray[Any]


@dataclass(frozen=True, eq=False)
class _Made:
    folder: Path
    drop: Drop


@cache
def _make_run(seed: int) -> _Made:
    # Kept for the whole test process and removed at its end.
    folder = Path(tempfile.mkdtemp(prefix="tfsat-drop-"))
    atexit.register(shutil.rmtree, folder)
    model, imperfections = load_robot(), draw_as_built(ROBOT)
    # Within 8 mm, so that no offset reaches its bound of 10 mm.
    off = with_com_offsets(model, np.random.default_rng(ROBOT).uniform(-0.008, 0.008, (3, 3)))
    emulated_drop = drop(off, imperfections, model=model, seed=seed, rate_rad_s=RATE_RAD_S)
    (folder / "SD.bin").write_bytes(emulated_drop.card)
    calibration = calibrated_from_truth(model, imperfections, ROBOT)
    # An hour after the calibration.
    tell_time(folder / "SD.bin", DROPPED)
    (folder / CERTIFICATE).write_text(format_calibration(calibration), encoding="utf-8")
    (folder / "maneuver.toml").write_text(format_maneuver(four_stroke(59.0, 70.0)), encoding="utf-8")
    return _Made(folder, emulated_drop)


def made_drop(seed: int = 1) -> Drop:
    """Return the drop of `run_folder`, with its truth."""
    return _make_run(seed).drop


def made_folder(seed: int = 1) -> Path:
    """Return the folder with that drop's files, which must not be changed."""
    return _make_run(seed).folder


def run_folder(folder: Path, seed: int = 1) -> None:
    """Create a folder with a drop of `ROBOT`, its calibration and its maneuver."""
    shutil.copytree(_make_run(seed).folder, folder)


def on_other_logger(folder: Path, serial: bytes) -> None:
    """Change the drop as if another logger had recorded it, and its certificate to match."""
    # Both the card and the certificate: only their mismatch would be refused.
    change_headers(folder / "SD.bin", board_serial=list(serial))
    certificate = read_calibration(folder / CERTIFICATE)
    subject = replace(certificate.subject, logger_serial=serial.hex())
    (folder / CERTIFICATE).write_text(
        format_calibration(replace(certificate, subject=subject)), encoding="utf-8"
    )


def tell_time(card: Path, at: datetime | None) -> None:
    """Set the recording's start time, as `record start` would; None: the logger was not told the time."""
    change_headers(card, wall_clock_us=0 if at is None else round(at.timestamp() * 1e6))


def change_headers(card: Path, **values: int | list[int]) -> None:
    """Fields of the recording's header, by name, in each of its blocks."""
    fields = [*BLOCK_HEADER_DTYPE, *LOG_HEADER_DTYPE]
    # Fields of block head and log header in one record, with the unused rest and the CRC behind.
    filled = np.dtype(fields).itemsize
    dtype = np.dtype([*fields, ("rest", "u1", (CRC_OFFSET - filled,)), ("crc", "<u4")])
    blocks = np.frombuffer(bytearray(card.read_bytes()), dtype).copy()
    for row in np.flatnonzero((blocks["magic"] == BLOCK_MAGIC) & (blocks["kind"] == BlockKind.HEADER)):
        for name, value in values.items():
            blocks[row][name] = value
        # A right CRC: the decoder must see a changed header, not a broken block.
        blocks[row]["crc"] = zlib.crc32(blocks[row].tobytes()[:CRC_OFFSET])
    card.write_bytes(blocks.tobytes())


def change_samples(card: Path, change: Callable[[Blocks, NDArray[np.float64]], None]) -> None:
    """Lets `change` edit the data blocks in place, and gives them right CRCs again.

    It gets the k blocks (`DATA_BLOCK_DTYPE`) and the (k, 6) times of their samples by the logger's clock, s.
    """
    blocks = np.frombuffer(bytearray(card.read_bytes()), DATA_BLOCK_DTYPE).copy()
    rows = np.flatnonzero((blocks["magic"] == BLOCK_MAGIC) & (blocks["kind"] == BlockKind.DATA))
    data = blocks[rows]
    # Times as float seconds of the logger's clock: the change can depend on them.
    change(data, 1e-6 * (data["time_us"][:, None] + data["samples"]["time_offset_us"]))
    for block in data:
        block["crc"] = zlib.crc32(block.tobytes()[:CRC_OFFSET])
    blocks[rows] = data
    card.write_bytes(blocks.tobytes())


def remove_blocks(card: Path, from_s: float, until_s: float) -> None:
    """Zeroes the data blocks that began between two times by the logger's clock."""
    image = bytearray(card.read_bytes())
    blocks = np.frombuffer(bytes(image), DATA_BLOCK_DTYPE)
    begins = 1e-6 * blocks["time_us"].astype(np.float64)
    data = (blocks["magic"] == BLOCK_MAGIC) & (blocks["kind"] == BlockKind.DATA)
    for row in np.flatnonzero(data & (begins >= from_s) & (begins < until_s)):
        # Zeros, as a card shows blocks that were never written.
        image[row * BLOCK_BYTES : (row + 1) * BLOCK_BYTES] = bytes(BLOCK_BYTES)
    card.write_bytes(bytes(image))


def released_s(run: Path) -> float:
    release_us = load(run / "SD.bin").release_us
    assert release_us is not None
    return release_us * 1e-6


def cut(run: Path, after_release_s: float) -> None:
    """Power was cut, or the copy ends there."""
    card = run / "SD.bin"
    image = card.read_bytes()
    begins = np.frombuffer(image, DATA_BLOCK_DTYPE)["time_us"] * 1e-6
    # Up to the block that begins at that time.
    card.write_bytes(image[: int((begins < released_s(run) + after_release_s).argmin()) * BLOCK_BYTES])
