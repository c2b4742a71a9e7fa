"""The same program on a Cortex-M7, and the instructions that the core takes there.

QEMU's mps2-an500, whose files are this computer's by semihosting.
"""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

from tests.validation.campaign import Broken
from tests.validation.logger_proof.campaign import run

MACHINE = "mps2-an500"
FULL_SEEDS = 96
"""Three of each kind of fault at each rate."""
BATCH = 8
LIMIT_S = 240


def qemu(program: Path, *arguments: str) -> str:
    """Runs a program of `build_for_m7` to its end; one instruction takes one ns. What it printed.

    Raises:
        Broken: it did not end well.
    """
    # Semihosting takes the arguments one by one.
    words = ",".join(f"arg={word}" for word in ("program", *arguments))
    command = [
        *("qemu-system-arm", "-M", MACHINE, "-nographic", "-monitor", "none", "-serial", "none"),
        *("-semihosting-config", f"enable=on,target=native,{words}"),
        *("-icount", "shift=0,sleep=off", "-kernel", str(program)),
    ]
    process = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=LIMIT_S, stdin=subprocess.DEVNULL
    )
    if process.returncode != 0:
        raise Broken(f"the Cortex-M7 ended with {process.returncode}: {process.stdout}{process.stderr}")
    return process.stdout


def compare(pc: Path, m7: Path, seed: int, count: int = 1) -> list[bytes]:
    """Compare each seed's image and account between the PC and the Cortex-M7, and return them.

    Raises Broken where the bytes differ.
    """
    with tempfile.TemporaryDirectory() as name:
        folders = [Path(name) / "pc", Path(name) / "m7"]
        for folder in folders:
            folder.mkdir()
        run(pc, seed, count, folders[0])
        qemu(m7, str(seed), str(count), str(folders[1]))
        results = []
        for number in range(seed, seed + count):
            # Image and account: the card's bytes and what the program says of them.
            for suffix in ("bin", "truth"):
                here, there = ((folder / f"{number}.{suffix}").read_bytes() for folder in folders)
                if here != there:
                    raise Broken(f"seed {number}: the Cortex-M7's .{suffix} is another than the PC's")
                results.append(here)
        return results


CLOCK_HZ = 600_000_000
SHARE_MAX = 0.10
"""Of the processor, that sampling may take at an instruction a cycle; what it waits for at the buses comes on top."""


class Figure(NamedTuple):
    """Instructions of one thing done `times` over; `most` to 40 instructions."""

    times: int
    mean: int
    most: int


class Instructions(NamedTuple):
    """At one sampling rate, ports excluded where `ports` says what they take.

    Attributes:
        sample: The whole sampling interrupt while recording, ports included.
        idle_sample: Likewise while nothing is recorded.
        ports: Of them, the emulated buses, converter and inputs.
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
        return Figure(self.sample.times, self.sample.mean - self.ports, self.sample.most - self.ports)

    @property
    def share(self) -> float:
        """Of 600 MHz, at an instruction a cycle: sampling and writing its blocks."""
        # Blocks a sample, about a sixth: each sample pays its share of a block.
        blocks_a_sample = self.pass_with_block.times / self.sample.times
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
    # Sampling must leave 90 % of the processor to USB and the card's driver.
    if counted.share > SHARE_MAX:
        raise Broken(f"the core takes {counted.share:.1%} of the processor at {rate_hz} Hz")
    return counted
