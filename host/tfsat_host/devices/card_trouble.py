"""A recording that does not reach its card: what that means for the drop, and what to do."""

from __future__ import annotations

from typing import NamedTuple

from tfsat_host.devices.logger import LoggerClient, ram_seconds
from tfsat_host.errors import RefusedError
from tfsat_host.protocol.enums import CardState, DropPhase, ErrorCode, LoggerState
from tfsat_host.protocol.messages import LoggerStatusReply
from tfsat_host.protocol.remedies import REMEDIES

BLOCKS_TIMEOUT_S = 3.0
"""A block is begun every 0.1 s at the latest, and a slow card takes nothing for 0.5 s."""
_NEW_FILE = "tfsat-host record stop, then tfsat-host record start"


class NotOnCard(RefusedError):
    """The logger records, but not onto its card: armed now, the drop would be in RAM at best."""


class DropInDanger(NamedTuple):
    """What happens to a drop, and what to do about it."""

    meaning: str
    next_step: str


def card_is_bad(status: LoggerStatusReply) -> bool:
    """The logger has looked at its card, and it takes nothing."""
    return status.card not in (CardState.READY, CardState.UNKNOWN)


def file_was_full(status: LoggerStatusReply) -> bool:
    """The last recording ended by itself since its file had no more room; the card may have plenty."""
    return status.state == LoggerState.STOPPED and status.error == ErrorCode.CARD_FULL


def state_words(status: LoggerStatusReply) -> str:
    """The logger's state and, unless there is none, what is wrong."""
    if file_was_full(status):
        return "stopped: its file was full"
    state = status.state.name.lower()
    return (
        state if status.error == ErrorCode.NONE else f"{state}: {status.error.name.lower().replace('_', ' ')}"
    )


def drop_in_danger(status: LoggerStatusReply) -> DropInDanger | None:
    """Something to shout while a drop is in RAM and its card takes nothing; None where all is well.

    Until the logger gives the card up, 15 s later, its state alone does not tell.
    """
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
        f"{landed}The card is tried on and gets everything if it comes back; if it does not: "
        "tfsat-host record stop, then tfsat-host log fetch ram",
    )


def recording_in_danger(status: LoggerStatusReply) -> NotOnCard | None:
    """Why a drop now would not be on the card although a recording was started; None where it would be.

    Where nothing is recorded at all, that is another matter: see `state`.
    """
    if status.state == LoggerState.FAILED:
        what = f"The recording has failed: {_lowered(REMEDIES[status.error][0])}"
        return _not_on_card(
            what, status, "Put in a card that tfsat-host status calls ready, then: tfsat-host record start"
        )
    if status.state == LoggerState.RECORDING and card_is_bad(status):
        what = f"The logger records, but its card is {_card(status)}."
        return _not_on_card(what, status, f"Bring the card back: it is tried on. If it stays so: {_NEW_FILE}")
    return None


def stalled_recording(logger: LoggerClient, status: LoggerStatusReply) -> NotOnCard | None:
    """Likewise, after a look at the blocks: a card that is called ready must take some. Waits for the next one.

    Raises:
        TfsatError: the logger does not answer any more.
    """
    refusal = recording_in_danger(status)
    if (
        status.state == LoggerState.FAILED
        and refusal is not None
        and not logger.takes_samples(status.samples)
    ):
        refusal.meaning = "It takes no samples any more, not even into RAM: a drop now would leave no data."
    if refusal is not None or status.state != LoggerState.RECORDING:
        return refusal
    later = logger.after_more_blocks(status.blocks_written, BLOCKS_TIMEOUT_S)
    refusal = recording_in_danger(later)
    if refusal is not None or later.blocks_written > status.blocks_written:
        return refusal
    what = f"The logger records, but its card has taken nothing for {BLOCKS_TIMEOUT_S:g} s."
    return _not_on_card(what, later, f"Wait, and try again. If it stays so: {_NEW_FILE}")


def _not_on_card(what: str, status: LoggerStatusReply, next_step: str) -> NotOnCard:
    if status.ram_holds_drop:
        return NotOnCard(
            what=what,
            meaning="RAM holds an earlier drop and takes no other: a drop now would leave no data.",
            next_step="Keep the power on. tfsat-host log fetch ram",
        )
    return NotOnCard(
        what=what,
        meaning="A drop now would not be on the card: RAM keeps the newest "
        f"{ram_seconds(status.rate_hz):.0f} s at best, until the logger's power goes, "
        "and it must be fetched right after the drop (tfsat-host log fetch ram).",
        next_step=next_step,
    )


def _card(status: LoggerStatusReply) -> str:
    return status.card.name.lower().replace("_", " ")


def _lowered(sentence: str) -> str:
    """`No SD card answers.` after a colon; names stay as they are."""
    return sentence[:1].lower() + sentence[1:]
