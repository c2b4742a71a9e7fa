"""`tfsat-host calibrate`: guided measurements before a drop, one quantity a command, all into one certificate."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.cli.calibrate import servo, show
from tfsat_host.cli.calibrate.jog_bench import add_sequencer_port
from tfsat_host.cli.calibrate.options import add_campaign_options, add_joint_option
from tfsat_host.cli.options import file_name, number
from tfsat_host.cli.subcommands import add_subcommands
from tfsat_host.errors import UsageError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.progress import Known
    from tfsat_host.calibration.steps.evidence import Evidence, Origin
    from tfsat_host.calibration.steps.step import Axis, Step
    from tfsat_host.cli.calibrate.flow import Reader
    from tfsat_host.robot import RobotModel

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
    servo.configure(added["servo"])
    show.configure(added["show"])


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


def run(args: argparse.Namespace, out: Output) -> int:
    """Measures and writes; what was accepted before an end is kept."""
    if args.quantity == "servo":
        return servo.run(args, out)
    if args.quantity == "show":
        return show.run(args, out)
    if args.quantity == "bias" and args.log is not None:
        from tfsat_host.cli.calibrate import log

        return log.run(args, out)
    from tfsat_host.cli.calibrate.campaign import note_without_zero, open_campaign, tell
    from tfsat_host.cli.calibrate.flow import Flow, with_rest
    from tfsat_host.robot import load_robot

    steps = _steps(args)
    model = load_robot(args.robot)
    with _opened(args, model, out) as (origin, read):
        campaign = open_campaign(args, origin, model, out)
        before = campaign.calibration
        if args.quantity == "misalignment" and args.anew:
            campaign.sensors_moved(datetime.now(UTC))
        if args.quantity in ("misalignment", "scale"):
            steps = with_rest(steps, campaign)
            note_without_zero(campaign, args, out)
        flow = Flow(steps, campaign, read, model, args, out)
        flow.run()
    tell(args, campaign, flow.kept, before, model, out)
    return 0


@contextmanager
def _opened(args: argparse.Namespace, model: RobotModel, out: Output) -> Iterator[tuple[Origin, Reader]]:
    """Whose sensors they are, and what has a step done and read: by hand, or (`--jog`) by the joint's servo."""
    from tfsat_host.calibration.steps.step import StepKind
    from tfsat_host.cli.calibrate.bench import open_bench
    from tfsat_host.cli.calibrate.jog_bench import open_jog_bench
    from tfsat_host.cli.calibrate.recording import record, record_jogged

    if not getattr(args, "jog", False):
        with open_bench(args, model, out) as bench:
            yield bench.origin, lambda step, known: record(step, bench, known, out)
        return
    if args.joint is None:
        raise UsageError(
            what="--jog has a servo move a joint; --turn is done by hand.",
            meaning="Nothing was measured.",
            next_step="Leave one of them out.",
        )
    with open_jog_bench(args, model, out) as jogging:

        def read(step: Step, known: Known) -> Evidence:
            if step.kind == StepKind.SWEEP:
                return record_jogged(step, jogging, out)
            return record(step, jogging, known, out)

        yield jogging.origin, read


def _steps(args: argparse.Namespace) -> tuple[Step, ...]:
    from tfsat_host.calibration.steps.step import rest, sweeps, swings, turn, zero

    match args.quantity:
        case "bias":
            return (rest(),)
        case "zero":
            return (zero(args.joint),)
        case "misalignment":
            return swings(args.joint)
        case _:
            return sweeps(args.joint) if args.turn is None else (turn(*_turn(args.turn)),)


def _turn(words: Sequence[str]) -> tuple[Axis, float]:
    """Axis and angle in deg. Raises UsageError."""
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
