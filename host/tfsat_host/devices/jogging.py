"""Moving one joint slowly, on a person's word, and letting it go whatever happens."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import dataclass

from tfsat_host.devices.board_errors import BoardRefusal, board_error
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import JOG_CONFIRM, JOG_IDLE_MS, JOG_SPEED_CDEG_S
from tfsat_host.protocol.messages import (
    ErrorReply,
    JogReply,
    JogRequest,
    SequencerStatusReply,
    SettingsReadReply,
    SettingsReadRequest,
)

POLL_S = 0.1
ORDER_S = JOG_IDLE_MS / 1000 / 4
"""The board lets go after JOG_IDLE_MS without an order: three may get lost."""
GRACE_S = 2.0
"""Beyond the time that the way takes at the board's speed."""


class JogError(TfsatError):
    """A jog did not go as ordered."""


class JogRefused(RefusedError):
    """The jog would leave the limits that the board keeps."""

    code = "joint-limits"


@dataclass(frozen=True, slots=True)
class Jog:
    """One joint's way.

    Attributes:
        joint: 1 to 3.
        from_cdeg: Where the joint is, 0.01 deg; its first pulse holds it there.
        to_cdeg: Where it goes, 0.01 deg.
    """

    joint: int
    from_cdeg: int
    to_cdeg: int

    @property
    def duration_s(self) -> float:
        """At the board's jogging speed."""
        return abs(self.to_cdeg - self.from_cdeg) / JOG_SPEED_CDEG_S


class JogClient(SequencerClient):
    """The sequencer, asked to move a joint."""

    def check(self, jog: Jog) -> None:
        """Whether the board would take this jog now.

        Raises:
            BoardRefusal: it is not safe.
            JogRefused: an end of the way lies outside the joint's limits in the board's servo settings.
        """
        if self.status().state != SequencerState.SAFE:
            raise board_error(ErrorReply(JogRequest.TYPE, ErrorCode.WRONG_STATE, -1))
        settings = self._client.request(SettingsReadRequest(), SettingsReadReply).servo[jog.joint - 1]
        for option, angle_cdeg in (("--from", jog.from_cdeg), ("--to", jog.to_cdeg)):
            if not settings.min_cdeg <= angle_cdeg <= settings.max_cdeg:
                raise JogRefused(
                    what=f"{option} {angle_cdeg / 100:g} is outside joint {jog.joint}'s limits, "
                    f"{settings.min_cdeg / 100:g} to {settings.max_cdeg / 100:g} deg.",
                    meaning="Nothing was moved; the servo would have been driven against its stop.",
                    next_step="Name angles within the limits, which are part of the board's servo settings.",
                )

    def run(self, jog: Jog, hold_s: float, stopped: Callable[[], bool], shown: Callable[[int], None]) -> bool:
        """Moves the joint, holds it, and lets it go; afterwards the board is safe.

        Args:
            jog: The way; `check` it first.
            hold_s: How long to hold the joint at the way's end.
            stopped: Asked several times a second whether to let go now.
            shown: Told the angle that the servo is commanded to, 0.01 deg.

        Returns:
            Whether the joint arrived and was held for all of `hold_s`.

        Raises:
            BoardRefusal: the board was not safe.
            JogError: the board ended the jog by itself, did not bring the joint to its end, or did not say
                that it let go.
            PortError, NoAnswer: the connection broke; the board lets go when it notices.
        """
        try:
            held = self._move_and_hold(jog, hold_s, stopped, shown)
        except BoardRefusal:  # the board does not jog: there is nothing to let go
            raise
        except BaseException:
            self._let_go(jog.joint)
            raise
        self._let_go(jog.joint)
        return held

    def _move_and_hold(
        self, jog: Jog, hold_s: float, stopped: Callable[[], bool], shown: Callable[[int], None]
    ) -> bool:
        now_s = self._client.transport.now_s
        angle_cdeg = self._order(jog, jog.from_cdeg)
        started_s = ordered_s = now_s()
        arrived_s: float | None = None
        while not stopped():
            shown(angle_cdeg)
            if arrived_s is None and angle_cdeg == jog.to_cdeg:
                arrived_s = now_s()
            if arrived_s is not None and now_s() - arrived_s >= hold_s:
                return True
            if arrived_s is None and now_s() - started_s > jog.duration_s + GRACE_S:
                raise _stalled(jog, angle_cdeg)
            self._client.wait(POLL_S)
            angle_cdeg = self._angle_while_jogging(jog.joint)
            if now_s() - ordered_s >= ORDER_S:
                angle_cdeg = self._order(jog, angle_cdeg)
                ordered_s = now_s()
        return False

    def _order(self, jog: Jog, angle_cdeg: int) -> int:
        """Where the joint is goes with each order: a board that has just restarted does not jerk it back."""
        request = JogRequest(jog.joint, angle_cdeg, jog.to_cdeg, JOG_CONFIRM)
        return self._client.request(request, JogReply).angle_cdeg

    def _angle_while_jogging(self, joint: int) -> int:
        status = self.status()
        if status.state != SequencerState.JOGGING:
            raise _ended_by_board(joint, status)
        return status.joint_angle_cdeg[joint - 1]

    def _let_go(self, joint: int) -> None:
        """Disarms, and asks again whether it is so."""
        try:
            self.disarm()
            state = self.status().state
        except TfsatError as error:
            raise self._held_error(joint, error.what) from error
        if state != SequencerState.SAFE:
            raise self._held_error(joint, f"The sequencer says that it is {state.name.lower()}.")

    def _held_error(self, joint: int, reason: str) -> JogError:
        port = shlex.quote(self.port)
        return JogError(
            what=f"The sequencer did not confirm that it let joint {joint} go. {reason}",
            meaning="It lets go when it notices the closed port, or "
            f"{JOG_IDLE_MS // 1000} s after the last order; until then the servo may hold the joint.",
            next_step=f"Keep hands off. tfsat-host status --port {port} shows whether it is safe; if not, "
            f"tfsat-host disarm --port {port}, or cut the sequencer's power.",
        )


def _stalled(jog: Jog, angle_cdeg: int) -> JogError:
    return JogError(
        what=f"Joint {jog.joint} was commanded to {angle_cdeg / 100:g} deg only after "
        f"{jog.duration_s + GRACE_S:.0f} s; {jog.to_cdeg / 100:g} deg was asked for.",
        meaning="The joint was let go.",
        next_step="Run the same command again from where the joint is now; if it recurs, report it.",
    )


def _ended_by_board(joint: int, status: SequencerStatusReply) -> JogError:
    restarted = status.reset_cause.name.lower().replace("_", " ")
    return JogError(
        what=f"The sequencer ended the jog by itself: it is {status.state.name.lower()}, "
        f"up for {status.uptime_ms / 1000:.0f} s, last started by {restarted}.",
        meaning=f"Joint {joint} was let go. A servo that stalls can pull the supply down and restart the board.",
        next_step="Check the battery and that nothing blocks the joint; then the same command, --from where it is now.",
    )
