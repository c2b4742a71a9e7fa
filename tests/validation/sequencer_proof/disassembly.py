"""The image's instructions with their cycles, as far as the longest paths need them.

Cycles are those of the AVR instruction set manual (Microchip DS40002198) for the AVRe+ core with a 16-bit program
counter.
"""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

_LABEL = re.compile(r"^([0-9a-f]+) <(.+)>:$")
_INSTRUCTION = re.compile(r"^\s+([0-9a-f]+):\t([a-z]+)(?:\t([^;]*?))?\s*(?:;.*)?$")
_TWO = re.findall(
    "[a-z]+", "adiw sbiw mul muls mulsu fmul fmuls fmulsu ld ldd st std lds sts push pop rjmp ijmp sbi cbi"
)
_CYCLES = {"lpm": 3, "jmp": 3, "rcall": 3, "icall": 3, "call": 4, "ret": 4, "reti": 4} | dict.fromkeys(
    _TWO, 2
)
"""Of those that take more than one."""
_BRANCH = re.compile(r"br(ne|eq|cc|cs|lt|ge|mi|pl|tc|ts|vc|vs|hc|hs|ie|id|sh|lo)")
_SKIPS = {"cpse", "sbrc", "sbrs", "sbic", "sbis"}
_TWO_WORDS = {"call", "jmp", "lds", "sts"}
JUMPS, CALLS = {"jmp", "rjmp"}, {"call", "rcall"}
STATUS_REGISTER = "0x3f"


@dataclass(frozen=True, slots=True)
class Instruction:
    """One of the image. `target`: where a branch, jump or call goes, byte address."""

    address: int
    operation: str
    operands: tuple[str, ...]
    function: str
    target: int | None

    @property
    def following(self) -> int:
        # Two-word instructions are four bytes long.
        return self.address + (4 if self.operation in _TWO_WORDS else 2)

    @property
    def restores_status(self) -> bool:
        return self.operation == "out" and self.operands[0] == STATUS_REGISTER


@dataclass(frozen=True, slots=True)
class Program:
    """All instructions by address, and the functions' first ones by name."""

    instructions: dict[int, Instruction]
    functions: dict[str, int]

    def next(self, instruction: Instruction) -> list[tuple[int, int]]:
        """(address, cycles) of what may follow within the function; calls count without what they call."""
        if _BRANCH.fullmatch(instruction.operation):
            # A branch that is not taken costs one cycle, one that is taken two.
            return [(instruction.following, 1), (_known_target(instruction), 2)]
        if instruction.operation in _SKIPS:
            skipped = self.instructions[instruction.following]
            # A skip takes a cycle for each word that it skips.
            words = (skipped.following - skipped.address) // 2
            return [(instruction.following, 1), (skipped.following, 1 + words)]
        if instruction.operation in JUMPS:
            return [(_known_target(instruction), _CYCLES[instruction.operation])]
        return [(instruction.following, _CYCLES.get(instruction.operation, 1))]


@cache
def disassemble(elf: Path) -> Program:
    """Disassemble the image with avr-objdump."""
    text = subprocess.run(
        ["avr-objdump", "-d", "-C", "--no-show-raw-insn", str(elf)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    instructions: dict[int, Instruction] = {}
    functions: dict[str, int] = {}
    name = ""
    for line in text.splitlines():
        # A label starts a function; its instructions follow.
        if label := _LABEL.match(line):
            name = label[2]
            functions[name] = int(label[1], 16)
        elif match := _INSTRUCTION.match(line):
            address, operation = int(match[1], 16), match[2]
            operands = tuple(part.strip() for part in (match[3] or "").split(",")) if match[3] else ()
            instructions[address] = Instruction(
                address, operation, operands, name, _target(address, operation, operands)
            )
    return Program(instructions, functions)


def _target(address: int, operation: str, operands: tuple[str, ...]) -> int | None:
    if operation in {"call", "jmp"}:
        return int(operands[0], 16)
    if _BRANCH.fullmatch(operation) or operation in {"rjmp", "rcall"}:
        # Relative jumps count from the following instruction.
        return address + 2 + int(operands[0].removeprefix("."))
    return None


def _known_target(instruction: Instruction) -> int:
    if instruction.target is None:
        raise ValueError(f"where does {instruction.operation} at {instruction.address:#x} go?")
    return instruction.target
