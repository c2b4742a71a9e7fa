"""The logger before it is flashed, and afterwards: nothing is lost, and it runs what was written."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass

from tfsat_host.devices.board_errors import NoAnswer, WrongBoard
from tfsat_host.devices.client import Client
from tfsat_host.devices.discovery import Identity, identify
from tfsat_host.devices.identity import BoardIdentity
from tfsat_host.devices.port_errors import PortError
from tfsat_host.flashing import teensy
from tfsat_host.flashing.avrdude import FlashError
from tfsat_host.flashing.image import Image
from tfsat_host.flashing.ports import Computer
from tfsat_host.flashing.running import FlashRefused
from tfsat_host.protocol.enums import Board, LoggerState
from tfsat_host.protocol.messages import LoggerStatusReply, LoggerStatusRequest

POLL_S = 0.1
SKETCH_TIMEOUT_S = 15.0
_SKETCH = Identity("logger", "sketch")
_NOT_FLASHED = "Nothing was flashed."


@dataclass(frozen=True, slots=True)
class LoggerTarget:
    """The logger that will be flashed; `identity` is None where it does not answer, `port` where there is none."""

    port: str | None
    identity: BoardIdentity | None


def look(computer: Computer, port: str | None) -> LoggerTarget:
    """Asks who is at `port`. Raises PortError, WrongBoard, and FlashRefused where a recording would be lost."""
    if port is None:
        return LoggerTarget(None, None)
    with closing(computer.connect(port)) as transport:
        client = Client(transport)
        try:
            identity = client.identify(Board.LOGGER)
        except NoAnswer:
            return LoggerTarget(port, None)
        if identity.speaks_this_protocol:
            _insist_on_idle(port, client.request(LoggerStatusRequest(), LoggerStatusReply))
    return LoggerTarget(port, identity)


def _insist_on_idle(port: str, status: LoggerStatusReply) -> None:
    if status.ram_holds_drop:
        raise FlashRefused(
            "ram-holds-drop",
            what=f"The RAM of the logger at {port} holds a drop that no card has.",
            meaning=f"Flashing would erase it. {_NOT_FLASHED}",
            next_step="tfsat-host log fetch ram, then tfsat-host log erase ram, then the same command again.",
        )
    if status.state in (LoggerState.RECORDING, LoggerState.STOPPING):
        raise FlashRefused(
            "recording",
            what=f"The logger at {port} is {status.state.name.lower()}.",
            meaning=f"Flashing would cut the recording off. {_NOT_FLASHED}",
            next_step="tfsat-host record stop, then the same command again.",
        )


def refuse_needless(target: LoggerTarget, image: Image, *, force: bool) -> None:
    """Raises FlashRefused where the image runs already, or nobody answers, unless `force`."""
    if force:
        return
    if target.identity is None:
        where = (
            "There is no logger's port"
            if target.port is None
            else f"The board at {target.port} does not answer"
        )
        raise FlashRefused(
            "silent",
            what=f"{where}: nobody says whether its RAM holds a drop.",
            meaning=_NOT_FLASHED,
            next_step="If you are sure that this is the logger and that nothing in it is needed: add --force.",
        )
    if target.identity.image_crc == image.crc:
        raise FlashRefused(
            "already-running",
            what=f"The logger at {target.port} runs this image already ({image.crc}).",
            meaning="Nothing was flashed, and nothing needs to be.",
            next_step="Add --force to flash it anyway.",
        )


def write(
    computer: Computer, loader: str, image: Image, target: LoggerTarget, step: Callable[[str], None]
) -> tuple[str, BoardIdentity]:
    """Wakes the bootloader, has the loader write, and asks the board what it runs: its port and what it says.

    Raises:
        FlashError: a step failed; says which and what to do.
        PortError: the port could not be opened.
    """
    others = _sketches(computer) - {target.port}
    if target.port is not None:
        step(f"waking the bootloader of the Teensy at {target.port}")
        computer.touch(target.port, teensy.REBOOT_BAUDRATE)
    step(f"writing {len(image.data)} bytes; if nothing happens, press the button on the Teensy")
    teensy.run_loader(computer, teensy.command_line(loader, image.path))
    step("waiting for the new sketch")
    port, identity = _ask_again(computer, target.port, others)
    if identity.image_crc != image.crc:
        raise FlashError(
            "other-image",
            what=f"The logger at {port} runs image {identity.image_crc}; {image.crc} was written.",
            meaning="It does not run what was asked for: another Teensy was flashed, or the writing failed.",
            next_step=f"Unplug every other Teensy, then: {teensy.AGAIN}",
        )
    return port, identity


def _sketches(computer: Computer) -> set[str]:
    return {port.device for port in computer.ports() if identify(port) == _SKETCH}


def _ask_again(computer: Computer, before: str | None, others: set[str]) -> tuple[str, BoardIdentity]:
    deadline_s = computer.now_s() + SKETCH_TIMEOUT_S
    reason = "No port that looks like the logger came back."
    while computer.now_s() < deadline_s:
        fresh = sorted(_sketches(computer) - others - {before})
        for port in fresh if before is None else [before, *fresh]:
            try:
                with closing(computer.connect(port)) as transport:
                    return port, Client(transport).identify(Board.LOGGER)
            except (PortError, NoAnswer, WrongBoard) as error:
                reason = error.what
        computer.sleep(POLL_S)
    raise FlashError(
        "silent",
        what=f"The image was written, but the board did not say who it is. {reason}",
        meaning="It may not be a tfsat image, or it crashes at its start. Do not record a drop with this board yet.",
        next_step="Unplug the board and plug it in again, then: tfsat-host status",
    )
