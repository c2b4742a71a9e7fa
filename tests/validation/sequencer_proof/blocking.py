"""How long interrupts are held off, path by path, computed from the instructions of the image that is flashed.

A path begins where interrupts go off, at an interrupt or a CLI, and ends where they come on again: RETI, SEI, or the
status register written back. Its length is that of the longest way through it, all branches free, each loop run as
often as `LOOPS` says at the most. What it calls counts with it. Nothing is measured: `test_campaigns` holds the figures
against the emulator's.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from tests.validation.sequencer_proof.disassembly import CALLS, Instruction, Program, disassemble
from tests.validation.sequencer_proof.signals import CYCLES_PER_US
from tfsat_host.protocol.limits import MAX_STROKES

ENTRY_CYCLES = 5
"""From the end of the instruction that was interrupted to the vector's jump (ATmega32U4 datasheet, section 4.7.1)."""
JUMP_CYCLES = 3
VECTOR_BYTES = 4
BLOCKED_BEFORE_RELEASE_MAX_US = 78
"""Arming, which holds a servo's line; while armed, a servo's edge and the switches' interrupt are next."""
BLOCKED_MAX_US = 188
NEVER_ON = (10, 11)
"""USB's vectors never interrupt: usb_stream.cpp calls them, and masks them with interrupts off."""
ONCE = ("tfsat_save_reset_flags", "abort", "_exit")
"""Run before interrupts are first on, or never return."""
NEVER_CALLED = ("delay", "longjmp")
"""The core's wait for room in a buffer, since UsbStream::write() hands on less than there is; and what leaves a wait
for the host, which turns interrupts on as its own last act."""
LOOPS: dict[str, tuple[int, ...]] = {
    "__udivmodsi4_ep": (33,),
    "__vector_16": (2, 28),
    "set_output_mode": (7, 7),
    "Serial_::write": (2, 25),
    "Timer1Servos::cancel": (MAX_STROKES + 1, 4),
    "Timer1Servos::forget_changes": (4,),
    "Timer1Servos::hold": (3,),
    "Timer1Servos::prepare_next_edge": (3, 1, 3, MAX_STROKES, MAX_STROKES + 1, 3, 3),
    "Timer1Servos::set_edge": (3, 3),
    "Timer1Servos::stop": (4, 3),
    "USB_Recv": (2,),
}
"""How often the first instruction of each loop runs at the most, in the order of their addresses: a bit a time
(division, shifts), a channel a time, a change of the schedule a time, 24 bytes a write, 1 byte a read. A servo's edge
is prepared in one round: a second one is for an edge that was too late, which needs more blocking than there is.
__vector_16, the switches' interrupt: a stamped edge, then quiet; see FOLLOWING_US."""
UNSCHEDULED_LOOPS = {"Timer1Servos::prepare_next_edge": (3, 1, 1, 1, 1, 3, 3)}
"""Likewise, before the release: nothing is scheduled, so that no gap is divided, either."""
FOLLOWING_US = 250
"""What the switches' interrupt takes beyond that while contacts chatter (release_capture.cpp, kFollowTicks): it sees
each edge meanwhile."""


class UnboundedError(ValueError):
    """The image has a loop that `LOOPS` does not know."""


class Blocked(NamedTuple):
    """A path. `function`: where interrupts go off."""

    function: str
    address: int
    """Of its first instruction with interrupts off: an interrupt's vector, or what follows the CLI."""
    cycles: int


def blocked_paths(elf: Path, *, scheduled: bool = True) -> list[Blocked]:
    """Compute the image's paths with interrupts off, the longest first.

    `scheduled` includes the time while strokes are ahead. Raises UnboundedError.
    """
    walk = _Walk(disassemble(elf), scheduled)
    for _ in walk.paths():  # once for the loops that there are
        pass
    walk.costs.clear()
    walk.discover = False
    # The longest path first: it is what the blocking limit is about.
    return sorted((Blocked(*path) for path in walk.paths()), key=lambda path: -path.cycles)


def short_name(function: str) -> str:
    """Without namespaces, arguments and what the compiler appends."""
    bare = re.sub(r"\(anonymous namespace\)::|tfsat::(sequencer|protocol)::", "", function)
    return bare.split("(")[0].split(" [clone")[0].split(".constprop")[0].strip()


Edges = dict[int, list[tuple[int, int]]]


