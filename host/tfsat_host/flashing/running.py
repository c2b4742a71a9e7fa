"""What runs on the sequencer before it is flashed, and whether it may be taken away."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass

from tfsat_host.devices.board_errors import NoAnswer
from tfsat_host.devices.client import Client
from tfsat_host.devices.identity import BoardIdentity
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.errors import RefusedError
from tfsat_host.flashing.bootloader import in_bootloader
from tfsat_host.flashing.image import Image
from tfsat_host.flashing.ports import Computer
from tfsat_host.protocol.enums import Board, SequencerState


class FlashRefused(RefusedError):
    """Flashing would be needless, or nobody knows whether it is safe; `code` says which."""

    def __init__(self, code: str, *, what: str, meaning: str, next_step: str) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.code = code


@dataclass(frozen=True, slots=True)
class Target:
    """The board that will be flashed.

    Attributes:
        port: Where it is.
        waits: It is in its bootloader already.
        identity: What its sketch says of itself; None where it does not answer.
    """

    port: str
    waits: bool
    identity: BoardIdentity | None

    @property
    def state_unknown(self) -> bool:
        """Its sketch speaks another protocol: of its state, only DISARM's answer can be understood."""
        return self.identity is not None and not self.identity.speaks_this_protocol


def look(computer: Computer, port: str) -> Target:
    """Asks who is at `port`.

    Raises:
        PortError: the port could not be opened.
        WrongBoard: it is the logger.
        FlashRefused: the sequencer is not safe.
    """
    if port in in_bootloader(computer):
        return Target(port, waits=True, identity=None)
    with closing(computer.connect(port)) as transport:
        client = Client(transport)
        try:
            identity = client.identify(Board.SEQUENCER)
        except NoAnswer:
            return Target(port, waits=False, identity=None)
        sequencer = SequencerClient(client, identity)
        if identity.speaks_this_protocol:
            _insist_on_safe(port, sequencer.status().state)
    return Target(port, waits=False, identity=identity)


def _insist_on_safe(port: str, state: SequencerState) -> None:
    if state != SequencerState.SAFE:
        raise FlashRefused(
            "not-safe",
            what=f"The sequencer at {port} is {state.name.lower()}; it is flashed only while it is safe.",
            meaning="Flashing would end that and let the servos go. Nothing was flashed.",
            next_step="tfsat-host disarm, then the same command again.",
        )


def refuse_needless(target: Target, image: Image, *, force: bool) -> None:
    """Raises FlashRefused for an emulated core, and where the image runs already or nobody answers, unless `force`."""
    if target.identity is not None and target.identity.runs_natively:
        raise FlashRefused(
            "emulated",
            what=f"The sequencer at {target.port} is the firmware's core on a computer: it has no flash.",
            meaning="Nothing was flashed.",
            next_step="Name a real board's port. To run the image itself: tfsat-host emulate --sequencer avr",
        )
    if force:
        return
    if target.identity is None:
        silent = "waits in its bootloader" if target.waits else "does not answer"
        raise FlashRefused(
            "silent",
            what=f"The board at {target.port} {silent}: it does not say what it is and whether it is safe.",
            meaning="Nothing was flashed.",
            next_step="If you are sure that it is the sequencer and that nothing is armed: add --force.",
        )
    if target.identity.image_crc == image.crc:
        raise FlashRefused(
            "already-running",
            what=f"The sequencer at {target.port} runs this image already ({image.crc}).",
            meaning="Nothing was flashed, and nothing needs to be.",
            next_step="Add --force to flash it anyway.",
        )


def make_safe(computer: Computer, port: str) -> None:
    """Disarms a board of whatever protocol. Raises FlashRefused unless it says that it is safe."""
    with closing(computer.connect(port)) as transport:
        client = Client(transport)
        state = SequencerClient(client, client.identify(Board.SEQUENCER)).disarm()
    _insist_on_safe(port, state)
