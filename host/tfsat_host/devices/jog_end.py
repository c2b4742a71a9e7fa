"""How a jog ended: as ordered, at a person's wish, or otherwise; and where the joint was let go."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import dataclass

from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.limits import JOG_IDLE_MS
from tfsat_host.protocol.messages import SequencerStatusReply
from tfsat_host.protocol.remedies import REMEDIES

IDLE_S = JOG_IDLE_MS / 1000
"""The board lets go after so long without an order."""
_UPTIME_RANGE_MS = 1 << 32
"""The board's uptime begins anew after 49 days."""


@dataclass(frozen=True, slots=True)
class JogEnd:
    """A jog that is over; the joint is limp.

    Attributes:
        held: The joint arrived and was held for as long as was asked.
        angle_cdeg: Where the servo was told to be when it was let go, 0.01 deg.
    """

    held: bool
    angle_cdeg: int


class JogError(TfsatError):
    """A jog did not go as ordered.

    Attributes:
        details: For `--json`: the joint, and the angle in deg that its servo was told last.
    """

    def __init__(self, joint: int, angle_cdeg: int, *, what: str, meaning: str, next_step: str) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.details = jog_details(joint, angle_cdeg)


class JogRefused(RefusedError):
    """The jog would leave the limits that the board keeps."""

    code = "joint-limits"


def jog_details(joint: int, angle_cdeg: int) -> dict[str, float]:
    """Which joint and where it was let go, for `--json`."""
    return {"joint": joint, "last_angle_deg": angle_cdeg / 100}


def last_told(joint: int, angle_cdeg: int) -> str:
    """Where a limp joint was told to be: it may have sagged since."""
    return f"Joint {joint} was last told {angle_cdeg / 100:g} deg"


def from_here(angle_cdeg: int) -> str:
    """How to go on with a joint that was let go."""
    return (
        f"the same command with --from {angle_cdeg / 100:g} goes on, "
        "or --from its angle now if it has sagged or was moved."
    )


def from_the_start(start_cdeg: int) -> Callable[[int], str]:
    """How to go on with a joint that was let go on a tour, which begins anew."""
    return lambda _angle_cdeg: (
        f"bring it to {start_cdeg / 100:g} deg by hand and type the same command again."
    )


def stalled(
    joint: int, angle_cdeg: int, to_cdeg: int, after_s: float, again: Callable[[int], str]
) -> JogError:
    """The board did not bring the joint to its end in time; `again` says how to go on."""
    return JogError(
        joint,
        angle_cdeg,
        what=f"Joint {joint} was commanded to {angle_cdeg / 100:g} deg only after "
        f"{after_s:.0f} s; {to_cdeg / 100:g} deg was asked for.",
        meaning="The joint was let go.",
        next_step=f"Once more: {again(angle_cdeg)} If it recurs, report it.",
    )


def ended_by_board(
    joint: int,
    angle_cdeg: int,
    status: SequencerStatusReply,
    before_ms: int,
    again: Callable[[int], str],
) -> JogError:
    """The board does not jog any more; its uptimes tell a restart from a host that was away.

    Args:
        joint: 1 to 3.
        angle_cdeg: What its servo was told last, 0.01 deg.
        status: As it is now.
        before_ms: The uptime when it was asked last.
        again: How to go on, from the angle that the servo was told last.
    """
    what, why = _cause(status, (status.uptime_ms - before_ms) % _UPTIME_RANGE_MS)
    fault = "" if status.fault == ErrorCode.NONE else f" {REMEDIES[status.fault][0]}"
    return JogError(
        joint,
        angle_cdeg,
        what=f"{what} It is {status.state.name.lower()}.{fault}",
        meaning=f"{last_told(joint, angle_cdeg)} and was let go. {why}",
        next_step=f"Look at the joint and its servo; then {again(angle_cdeg)}",
    )


def _cause(status: SequencerStatusReply, passed_ms: int) -> tuple[str, str]:
    """What happened and why, from the time on the board's clock since it was asked last."""
    if passed_ms >= _UPTIME_RANGE_MS // 2:  # its clock went back
        cause = status.reset_cause.name.lower().replace("_", " ")
        return (
            f"The sequencer restarted {status.uptime_ms / 1000:.1f} s ago ({cause}), which ended the jog.",
            "A servo that stalls can pull the supply down and restart the board: check the battery, "
            "and that nothing blocks the joint.",
        )
    if passed_ms >= JOG_IDLE_MS:
        return (
            f"This computer was away for {passed_ms / 1000:.1f} s, and the sequencer ended the jog.",
            f"The sequencer lets a joint go after {IDLE_S:g} s without an order: the program was stopped, "
            "or the computer slept or was overloaded. The board did not restart.",
        )
    return (
        f"The sequencer ended the jog by itself. It did not restart: up for {status.uptime_ms / 1000:.0f} s.",
        f"It saw its port closed, or no order reached it for {IDLE_S:g} s: check the cable.",
    )


def not_let_go(joint: int, angle_cdeg: int, port: str, reason: str) -> JogError:
    """Nobody knows whether the joint is limp."""
    named = shlex.quote(port)
    return JogError(
        joint,
        angle_cdeg,
        what=f"The sequencer did not confirm that it let joint {joint} go. {reason}",
        meaning=f"{last_told(joint, angle_cdeg)}. The sequencer lets it go when it notices the closed port, or "
        f"{IDLE_S:g} s after the last order; until then the servo may hold or move the joint.",
        next_step=f"Keep hands off. tfsat-host status --port {named} shows whether it is safe; if not, "
        f"tfsat-host disarm --port {named}, or cut the sequencer's power.",
    )
