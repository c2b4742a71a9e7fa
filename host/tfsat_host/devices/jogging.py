"""Moving one joint slowly, on a person's word, and letting it go whatever happens."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import Protocol

from tfsat_host.devices.board_errors import BoardRefusal, NoAnswer
from tfsat_host.devices.jog_path import (
    IDLE_S,
    Jog,
    JogEnd,
    JogError,
    JogRefused,
    JogTour,
    from_here,
    from_the_start,
    last_commanded,
)
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import JOG_CONFIRM, JOG_IDLE_MS
from tfsat_host.protocol.remedies import REMEDIES

_UPTIME_RANGE_MS = 1 << 32
"""The board's uptime begins again at zero after 49 days."""
POLL_S = 0.1
ORDER_S = IDLE_S / 4
"""The board lets go after IDLE_S without an order: two may get lost."""
FRESH_S = IDLE_S / 4
"""An answer older than this allows no order: the board would take it as a new jog of a joint it has let go."""
ARRIVAL_TIMEOUT_S = 2.0
"""Beyond the time that the way takes at the board's speed."""


class TourWatch(Protocol):
    """Whoever follows a tour. What a method raises ends the tour, and the joint is let go."""

    def pause(self, duration_s: float) -> None:
        """Lets so much time pass on the sequencer's clock; another board can be read meanwhile."""

    def on_angle(self, stop: int, angle_cdeg: int) -> None:
        """Gets the commanded angle several times a second, on the way to a stop (from 0) and at rest there."""

    def on_rest(self, stop: int) -> None:
        """Called when the joint has rested at a stop for as long as it should; it is still held there.

        The board lets go of a joint that it gets no order for: this must not take half a second.
        """


