"""Arming a sequencer: what blocks it, what a person has to know first, the word, and the proof.

The logger and the certificate are looked at as well: whether the drop will be on the logger's card refuses, unless
that is accepted; objections to the calibration do not, since a drop without one can be evaluated with one that
follows, a drop that is not flown cannot.
"""

from __future__ import annotations

import os
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from tfsat_host.devices.arm_refusal import arm_refusal
from tfsat_host.devices.serial_ports import PortError, find_port, port_variable
from tfsat_host.errors import Interrupted, TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import Listener
from tfsat_host.present.stored_settings import flight_words
from tfsat_host.protocol.enums import LoggerState, SequencerState
from tfsat_host.protocol.limits import START_POSE_TOLERANCE_CDEG
from tfsat_host.run.files import find_certificate
from tfsat_host.run.held_maneuver import HeldManeuver, note_held

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tfsat_host.calibration.steps.evidence import Origin
    from tfsat_host.devices.board_identity import Device
    from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver
    from tfsat_host.run.certificate_check import CertificateState

_CLEAR = "Keep hands, hair and cables clear of the joints."
_SINCE_ARMING = {
    SequencerState.RUNNING: "Both switches opened right after the arming: the maneuver runs now. Stand clear.",
    SequencerState.DONE: "Both switches opened right after the arming: the maneuver was flown.",
    SequencerState.SAFE: "It was disarmed or lost its power: a drop now would fly nothing.",
}


class Operator(Listener, Protocol):
    """Whoever arms: reads, and gives the word."""

    @property
    def yes(self) -> bool:
        """Every question is answered with yes: none is asked."""

    def ask(self, prompt: str, *, meaning: str, accept: Sequence[str]) -> None:
        """Returns where one of `accept` was typed. Raises TfsatError where not."""


@dataclass(frozen=True, slots=True)
class ArmedSequencer:
    """A sequencer that says that it is armed.

    Attributes:
        maneuver: What will fly.
        recording: Whether the drop will be on the logger's card; None: it was not asked, or did not say.
        calibration: State of the certificate; None without one.
        at_start_pose: Whether the measured joints are; None: not measured.
        device: The sequencer and its port.
    """

    maneuver: StoredManeuver
    recording: bool | None
    calibration: CertificateState | None
    at_start_pose: bool | None
    device: Device


def arm(
    sequencer: SequencerClient,
    operator: Operator,
    *,
    joints_cdeg: Sequence[int] | None = None,
    sequencer_named: bool = False,
    unrecorded: bool = False,
    certificate: Path | None = None,
) -> ArmedSequencer:
    """Arms once nothing blocks it and the operator has given the word.

    Args:
        sequencer: The board.
        operator: Hears what has to be known before the word.
        joints_cdeg: Measured angles of joints 1 to 3, 0.01 deg: a joint off its start pose refuses.
        sequencer_named: Its port was named: no others are searched, and only the environment names a logger.
        unrecorded: Arm even if the logger's recording does not reach its card.
        certificate: To hold against the drop; None: the one that lies here, if any.

    Raises:
        BoardRefusal: the board would refuse, or refused.
        NotOnCard: a recording was started and does not reach its card.
        TfsatError: the operator did not give the word; or the board took it, and is not armed now.
    """
    maneuver, status = sequencer.read_back(), sequencer.status()
    # Predict the board's refusal, so that nobody types the word in vain.
    refusal = arm_refusal(status, maneuver, sequencer.settings().settings, joints_cdeg)
    if refusal is not None:
        raise refusal
    # While the sequencer is still safe: a drop that is not recorded leaves no data.
    recording, origin, session = _logger(
        operator, maneuver.crc, sequencer_named=sequencer_named, unrecorded=unrecorded
    )
    calibration = _calibration(certificate, origin, operator)
    operator.note(flight_words(maneuver))
    operator.note(_servo_warning(status.state))
    _demand_the_word(operator)
    # After the question: the board heeds a report only while it is fresh, and a person may take a while.
    at_start_pose = None if joints_cdeg is None else sequencer.report_joints(joints_cdeg)
    sequencer.arm()
    # The acknowledgement is no proof: the switches may have opened, or the power gone, since.
    state = sequencer.status().state
    if state != SequencerState.ARMED:
        raise TfsatError(
            what=f"The sequencer took the arming, but now it is {state.name.lower()}.",
            meaning=_SINCE_ARMING.get(state, "A drop now would not fly the maneuver."),
            next_step=Advice(NextStep("status"), " shows why; then disarm, and arm again."),
        )
    # File what is armed under the session being recorded, for the evaluation to compare with.
    if session is not None:
        held_maneuver = HeldManeuver(maneuver, sequencer.identity.serial, has_flown=False)
        note_held(held_maneuver, session, "arm", operator.note)
    return ArmedSequencer(maneuver, recording, calibration, at_start_pose, sequencer.device())


