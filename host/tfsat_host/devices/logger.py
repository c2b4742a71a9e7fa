"""What a host asks of the logger."""

from __future__ import annotations

import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from tfsat_host.devices.board_errors import BoardError, VerifyError
from tfsat_host.devices.client import BoardClient
from tfsat_host.devices.log_transfer import (
    Listing,
    Outcome,
    Put,
    Span,
    fetch_blocks,
    list_logs,
)
from tfsat_host.devices.logger_configuration import StoredLoggerSettings
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import Board, CardState, DropPhase, ErrorCode, LoggerState
from tfsat_host.protocol.limits import PARTIAL_BLOCK_MS, RING_BLOCKS, SAMPLES_PER_BLOCK
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.remedies import REMEDIES

STOP_TIMEOUT_S = 20.0
"""The ring's blocks may wait for a card that stalls; one that is gone is given up after 15 s (card_writer.h)."""
START_TIMEOUT_S = 25.0
"""A card takes the first block within a second; for one that takes nothing, RAM lasts for 17 s at 280 Hz."""
POLL_S = 0.1
BLOCKS_TIMEOUT_S = 3.0
"""A block is begun every 0.1 s at the latest, and a slow card takes nothing for 0.5 s."""
_NEW_FILE = Advice(NextStep("record stop"), ", then ", NextStep("record start"))
_FETCH_RAM = Advice("Keep the power on. ", NextStep("log fetch", ("ram",)))
SAMPLES_WAIT_S = 0.5
"""Five samples at the lowest rate."""
LIVE_TIMEOUT_S = 1.0


def ram_seconds(rate_hz: int) -> float:
    """Compute how many seconds of recording RAM keeps when no card takes anything."""
    # A block is closed when it is full or has waited for its time limit, whichever comes first.
    block_s = min(SAMPLES_PER_BLOCK / rate_hz, PARTIAL_BLOCK_MS / 1000)
    return RING_BLOCKS * block_s


class CardError(BoardError):
    """A recording that the card refused, or gave up: what happens has no place but the logger's RAM."""

    def __init__(self, request: int, status: msg.LoggerStatusReply) -> None:
        super().__init__(msg.ErrorReply(request, status.error, -1))
        seconds = f"{ram_seconds(status.rate_hz):.0f} s"
        if status.ram_holds_drop:
            self.meaning = f"The drop is in the logger's RAM only ({seconds} of it), until its power goes."
            self.next_step = _FETCH_RAM
        elif request == msg.RecordStartRequest.TYPE:
            self.meaning = (
                f"Do not drop: there is no recording on the card. RAM keeps the newest {seconds}, "
                "until the logger's power goes."
            )
        else:
            self.meaning = (
                f"The card has no end of it. RAM keeps the newest {seconds}, until the logger's power goes."
            )
            self.next_step = _FETCH_RAM