class JogClient(SequencerClient):
    """The sequencer, asked to move a joint."""

    def check(self, jog: Jog) -> None:
        """Check that the board would take this jog now.

        Raises:
            BoardRefusal: it is not safe.
            JogRefused: an end of the way lies outside the joint's limits in the board's servo settings.
        """
        ends = (("--from", jog.from_cdeg), ("--to", jog.to_cdeg))
        self._check(jog.joint, [(angle, f"{option} {angle / 100:g}") for option, angle in ends])

    def check_tour(self, tour: JogTour) -> None:
        """Check that the board would take this tour now. Raises BoardRefusal, JogRefused."""
        self._check(tour.joint, [(angle, f"A stop at {angle / 100:g} deg") for angle in tour.stops_cdeg])

    def _check(self, joint: int, angles: Sequence[tuple[int, str]]) -> None:
        """Check that the board is safe and that the angles are within the joint's limits.

        Each angle, 0.01 deg, comes with its name in a refusal.
        """
        self.insist_on_safe(msg.JogRequest)
        # The limits are those that the board holds and enforces itself, not a file's.
        limits = self._client.request(msg.SettingsReadRequest(), msg.SettingsReadReply).servo[joint - 1]
        for angle_cdeg, what in angles:
            if not limits.min_cdeg <= angle_cdeg <= limits.max_cdeg:
                raise JogRefused(
                    what=f"{what} is outside joint {joint}'s limits, "
                    f"{limits.min_cdeg / 100:g} to {limits.max_cdeg / 100:g} deg.",
                    meaning="Nothing was moved; the servo would have been driven against its stop.",
                    next_step=Advice(
                        "Name angles within the limits, which are part of the board's servo settings: ",
                        NextStep("upload-servos", ("--show",)),
                    ),
                )

    def run(
        self, jog: Jog, hold_s: float, stopped: Callable[[], bool], show_angle: Callable[[int], None]
    ) -> JogEnd:
        """Moves the joint, holds it, and lets it go; afterwards the board is safe.

        Args:
            jog: The way; `check` it first.
            hold_s: How long to hold the joint at the way's end.
            stopped: Asked several times a second whether to let go now. A KeyboardInterrupt ends the jog as well.
            show_angle: Gets the angle that the servo is commanded to, 0.01 deg.

        Raises:
            BoardRefusal: the board was not safe.
            JogError: the board ended the jog, did not bring the joint to its end, or did not say
                that it let go.
            NoAnswer: the first order was not answered; the joint was let go.
        """
        motion = _Motion(self, jog, self.wait, from_here)

        def moves() -> bool:
            motion.begin()
            return motion.move_and_hold(hold_s, stopped, show_angle)

        return self._letting_go(motion, moves)

    def tour(self, tour: JogTour, stopped: Callable[[], bool], watch: TourWatch) -> JogEnd:
        """Moves the joint from stop to stop, holds it at each, and lets it go; afterwards the board is safe.

        `check_tour` it first. `stopped`, BoardRefusal, JogError, NoAnswer: see `run`.
        """
        start_cdeg = tour.stops_cdeg[0]
        # A jog from the start to the start: the first order only holds the joint where it is.
        motion = _Motion(
            self, Jog(tour.joint, start_cdeg, start_cdeg), watch.pause, from_the_start(start_cdeg)
        )

        def moves() -> bool:
            motion.begin()
            # The first pair is the start twice: the joint rests at the first stop as at the others.
            for stop, (from_cdeg, to_cdeg) in enumerate(pairwise((start_cdeg, *tour.stops_cdeg))):
                if stop > 0:
                    motion.go_on(Jog(tour.joint, from_cdeg, to_cdeg))
                if not motion.move_and_hold(tour.hold_s, stopped, partial(watch.on_angle, stop)):
                    return False
                watch.on_rest(stop)
            return True

        return self._letting_go(motion, moves)

    def order(self, jog: Jog, angle_cdeg: int) -> int:
        """Sends the order once; the angle that the servo is commanded to then, 0.01 deg. Raises NoAnswer, BoardRefusal.

        Never repeated unseen: a host that froze in between would move a joint that the board has let go.
        Where the joint is goes with each order: a board that has just restarted does not jerk it back.
        """
        request = msg.JogRequest(jog.joint, angle_cdeg, jog.to_cdeg, JOG_CONFIRM)
        return self._client.request(request, msg.JogReply, attempts=1).angle_cdeg

    def _letting_go(self, motion: _Motion, moves: Callable[[], bool]) -> JogEnd:
        """Lets go after `moves`, which says whether all was held, however it ends."""
        was_held = False
        try:
            was_held = moves()
        except BoardRefusal:  # the board does not jog: there is nothing to let go
            raise
        except KeyboardInterrupt:
            # Ctrl-C is a way to end a jog: let go in order, and tell that it was not held.
            self._let_go(motion)
        except BaseException:
            # Whatever went wrong, no joint stays driven; the error goes on after that.
            self._let_go(motion)
            raise
        else:
            self._let_go(motion)
        return JogEnd(was_held, motion.angle_cdeg)

    def _let_go(self, motion: _Motion) -> None:
        """Disarms, and asks again whether it is so."""
        try:
            self.disarm()
            state = self.status().state
        except TfsatError as error:
            raise motion.not_let_go(error.what) from error
        if state != SequencerState.SAFE:
            raise motion.not_let_go(f"The sequencer says that it is {state.name.lower()}.")