@dataclass(slots=True)
class _Walk:
    program: Program
    scheduled: bool
    costs: dict[int, int] = field(default_factory=dict)
    headers: dict[str, list[int]] = field(default_factory=dict)
    discover: bool = True

    def paths(self) -> Iterator[tuple[str, int, int]]:
        instructions, functions = self.program.instructions, self.program.functions
        for number in range(1, 43):
            vector = f"__vector_{number}"
            if vector in functions and number not in NEVER_ON:
                # Interrupts off at the vector: entry, jump, and everything until they are on again.
                start = functions[vector]
                yield (
                    vector,
                    number * VECTOR_BYTES,
                    ENTRY_CYCLES + JUMP_CYCLES + self._longest(start, saved_off=True),
                )
        for instruction in instructions.values():
            if (
                instruction.operation == "cli"
                # A CLI in an interrupt is inside a path that is counted already.
                and instruction.function not in ONCE
                and not self._in_interrupt(instruction)
            ):
                yield (
                    short_name(instruction.function),
                    instruction.following,
                    1 + self._longest(instruction.following, saved_off=False),
                )

    def _calls(self, instruction: Instruction) -> str:
        if instruction.operation not in CALLS or instruction.target is None:
            return ""
        return short_name(self.program.instructions[instruction.target].function)

    def _in_interrupt(self, instruction: Instruction) -> bool:
        return instruction.function.startswith("__vector_")

    def _call(self, start: int) -> int:
        """Compute the cycles of a function called with interrupts off, up to its return."""
        if start not in self.costs:
            self.costs[start] = self._longest(start, saved_off=True)
        return self.costs[start]

    def _longest(self, start: int, *, saved_off: bool) -> int:
        edges: Edges = {}
        ends: dict[int, int] = {}
        # Depth first over all instructions that can follow with interrupts off.
        todo = [start]
        while todo:
            address = todo.pop()
            if address in edges:
                continue
            instruction = self.program.instructions[address]
            following = self.program.next(instruction)
            edges[address] = []
            called = self._calls(instruction)
            if called in NEVER_CALLED or (called == "__udivmodsi4" and not self.scheduled):
                continue
            if (
                instruction.operation in {"ret", "reti", "ijmp"}
                or instruction.operation == "sei"
                # The status register written back ends the path only where it was saved with interrupts on.
                or (instruction.restores_status and not saved_off)
            ):
                # Ends count the cycles of the last instruction with them.
                ends[address] = following[0][1]
                continue
            if instruction.operation == "icall":
                # An indirect call cannot be bounded from the disassembly.
                raise UnboundedError(f"what is called at {address:#x} in {instruction.function}?")
            call_cycles = (
                self._call(instruction.target)
                if instruction.operation in CALLS and instruction.target is not None
                else 0
            )
            edges[address] = [(to, cycles + call_cycles) for to, cycles in following]
            todo.extend(to for to, _ in following)
        reached = self._distances(edges, start)
        return max((reached[address] + cycles for address, cycles in ends.items()), default=0)

    def _distances(self, edges: Edges, start: int) -> dict[int, int]:
        """Compute the longest path from `start` to each instruction, in cycles.

        Loops have a single entry.
        """
        reached = {start: 0}
        # In the order of the groups: every way in has been counted before its group.
        for group in _groups(edges, start):
            members = set(group)
            ways_in = [(reached[address], address) for address in group if address in reached]
            if not ways_in:
                continue
            if len(group) == 1 and all(to != group[0] for to, _ in edges[group[0]]):
                # A group of one without a jump to itself is no loop.
                inside = {group[0]: ways_in[0][0]}
            else:
                inside = self._loop(edges, members, ways_in)
            for address, distance in inside.items():
                reached[address] = distance
                for to, cycles in edges[address]:
                    if to not in members:
                        reached[to] = max(reached.get(to, 0), distance + cycles)
        return reached

    def _loop(self, edges: Edges, members: set[int], ways_in: list[tuple[int, int]]) -> dict[int, int]:
        if len(ways_in) != 1:
            # A loop with two ways in has no bound that LOOPS could state.
            raise UnboundedError(f"a loop with {len(ways_in)} ways in at {min(members):#x}")
        distance, header = ways_in[0]
        body: Edges = {
            address: [(to, cycles) for to, cycles in edges[address] if to in members and to != header]
            for address in members
        }
        # The longest turn, once round: its cycles times the bound.
        once = self._distances(body, header)
        turn = max(
            once[address] + cycles for address in members for to, cycles in edges[address] if to == header
        )
        loop_cycles = (self._times(header) - 1) * turn
        return {address: distance + loop_cycles + way for address, way in once.items()}

    def _times(self, header: int) -> int:
        name = short_name(self.program.instructions[header].function)
        # Loop headers of a function, in the order of their addresses.
        loop_headers = self.headers.setdefault(name, [])
        if header not in loop_headers:
            loop_headers.append(header)
            loop_headers.sort()
        if self.discover:
            # In the first pass no bound is needed, only the loops themselves.
            return 1
        bounds = (LOOPS if self.scheduled else LOOPS | UNSCHEDULED_LOOPS).get(name, ())
        # LOOPS must know every loop of a function, or the bound is missing.
        if len(bounds) != len(loop_headers):
            raise UnboundedError(f"{name} has {len(loop_headers)} loops, LOOPS knows {len(bounds)}")
        return bounds[loop_headers.index(header)]


