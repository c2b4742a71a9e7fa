"""A jog before and after it: where a joint moves, the words for the person beside it, and how it ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

from tfsat_host.errors import Interrupted, RefusedError, TfsatError
from tfsat_host.protocol.limits import JOG_IDLE_MS, JOG_SPEED_CDEG_S
from tfsat_host.quantity import Column, Columns, fields

IDLE_S = JOG_IDLE_MS / 1000
"""The board lets go after so long without an order."""


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

    def explanation(self, hold_s: float) -> str:
        """Explain what will move and how it is stopped, for a person to read before confirming."""
        start_deg = self.from_cdeg / 100
        stay = f"stay there for {hold_s:g} s" if hold_s else "stay there for a moment"
        return (
            f"Joint {self.joint} will move from {start_deg:g} to {self.to_cdeg / 100:g} deg at "
            f"{JOG_SPEED_CDEG_S / 100:g} deg/s ({self.duration_s:.1f} s), {stay} and be let go. "
            "The other joints stay limp. Ctrl-C or Ctrl-Z lets it go at once, and so does the board "
            f"{IDLE_S:g} s after this program's last order.\n"
            f"The joint is limp now; its first pulse takes it to {start_deg:g} deg at the servo's full speed. "
            f"If its angle differs, bring it to {start_deg:g} deg by hand first, or say no and give --from its angle.\n"
            "Keep hands, hair and cables clear of the joint."
        )


@dataclass(frozen=True, slots=True)
class JogTour:
    """One joint's stops.

    Attributes:
        joint: 1 to 3.
        stops_cdeg: Where it rests, 0.01 deg; at the first of them it is now, and its first pulse holds it there.
        hold_s: How long it rests at each.
    """

    joint: int
    stops_cdeg: tuple[int, ...]
    hold_s: float

    @property
    def duration_s(self) -> float:
        """At the board's jogging speed, rests included."""
        way_cdeg = sum(abs(after - before) for before, after in pairwise(self.stops_cdeg))
        return way_cdeg / JOG_SPEED_CDEG_S + len(self.stops_cdeg) * self.hold_s


@dataclass(frozen=True, slots=True)
class JogEnd:
    """A jog that is over; the joint is limp.

    Attributes:
        held: The joint arrived and was held for as long as was asked.
        angle_cdeg: Where the servo was commanded to be when it was let go, 0.01 deg.
    """

    held: bool
    angle_cdeg: int


_LAST_COMMANDED: Columns = (
    *fields("joint"),
    Column("last_angle_deg", of=lambda error: error.angle_cdeg / 100),
)


class JogError(TfsatError):
    """A jog did not go as ordered; `angle_cdeg` is what the joint was commanded to last, in 0.01 deg."""

    columns = _LAST_COMMANDED

    def __init__(self, joint: int, angle_cdeg: int, *, what: str, meaning: str, next_step: str) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.joint, self.angle_cdeg = joint, angle_cdeg


class JogInterrupted(Interrupted):
    """Ctrl-C or Ctrl-Z while the joint moved or was held; it was let go.

    Args:
        joint: 1 to 3.
        end: How the jog ended.
        what: Ended it.
        again: How to go on, from the angle that was commanded last.
        lost: A sentence of what the end costs, with a space before it.
    """

    columns = _LAST_COMMANDED

    def __init__(
        self, joint: int, end: JogEnd, what: str, again: Callable[[int], str], lost: str = ""
    ) -> None:
        let_go = f"{last_commanded(joint, end.angle_cdeg)} and was let go on its way"
        super().__init__(
            what=what,
            meaning=f"{let_go}; the sequencer is safe.{lost}",
            next_step=again(end.angle_cdeg).capitalize(),
        )
        self.joint, self.angle_cdeg = joint, end.angle_cdeg


class JogRefused(RefusedError):
    """The jog would leave the limits that the board keeps."""

    code = "joint-limits"


def last_commanded(joint: int, angle_cdeg: int) -> str:
    """Describe the angle last commanded to a limp joint, which may have sagged since."""
    return f"Joint {joint} was last commanded to {angle_cdeg / 100:g} deg"


def from_here(angle_cdeg: int) -> str:
    """Tell how to go on with a joint that was let go."""
    return (
        f"the same command with --from {angle_cdeg / 100:g} goes on, "
        "or --from its angle now if it has sagged or was moved."
    )


def from_the_start(start_cdeg: int) -> Callable[[int], str]:
    """Return a function that tells how to go on with a joint let go on a tour, which starts again."""
    return lambda _angle_cdeg: (
        f"bring it to {start_cdeg / 100:g} deg by hand and type the same command again."
    )
