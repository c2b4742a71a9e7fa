"""A record that the sequencer stores in EEPROM: asked for until it is there, then read back and compared."""

from __future__ import annotations

from collections.abc import Callable

from tfsat_host.devices.client import Client
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.messages import ManeuverCommitReply, SettingsWriteReply

STORE_POLL_S = 0.02
STORE_TIMEOUT_S = 3.0
"""The EEPROM takes 3.4 ms a byte, a full maneuver 0.4 s."""


class VerifyError(TfsatError):
    """What was read back is not what was sent."""

    code = "verify-failed"


def repeat_until_stored(
    client: Client, ask: Callable[[], ManeuverCommitReply | SettingsWriteReply], kept: str
) -> bool:
    """Repeats a request until the EEPROM holds what it is about; True when that had to be written.

    Args:
        client: The link, whose clock the timeout is of.
        ask: Sends the request once.
        kept: The sentence that says what the board still holds if this fails.

    Raises:
        VerifyError: the board was still writing after STORE_TIMEOUT_S.
    """
    deadline = client.transport.now_s() + STORE_TIMEOUT_S
    written = False
    while True:
        reply = ask()
        # The last answer alone does not tell: had it been lost, its repetition finds the record there already.
        written = written or bool(reply.written)
        if reply.stored:
            return written
        if client.transport.now_s() > deadline:
            raise VerifyError(
                what=f"The sequencer was still writing after {STORE_TIMEOUT_S:g} s.",
                meaning=f"Its EEPROM may be worn out. {kept}",
                next_step="Power the board off and on, then run the same upload again.",
            )
        client.wait(STORE_POLL_S)
