"""`tfsat-host arm` and `tfsat-host disarm`."""

from __future__ import annotations

import argparse

from tfsat_host.cli.connection import open_sequencer
from tfsat_host.cli.options import add_device_options
from tfsat_host.cli.output import Output

_MEANING = "Nothing was armed."


def configure(parser: argparse.ArgumentParser) -> None:
    """The device only."""
    add_device_options(parser, "sequencer")


def run(args: argparse.Namespace, out: Output) -> int:
    """Arms or disarms, whichever command was typed."""
    with open_sequencer(args, out) as sequencer:
        if args.command == "disarm":
            state = sequencer.disarm()
            text = "Disarmed: the servos get no pulses and the release starts nothing."
        else:
            stored = sequencer.read_back()
            out.note(
                f"The {stored.origin.name.lower()} maneuver of {len(stored.strokes)} strokes would fly, "
                f"ending {stored.end_us / 1e6:.2f} s after release. The servos will move to their start pose."
            )
            if not out.yes:
                out.ask("Type ARM to arm: ", meaning=_MEANING, accept=("arm",))
            state = sequencer.arm()
            text = "Armed: when both switches open, the maneuver runs. Pulling the cable does not disarm."
        out.result({"state": state.name.lower(), "device": sequencer.identity.as_dict()}, text)
    return 0