class LoggerClient(BoardClient):
    """The logger at the other end of a link."""

    board = Board.LOGGER

    def status(self) -> msg.LoggerStatusReply:
        """Read the board's status."""
        return self._client.request(msg.LoggerStatusRequest(), msg.LoggerStatusReply)

    def start_recording(
        self, number: int | None = None, *, unix_us: int = 0, maneuver_crc: int | None = None
    ) -> msg.RecordStartReply:
        """Starts a recording.

        Args:
            number: Tells this start from others; drawn at random by default.
            unix_us: Time of day for the log; 0 leaves the logger's clock as it is.
            maneuver_crc: Of the maneuver that the sequencer holds, for the log's header; None: not known.
        """
        chosen = secrets.randbits(32) if number is None else number
        maneuver = (maneuver_crc is not None, maneuver_crc or 0)
        return self._client.request(msg.RecordStartRequest(chosen, unix_us, *maneuver), msg.RecordStartReply)

    def wait_for_card(self) -> msg.LoggerStatusReply:
        """Waits until the card takes the blocks of the recording that was started; the status then.

        Raises:
            CardError: the card failed.
            TfsatError: the recording was ended, or the card took nothing for START_TIMEOUT_S.
        """
        deadline = self.now_s() + START_TIMEOUT_S
        while True:
            status = self.status()
            if status.state == LoggerState.FAILED:
                raise CardError(msg.RecordStartRequest.TYPE, status)
            if status.state != LoggerState.RECORDING:
                raise TfsatError(
                    what=f"The logger does not record any more: it is {status.state.name.lower()}.",
                    meaning="Its power was cut, or somebody stopped the recording. A drop now would not be recorded.",
                    next_step="Check the logger's supply, then run the same command again.",
                )
            # Only a block on the medium proves the card; the state RECORDING does not.
            if status.blocks_written > 0:
                return status
            if self.now_s() > deadline:
                raise TfsatError(
                    what=f"The card took nothing for {START_TIMEOUT_S:g} s after the recording was started.",
                    meaning="The recording waits in the logger's memory and will be lost. Do not drop.",
                    next_step="Put another card into the logger, restart it, and run the same command again.",
                )
            self.wait(POLL_S)

    def after_more_blocks(self, blocks: int, timeout_s: float) -> msg.LoggerStatusReply:
        """Wait for the card to take more than `blocks`, and return the status.

        Returns earlier if the logger does not record, or after `timeout_s`.
        """
        deadline = self.now_s() + timeout_s
        while True:
            status = self.status()
            moving = status.state == LoggerState.RECORDING and status.blocks_written <= blocks
            if not moving or self.now_s() > deadline:
                return status
            self.wait(POLL_S)

    def takes_samples(self, samples: int) -> bool:
        """Wait briefly and return whether the recording then has more than `samples`, on the card or not."""
        self.wait(SAMPLES_WAIT_S)
        return self.status().samples > samples

    def stop_recording(self) -> msg.RecordStopReply:
        """Ends the recording and waits until the card has all of it.

        Raises:
            BoardError: there is no recording.
            CardError: the card failed; RAM keeps the newest seconds.
            TfsatError: the logger was still writing after STOP_TIMEOUT_S.
        """
        deadline = self.now_s() + STOP_TIMEOUT_S
        while True:
            # The same request again is harmless, and its answer tells how far the logger has got.
            reply = self._client.request(msg.RecordStopRequest(), msg.RecordStopReply)
            if reply.state == LoggerState.STOPPED:
                return reply
            if reply.state == LoggerState.FAILED:
                raise CardError(msg.RecordStopRequest.TYPE, self.status())
            if self.now_s() > deadline:
                raise TfsatError(
                    what=f"The logger was still writing {STOP_TIMEOUT_S:g} s after the request to stop.",
                    meaning="The card stalls or has failed; what reached it can be decoded.",
                    next_step=Advice(
                        "Keep the power on, run ",
                        NextStep("status"),
                        "; copy the card before using it again.",
                    ),
                )

    def set_clock(self, unix_us: int) -> None:
        """Sets the time of day; it is lost with the power."""
        self._client.request(msg.ClockSetRequest(unix_us), msg.ClockSetReply)

    def settings(self) -> StoredLoggerSettings:
        """Read the settings in force."""
        reply = self._client.request(msg.LoggerSettingsReadRequest(), msg.LoggerSettingsReadReply)
        return StoredLoggerSettings(reply.origin, reply.settings, reply.rate_max_hz)

    def write_settings(self, settings: msg.LoggerSettings) -> StoredLoggerSettings:
        """Has the settings stored, reads them back and compares; the settings then in force.

        Raises:
            BoardError: the logger refused; its settings are unchanged.
            VerifyError: it holds something else than was sent.
        """
        self._client.request(msg.LoggerSettingsWriteRequest(settings), msg.LoggerSettingsWriteReply)
        stored = self.settings()
        if stored.settings != settings:
            raise VerifyError(
                what=f"The logger holds {stored.settings}, but {settings} was sent.",
                meaning="It would record otherwise than you asked for.",
                next_step="Run the same command again; if it recurs, replace the board.",
            )
        return stored

    def listing(self) -> Listing:
        """List the contents of RAM, if any, and the card's recordings. Raises BoardError while it records."""
        return list_logs(self._client)

    def logs(self) -> list[msg.LogEntry]:
        """Return the recordings in RAM and on the card in one list; an unreadable card contributes none.

        Raises BoardError while it records.
        """
        return self.listing().entries

    def wait_for_listing(self, timeout_s: float) -> Listing:
        """List RAM and card once a drop that RAM still takes is over.

        Raises BoardError when it goes on for longer than `timeout_s`.
        """
        deadline = self.now_s() + timeout_s
        while True:
            try:
                return self.listing()
            except BoardError as error:
                # WRONG_STATE: RAM still takes the drop. Any other error will not pass with time.
                if error.code != ErrorCode.WRONG_STATE or self.now_s() > deadline:
                    raise
            self.wait(POLL_S)

    def end_capture(self) -> None:
        """Ends the recording, or what goes on in RAM after the card has failed; waits for nothing.

        Raises BoardError when there is no recording.
        """
        self._client.request(msg.RecordStopRequest(), msg.RecordStopReply)

    def fetch_blocks(self, entry: msg.LogEntry, spans: Iterable[Span], put: Put) -> Outcome:
        """See `log_transfer.fetch_blocks`."""
        return fetch_blocks(self._client, entry, spans, put)

    def fetch_whole(self, entry: msg.LogEntry) -> bytes:
        """Fetch a recording into memory; zeros where the card does not read it. Raises as `fetch_blocks`."""
        blocks: dict[int, bytes] = {}
        self.fetch_blocks(entry, [(0, entry.blocks)], blocks.__setitem__)
        return b"".join(blocks[index] for index in range(entry.blocks))

    def erase_log(self, entry: msg.LogEntry) -> None:
        """Removes a recording from the card; of RAM: gives up what it holds.

        One that is gone already is no error: the answer to a first request may have been lost.

        Raises:
            BoardError: another recording has its number now, or the card refuses.
        """
        try:
            self._client.request(msg.LogEraseRequest(entry.number, entry.session), msg.LogEraseReply)
        except BoardError as error:
            # A repeated request finds the recording gone: that is what was asked for.
            if error.code != ErrorCode.NO_SUCH_LOG:
                raise

    @contextmanager
    def live(self) -> Iterator[msg.LiveReply]:
        """Live sampling while the block runs; gives rate and scales."""
        reply = self.start_live()
        try:
            yield reply
        finally:
            self.stop_live()

    def start_live(self) -> msg.LiveReply:
        """Switches live sampling on, until `stop_live` or until the port is closed; gives rate and scales."""
        self._client.live_samples(0.0)  # what was left unread is of another time
        return self._client.request(msg.LiveRequest(1), msg.LiveReply)

    def stop_live(self) -> None:
        """Switches live sampling off."""
        self._client.request(msg.LiveRequest(0), msg.LiveReply)

    def live_samples(self) -> list[LiveSample]:
        """Samples since the last call, while live sampling is on. Raises TfsatError: none within LIVE_TIMEOUT_S."""
        samples = self._client.live_samples(LIVE_TIMEOUT_S)
        if not samples:
            raise TfsatError(
                what=f"No live sample within {LIVE_TIMEOUT_S:g} s.",
                meaning="The logger has stopped sampling, or the cable is loose.",
                next_step=Advice(NextStep("status")),
            )
        return samples

    def samples_of(self, duration_s: float) -> list[LiveSample]:
        """Wait for `duration_s` and return the live samples that arrived, perhaps none. Raises PortError."""
        self.wait(duration_s)
        return self._client.live_samples(0.0)


