"""Blocks of RAM to spare while a file is filled with zeros, where sampling and the card share the processor."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from tests.cpp.compiling import EMULATOR_SOURCES, REPOSITORY
from tests.logger_proof.broken import Broken
from tests.logger_proof.building import SOURCES, WARNINGS, compiler, run_tool

RATES_HZ = (280, 850, 900, 1000)
TRANSFERS_NS = (20_700, 23_000, 30_000)
"""Of the processor for a block: the clock's limit, SdFat's maintainer's figure, and a dear one."""
STALLS_ONE_IN = (0, 100)
RUN_LIMIT_S = 300
_EMULATOR = (
    "sensors/mpu6050",
    "sensors/low_pass",
    "sensors/angle_sensor",
    "card/block_device",
    "boards/logger_board",
)


@dataclass(frozen=True, slots=True)
class Spare:
    """Of the ring's blocks, the fewest that were free.

    Attributes:
        rate_hz: Of sampling.
        transfer_ns: Processor time that a block takes on its way to the card.
        stall_one_in: Writes, of which one keeps the card busy for 50 to 500 ms; 0: none.
        at_start: In the first 30 s of a recording with the factory's file.
        at_change: Since the next file began, when the first was full.
    """

    rate_hz: int
    transfer_ns: int
    stall_one_in: int
    at_start: int
    at_change: int


def build(folder: Path) -> Path:
    """The emulated logger board, optimized. Raises BuildError."""
    core = [
        path for name in ("core", "protocol", "release") for path in sorted((SOURCES / name).glob("*.cpp"))
    ]
    sources = [REPOSITORY / "tests" / "logger_proof" / "shared_processor.cpp", *core]
    sources += [EMULATOR_SOURCES / f"{name}.cpp" for name in _EMULATOR]
    includes = (f"-I{EMULATOR_SOURCES}", f"-I{REPOSITORY / 'tests' / 'cpp'}")
    program = folder / "shared_processor"
    run_tool(
        folder, compiler(), "-std=c++17", "-O2", *WARNINGS, *includes, *map(str, sources), "-o", str(program)
    )
    return program


def measure(
    program: Path, rates_hz: Sequence[int] = RATES_HZ, transfers_ns: Sequence[int] = TRANSFERS_NS
) -> list[Spare]:
    """Each rate with each cost, without and with stalls. Raises Broken: a sample was lost."""
    cases = [(rate, cost, stalls) for rate in rates_hz for cost in transfers_ns for stalls in STALLS_ONE_IN]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda case: _measured(program, *case), cases))


def _measured(program: Path, rate_hz: int, transfer_ns: int, stall_one_in: int) -> Spare:
    command = [str(program), str(rate_hz), str(transfer_ns), str(stall_one_in)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=RUN_LIMIT_S)
    if done.returncode != 0:
        raise Broken(f"{' '.join(command[1:])}: exit code {done.returncode}\n{done.stderr}")
    spare = Spare(rate_hz, transfer_ns, stall_one_in, *map(int, done.stdout.split()))
    if min(spare.at_start, spare.at_change) < 0:
        raise Broken(f"samples were lost: {spare}")
    return spare