def _demand_the_word(operator: Operator) -> None:
    if operator.yes:
        return
    meaning = "Nothing was armed."
    try:
        operator.ask("Type ARM to arm: ", meaning=meaning, accept=("arm",))
    except KeyboardInterrupt:
        again = "Run the same command again when ready."
        raise Interrupted(what="Interrupted.", meaning=meaning, next_step=again) from None


def _servo_warning(state: SequencerState) -> str:
    """Format the warning of what the servos do when armed, before any release."""
    if state == SequencerState.DONE:
        return (
            f"The servos hold the end pose now, each within {START_POSE_TOLERANCE_CDEG / 100:g} deg of its start pose "
            "(further away, ARM is refused). At the arming they take joints 1, 2 and 3 to 0 deg at their full speed, "
            f"before any release. {_CLEAR}"
        )
    return Advice(
        "The servos are limp now. At the arming, before any release, they take joints 1, 2 and 3 to the start pose, "
        "0 deg: a joint that is elsewhere jumps there at the servo's full speed. Bring it to 0 deg first, by hand "
        "or with ",
        NextStep("jog"),
        f". {_CLEAR}",
    )


def _logger(
    operator: Operator, maneuver_crc: int, *, sequencer_named: bool, unrecorded: bool
) -> tuple[bool | None, Origin | None, int | None]:
    """Query the logger for its recording state, the origin of its sensors and the session it records.

    None where it was not asked or did not answer; the session is None, too, if it records nothing.

    Raises NotOnCard: a recording was started and does not reach its card.
    """
    from tfsat_host.devices.logger import LoggerClient, stalled_recording
    from tfsat_host.devices.transport import SerialTransport
    from tfsat_host.preflight.preflight_evidence import origin_of_logger

    if sequencer_named and not os.environ.get(port_variable("logger")):
        operator.warn(
            f"The logger was not asked whether it records: --port names the sequencer only. A drop that is not "
            f"recorded leaves no data. To have it asked, set {port_variable('logger')}=PORT"
        )
        return None, None, None
    try:
        port = find_port("logger")
    except PortError as error:
        operator.warn(
            f"The logger was not asked whether it records: a drop that is not recorded leaves no data. {error.what}"
        )
        return None, None, None
    try:
        with closing(SerialTransport(port)) as transport:
            logger = LoggerClient.connect(transport)
            status = logger.status()
            origin = origin_of_logger(logger.identity, status.who_am_i)
            # Watch the card take blocks: for up to 15 s the state alone does not show that it failed.
            danger = stalled_recording(logger, status)
    except TfsatError as error:
        # A silent logger does not refuse: the operator arms with the warning, or does not.
        operator.warn(f"The logger did not say whether it records. {error.what}")
        return None, None, None
    recording = danger is None and status.state == LoggerState.RECORDING
    # A recording was started, so data are wanted: one that does not reach its card refuses.
    if danger is not None and not unrecorded:
        unrecorded_arming = NextStep("arm", ("--unrecorded",))
        raise danger.with_words(
            meaning=f"{danger.meaning} Nothing was armed.",
            next_step=Advice(danger.next_step, "\nTo arm all the same: ", unrecorded_arming),
        )
    if danger is not None:
        operator.warn(f"{danger.what} {danger.meaning}")
    elif not recording:
        operator.warn(
            Advice(
                f"The logger at {port} is not recording ({status.state.name.lower()}): a drop now would leave no data. "
                "Start it: ",
                NextStep("record start"),
            )
        )
    elif status.maneuver_known and status.maneuver_crc != maneuver_crc:
        operator.warn(
            Advice(
                f"The recording's header names maneuver {status.maneuver_crc:04x}, the sequencer holds "
                f"{maneuver_crc:04x}: the card alone would tell of the wrong one. A recording that names it: ",
                NextStep("record stop"),
                ", then ",
                NextStep("record start"),
            )
        )
    return recording, origin, status.session if recording else None


def _calibration(named: Path | None, origin: Origin | None, operator: Operator) -> CertificateState | None:
    """Report the objections to the calibration, and return its state; None: there is none.

    Called before the servos get pulses: afterwards the sensors may be different ones. The certificate is the
    `named` one, or the default one in the current folder (an emulated robot has its own). `origin` is None if
    the logger was not asked.
    """
    file = find_certificate(named, Path(), emulated=origin is not None and origin.emulated)
    if file is None:
        return None
    from tfsat_host.calibration.certificate.file import read_calibration
    from tfsat_host.run.certificate_check import check_certificate, report_certificate

    # No objection refuses: a calibration may follow the drop, a drop that is not flown cannot.
    state = report_certificate(
        lambda: check_certificate(read_calibration(file), origin, file),
        file,
        operator,
        "" if origin is None else "drop",
    )
    if origin is None:
        operator.note(f"Calibration {file}: the logger was not asked whether it is of this robot's sensors.")
    return state
