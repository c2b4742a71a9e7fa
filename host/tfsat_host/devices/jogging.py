"""Moving one joint slowly, on a person's word, and letting it go whatever happens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

from tfsat_host.devices.board_errors import BoardRefusal, NoAnswer, board_error
from tfsat_host.devices.jog_end import (
    IDLE_S,
    JogEnd,
    JogError,
    JogRefused,
    ended_by_board,
    from_here,
    from_the_start,
    not_let_go,
    stalled,
)
from tfsat_host.devices.jog_tour import JogTour, TourWatch
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import JOG_CONFIRM, JOG_SPEED_CDEG_S
from tfsat_host.protocol.messages import (
    ErrorReply,
    JogReply,
    JogRequest,
    ServoSetting,
    SettingsReadReply,
    SettingsReadRequest,
)

__all__ = ["Jog", "JogClient", "JogEnd", "JogError", "JogRefused", "JogTour", "TourWatch"]

POLL_S = 0.1
ORDER_S = IDLE_S / 4
"""The board lets go after IDLE_S without an order: two may get lost."""
FRESH_S = IDLE_S / 4
"""An answer older than this allows no order: the board would take it as a new jog of a joint it has let go."""
GRACE_S = 2.0
"""Beyond the time that the way takes at the board's speed."""


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
        settings = self._settings_if_safe(jog.joint)
        for option, angle_cdeg in (("--from", jog.from_cdeg), ("--to", jog.to_cdeg)):
            if not settings.min_cdeg <= angle_cdeg <= settings.max_cdeg:
                raise _outside(jog.joint, f"{option} {angle_cdeg / 100:g}", settings)

    def check_tour(self, tour: JogTour) -> None:
        """Whether the board would take this tour now. Raises BoardRefusal, JogRefused."""
        settings = self._settings_if_safe(tour.joint)
        for angle_cdeg in tour.stops_cdeg:
            if not settings.min_cdeg <= angle_cdeg <= settings.max_cdeg:
                raise _outside(tour.joint, f"A stop at {angle_cdeg / 100:g} deg", settings)

    def run(
        self, jog: Jog, hold_s: float, stopped: Callable[[], bool], shown: Callable[[int], None]
    ) -> JogEnd:
        """Moves the joint, holds it, and lets it go; afterwards the board is safe.

        Args:
            jog: The way; `check` it first.
            hold_s: How long to hold the joint at the way's end.
            stopped: Asked several times a second whether to let go now. A KeyboardInterrupt ends the jog as well.
            shown: Told the angle that the servo is commanded to, 0.01 deg.

        Raises:
            BoardRefusal: the board was not safe.
            JogError: the board ended the jog by itself, did not bring the joint to its end, or did not say
                that it let go.
            NoAnswer: the first order was not answered; the joint was let go.
        """
        motion = _Motion(self, jog, self.wait, from_here)

        def moves() -> bool:
            motion.begin()
            return motion.move_and_hold(hold_s, stopped, shown)

        return self._letting_go(motion, moves)

    def tour(self, tour: JogTour, stopped: Callable[[], bool], watch: TourWatch) -> JogEnd:
        """Moves the joint from stop to stop, holds it at each, and lets it go; afterwards the board is safe.

        Args:
            tour: The stops; `check_tour` it first.
            stopped: See `run`.
            watch: Follows it.

        Raises:
            BoardRefusal, JogError, NoAnswer: see `run`.
        """
        start_cdeg = tour.stops_cdeg[0]
        motion = _Motion(
            self, Jog(tour.joint, start_cdeg, start_cdeg), watch.pause, from_the_start(start_cdeg)
        )

        def moves() -> bool:
            motion.begin()
            for stop, (from_cdeg, to_cdeg) in enumerate(pairwise((start_cdeg, *tour.stops_cdeg))):
                if stop > 0:
                    motion.go_on(Jog(tour.joint, from_cdeg, to_cdeg))
                if not motion.move_and_hold(tour.hold_s, stopped, partial(watch.shown, stop)):
                    return False
                watch.rested(stop)
            return True

        return self._letting_go(motion, moves)

    def order(self, jog: Jog, angle_cdeg: int) -> int:
        """Sends the order once; the angle that the servo is told then, 0.01 deg. Raises NoAnswer, BoardRefusal.

        Never repeated unseen: a host that froze in between would move a joint that the board has let go.
        Where the joint is goes with each order: a board that has just restarted does not jerk it back.
        """
        request = JogRequest(jog.joint, angle_cdeg, jog.to_cdeg, JOG_CONFIRM)
        return self._client.request(request, JogReply, attempts=1).angle_cdeg

    def now_s(self) -> float:
        """Seconds on the transport's clock."""
        return self._client.transport.now_s()

    def wait(self, duration_s: float) -> None:
        """Lets time pass. Raises PortError."""
        self._client.wait(duration_s)

    def _settings_if_safe(self, joint: int) -> ServoSetting:
        if self.status().state != SequencerState.SAFE:
            raise board_error(ErrorReply(JogRequest.TYPE, ErrorCode.WRONG_STATE, -1))
        return self._client.request(SettingsReadRequest(), SettingsReadReply).servo[joint - 1]

    def _letting_go(self, motion: _Motion, moves: Callable[[], bool]) -> JogEnd:
        """Lets go after `moves`, which says whether all was held, however it ends."""
        held = False
        try:
            held = moves()
        except BoardRefusal:  # the board does not jog: there is nothing to let go
            raise
        except KeyboardInterrupt:
            self._let_go(motion)
        except BaseException:
            self._let_go(motion)
            raise
        else:
            self._let_go(motion)
        return JogEnd(held, motion.angle_cdeg)

    def _let_go(self, motion: _Motion) -> None:
        """Disarms, and asks again whether it is so."""
        joint, angle_cdeg = motion.jog.joint, motion.angle_cdeg
        try:
            self.disarm()
            state = self.status().state
        except TfsatError as error:
            raise not_let_go(joint, angle_cdeg, self.port, error.what) from error
        if state != SequencerState.SAFE:
            reason = f"The sequencer says that it is {state.name.lower()}."
            raise not_let_go(joint, angle_cdeg, self.port, reason)


