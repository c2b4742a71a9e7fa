"""What both boards say of themselves: the lines of `status`, and the words that they share."""

from __future__ import annotations

from tfsat_host.protocol.limits import SWITCH_COUNT

Rows = list[tuple[str, str]]
"""Name and text of each line; a name that is indented belongs to the line before it."""


def switches_closed(switches_open: int) -> list[bool]:
    """Whether each release switch is closed, from the status bits."""
    return [not switches_open >> bit & 1 for bit in range(SWITCH_COUNT)]


def switch_words(switches_open: int) -> str:
    """The release switches for people."""
    return ", ".join(
        f"{number} {'closed' if closed else 'OPEN'}"
        for number, closed in enumerate(switches_closed(switches_open), 1)
    )


def open_switches(switches_open: int) -> str:
    """Which are open, named: `release switch 2`."""
    numbers = [str(number) for number, closed in enumerate(switches_closed(switches_open), 1) if not closed]
    return f"release switch{'es' if len(numbers) > 1 else ''} {' and '.join(numbers)}"


def with_fault(state: str, fault: str) -> str:
    """A state and, unless there is none, the fault in it."""
    return state if fault == "none" else f"{state}: {fault.replace('_', ' ')}"
