"""Instructions that the logger's core takes on the Cortex-M7, counted by QEMU."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tests.logger_proof.broken import Broken
from tests.logger_proof.m7 import qemu

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