class _Motion:
    """One joint under way.

    Attributes:
        jog: The way.
        angle_cdeg: What the servo was told last, as far as the board has said.

    Args:
        board: Moves it.
        jog: The way.
        pause: Lets time pass between two looks at the board.
        again: How to go on where the board has let the joint go, from the angle that it was told last.
    """

    def __init__(
        self, board: JogClient, jog: Jog, pause: Callable[[float], None], again: Callable[[int], str]
    ) -> None:
        self.jog = jog
        self.angle_cdeg = jog.from_cdeg
        self._board = board
        self._pause = pause
        self._again = again
        self._uptime_ms = 0
        self._asked_s = 0.0
        self._ordered_s = 0.0

    def begin(self) -> None:
        """Sends the first order, which holds the joint where it is. Raises what requests raise."""
        self._uptime_ms = self._board.status().uptime_ms
        self.angle_cdeg = self._board.order(self.jog, self.jog.from_cdeg)
        self._ordered_s = self._board.now_s()

    def go_on(self, jog: Jog) -> None:
        """Orders another way, from where the joint is held. Raises JogError and what requests raise."""
        self.jog = jog
        self._look()
        self._order_again()

    def move_and_hold(self, hold_s: float, stopped: Callable[[], bool], shown: Callable[[int], None]) -> bool:
        """Whether it arrived and was held; False when it was stopped. Raises JogError and what requests raise."""
        now_s = self._board.now_s
        started_s = now_s()
        longest_s = self.jog.duration_s + GRACE_S
        arrived_s: float | None = None
        while not stopped():
            shown(self.angle_cdeg)
            if arrived_s is None and self.angle_cdeg == self.jog.to_cdeg:
                arrived_s = now_s()
            if arrived_s is not None and now_s() - arrived_s >= hold_s:
                return True
            if arrived_s is None and now_s() - started_s > longest_s:
                self._look()  # a program that was frozen for so long must not blame the board
                raise stalled(self.jog.joint, self.angle_cdeg, self.jog.to_cdeg, longest_s, self._again)
            self._pause(max(0.0, min(POLL_S, self._ordered_s + ORDER_S - now_s())))
            self._look()
            if now_s() - self._ordered_s >= ORDER_S:
                self._order_again()
        return False

    def _look(self) -> None:
        """Asks for the angle before each order: only a joint that is still held is moved on."""
        self._asked_s = self._board.now_s()
        status = self._board.status()
        if status.state != SequencerState.JOGGING:
            raise ended_by_board(self.jog.joint, self.angle_cdeg, status, self._uptime_ms, self._again)
        self._uptime_ms = status.uptime_ms
        self.angle_cdeg = status.joint_angle_cdeg[self.jog.joint - 1]

    def _order_again(self) -> None:
        while self._board.now_s() - self._asked_s > FRESH_S:  # frozen since: the joint may be limp by now
            self._look()
        try:
            self.angle_cdeg = self._board.order(self.jog, self.angle_cdeg)
        except NoAnswer:  # one may get lost; whether the joint is still held is asked before the next
            return
        self._ordered_s = self._board.now_s()


def _outside(joint: int, what: str, settings: ServoSetting) -> JogRefused:
    return JogRefused(
        what=f"{what} is outside joint {joint}'s limits, "
        f"{settings.min_cdeg / 100:g} to {settings.max_cdeg / 100:g} deg.",
        meaning="Nothing was moved; the servo would have been driven against its stop.",
        next_step="Name angles within the limits, which are part of the board's servo settings: "
        "tfsat-host upload-servos --show",
    )
