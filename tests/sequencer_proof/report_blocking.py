"""Section 1 of the report, continued: how long interrupts are held off, path by path."""

from __future__ import annotations

from pathlib import Path

from tests.sequencer_proof.blocking import FOLLOWING_US, Blocked, blocked_paths
from tests.sequencer_proof.report_text import table
from tests.sequencer_proof.signals import CYCLES_PER_US

LEAST_CYCLES = CYCLES_PER_US
"""Shorter paths make one row together."""
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
    "ReleaseCapture::levels": "capture begins anew after noise",
    "Timer1Servos::hold": "a servo is told where to stand (arming, JOG)",
    "Timer1Servos::cancel": "the strokes left are dropped (a false release, a missed stroke)",
    "Timer1Servos::stop": "all servos are let go (DISARM)",
    "Timer1Servos::schedule": "a stroke is scheduled (at the release)",
    "UsbStream::write": "24 bytes to the cable",
    "UsbStream::serve": "the bus: reset, start of frame",
    "Serial_::write": "bytes into the cable's buffer",
    "USB_Recv": "a byte from the cable",
    "main": "start-up, and what the compiler made part of the main loop",
}


def render(image: Path) -> str:
    """Of the ELF beside the image."""
    elf = image.with_suffix(".elf")
    before = {path.address: path.cycles for path in blocked_paths(elf, scheduled=False)}
    paths = blocked_paths(elf)
    rows: list[tuple[object, ...]] = [
        (
            WHAT.get(path.function, ""),
            f"`{path.function}`",
            *_figures(before[path.address]),
            *_figures(path.cycles),
        )
        for path in _longest_of_each(paths)
    ]
    short = [path for path in paths if path.cycles < LEAST_CYCLES]
    rows.append(
        (f"{len(short)} more", "", "", "", f"at most {max(path.cycles for path in short)}", "below 1")
    )
    header = ("what holds interrupts off", "where", "cycles", "µs", "cycles with strokes ahead", "µs")
    return (
        "**How long interrupts are off**, computed from the instructions of the image, not measured: the longest way "
        "through each path, all\nbranches free, loops at their bounds, from the entry of an interrupt or a CLI until "
        "they are on again. The short form of this report\nholds it against the emulator: nothing takes longer.\n"
        "An edge of a servo is made by the timer: being late, up to 0.5 ms, does not move it. A switch's first edge is "
        "stamped by its timer,\nwhatever is off; what chatter does to a date can last as long as the longest path "
        "before the release, and then until both are open again.\nThe switches' own interrupt goes on for up to "
        f"{FOLLOWING_US} µs more while contacts chatter, and sees each edge meanwhile. USB's two\ninterrupts never "
        "come: the main loop calls what they would do.\n\n" + table(header, rows)
    )


def _figures(cycles: int) -> tuple[int, str]:
    return cycles, f"{cycles / CYCLES_PER_US:.1f}"


def _longest_of_each(paths: list[Blocked]) -> list[Blocked]:
    """One for each function, of those that are worth a row."""
    found: dict[str, Blocked] = {}
    for path in paths:
        if path.cycles >= LEAST_CYCLES:
            found.setdefault(path.function, path)
    return list(found.values())
