"""The same program on a Cortex-M7, and the instructions that the core takes there.

QEMU's mps2-an500, whose files are this computer's by semihosting.
"""

from __future__ import annotations

import hashlib
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tests.logger_proof.campaign import run
from tests.proof.campaign import Broken, Job, paragraph, table

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


def twin_jobs(pc: Path, m7: Path, seeds: Iterable[int], batch: int = BATCH) -> list[Job]:
    """The comparison of all these seeds, `batch` of them a job."""
    return [partial(compare, pc, m7, first, batch) for first in seeds]


def twins(parts: Sequence[Sequence[bytes]]) -> Twins:
    """What the jobs of `twin_jobs` found."""
    results = [result for part in parts for result in part]
    return Twins(len(results) // 2, sum(map(len, results)), hashlib.sha256(b"".join(results)).hexdigest())


CLOCK_HZ = 600_000_000
MOST_SHARE = 0.10
"""Of the processor, that sampling may take at an instruction a cycle; what it waits for at the buses comes on top."""


@dataclass(frozen=True, slots=True)
class Figure:
    """Instructions of one thing done `count` times; `most` to 40 instructions."""

    count: int
    mean: int
    most: int


@dataclass(frozen=True, slots=True)
class Instructions:
    """At one sampling rate, ports excluded where `ports` says what they take.

    Attributes:
        sample: The whole sampling interrupt while recording, ports included.
        idle_sample: Likewise while nothing is recorded.
        ports: Of them, the stand-ins for buses, converter and inputs.
        empty_pass: A pass of the main loop that has nothing to write.
        pass_with_block: One that hands a block to the card, without the card's driver.
    """

    rate_hz: int
    sample: Figure
    idle_sample: Figure
    ports: int
    empty_pass: Figure
    pass_with_block: Figure

    @property
    def core(self) -> Figure:
        """The core's own part of a sample."""
        return Figure(self.sample.count, self.sample.mean - self.ports, self.sample.most - self.ports)

    @property
    def share(self) -> float:
        """Of 600 MHz, at an instruction a cycle: sampling and writing its blocks."""
        blocks_a_sample = self.pass_with_block.count / self.sample.count
        per_sample = self.core.mean + blocks_a_sample * self.pass_with_block.mean
        return per_sample * self.rate_hz / CLOCK_HZ


def count_instructions(program: Path, rate_hz: int) -> Instructions:
    """Runs `instructions` of board/. Raises Broken."""
    lines = [line.split() for line in qemu(program, str(rate_hz)).splitlines()]
    figures = {line[0]: Figure(*map(int, line[1:])) for line in lines}
    if set(figures) != {"idle_sample", "sample", "pass", "pass_with_block", "ports"}:
        raise Broken(f"the Cortex-M7 counted {sorted(figures)}")
    counted = Instructions(
        rate_hz=rate_hz,
        sample=figures["sample"],
        idle_sample=figures["idle_sample"],
        ports=figures["ports"].mean,
        empty_pass=figures["pass"],
        pass_with_block=figures["pass_with_block"],
    )
    if counted.share > MOST_SHARE:
        raise Broken(f"the core takes {counted.share:.1%} of the processor at {rate_hz} Hz")
    return counted


def twins_page(same: Twins) -> str:
    text = paragraph(
        f"{same.seeds} of these runs on the PC, with the address and undefined-behaviour sanitizers on, and on the "
        "Cortex-M7: the card's image and the account of what it was given are the same to the byte, "
        f"{same.bytes_compared} bytes in all, SHA-256 `{same.sha256}`."
    )
    return f"## 4. The same bytes on a Cortex-M7\n\n{text}"


def instructions_page(counted: Sequence[Instructions]) -> str:
    rows = [
        (
            *(one.rate_hz, one.core.mean, one.core.most, one.idle_sample.mean - one.ports),
            *(one.pass_with_block.mean, one.empty_pass.mean, f"{one.share:.2%}"),
        )
        for one in counted
    ]
    header = (
        *("Hz", "a sample: mean", "most", "mean when idle"),
        *("a pass that writes a block", "an empty pass", "of 600 MHz"),
    )
    text = paragraph(
        "Of the core, -O2, counted by QEMU to 40 instructions; ports and drivers excluded. The most is a sample that "
        "closes a block. The last column is sampling and handing on its blocks, at an instruction a cycle; the wait "
        "for the buses comes on top."
    )
    return f"## 5. Instructions on the Cortex-M7\n\n{text}\n\n{table(header, rows)}"
