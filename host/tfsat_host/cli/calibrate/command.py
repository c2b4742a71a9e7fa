"""`tfsat-host calibrate`: guided measurements before a drop, one quantity a command, all into one certificate."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tfsat_host.cli.calibrate.options import add_campaign_options, add_joint_option, add_sequencer_port
from tfsat_host.cli.options import add_output_options, file_name, number
from tfsat_host.cli.subcommands import add_subcommands
from tfsat_host.errors import UsageError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.steps.step import Axis

LEAST_TURN_DEG, MOST_TURN_DEG = 90.0, 720.0
_AXES: dict[str, Axis] = {"x": "x", "y": "y", "z": "z"}
_QUANTITIES = {
    "bias": ("what the gyros read at rest", "Read all gyros while the robot lies still."),
    "zero": (
        "what the angle sensors show where a joint is closed",
        "Read the angle sensors while the holding attachment keeps a joint, or all of them, closed.",
    ),
    "misalignment": (
        "which way each gyro's axes point, from swings about a joint",
        "Find how each gyro that a joint turns is mounted on its body: the robot is swung by hand as the screen says.",
    ),
    "scale": (
        "how much the gyros read too much or too little, and how the angle sensors bend",
        "Compare the gyros with the angle sensors while a joint is moved from rest to rest, or with a turn of the "
        "whole robot through a known angle.",
    ),
    "servo": (
        "where a servo takes its joint when told an angle",
        "Have the sequencer move a joint through its range, both ways, and measure where it stops.",
    ),
    "show": (
        "all that is calibrated, how old it is, and what is missing for a drop",
        "Show what a certificate holds, and what the next drop cannot rely on.",
    ),
}
"""What each quantity is, and what its command does."""


def configure(parser: argparse.ArgumentParser) -> None:
    """One subcommand a quantity."""
    parser.description = (
        "Measure what the robot's sensors and servos do, step by step as the screen says. Each accepted step is kept "
        "at once in a certificate, with its raw recording: steps can be repeated, and a calibration goes on where it "
        "ended. docs/calibration.md explains it."
    )
    added = add_subcommands(
        parser, {name: text for name, (text, _) in _QUANTITIES.items()}, title="quantities", dest="quantity"
    )
    for name, quantity in added.items():
        quantity.description = _QUANTITIES[name][1]
    _configure_bias(added["bias"])
    _configure_zero(added["zero"])
    _configure_misalignment(added["misalignment"])
    _configure_scale(added["scale"])
    _configure_servo(added["servo"])
    _configure_show(added["show"])


def _configure_bias(bias: argparse.ArgumentParser) -> None:
    bias.add_argument(
        "--log",
        metavar="FILE",
        type=file_name,
        help="take it from the quiet minutes of a recording before its release; needs no board",
    )
    add_campaign_options(bias)


def _configure_zero(zero: argparse.ArgumentParser) -> None:
    which = zero.add_mutually_exclusive_group(required=True)
    add_joint_option(which, required=False)
    which.add_argument("--all", action="store_true", help="all joints at once, an attachment on each")
    zero.add_argument(
        "--anew",
        action="store_true",
        help="do not compare it with the last zero: after a sensor that had slipped was fastened",
    )
    add_campaign_options(zero)


def _configure_misalignment(misalignment: argparse.ArgumentParser) -> None:
    add_joint_option(misalignment, required=True)
    misalignment.add_argument(
        "--anew",
        action="store_true",
        help="sensors were moved or fastened: what was measured before counts as before a landing",
    )
    add_campaign_options(misalignment)


def _configure_scale(scale: argparse.ArgumentParser) -> None:
    how = scale.add_mutually_exclusive_group(required=True)
    add_joint_option(how, required=False)
    how.add_argument(
        "--turn",
        nargs=2,
        metavar=("AXIS", "DEG"),
        help="turn the whole robot by hand about a body axis, x y or z, by a known angle, such as z 360: for the axis "
        "about which no joint turns",
    )
    scale.add_argument(
        "--jog", action="store_true", help="with --joint: the sequencer's servo moves the joint, not a hand"
    )
    add_sequencer_port(scale)
    add_campaign_options(scale)


def _configure_servo(servo: argparse.ArgumentParser) -> None:
    add_joint_option(servo, required=True)
    servo.add_argument(
        "--no-upload", action="store_true", help="measure only: the sequencer keeps its servo settings"
    )
    add_sequencer_port(servo)
    add_campaign_options(servo)


def _configure_show(show: argparse.ArgumentParser) -> None:
    group = show.add_argument_group("certificate")
    group.add_argument(
        "--out",
        metavar="FILE",
        type=file_name,
        help="the certificate that the steps went into (default as theirs)",
    )
    group.add_argument(
        "--robot", metavar="FILE", type=file_name, help="robot file (default: the drop tower robot)"
    )
    group.add_argument("--emulated", action="store_true", help="that of the emulated robot")
    add_output_options(show)


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures and writes; what was accepted before an end is kept."""
    if args.quantity == "servo":
        from tfsat_host.cli.calibrate import servo

        return servo.run(args, out)
    if args.quantity == "show":
        from tfsat_host.cli.calibrate import show

        return show.run(args, out)
    from tfsat_host.cli.calibrate import flow

    if args.quantity == "bias" and args.log is not None:
        return flow.take_from_log(args, out)
    return flow.measure(args, _turned(args), out)


def _turned(args: argparse.Namespace) -> tuple[Axis, float] | None:
    """Axis and angle in deg of a turn by hand. Raises UsageError."""
    words: Sequence[str] | None = getattr(args, "turn", None)
    if words is None:
        return None
    if args.jog:
        raise UsageError(
            what="--jog has a servo move a joint; --turn is done by hand.",
            meaning="Nothing was measured.",
            next_step="Leave one of them out.",
        )
    try:
        axis, angle_deg = _AXES.get(words[0]), number(words[1])
    except argparse.ArgumentTypeError as error:
        raise _no_turn(str(error)) from None
    if axis is None:
        raise _no_turn(f"{words[0]!r} is no axis of a body: write x, y or z")
    if not LEAST_TURN_DEG <= abs(angle_deg) <= MOST_TURN_DEG:
        raise _no_turn(
            f"a turn is one of {LEAST_TURN_DEG:g} to {MOST_TURN_DEG:g} deg either way, not of {words[1]}"
        )
    return axis, angle_deg


def _no_turn(problem: str) -> UsageError:
    return UsageError(
        what=f"Argument --turn: {problem}.",
        meaning="Nothing was measured.",
        next_step="tfsat-host calibrate scale --help",
    )
