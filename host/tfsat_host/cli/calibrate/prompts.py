"""What a person is asked to hold and to move, in plain words."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from tfsat_host.calibration.steps.step import Step, StepKind
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from collections.abc import Callable

TURN_RATE_DEG_S, SHORTEST_TURN_S = 90.0, 2.0
"""On average over a turn by hand: its fastest moment is about twice that, far inside the gyros' range."""
LEAD_S = 3.0
"""With `--yes` nobody says that the robot is held and moves: so long after the task the sensors are read."""


class PersonAtPrompt:
    """Tells a person what to do and waits for Enter; with `--yes` the reading starts after `LEAD_S`."""

    def __init__(self, out: Output) -> None:
        self._out = out

    @property
    def lead_s(self) -> float:
        """Zero where Enter says that all is ready."""
        return LEAD_S if self._out.yes else 0.0

    def begin(self, step: Step) -> None:
        """Asks for it. Raises UsageError without a terminal, RefusedError for anything but Enter."""
        announce(step, self._out)
        if self._out.yes:
            self._out.note(f"The sensors are read from {LEAD_S:g} s from now on.")
        else:
            self._out.ask(
                "Enter when you are ready, q ends: ", meaning="This step was not measured.", accept=("",)
            )


def announce(step: Step, out: Output) -> None:
    """The heading and the task of a step that hands do."""
    out.note(f"\n{title(step)}")
    for line in task(step):
        out.note(f"  {line}")


def title(step: Step) -> str:
    """What the step is, in a few words."""
    match step.kind:
        case StepKind.REST:
            return "Rest: everything lies still"
        case StepKind.ZERO:
            return "Zero point of " + ("all joints" if step.joint is None else f"joint {step.joint}")
        case StepKind.SWING | StepKind.SWEEP:
            verb = "Swing" if step.kind == StepKind.SWING else "Sweep"
            return f"{verb} of {bodies(step.moved)} about joint {step.joint}"
        case StepKind.TURN:
            return f"Turn of the whole robot about {step.axis}"
        case StepKind.SERVO:
            return f"Servo of joint {step.joint}"


def task(step: Step) -> tuple[str, ...]:
    """What to hold and what to move, line by line, of a step that hands do."""
    return _TASKS[step.kind](step)


def _rest(step: Step) -> tuple[str, ...]:
    return (
        "Lay the robot on the bench and take your hands off it, and off the bench.",
        f"It is read for {_seconds(step)}.",
    )


def _zero(step: Step) -> tuple[str, ...]:
    joints = "every joint" if step.joint is None else f"joint {step.joint}"
    return (
        f"Put the holding attachment on {joints} and screw it down, so that the joint is closed.",
        f"Let the robot lie still. It is read for {_seconds(step)}.",
    )


def _swing(step: Step) -> tuple[str, ...]:
    return (
        _closed(step),
        f"Hold {bodies(step.held)} on the bench.",
        f"Swing {_moved(step)} about joint {step.joint}, about 60 deg out and back, two seconds a swing.",
        f"Begin with the joint closed and at rest, then keep swinging for {_seconds(step)}.",
    )


def _sweep(step: Step) -> tuple[str, ...]:
    return (
        _closed(step),
        f"Hold {bodies(step.held)} on the bench.",
        f"Move {_moved(step)} about joint {step.joint} to 30, 60 and 90 deg and back to 60, 30 and 0, twice; "
        "rest a second at each.",
        "Begin with the joint closed and at rest. A few degrees more or less do not matter, the rests do.",
    )


def _turn(step: Step) -> tuple[str, ...]:
    way = "counter-clockwise" if step.angle_deg > 0 else "clockwise"
    duration_s = max(SHORTEST_TURN_S, abs(step.angle_deg) / TURN_RATE_DEG_S)
    return (
        "Close all joints with the holding attachment on.",
        f"Stand the robot so that its {step.axis} axis is upright, one edge against something straight.",
        f"Turn it {abs(step.angle_deg):g} deg {way}, as seen against the {step.axis} axis, in about "
        f"{duration_s:.0f} s ({abs(step.angle_deg) / duration_s:.0f} deg/s on average), and lay the same "
        "edge on; then turn it back. Three times there and back; rest a second at each end.",
    )


_TASKS: dict[StepKind, Callable[[Step], tuple[str, ...]]] = {
    StepKind.REST: _rest,
    StepKind.ZERO: _zero,
    StepKind.SWING: _swing,
    StepKind.SWEEP: _sweep,
    StepKind.TURN: _turn,
}


def _seconds(step: Step) -> str:
    from tfsat_host.calibration.progress import DURATION_S

    return f"{DURATION_S[step.kind]:g} s"


def _closed(step: Step) -> str:
    others = [joint for joint in (1, 2, 3) if joint != step.joint]
    return (
        f"Close joints {others[0]} and {others[1]}, the holding attachment on; "
        f"take it off joint {step.joint} and close that by hand."
    )


def _moved(step: Step) -> str:
    """With what hangs on it."""
    along = [body for body in (1, 2, 3, 4) if body not in (*step.moved, *step.held)]
    return bodies(step.moved) + (f" ({bodies(along)} goes along)" if along else "")


def bodies(numbers: Iterable[int]) -> str:
    """Such as `body 1` or `bodies 2, 3 and 4`."""
    names = [str(number) for number in sorted(numbers)]
    if len(names) == 1:
        return f"body {names[0]}"
    return f"bodies {', '.join(names[:-1])} and {names[-1]}"