class _Motion:
    """One joint under way.

    Attributes:
        jog: The way.
        angle_cdeg: What the servo was commanded to last, as far as the board has answered.

    Args:
        board: Moves it.
        jog: The way.
        pause: Lets time pass between two looks at the board.
        again: How to go on where the board has let the joint go, from the angle that it was commanded to last.
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
        # The uptime before the first order tells a restart of the board later on.
        self._uptime_ms = self._board.status().uptime_ms
        self.angle_cdeg = self._board.order(self.jog, self.jog.from_cdeg)
        self._ordered_s = self._board.now_s()

    def go_on(self, jog: Jog) -> None:
        """Orders another way, from where the joint is held. Raises JogError and what requests raise."""
        self.jog = jog
        self._look()
        self._order_again()

    def move_and_hold(
        self, hold_s: float, stopped: Callable[[], bool], show_angle: Callable[[int], None]
    ) -> bool:
        """Move the joint and hold it; return True once held, False if stopped.

        Raises JogError and what requests raise.
        """
        now_s = self._board.now_s
        started_s = now_s()
        longest_s = self.jog.duration_s + ARRIVAL_TIMEOUT_S
        arrived_s: float | None = None
        while not stopped():
            show_angle(self.angle_cdeg)
            if arrived_s is None and self.angle_cdeg == self.jog.to_cdeg:
                # The hold counts from the first answer that gives the end as the commanded angle.
                arrived_s = now_s()
            if arrived_s is not None and now_s() - arrived_s >= hold_s:
                return True
            if arrived_s is None and now_s() - started_s > longest_s:
                self._look()  # a program that was frozen for so long must not blame the board
                raise self._error(
                    f"Joint {self.jog.joint} was commanded to {self.angle_cdeg / 100:g} deg only after "
                    f"{longest_s:.0f} s; {self.jog.to_cdeg / 100:g} deg was asked for.",
                    "The joint was let go.",
                    Advice("Once more: ", self._again(self.angle_cdeg), " If it recurs, report it."),
                )
            # Sleep no longer than until the next order is due: the board lets go without orders.
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
            raise self._ended_by_board(status)
        # Kept from look to look, to tell a restart from a host that was away.
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

    def _error(self, what: str, meaning: str, next_step: str) -> JogError:
        return JogError(self.jog.joint, self.angle_cdeg, what=what, meaning=meaning, next_step=next_step)

    def _ended_by_board(self, status: msg.SequencerStatusReply) -> JogError:
        """Build the error for a jog that the board ended.

        The board's uptimes tell a restart from a host that was away.
        """
        # The difference modulo the counter's range bridges its wrap-around; half of it or more is negative.
        passed_ms = (status.uptime_ms - self._uptime_ms) % _UPTIME_RANGE_MS
        if passed_ms >= _UPTIME_RANGE_MS // 2:  # its clock went back
            cause = status.reset_cause.name.lower().replace("_", " ")
            what = (
                f"The sequencer restarted {status.uptime_ms / 1000:.1f} s ago ({cause}), which ended the jog."
            )
            why = (
                "A servo that stalls can pull the supply down and restart the board: check the battery, "
                "and that nothing blocks the joint."
            )
        elif passed_ms >= JOG_IDLE_MS:
            what = f"This computer was away for {passed_ms / 1000:.1f} s, and the sequencer ended the jog."
            why = (
                f"The sequencer lets a joint go after {IDLE_S:g} s without an order: the program was stopped, "
                "or the computer slept or was overloaded. The board did not restart."
            )
        else:
            up_s = status.uptime_ms / 1000
            what = f"The sequencer ended the jog automatically. It did not restart: up for {up_s:.0f} s."
            why = f"It saw its port closed, or no order reached it for {IDLE_S:g} s: check the cable."
        fault = "" if status.fault == ErrorCode.NONE else f" {REMEDIES[status.fault][0]}"
        return self._error(
            f"{what} It is {status.state.name.lower()}.{fault}",
            f"{last_commanded(self.jog.joint, self.angle_cdeg)} and was let go. {why}",
            Advice("Look at the joint and its servo; then ", self._again(self.angle_cdeg)),
        )

    def not_let_go(self, reason: str) -> JogError:
        """It is not known whether the joint is limp."""
        port = ("--port", self._board.port)
        return self._error(
            f"The sequencer did not confirm that it let joint {self.jog.joint} go. {reason}",
            f"{last_commanded(self.jog.joint, self.angle_cdeg)}. The sequencer lets it go when it notices the closed "
            f"port, or {IDLE_S:g} s after the last order; until then the servo may hold or move the joint.",
            Advice(
                "Keep hands off. ",
                NextStep("status", port),
                " shows whether it is safe; if not, ",
                NextStep("disarm", port),
                ", or cut the sequencer's power.",
            ),
        )
