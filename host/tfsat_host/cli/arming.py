"""`tfsat-host arm` and `tfsat-host disarm`."""

from __future__ import annotations

import argparse
import os
from contextlib import closing

from tfsat_host.cli.advice import refuse_emulated
from tfsat_host.cli.connection import open_any_sequencer, open_sequencer
from tfsat_host.cli.options import add_device_options
from tfsat_host.cli.output import Output
from tfsat_host.errors import TfsatError

_MEANING = "Nothing was armed."
_LAST_RESORT = "Until disarm has said Disarmed the robot may move: stand clear and cut the sequencer's power."


def configure(parser: argparse.ArgumentParser) -> None:
    """The device only."""
    add_device_options(parser, "sequencer")


def run(args: argparse.Namespace, out: Output) -> int:
    """Arms or disarms, whichever command was typed."""
    if args.command == "arm":
        return _arm(args, out)
    try:
        return _disarm(args, out)
    except TfsatError as error:
        error.next_step = f"{error.next_step}\n{_LAST_RESORT}"
        raise


def _arm(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.devices.sequencer import arm_refusal

    refuse_emulated(args, "arm", "The arming would be gone with the command.")
    with open_sequencer(args, out) as sequencer:
        refusal = arm_refusal(sequencer.status())
        if refusal is not None:
            raise refusal
        recording = _look_at_logger(args, out)
        stored = sequencer.read_back()
        out.note(
            f"The {stored.origin.name.lower()} maneuver of {len(stored.strokes)} strokes would fly, "
            f"ending {stored.end_us / 1e6:.2f} s after release. The servos will move to their start pose."
        )
        if not out.yes:
            out.ask("Type ARM to arm: ", meaning=_MEANING, accept=("arm",))
        state = sequencer.arm()
        out.result(
            {
                "state": state.name.lower(),
                "recording": recording,
                "device": {"port": sequencer.port, **sequencer.identity.as_dict()},
            },
            "Armed: when both switches open, the maneuver runs. Pulling the cable does not disarm.",
        )
    return 0


def _disarm(args: argparse.Namespace, out: Output) -> int:
    with open_any_sequencer(args, out) as sequencer:
        state = sequencer.disarm()
        identity = sequencer.identity
        if not identity.speaks_this_protocol:
            out.warn(
                f"The sequencer's firmware {identity.firmware} speaks another protocol than this program. DISARM is "
                "the same in all, so it was sent; every other command will refuse and say which side to update."
            )
        out.result(
            {
                "state": state.name.lower(),
                "same_protocol": identity.speaks_this_protocol,
                "device": {"port": sequencer.port, **identity.as_dict()},
            },
            "Disarmed: the servos get no pulses and the release starts nothing.",
        )
    return 0


def _look_at_logger(args: argparse.Namespace, out: Output) -> bool | None:
    """Whether the logger records, with a warning if not; None when there is none to ask.

    An explicit `--port` scans no others: then only the environment names a logger.
    """
    from tfsat_host.devices.discovery import PortError, find_port, port_variable
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.transport import SerialTransport
    from tfsat_host.protocol.enums import LoggerState

    if args.port is not None and not os.environ.get(port_variable("logger")):
        out.note(f"The logger was not asked whether it records ({port_variable('logger')} names none).")
        return None
    try:
        port = find_port("logger")
    except PortError as error:
        out.note(f"The logger was not asked whether it records. {error.what}")
        return None
    try:
        with closing(SerialTransport(port)) as transport:
            status = LoggerClient.connect(transport).status()
    except TfsatError as error:
        out.warn(f"The logger did not say whether it records. {error.what}")
        return None
    recording = status.state == LoggerState.RECORDING and status.blocks_written > 0
    if not recording:
        out.warn(
            f"The logger at {port} is not recording ({status.state.name.lower()}): a drop now would leave no data. "
            "Start it: tfsat-host record start"
        )
    return recording
