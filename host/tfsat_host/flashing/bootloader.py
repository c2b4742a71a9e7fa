"""Waking the bootloader and finding the board again: its port goes, another comes, and back."""

from __future__ import annotations

from collections.abc import Callable

from tfsat_host.devices.board_errors import NoAnswer, WrongBoard
from tfsat_host.devices.client import Client
from tfsat_host.devices.discovery import Identity, PortInfo, identify
from tfsat_host.devices.identity import BoardIdentity
from tfsat_host.devices.port_errors import PortError
from tfsat_host.flashing.avrdude import FlashError
from tfsat_host.flashing.ports import Computer
from tfsat_host.protocol.enums import Board

POLL_S = 0.1
BOOTLOADER_TIMEOUT_S = 8.0
"""The bootloader itself goes back to the sketch after 8 s."""
HINT_S = 4.0
PERMISSIONS_S = 0.3
"""A new port's permissions are set by udev a moment after it has appeared."""
SKETCH_TIMEOUT_S = 15.0
"""The sketch's port is back in 2 s; Windows takes longer the first time."""

_BOOTLOADER = Identity("sequencer", "bootloader")
_SKETCH = Identity("sequencer", "sketch")
_NOT_FLASHED = "Nothing was flashed; the board goes on with the sketch that it has."


def in_bootloader(computer: Computer) -> dict[str, PortInfo]:
    """The ports at which a bootloader waits, by name."""
    return {port.device: port for port in computer.ports() if identify(port) == _BOOTLOADER}


def wake(computer: Computer, port: str, hint: Callable[[str], None]) -> str:
    """Sends the board at `port` into its bootloader; the bootloader's port.

    Raises:
        PortError: the port could not be opened.
        FlashError: no bootloader, or more than one, appeared in time.
    """
    others = in_bootloader(computer)
    computer.touch(port)
    deadline_s = computer.now_s() + BOOTLOADER_TIMEOUT_S
    hint_s: float | None = computer.now_s() + HINT_S
    while True:
        found = sorted(in_bootloader(computer).keys() - others.keys())
        if len(found) > 1:
            raise FlashError(
                "ambiguous",
                what=f"{len(found)} bootloaders appeared at once: {', '.join(found)}.",
                meaning=f"One of them is another board's. {_NOT_FLASHED}",
                next_step="Unplug the other boards, wait 10 s, then the same command again.",
            )
        if found:
            computer.sleep(PERMISSIONS_S)
            return found[0]
        if computer.now_s() > deadline_s:
            raise _not_seen(port)
        if hint_s is not None and computer.now_s() > hint_s:
            hint("The bootloader has not shown up yet: press the board's reset button twice.")
            hint_s = None
        computer.sleep(POLL_S)


def _not_seen(port: str) -> FlashError:
    return FlashError(
        "bootloader-not-seen",
        what=f"No bootloader appeared within {BOOTLOADER_TIMEOUT_S:g} s after the 1200-baud touch of {port}.",
        meaning=_NOT_FLASHED,
        next_step="Press the board's reset button twice; its LED pulses for 8 s. Within that time type:\n"
        "tfsat-host flash sequencer --force",
    )


def sketches(computer: Computer) -> set[str]:
    """The ports that look like a sequencer with its sketch."""
    return {port.device for port in computer.ports() if identify(port) == _SKETCH}


def ask_again(computer: Computer, before: str | None, others: set[str]) -> tuple[str, BoardIdentity]:
    """Waits for the flashed sketch and asks who it is.

    Args:
        computer: Ports and time.
        before: The sketch's port before, if it was known; the board may come back at another.
        others: Ports of other sequencers: those that were there while the board was in its bootloader.

    Returns:
        The port, and what HELLO says.

    Raises:
        FlashError: no port came back, or nobody answered there.
    """
    deadline_s = computer.now_s() + SKETCH_TIMEOUT_S
    reason = "No port that looks like the sequencer came back."
    while computer.now_s() < deadline_s:
        for port in _candidates(computer, before, others):
            try:
                return port, _hello(computer, port)
            except (PortError, NoAnswer, WrongBoard) as error:
                reason = error.what
        computer.sleep(POLL_S)
    raise FlashError(
        "silent",
        what=f"The image was written and verified, but the board did not say who it is. {reason}",
        meaning="It may not be a tfsat image, or it crashes at its start. Do not fly this board yet.",
        next_step="Unplug the board and plug it in again, then: tfsat-host status",
    )


def _candidates(computer: Computer, before: str | None, others: set[str]) -> list[str]:
    """The former port, which need not be listed (a link, a clone's ids), and those that came anew."""
    fresh = sorted(sketches(computer) - others - {before})
    return fresh if before is None or before in in_bootloader(computer) else [before, *fresh]


def _hello(computer: Computer, port: str) -> BoardIdentity:
    transport = computer.connect(port)
    try:
        return Client(transport).identify(Board.SEQUENCER)
    finally:
        transport.close()
