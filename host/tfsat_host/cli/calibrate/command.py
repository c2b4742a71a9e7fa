"""`tfsat-host calibrate`: guided measurements before a drop, one quantity a command, all into one certificate."""

from __future__ import annotations

import argparse

from tfsat_host.cli.calibrate.options import (
    add_campaign_options,
    add_certificate_options,
    add_joint_option,
    add_sequencer_port,
    turned,
)
from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.cli.subcommands import add_subcommands
from tfsat_host.present.output import Output

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
        "where a servo takes its joint when commanded to an angle",
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
    helps = {name: text for name, (text, _) in _QUANTITIES.items()}
    of = add_subcommands(parser, helps, title="quantities", dest="quantity")
    for name, quantity in of.items():
        quantity.description = _QUANTITIES[name][1]
    log = "take it from the quiet minutes of a recording before its release; needs no board"
    of["bias"].add_argument("--log", metavar="FILE", type=file_name, help=log)
    which = of["zero"].add_mutually_exclusive_group(required=True)
    add_joint_option(which, required=False)
    which.add_argument("--all", action="store_true", help="all joints at once, an attachment on each")
    for name, text in (
        ("zero", "do not compare it with the last zero: after a sensor that had slipped was fastened"),
        (
            "misalignment",
            "sensors were moved or fastened: what was measured before counts as before a landing",
        ),
    ):
        of[name].add_argument("--anew", action="store_true", help=text)
    add_joint_option(of["misalignment"], required=True)
    add_joint_option(of["servo"], required=True)
    how = of["scale"].add_mutually_exclusive_group(required=True)
    add_joint_option(how, required=False)
    turn = (
        "turn the whole robot by hand about a body axis, x y or z, by a known angle, such as z 360: for the axis "
        "about which no joint turns"
    )
    how.add_argument("--turn", nargs=2, metavar=("AXIS", "DEG"), help=turn)
    jog = "with --joint: the sequencer's servo moves the joint, not a hand"
    of["scale"].add_argument("--jog", action="store_true", help=jog)
    keeps = "measure only: the sequencer keeps its servo settings"
    of["servo"].add_argument("--no-upload", action="store_true", help=keeps)
    add_sequencer_port(of["scale"])
    add_sequencer_port(of["servo"])
    for name in ("bias", "zero", "misalignment", "scale", "servo"):
        add_campaign_options(of[name])
    shown = add_certificate_options(
        of["show"], "the certificate that the steps went into (default as theirs)"
    )
    shown.add_argument("--emulated", action="store_true", help="that of the emulated robot")
    add_output_options(of["show"])


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
    return flow.measure(args, turned(args), out)
