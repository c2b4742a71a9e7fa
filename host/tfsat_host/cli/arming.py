"""`tfsat-host arm` and `tfsat-host disarm`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tfsat_host.cli.advice import Interrupted, device_option, refuse_emulated
from tfsat_host.cli.arming_calibration import tell_calibration
from tfsat_host.cli.arming_logger import look_at_logger
from tfsat_host.cli.connection import open_any_sequencer, open_sequencer
from tfsat_host.cli.options import add_device_options, file_name, joint_angle_cdeg
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import Output
from tfsat_host.protocol.limits import JOINT_COUNT, START_POSE_TOLERANCE_CDEG

if TYPE_CHECKING:
    from tfsat_host.devices.sequencer import SequencerClient
    from tfsat_host.protocol.enums import SequencerState

"""No joint has more."""
_MEANING = "Nothing was armed."
_DISARMED = "Disarmed: the servos get no pulses and the release starts nothing."
_EMULATED_DISARMED = (
    "The emulated robot of this command was disarmed, no other: a robot on a cable is as it was. "
    "For that one: tfsat-host disarm"
)
_LAST_RESORT = "Until disarm has said Disarmed the robot may move: stand clear and cut the sequencer's power."


def configure(parser: argparse.ArgumentParser) -> None:
    """The device; for arm, the joints' measured angles."""
    add_device_options(parser, "sequencer")
    if parser.prog.endswith(" disarm"):
        return
    parser.add_argument(
        "--unrecorded",
        action="store_true",
        help="arm even if the logger's recording does not reach its card",
    )
    parser.add_argument(
        "--joints",
        metavar=("A1", "A2", "A3"),
        nargs=JOINT_COUNT,
        type=joint_angle_cdeg,
        dest="joints_cdeg",
        help="measured angles of joints 1 to 3, deg: a joint off its start pose refuses the arming",
    )
    parser.add_argument(
        "--calibration",
        metavar="FILE",
        type=file_name,
        help="certificate to hold against the drop; it never refuses an arming (default: calibration.toml here, of an "
        "emulated robot calibration-emulated.toml)",
    )


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
    from tfsat_host.cli.maneuver_words import flight_words, maneuver_as_dict
    from tfsat_host.devices.arm_refusal import arm_refusal

    refuse_emulated(args, "arm", "The arming would be gone with the command.")
    with open_sequencer(args, out) as sequencer:
        stored = sequencer.read_back()
        status = sequencer.status()
        refusal = arm_refusal(status, stored, sequencer.settings().settings, args.joints_cdeg)
        if refusal is not None:
            raise refusal
        logger = look_at_logger(args, out)
        calibration = tell_calibration(args, logger.origin, out)
        out.note(flight_words(stored))
        out.note(_servo_warning(status.state))
        _demand_the_word(out)
        # After the question: the board heeds a report only while it is fresh, and a person may take a while.
        at_start_pose = None if args.joints_cdeg is None else sequencer.report_joints(args.joints_cdeg)
        sequencer.arm()
        state = _confirmed_state(sequencer, args)
        out.result(
            {
                "state": state.name.lower(),
                "recording": logger.recording,
                "calibration": calibration,
                "at_start_pose": at_start_pose,
                "maneuver": maneuver_as_dict(stored),
                "device": {"port": sequencer.port, **sequencer.identity.as_dict()},
            },
            "Armed: when both switches open, the maneuver runs. Pulling the cable does not disarm.",
        )
    return 0


def _servo_warning(state: SequencerState) -> str:
    """What the servos do at the word, before any release."""
    from tfsat_host.protocol.enums import SequencerState

    warning = "Hands, hair and cables out of the joints' way."
    if state == SequencerState.DONE:
        return (
            f"The servos hold the end pose now, each within {START_POSE_TOLERANCE_CDEG / 100:g} deg of its start pose "
            "(further away, ARM is refused). At the arming they take joints 1, 2 and 3 to 0 deg at their full speed, "
            f"before any release. {warning}"
        )
    return (
        "The servos are limp now. At the arming, before any release, they take joints 1, 2 and 3 to the start pose, "
        "0 deg: a joint that is elsewhere jumps there at the servo's full speed. Bring it to 0 deg first, by hand "
        f"or with tfsat-host jog. {warning}"
    )


def _demand_the_word(out: Output) -> None:
    if out.yes:
        return
    try:
        out.ask("Type ARM to arm: ", meaning=_MEANING, accept=("arm",))
    except KeyboardInterrupt:
        raise Interrupted(
            what="Interrupted.", meaning=_MEANING, next_step="Run the same command again when ready."
        ) from None


def _confirmed_state(sequencer: SequencerClient, args: argparse.Namespace) -> SequencerState:
    """ARMED, as the status says after the answer to ARM. Raises TfsatError for any other state."""
    from tfsat_host.protocol.enums import SequencerState

    state = sequencer.status().state
    if state == SequencerState.ARMED:
        return state
    meaning = {
        SequencerState.RUNNING: "Both switches opened right after the arming: the maneuver runs now. Stand clear.",
        SequencerState.DONE: "Both switches opened right after the arming: the maneuver was flown.",
        SequencerState.SAFE: "It was disarmed or lost its power: a drop now would fly nothing.",
    }.get(state, "A drop now would not fly the maneuver.")
    raise TfsatError(
        what=f"The sequencer took the arming, but now it is {state.name.lower()}.",
        meaning=meaning,
        next_step=f"tfsat-host status{device_option(args)} shows why; then disarm, and arm again.",
    )


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
                "emulated": args.emulated,
                "device": {"port": sequencer.port, **identity.as_dict()},
            },
            _EMULATED_DISARMED if args.emulated else _DISARMED,
        )
    return 0
