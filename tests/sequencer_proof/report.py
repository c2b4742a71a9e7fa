"""The report: docs/sequencer-proof.md. Every figure in it comes from a campaign or from the build."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from tests.proof.campaign import output, table
from tests.sequencer_proof import (
    blocking,
    damage,
    dating,
    held_pins,
    jolts,
    link_abuse,
    noise,
    one_rule,
    power_cuts,
    releases,
    resets,
    waiting,
)
from tests.sequencer_proof.campaigns import SEED_OF, Proof
from tests.sequencer_proof.rigs import image_report
from tfsat_host.flashing.image import FLASH_BYTES
from tfsat_host.protocol.limits import FIRMWARE_VERSION

RAM_BYTES = 2560
NOT_MODELLED = """\
- **The supply.** There is no voltage. A brown-out is a forced reset with its flag set; a power cut stops the program
  between two instructions and tears the EEPROM byte under way as the tables say.
- **The bootloader.** The program starts at the reset. What the real one does after a brown-out stands in
  [sequencer.md](sequencer.md#resets).
- **The moment of an interrupt.** simavr takes no time to enter one. The harness adds the datasheet's 5 cycles
  (0.3 µs), but not the few cycles by which a long instruction delays it; inputs change between two instructions.
- **What the board drives, read back.** simavr shows PORTx where a timer drives a pin; the harness puts the pin's own
  level in its place, as the chip does.
- **The crystal.** Its error scales all times alike.
- **USB signals.** The host's end is modelled by packets, not by wires.
- **Servos.** The onset is the rise of the pulse on the pin. What a servo makes of it is its own affair."""


@dataclass(frozen=True, slots=True)
class Tools:
    """Versions of what the figures depend on."""

    avr_gcc: str
    simavr: str

    @classmethod
    def found(cls) -> Self:
        return cls(
            output("avr-gcc", "-dumpversion"),
            output("pkg-config", "--modversion", "simavr"),
        )


def hex_sha256(image: Path) -> str:
    """Of the HEX file as it is handed to avrdude."""
    return hashlib.sha256(image.read_bytes()).hexdigest()


def render(proof: Proof, image: Path, tools: Tools) -> str:
    """The whole report, Markdown. The same image and tools give the same text."""
    sections = [
        _head(image, tools),
        _releases(proof),
        jolts.page(proof.jolted, proof.closed),
        one_rule.page(proof.rule),
        blocking.page(image),
        power_cuts.page(proof.cuts, proof.rewrites),
        damage.page(proof.damaged, proof.damaged_image),
        link_abuse.page(proof.abused),
        noise.page(proof.noisy),
        resets.page(proof.resets, proof.hangs),
        held_pins.page(proof.held),
        _size(proof, image),
        f"## What the emulation leaves out\n\n{NOT_MODELLED}",
        _seeds(),
    ]
    return "\n\n".join(sections) + "\n"


def _head(image: Path, tools: Tools) -> str:
    report = image_report(image)
    version = ".".join(map(str, FIRMWARE_VERSION))
    identity = table(
        ("", ""),
        [
            ("firmware", version),
            ("SHA-256 of the HEX", f"`{hex_sha256(image)}`"),
            ("CRC-32 of the image, as HELLO and STATUS tell it", f"`{report['image_crc32']}`"),
            ("compiler", f"avr-gcc {tools.avr_gcc}"),
            ("emulator", f"libsimavr {tools.simavr}"),
        ],
    )
    return (
        "# What the sequencer was measured to do\n\n"
        "Written by `make sequencer-report`; do not edit. Not a model: the HEX that is flashed runs "
        "in libsimavr, instruction by\n"
        "instruction, and the emulator measures at its pins, in CPU cycles (62.5 ns). No board lay "
        "on a bench for this. Only the rows\n"
        "that say *native* run the same core compiled for a PC. Everything below held in every run: a "
        "campaign that finds a single\n"
        "exception fails, and writes no report. What the words mean: [sequencer.md](sequencer.md).\n\n"
        + identity
    )


def _releases(proof: Proof) -> str:
    avr = [release for part in proof.avr for release in part.releases]
    fast = [release for part in proof.fast for release in part.releases]
    native = [release for part in proof.native for release in part]
    plan = proof.avr[0].plan
    dated = (proof.dated, proof.fast_dated, proof.fastest_dated)
    sections = [
        f"## 1. Releases\n\n{releases.conditions([*avr, *fast, *native])}",
        f"**Onset of each stroke of 59/70 in the flashed image, {len(avr)} releases with slow chatter**, "
        "µs after the release:",
        releases.stroke_table(plan, avr),
        f"Errors of these {4 * len(avr)} strokes:",
        f"```\n{releases.error_histogram(avr)}\n```",
        f"**The same with fast chatter**, {len(fast)} releases, in one half of them mixed with slow. Where edges "
        "of both switches lie within a\nmicrosecond the rule has two answers, and the nearer one counts:",
        releases.stroke_table(plan, fast),
        f"Slow and fast mixed over {len(native)} releases of the *native* core, whose edges are exact to the tick:",
        releases.stroke_table(plan, native),
        dating.page([[one for part in parts for one in part] for parts in dated]),
        releases.signal_table([*avr, *fast], native),
        waiting.page(proof.waits, proof.knocks, plan.strokes),
    ]
    return "\n\n".join(sections)


def _size(proof: Proof, image: Path) -> str:
    report = image_report(image)
    flash_budget, ram_budget = report["flash_budget_bytes"], report["ram_budget_bytes"]
    rows = [
        ("flash", f"{report['flash_bytes']} ({report['flash_percent']}%)", f"at most {flash_budget} of {FLASH_BYTES} "
         "after the bootloader"),
        ("static RAM", report["ram_bytes"], f"at most {ram_budget} of {RAM_BYTES}"),
        ("stack never touched", proof.never_used, f"at least {report['stack_spare_bytes']}"),
    ]  # fmt: skip
    return (
        "## 5. Size\n\n" + table(("", "bytes", "budget"), rows) + "\n\n"
        "The build fails above the first two budgets. The third is the least over the campaigns of "
        "sections 1 to 3, "
        "by the board's own STATUS, and by its RAM as a\ndebugger sees it."
    )


def _seeds() -> str:
    seeds = ", ".join(f"{name} {seed}" for name, seed in SEED_OF.items())
    return f"## Seeds\n\nOf each campaign's first job; every further job has the next: {seeds}."
