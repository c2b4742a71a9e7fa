"""One thing that is done with the robot while its sensors are read (paper, section "Calibrations"), and how."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final, Literal

Axis = Literal["x", "y", "z"]
AXES: Final[tuple[Axis, ...]] = ("x", "y", "z")
ALL_BODIES: Final = (1, 2, 3, 4)
SWEEP_STOPS_DEG: Final = (0.0, 30.0, 60.0, 90.0, 60.0, 30.0, 0.0)
"""Where a sweep rests, twice over: few places far apart determine scale, several of them a sensor's bend."""
SWEEP_ROUNDS: Final = 2
TURN_ROUNDS: Final = 3
"""So often is the robot turned there and back."""
PATTERNS: Final = (
    (1, (1,), (2, 3, 4)),
    (1, (2, 3), (1,)),
    (2, (1, 2), (3, 4)),
    (2, (3, 4), (1, 2)),
    (3, (4,), (1, 2, 3)),
)
"""Joint, bodies whose gyros measure the motion, bodies held on the bench, of each motion (paper, tab. misal).
Where the paper moves bodies 2 and 3 about joint 1, body 4 hangs on body 3 and moves along."""

TURN_RATE_DEG_S, MIN_TURN_S = 90.0, 2.0
"""On average over a turn by hand: its fastest moment is about twice that, far inside the gyros' range."""


class StepKind(StrEnum):
    """What the recording of a step is for."""

    REST = "rest"
    """Everything lies still: bias."""
    ZERO = "zero"
    """The holding attachment is on: zero point of the angle sensors."""
    SWING = "swing"
    """A joint is swung to and fro, some bodies held: directions."""
    SWEEP = "sweep"
    """A joint goes slowly from rest to rest: scale factors and the angle sensors' bend."""
    TURN = "turn"
    """The whole robot is turned through a known angle, there and back, from rest to rest: scale factors."""
    SERVO = "servo"
    """The sequencer moves a joint to commanded angles and holds it there: pulse map."""
    STROKES = "strokes"
    """A maneuver is flown, or runs on the bench: each servo's speed, acceleration and delay."""


DURATION_S: Final = {StepKind.REST: 20.0, StepKind.ZERO: 5.0, StepKind.SWING: 12.0}
"""Of steps that end by the clock; the others end with their last rest."""


@dataclass(frozen=True, slots=True)
class Step:
    """What is done, and with what.

    Attributes:
        kind: See there.
        joint: 1 to 3; None where no single joint is meant (a zero of all joints, a rest, a turn).
        moved: Bodies (1 to 4) whose gyros measure the motion; empty where nothing moves.
        held: Bodies that are kept still on the bench.
        axis: Of a turn: the body axis, all bodies being parallel.
        angle_deg: Of a turn: how far, positive about `axis`; the turns back go the other way.
    """

    kind: StepKind
    joint: int | None = None
    moved: tuple[int, ...] = ()
    held: tuple[int, ...] = ()
    axis: Axis | None = None
    angle_deg: float = 0.0

    @property
    def moving_joint(self) -> int:
        """The joint, of a step that moves one. Raises ValueError for any other."""
        if self.joint is None:
            raise ValueError(f"a {self.kind} moves no joint")
        return self.joint

    @property
    def key(self) -> str:
        """A name that two steps of the same purpose share: a repetition replaces what was recorded before."""
        parts = [str(self.kind)]
        if self.joint is not None:
            parts.append(f"joint-{self.joint}")
        # One joint is moved in several patterns, which differ by the bodies that measure.
        if self.kind in (StepKind.SWING, StepKind.SWEEP):
            parts.append("body-" + "-".join(map(str, self.moved)))
        if self.axis is not None:
            parts.append(self.axis)
        return "-".join(parts)


def rest() -> Step:
    """Return the step in which the whole robot lies still."""
    return Step(StepKind.REST, held=(1, 2, 3, 4))


def zero(joint: int | None) -> Step:
    """Return the step in which the attachment holds a joint, or all of them (None), at its zero angle."""
    return Step(StepKind.ZERO, joint, held=(1, 2, 3, 4))


def swings(joint: int) -> tuple[Step, ...]:
    """Return the swings of one joint: the paper's patterns."""
    return tuple(Step(StepKind.SWING, *pattern) for pattern in PATTERNS if pattern[0] == joint)


def sweeps(joint: int) -> tuple[Step, ...]:
    """Return the sweeps of one joint: the paper's patterns, from rest to rest."""
    return tuple(Step(StepKind.SWEEP, *pattern) for pattern in PATTERNS if pattern[0] == joint)