def _groups(edges: Edges, start: int) -> list[list[int]]:
    """Strongly connected ones, in the order of the ways through them (Tarjan, without recursion)."""
    order: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    on_stack: set[int] = set()
    groups: list[list[int]] = []
    work: list[tuple[int, Iterator[tuple[int, int]]]] = []

    def open_(address: int) -> None:
        order[address] = low[address] = len(order)
        stack.append(address)
        on_stack.add(address)
        work.append((address, iter(edges[address])))

    open_(start)
    while work:
        address, rest = work[-1]
        for to, _ in rest:
            if to not in order:
                open_(to)
                break
            if to in on_stack:
                # A node that is on the stack belongs to the group under way.
                low[address] = min(low[address], order[to])
        else:
            work.pop()
            if work:
                low[work[-1][0]] = min(low[work[-1][0]], low[address])
            # The header of the group: everything above it on the stack belongs to it.
            if low[address] == order[address]:
                group: list[int] = []
                while not group or group[-1] != address:
                    group.append(stack.pop())
                    on_stack.discard(group[-1])
                groups.append(group)
    # Reversed: Tarjan gives the groups in reverse order of the ways through them.
    return groups[::-1]


WHAT = {
    "__vector_9": "a servo's pin moved while a stroke is due",
    "__vector_16": "an edge of switch 1, until both are quiet",
    "__vector_17": "an edge of servo 1",
    "__vector_18": "an edge of servo 2",
    "__vector_19": "an edge of servo 3",
    "__vector_20": "the tick clock's overflow",
    "__vector_23": "the Arduino core's millisecond",
    "__vector_31": "an edge of switch 2, until both are quiet",
    "__vector_32": "the end of the mark on the stroke line",
    "ReleaseCapture::levels": "capture restarts after noise",
    "Timer1Servos::hold": "a servo gets its pose (arming, JOG)",
    "Timer1Servos::cancel": "the strokes left are dropped (a false release, a missed stroke)",
    "Timer1Servos::stop": "all servos are let go (DISARM)",
    "Timer1Servos::schedule": "a stroke is scheduled (at the release)",
    "UsbStream::write": "24 bytes to the cable",
    "UsbStream::serve": "the bus: reset, start of frame",
    "Serial_::write": "bytes into the cable's buffer",
    "USB_Recv": "a byte from the cable",
    "main": "start-up, and what the compiler made part of the main loop",
}


class PathRow(NamedTuple):
    """The longest path of one function, before the release and while strokes are ahead."""

    what: str
    function: str
    cycles: int
    us: float
    cycles_scheduled: int
    us_scheduled: float


def path_rows(elf: Path) -> list[PathRow]:
    """Compute one row for each function, the longest path first."""
    before = {path.address: path.cycles for path in blocked_paths(elf, scheduled=False)}
    longest: dict[str, Blocked] = {}
    for path in blocked_paths(elf):
        longest.setdefault(path.function, path)
    return [
        PathRow(
            WHAT.get(path.function, ""),
            path.function,
            before[path.address],
            before[path.address] / CYCLES_PER_US,
            path.cycles,
            path.cycles / CYCLES_PER_US,
        )
        for path in longest.values()
    ]