class NotOnCard(RefusedError):
    """The logger records, but not onto its card: armed now, the drop would be in RAM at best."""


class DropInDanger(NamedTuple):
    """What happens to a drop, and what to do about it."""

    meaning: str
    next_step: str


def card_is_bad(status: msg.LoggerStatusReply) -> bool:
    """Return whether the logger has looked at its card and found that it takes nothing."""
    return status.card not in (CardState.READY, CardState.UNKNOWN)


def file_was_full(status: msg.LoggerStatusReply) -> bool:
    """Return whether the last recording ended because its file was full; the card may have plenty of room."""
    return status.state == LoggerState.STOPPED and status.error == ErrorCode.CARD_FULL


def state_words(status: msg.LoggerStatusReply) -> str:
    """Format the logger's state and its error, if any."""
    if file_was_full(status):
        return "stopped: its file was full"
    state = status.state.name.lower()
    return (
        state if status.error == ErrorCode.NONE else f"{state}: {status.error.name.lower().replace('_', ' ')}"
    )


def drop_in_danger(status: msg.LoggerStatusReply) -> DropInDanger | None:
    """Something to shout while a drop is in RAM and its card takes nothing; None where all is well.

    Until the logger gives the card up, 15 s later, its state alone does not tell.
    """
    # Only between the release and the file's end, and only with a card that was found bad.
    in_use = status.state in (LoggerState.RECORDING, LoggerState.STOPPING)
    if not in_use or status.phase == DropPhase.WAITING or not card_is_bad(status):
        return None
    landed = (
        ""
        if status.phase == DropPhase.LANDED
        else "Wait for the landing: a stop now would cut the fall short. "
    )
    return DropInDanger(
        f"THE CARD IS {_card(status).upper()} AND THE DROP IS IN RAM ONLY, or a part of it. It is gone with the "
        "logger's power: keep it on.",
        Advice(
            f"{landed}The card is tried on and gets everything if it comes back; if it does not: ",
            NextStep("record stop"),
            ", then ",
            NextStep("log fetch", ("ram",)),
        ),
    )


