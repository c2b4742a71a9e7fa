"""The same program on a Cortex-M7: QEMU's mps2-an500, whose files are this computer's by semihosting."""

from __future__ import annotations

import hashlib
import os
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from tests.logger_proof.broken import Broken
from tests.logger_proof.campaign import run

MACHINE = "mps2-an500"
FULL_SEEDS = 96
"""Three of each kind of fault at each rate."""
SHORT_SEEDS = (1, 14, 15, 28)
BATCH = 8
LIMIT_S = 240


@dataclass(frozen=True, slots=True)
class Twins:
    """Runs whose results are the same bytes on both machines.

    Attributes:
        seeds: How many.
        bytes_compared: Images and accounts of what happened.
        sha256: Of all of them, in the order of their seeds.
    """

    seeds: int
    bytes_compared: int
    sha256: str


def qemu(program: Path, *arguments: str) -> str:
    """Runs a program of `build_for_m7` to its end; one instruction takes one ns. What it printed.

    Raises:
        Broken: it did not end well.
    """
    words = ",".join(f"arg={word}" for word in ("program", *arguments))
    command = [
        *("qemu-system-arm", "-M", MACHINE, "-nographic", "-monitor", "none", "-serial", "none"),
        *("-semihosting-config", f"enable=on,target=native,{words}"),
        *("-icount", "shift=0,sleep=off", "-kernel", str(program)),
    ]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=LIMIT_S, stdin=subprocess.DEVNULL
    )
    if done.returncode != 0:
        raise Broken(f"the Cortex-M7 ended with {done.returncode}: {done.stdout}{done.stderr}")
    return done.stdout


def compare(pc: Path, m7: Path, first: int, count: int) -> list[bytes]:
    """Each seed's results on both machines, which are the same. Raises Broken where they are not."""
    with tempfile.TemporaryDirectory() as name:
        folders = [Path(name) / "pc", Path(name) / "m7"]
        for folder in folders:
            folder.mkdir()
        run(pc, first, count, folders[0])
        qemu(m7, str(first), str(count), str(folders[1]))
        results = []
        for seed in range(first, first + count):
            for suffix in ("bin", "truth"):
                here, there = ((folder / f"{seed}.{suffix}").read_bytes() for folder in folders)
                if here != there:
                    raise Broken(f"seed {seed}: the Cortex-M7's .{suffix} is another than the PC's")
                results.append(here)
        return results


def twins(pc: Path, m7: Path, batches: Sequence[tuple[int, int]]) -> Twins:
    """All batches of (first seed, count), on all cores. Raises Broken."""
    digest, size = hashlib.sha256(), 0
    with ProcessPoolExecutor(max_workers=os.cpu_count()) as pool:
        for results in pool.map(compare, *zip(*((pc, m7, *batch) for batch in batches), strict=True)):
            for result in results:
                digest.update(result)
                size += len(result)
    return Twins(sum(count for _, count in batches), size, digest.hexdigest())
