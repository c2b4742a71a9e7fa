"""What the sequencer would answer to ARM, told before a person is asked to type the word."""

from __future__ import annotations

from collections.abc import Sequence

from tfsat_host.devices.board_errors import BoardError, board_error
from tfsat_host.devices.maneuver_transfer import StoredManeuver
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.limits import START_POSE_TOLERANCE_CDEG
from tfsat_host.protocol.messages import ArmRequest, ErrorReply, SequencerStatusReply
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.servo_settings import ServoSettings, find_misfit


def arm_refusal(
    status: SequencerStatusReply,
    maneuver: StoredManeuver,
    settings: ServoSettings,
    joints_cdeg: Sequence[int] | None = None,
) -> BoardError | None:
    """What the board would answer to ARM in this state, in its order of reasons; None: nothing against it.

    Args:
        status: The board's state now.
        maneuver: What would fly.
        settings: The servo settings in force.
        joints_cdeg: Measured angles of joints 1 to 3, 0.01 deg, if somebody measured them. A report that
            the board has from somebody else is not seen here.
    """
    if status.state == SequencerState.FAULT:
        return _refusal(ErrorCode.FAULT_LATCHED, f"A fault is latched: {_words(status.fault)}")
    if status.state not in (SequencerState.SAFE, SequencerState.DONE):
        return _refusal(ErrorCode.WRONG_STATE)
    misfit = find_misfit(maneuver.moves, settings)
    if misfit is not None:
        return _refusal(ErrorCode.SETTINGS_DO_NOT_FIT, f"The stored maneuver does not fit: {misfit.words}.")
    if status.switches_open:
        return _refusal(ErrorCode.SWITCH_OPEN)
    away = joints_off_start_pose(joints_cdeg or ())
    if away:
        where = ", ".join(f"joint {joint} is at {angle_cdeg / 100:g} deg" for joint, angle_cdeg in away)
        allowed = f"0 ± {START_POSE_TOLERANCE_CDEG / 100:g} deg"
        return _refusal(ErrorCode.NOT_AT_START_POSE, f"The start pose is {allowed}, but {where}.")
    return None


def joints_off_start_pose(joints_cdeg: Sequence[int]) -> list[tuple[int, int]]:
    """(joint, angle_cdeg) of the joints that ARM would not call at their start pose; joint 1 comes first."""
    return [
        (joint, angle_cdeg)
        for joint, angle_cdeg in enumerate(joints_cdeg, 1)
        if abs(angle_cdeg) > START_POSE_TOLERANCE_CDEG
    ]


def _refusal(code: ErrorCode, what: str | None = None) -> BoardError:
    """The board's own refusal, with `what` where the host knows more than the board would say."""
    error = board_error(ErrorReply(ArmRequest.TYPE, code, -1))
    if what is not None:
        error.what = what
    return error


def _words(fault: ErrorCode) -> str:
    what = REMEDIES[fault][0]
    return what[:1].lower() + what[1:]
