"""What one failed transfer with an IMU costs, on emulated buses that take their time."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.cpp.compiling import EMULATOR_SOURCES, build_program
from tests.logger_proof.broken import Broken
from tests.logger_proof.building import BOARD, SOURCES


@dataclass(frozen=True, slots=True)
class Glitches:
    """Of one kind at one rate.

    Attributes:
        kind: `nack` or `timeout`.
        rate_hz: Sampling rate; the buses run at 400 kHz.
        count: How many.
        lost, most: Samples of the struck IMU that they cost, in all and at most by one of them.
        others: Samples of the other IMUs that they cost.
    """

    kind: str
    rate_hz: int
    count: int
    lost: int
    most: int
    others: int


def run_glitches(folder: Path, rates_hz: Sequence[int]) -> list[Glitches]:
    """Of both kinds at each rate. Raises Broken if one costs more than the sample that it hit."""
    program = _built(folder)
    found = []
    for rate_hz in rates_hz:
        said = subprocess.run([program, str(rate_hz)], capture_output=True, text=True, check=True).stdout
        for line in said.splitlines():
            kind, *numbers = line.split()
            found.append(Glitches(kind, rate_hz, *map(int, numbers)))
    for one in found:
        if one.most > 1 or one.others:
            raise Broken(
                f"one {one.kind} costs {one.most} samples at {one.rate_hz} Hz, and others {one.others}"
            )
    return found


def _built(folder: Path) -> Path:
    sources = [BOARD / "glitches.cpp"]
    sources += [SOURCES / "core" / f"{name}.cpp" for name in ("settings", "mpu6050", "sampler")]
    sources += [EMULATOR_SOURCES / "sensors" / f"{name}.cpp" for name in ("mpu6050", "low_pass")]
    folder.mkdir(parents=True, exist_ok=True)
    return build_program(sources, folder / "glitches")
