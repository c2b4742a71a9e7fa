"""A reset between any two bytes that the board writes of what it keeps: nothing of it is lost.

The images of the retained RAM while the board works are taken cycle by cycle, and each that differs from
the one before is what a reset at that moment would have left.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.fixtures.sequencer.board import AvrBoard, ResetCause
from tests.fixtures.sequencer.cable import OLD, connect
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import STROKE_NOT_BEGUN_US, STROKE_TIME_UNKNOWN_US

CYCLES_PER_US = 16
RAM_OFFSET = 0x800000
"""Of data addresses in the ELF."""
FIRST = OLD.strokes[0]
ANGLE_CDEG = 5900
ALL = 0b111
"""Servos that get pulses, as STATUS tells."""
FALL_US = FIRST.t_us + 1600
"""About when the first stroke's first pulse falls: 1655.5 us after its rise."""


def retained_ram(elf: Path) -> range:
    """Return the addresses of the RAM that a reset leaves untouched."""
    table = subprocess.run(["avr-objdump", "-t", str(elf)], check=True, capture_output=True, text=True)
    line = next(line for line in table.stdout.splitlines() if line.endswith("retained"))
    # objdump prints a data address with the offset of the RAM.
    start = int(line.split()[0], 16) - RAM_OFFSET
    size = int(line.split()[-2], 16)
    return range(start, start + size)


def images(board: AvrBoard, addresses: range, duration_us: int) -> list[bytes]:
    """Run for `duration_us` and return each image of this RAM that differs from the one before."""
    ram_images = [board.copy(addresses)]
    for cycle in range(board.cycles, board.cycles + duration_us * CYCLES_PER_US, 2):
        # Every second cycle: a write takes two.
        board.run_to_cycle(cycle)
        if (image := board.copy(addresses)) != ram_images[-1]:
            ram_images.append(image)
    return ram_images


def reset_with(board: AvrBoard, addresses: range, image: bytes) -> None:
    for address, value in zip(addresses, image, strict=True):
        board.poke(address, value)
    board.reset(ResetCause.WATCHDOG)
    board.cable(False)
    board.run(20_000)


def arm(board: AvrBoard) -> None:
    client = connect(board)
    client.arm()
    board.cable(False)
    board.run(20_000)


def test_a_reset_while_a_stroke_is_noted_loses_neither_its_time_nor_the_run(
    sequencer: AvrBoard, sequencer_hex: Path
) -> None:
    arm(sequencer)
    for index in (0, 1):
        sequencer.switch(index, closed=False)
    sequencer.run(FALL_US)
    addresses = retained_ram(sequencer_hex.with_suffix(".elf"))
    torn = images(sequencer, addresses, 2_500)
    # Fewer images would mean that the window missed the write.
    assert len(torn) > 20
    outcomes = []
    for image in torn:
        reset_with(sequencer, addresses, image)
        client = connect(sequencer)
        status, report = client.status(), client.run_report()
        assert (status.state, status.fault) == (SequencerState.FAULT, ErrorCode.RESET_WHILE_RUNNING)
        assert report.released == 1
        # No later stroke may be reported as begun.
        assert set(report.start_us[1:]) == {STROKE_NOT_BEGUN_US}
        outcomes.append((report.start_us[0], status.joint_angle_cdeg[0], status.servos_driven))
    noted_us = outcomes[-1][0]
    # To 2 us, what the stamp is exact to.
    assert abs(noted_us - FIRST.t_us) <= 2
    # Between the interrupt's mark and the loop's note, nobody knows when; amid the mark, which is made
    # within a microsecond, not even whether: no pulses.
    assert list(dict.fromkeys(outcomes)) == [
        (STROKE_NOT_BEGUN_US, 0, ALL),
        (STROKE_NOT_BEGUN_US, 0, 0),
        (STROKE_TIME_UNKNOWN_US, ANGLE_CDEG, ALL),
        (noted_us, ANGLE_CDEG, ALL),
    ]


def test_a_reset_while_a_knock_is_noted_leaves_the_board_armed(
    sequencer: AvrBoard, sequencer_hex: Path
) -> None:
    arm(sequencer)
    addresses = retained_ram(sequencer_hex.with_suffix(".elf"))
    sequencer.switch(0, closed=False)
    sequencer.run(1_000)
    # Opened for a millisecond: less than the debounce.
    sequencer.switch(0, closed=True)
    torn = images(sequencer, addresses, 8_000)
    assert len(torn) > 5
    for image in torn:
        reset_with(sequencer, addresses, image)
        assert connect(sequencer).status().state == SequencerState.ARMED