def turn(axis: Axis, angle_deg: float) -> Step:
    """Return the step that turns the whole robot, all joints closed, about a body axis."""
    return Step(StepKind.TURN, moved=(1, 2, 3, 4), axis=axis, angle_deg=angle_deg)


def turn_leg_s(angle_deg: float) -> float:
    """Return how long one way of a turn by hand takes at nominal pace, s."""
    return max(MIN_TURN_S, abs(angle_deg) / TURN_RATE_DEG_S)


def servo(joint: int) -> Step:
    """Return the step in which a servo moves only the joint's outer side."""
    return Step(StepKind.SERVO, *next(pattern for pattern in PATTERNS if pattern[0] == joint))


def bodies(numbers: Iterable[int]) -> str:
    """Format body numbers in words: body 1; bodies 1 and 2; bodies 2, 3 and 4."""
    *first, last = map(str, sorted(numbers))
    return f"bodies {', '.join(first)} and {last}" if first else f"body {last}"


def title(step: Step) -> str:
    """Return the step's title, a few words."""
    match step.kind:
        case StepKind.REST:
            return "Rest: everything lies still"
        case StepKind.ZERO:
            return "Zero point of " + ("all joints" if step.joint is None else f"joint {step.joint}")
        case StepKind.SWING | StepKind.SWEEP:
            return f"{step.kind.capitalize()} of {bodies(step.moved)} about joint {step.joint}"
        case StepKind.TURN:
            return f"Turn of the whole robot about {step.axis}"
        case StepKind.SERVO:
            return f"Servo of joint {step.joint}"
        case StepKind.STROKES:
            return f"Strokes of joint {step.joint}"


def task(step: Step, robot_bodies: Sequence[int] = ALL_BODIES) -> tuple[str, ...]:
    """Return the instructions for a step that is done by hand, line by line.

    They say what to hold and what to move of a robot that has these bodies.
    """
    lasts = f"{DURATION_S.get(step.kind, 0.0):g} s"
    match step.kind:
        case StepKind.REST:
            return (
                "Lay the robot on the bench; keep hands off robot and bench.",
                f"Reading time: {lasts}.",
            )
        case StepKind.ZERO:
            joints = "every joint" if step.joint is None else f"joint {step.joint}"
            return (
                f"Close {joints} and screw the holding attachment down on it.",
                f"Let the robot lie still. Reading time: {lasts}.",
            )
        case StepKind.SWING:
            return (
                *_held_and_closed(step, robot_bodies),
                f"Swing {_name_moved(step, robot_bodies)} about joint {step.joint}, about 60 deg out and back, "
                "two seconds a swing.",
                f"Begin with the joint closed and at rest, then keep swinging for {lasts}.",
            )
        case StepKind.SWEEP:
            return (
                *_held_and_closed(step, robot_bodies),
                f"Move {_name_moved(step, robot_bodies)} about joint {step.joint} to 30, 60 and 90 deg and back to 60, "
                "30 and 0, twice; rest a second at each.",
                "Begin with the joint closed and at rest. The rests matter, a few degrees do not.",
            )
        case StepKind.TURN:
            way = "counter-clockwise" if step.angle_deg > 0 else "clockwise"
            angle_deg = abs(step.angle_deg)
            # Slow enough that even the fastest moment stays inside the gyros' range.
            duration_s = turn_leg_s(angle_deg)
            return (
                "Close all joints with the holding attachment on.",
                f"Stand the robot so that its {step.axis} axis is upright, one edge against something straight.",
                f"Turn it {angle_deg:g} deg {way}, as seen against the {step.axis} axis, in about {duration_s:.0f} s "
                f"({angle_deg / duration_s:.0f} deg/s on average), and lay the same edge on; then turn it back. Three "
                "times there and back; rest a second at each end.",
            )
        case StepKind.SERVO | StepKind.STROKES:
            raise ValueError("a servo moves in this step, no hand")


def _held_and_closed(step: Step, robot_bodies: Sequence[int]) -> tuple[str, str]:
    others = " and ".join(str(joint) for joint in robot_bodies[:-1] if joint != step.joint)
    closed = f"Close joint{'s' if ' ' in others else ''} {others}, the holding attachment on; take it off"
    return (
        f"{closed if others else 'Take the holding attachment off'} joint {step.joint} and close that by hand.",
        f"Hold {bodies(step.held)} on the bench.",
    )


def _name_moved(step: Step, robot_bodies: Sequence[int]) -> str:
    """Name the moved bodies, with those that hang on them."""
    # Neither measured nor held: it hangs on a moved body.
    along = [body for body in robot_bodies if body not in (*step.moved, *step.held)]
    verb = "moves" if len(along) == 1 else "move"
    return bodies(step.moved) + (f" ({bodies(along)} {verb} along)" if along else "")