def recording_in_danger(status: msg.LoggerStatusReply) -> NotOnCard | None:
    """Why a drop now would not be on the card although a recording was started; None where it would be.

    Where nothing is recorded at all, that is another matter: see `state`.
    """
    if status.state == LoggerState.FAILED:
        reason = REMEDIES[status.error][0]
        what = f"The recording has failed: {reason[:1].lower()}{reason[1:]}"
        ready = Advice(
            "Put in a card that ", NextStep("status"), " calls ready, then: ", NextStep("record start")
        )
        return _not_on_card(what, status, ready)
    if status.state == LoggerState.RECORDING and card_is_bad(status):
        what = f"The logger records, but its card is {_card(status)}."
        return _not_on_card(
            what, status, Advice("Bring the card back: it is tried on. If it stays so: ", _NEW_FILE)
        )
    return None


def stalled_recording(logger: LoggerClient, status: msg.LoggerStatusReply) -> NotOnCard | None:
    """Return why a drop now would not be on the card, after waiting for the next block.

    None if it would be, or if nothing is recorded. A card that is called ready must take some blocks.

    Raises:
        TfsatError: the logger does not answer any more.
    """
    refusal = recording_in_danger(status)
    # A failed recording goes on in RAM at best; a count of samples that stands still shows not even that.
    if (
        status.state == LoggerState.FAILED
        and refusal is not None
        and not logger.takes_samples(status.samples)
    ):
        refusal.meaning = "It takes no samples any more, not even into RAM: a drop now would leave no data."
    if refusal is not None or status.state != LoggerState.RECORDING:
        return refusal
    # A card that is called ready proves itself by taking one more block.
    later = logger.after_more_blocks(status.blocks_written, BLOCKS_TIMEOUT_S)
    refusal = recording_in_danger(later)
    if refusal is not None or later.blocks_written > status.blocks_written:
        return refusal
    what = f"The logger records, but its card has taken nothing for {BLOCKS_TIMEOUT_S:g} s."
    return _not_on_card(what, later, Advice("Wait, and try again. If it stays so: ", _NEW_FILE))


def _not_on_card(what: str, status: msg.LoggerStatusReply, next_step: str) -> NotOnCard:
    if status.ram_holds_drop:
        return NotOnCard(
            what=what,
            meaning="RAM holds an earlier drop and takes no other: a drop now would leave no data.",
            next_step=_FETCH_RAM,
        )
    return NotOnCard(
        what=what,
        meaning="A drop now would not be on the card: RAM keeps the newest "
        f"{ram_seconds(status.rate_hz):.0f} s at best, until the logger's power goes, "
        f"and it must be fetched right after the drop ({NextStep('log fetch', ('ram',))}).",
        next_step=next_step,
    )


def _card(status: msg.LoggerStatusReply) -> str:
    return status.card.name.lower().replace("_", " ")
