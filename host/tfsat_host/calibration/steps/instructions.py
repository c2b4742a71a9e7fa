"""What a person is asked to hold and to move in each step, in plain words."""

from __future__ import annotations

from tfsat_host.calibration.steps.step import DURATION_S, Step, StepKind, bodies

TURN_RATE_DEG_S, SHORTEST_TURN_S = 90.0, 2.0
"""On average over a turn by hand: its fastest moment is about twice that, far inside the gyros' range."""


def title(step: Step) -> str:
    """What the step is, in a few words."""
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


def task(step: Step) -> tuple[str, ...]:
    """What to hold and what to move, line by line, of a step that is done by hand."""
    lasts = f"{DURATION_S.get(step.kind, 0.0):g} s"
    match step.kind:
        case StepKind.REST:
            return (
                "Lay the robot on the bench and take your hands off it, and off the bench.",
                f"It is read for {lasts}.",
            )
        case StepKind.ZERO:
            joints = "every joint" if step.joint is None else f"joint {step.joint}"
            return (
                f"Put the holding attachment on {joints} and screw it down, so that the joint is closed.",
                f"Let the robot lie still. It is read for {lasts}.",
            )
        case StepKind.SWING:
            return (
                *_held_and_closed(step),
                f"Swing {_moved(step)} about joint {step.joint}, about 60 deg out and back, two seconds a swing.",
                f"Begin with the joint closed and at rest, then keep swinging for {lasts}.",
            )
        case StepKind.SWEEP:
            return (
                *_held_and_closed(step),
                f"Move {_moved(step)} about joint {step.joint} to 30, 60 and 90 deg and back to 60, 30 and 0, twice; "
                "rest a second at each.",
                "Begin with the joint closed and at rest. A few degrees more or less do not matter, the rests do.",
            )
        case StepKind.TURN:
            way = "counter-clockwise" if step.angle_deg > 0 else "clockwise"
            angle_deg = abs(step.angle_deg)
            duration_s = max(SHORTEST_TURN_S, angle_deg / TURN_RATE_DEG_S)
            return (
                "Close all joints with the holding attachment on.",
                f"Stand the robot so that its {step.axis} axis is upright, one edge against something straight.",
                f"Turn it {angle_deg:g} deg {way}, as seen against the {step.axis} axis, in about {duration_s:.0f} s "
                f"({angle_deg / duration_s:.0f} deg/s on average), and lay the same edge on; then turn it back. Three "
                "times there and back; rest a second at each end.",
            )
        case StepKind.SERVO:
            raise ValueError("a servo step is not done by hand")


def _held_and_closed(step: Step) -> tuple[str, str]:
    first, second = (joint for joint in (1, 2, 3) if joint != step.joint)
    return (
        f"Close joints {first} and {second}, the holding attachment on; take it off joint {step.joint} and close that "
        "by hand.",
        f"Hold {bodies(step.held)} on the bench.",
    )


def _moved(step: Step) -> str:
    """With what hangs on it."""
    along = [body for body in (1, 2, 3, 4) if body not in (*step.moved, *step.held)]
    return bodies(step.moved) + (f" ({bodies(along)} goes along)" if along else "")
