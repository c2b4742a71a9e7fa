"""What a host asks of the logger."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Self

from tfsat_host.devices.client import BoardError, BoardIdentity, Client
from tfsat_host.devices.transport import Transport
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.enums import Board, LoggerState
from tfsat_host.protocol.messages import (
    ErrorReply,
    LiveReply,
    LiveRequest,
    LiveSampleStream,
    LoggerStatusReply,
    LoggerStatusRequest,
    RecordStartReply,
    RecordStartRequest,
    RecordStopReply,
    RecordStopRequest,
)

STOP_TIMEOUT_S = 10.0
"""Three seconds of samples may wait for a card that stalls for half a second at a time."""
START_TIMEOUT_S = 15.0
"""A card fills its new file with zeros first, which takes 2 to 4 s."""
POLL_S = 0.1
LIVE_TIMEOUT_S = 1.0


class LoggerClient:
    """The logger at the other end of a link."""

    def __init__(self, client: Client, identity: BoardIdentity) -> None:
        self._client = client
        self.identity = identity

    @classmethod
    def connect(cls, transport: Transport) -> Self:
        """Asks who answers. Raises WrongBoard, NoAnswer, PortError."""
        client = Client(transport)
        return cls(client, client.hello(Board.LOGGER))

    @property
    def port(self) -> str:
        """What a person calls the port."""
        return self._client.transport.name

    def close(self) -> None:
        """Lets go of the port."""
        self._client.close()

    def status(self) -> LoggerStatusReply:
        """The board's state."""
        return self._client.request(LoggerStatusRequest(), LoggerStatusReply)

    def start_recording(self, number: int | None = None) -> RecordStartReply:
        """Starts a recording. `number` tells this start from others; drawn at random by default."""
        chosen = secrets.randbits(32) if number is None else number
        return self._client.request(RecordStartRequest(chosen), RecordStartReply)

    def wait_for_card(self) -> LoggerStatusReply:
        """Waits until the card takes the blocks of the recording that was started; the status then.

        Raises:
            BoardError: the card failed.
            TfsatError: somebody ended the recording, or the card took nothing for START_TIMEOUT_S.
        """
        deadline = self._client.transport.now_s() + START_TIMEOUT_S
        while True:
            status = self.status()
            if status.state == LoggerState.FAILED:
                raise BoardError(ErrorReply(RecordStartRequest.TYPE, status.error, -1))
            if status.state != LoggerState.RECORDING:
                raise TfsatError(
                    what=f"The logger does not record any more: it is {status.state.name.lower()}.",
                    meaning="Its power was cut, or somebody stopped the recording. A drop now would not be recorded.",
                    next_step="Check the logger's supply, then run the same command again.",
                )
            if status.blocks_written > 0:
                return status
            if self._client.transport.now_s() > deadline:
                raise TfsatError(
                    what=f"The card took nothing for {START_TIMEOUT_S:g} s after the recording was started.",
                    meaning="The recording waits in the logger's memory and will be lost. Do not drop.",
                    next_step="Put another card into the logger, restart it, and run the same command again.",
                )
            self._client.wait(POLL_S)

    def stop_recording(self) -> RecordStopReply:
        """Ends the recording and waits until the card has all of it.

        Raises:
            BoardError: there is no recording, or the card failed.
            TfsatError: the logger was still writing after STOP_TIMEOUT_S.
        """
        deadline = self._client.transport.now_s() + STOP_TIMEOUT_S
        while True:
            reply = self._client.request(RecordStopRequest(), RecordStopReply)
            if reply.state == LoggerState.STOPPED:
                return reply
            if reply.state == LoggerState.FAILED:
                raise BoardError(ErrorReply(RecordStopRequest.TYPE, self.status().error, -1))
            if self._client.transport.now_s() > deadline:
                raise TfsatError(
                    what=f"The logger was still writing {STOP_TIMEOUT_S:g} s after it was told to stop.",
                    meaning="The card stalls or has failed; what reached it can be decoded.",
                    next_step="Keep the power on, run tfsat-host status; copy the card before using it again.",
                )

    @contextmanager
    def live(self) -> Iterator[LiveReply]:
        """Live sampling while the block runs; gives rate and scales."""
        reply = self.start_live()
        try:
            yield reply
        finally:
            self.stop_live()

    def start_live(self) -> LiveReply:
        """Switches live sampling on, until `stop_live` or until the port is closed; gives rate and scales."""
        self._client.live_samples(0.0)  # what was left unread is of another time
        return self._client.request(LiveRequest(1), LiveReply)

    def stop_live(self) -> None:
        """Switches live sampling off."""
        self._client.request(LiveRequest(0), LiveReply)

    def live_samples(self, timeout_s: float = LIVE_TIMEOUT_S) -> list[LiveSampleStream]:
        """Samples that have arrived since the last call, while live sampling is on.

        Raises:
            TfsatError: none came within `timeout_s`.
        """
        samples = self._client.live_samples(timeout_s)
        if not samples:
            raise TfsatError(
                what=f"No live sample within {timeout_s:g} s.",
                meaning="The logger has stopped sampling, or the cable is loose.",
                next_step="tfsat-host status",
            )
        return samples
