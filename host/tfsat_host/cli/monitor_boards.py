"""The boards that `monitor` watches: asking them no more than a live view needs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from tfsat_host.devices.client import BoardIdentity, Client
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.ports import BoardName
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.monitoring.pace import REFRESH_S, status_interval_s
from tfsat_host.monitoring.reading import Reading, convert
from tfsat_host.monitoring.stream_meter import StreamMeter
from tfsat_host.protocol.messages import LoggerStatusReply, SequencerStatusReply
from tfsat_host.robot import AngleSensor


class Watch(Protocol):
    """One board under observation."""

    name: BoardName
    identity: BoardIdentity

    @property
    def port(self) -> str:
        """What a person calls the port."""

    def update(self, until_s: float) -> None:
        """Brings what is shown up to date and lets time pass to `until_s` on the transport's clock.

        Raises TfsatError when the board is lost.
        """

    def close(self) -> None:
        """Leaves the board as it was. Raises TfsatError when it is lost."""

    def give_up(self) -> None:
        """Lets go of a board that is lost; nothing is asked of it."""


class SequencerWatch:
    """Asks for the status, rarely while the sequencer is armed or runs. Sends nothing else."""

    name: BoardName = "sequencer"

    def __init__(self, client: Client, identity: BoardIdentity) -> None:
        self.identity = identity
        self._client = client
        self._board = SequencerClient(client, identity)
        self.status: SequencerStatusReply = self._board.status()
        self._asked_s = client.transport.now_s()

    @property
    def port(self) -> str:
        """What a person calls the port."""
        return self._client.transport.name

    def update(self, until_s: float) -> None:
        """Asks if it is time to. Raises TfsatError."""
        transport = self._client.transport
        if transport.now_s() - self._asked_s >= status_interval_s(self.status.state):
            self.status = self._board.status()
            self._asked_s = transport.now_s()
        self._client.wait(until_s - transport.now_s())

    def close(self) -> None:
        """Nothing was switched on."""

    def give_up(self) -> None:
        """Closes the port."""
        self._client.close()


class LoggerWatch:
    """Takes live samples, and asks for the status between them."""

    name: BoardName = "logger"

    def __init__(self, client: Client, identity: BoardIdentity, sensors: Sequence[AngleSensor]) -> None:
        self.identity = identity
        self._client = client
        self._sensors = sensors
        self._board = LoggerClient(client, identity)
        self.status: LoggerStatusReply = self._board.status()
        self._asked_s = client.transport.now_s()
        self.meter = StreamMeter()
        self.reading: Reading | None = None
        self._scales = self._board.start_live()

    @property
    def port(self) -> str:
        """What a person calls the port."""
        return self._client.transport.name

    def update(self, until_s: float) -> None:
        """Takes samples until then. Raises TfsatError, also where none come any more."""
        transport = self._client.transport
        if transport.now_s() - self._asked_s >= REFRESH_S:
            self.status = self._board.status()
            self._asked_s = transport.now_s()
        while True:
            samples = self._board.live_samples()
            self.meter.add(samples)
            self.reading = convert(samples[-1], self._scales, self._sensors)
            if transport.now_s() >= until_s:
                return

    def close(self) -> None:
        """Switches live sampling off."""
        self._board.stop_live()

    def give_up(self) -> None:
        """Closes the port, which ends live sampling as well."""
        self._client.close()
