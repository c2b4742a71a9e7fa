"""`tfsat-host arm` and `tfsat-host disarm`."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from tfsat_host.cli.boards import open_any_sequencer, open_sequencer, refuse_emulated
from tfsat_host.cli.usage import add_options, device, joint_angle_cdeg
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.stored_settings import MANEUVER
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.quantity import Column, Columns, fields, record
from tfsat_host.run.robot_arming import arm

_DISARMED = "Disarmed: the servos get no pulses and the release starts nothing."
_EMULATED_DISARMED = (
    "Disarmed: the emulated robot of this command. A robot on a cable is unchanged.\n"
    f"To disarm that one: {NextStep('disarm')}"
)
_LAST_RESORT = "The robot may still move: stand clear and cut the sequencer's power."


@dataclass(frozen=True, slots=True)
class Disarmed:
    """A sequencer that starts nothing any more."""

    state: SequencerState
    device: Device
    emulated: bool


_DISARM: Columns = (
    *fields("state same_protocol=device.identity.speaks_this_protocol emulated"),
    Column("device", columns=DEVICE),
)
_USAGE = f"""
--unrecorded        arm even if the logger's recording does not reach its card
--joints A1 A2 A3   measured angles of joints 1 to 3, deg: a joint off its start pose refuses the arming
--calibration FILE  certificate to check for this drop; it never refuses an arming (default: calibration.toml here,
                    of an emulated robot calibration-emulated.toml)
{device("sequencer")}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the sequencer's device options and, for `arm`, the joints' measured angles."""
    arms = parser.prog.endswith(" arm")
    joints = {"type": joint_angle_cdeg, "dest": "joints_cdeg"}
    add_options(parser, _USAGE if arms else device("sequencer"), joints=joints)


def run(args: argparse.Namespace, out: Output) -> int:
    """Arms or disarms, whichever command was typed."""
    if args.command == "arm":
        return _arm(args, out)
    try:
        return _disarm(args, out)
    except TfsatError as error:
        raise error.with_words(next_step=Advice(error.next_step, "\n", _LAST_RESORT)) from None


def _arm(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.certificate_check import CERTIFICATE_STATE

    refuse_emulated(args, "arm", "The arming would be gone with the command.")
    with open_sequencer(args, out) as sequencer:
        armed = arm(
            sequencer,
            out,
            joints_cdeg=args.joints_cdeg,
            sequencer_named=args.port is not None,
            unrecorded=args.unrecorded,
            certificate=args.calibration,
        )
        columns: Columns = (
            Column("state", of=lambda _: "armed"),
            *fields("recording at_start_pose"),
            Column("calibration", columns=CERTIFICATE_STATE),
            Column("maneuver", columns=MANEUVER),
            Column("device", columns=DEVICE),
        )
        out.result(
            record(columns, armed),
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
            record(_DISARM, Disarmed(state, sequencer.device(), args.emulated)),
            _EMULATED_DISARMED if args.emulated else _DISARMED,
        )
    return 0
