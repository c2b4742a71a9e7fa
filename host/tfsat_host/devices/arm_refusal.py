"""What the sequencer would answer to ARM, known before a person is asked to type the word."""

from __future__ import annotations

from collections.abc import Sequence

from tfsat_host.devices.board_errors import BoardError, board_error
from tfsat_host.devices.sequencer import StoredManeuver
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.enums import ErrorCode, Origin, SequencerState
from tfsat_host.protocol.limits import START_POSE_TOLERANCE_CDEG
from tfsat_host.protocol.messages import ArmRequest, ErrorReply, SequencerStatusReply
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.servo_settings import ServoSettings, find_misfit

STORES = {"maneuver": "the stored maneuver", "settings": "the servo settings"}
"""By the order of their bits."""
_WORDS = {
    ErrorCode.STORE_DAMAGED: ("is", "are", "damaged in the board's EEPROM"),
    ErrorCode.UPLOAD_INTERRUPTED: ("was", "were", "to be replaced by an upload that was never completed"),
    ErrorCode.STORE_OLD_LAYOUT: ("was", "were", "stored by an earlier firmware, in another layout"),
}


def arm_refusal(
    status: SequencerStatusReply,
    maneuver: StoredManeuver,
    settings: ServoSettings,
    joints_cdeg: Sequence[int] | None = None,
) -> BoardError | None:
    """Predict the board's refusal of ARM in this state, in its order of reasons; None if it would accept.

    `joints_cdeg`: measured angles of joints 1 to 3, 0.01 deg, if they were measured. A report that the board
    has from another host is not known here.
    """
    # The board's own order of checks, so that host and board give the same reason.
    if status.state == SequencerState.FAULT:
        return fault_latched(status.fault)
    if status.state not in (SequencerState.SAFE, SequencerState.DONE):
        return _refusal(ErrorCode.WRONG_STATE)
    if status.stores_damaged:
        return _refusal(first_defect(status.stores_damaged), describe_defects(status.stores_damaged))
    if maneuver.origin == Origin.FACTORY:
        return _refusal(ErrorCode.NO_MANEUVER)
    misfit = find_misfit(maneuver.timed_strokes, settings)
    if misfit is not None:
        return _refusal(misfit.code, f"The stored maneuver does not fit: {misfit.words}.")
    if status.switches_open:
        return _refusal(ErrorCode.SWITCH_OPEN, detail=status.switches_open)
    # After a run the servos hold their last angles: no hand moves a joint before they are let go.
    held_joints = (
        joints_off_start_pose(status.joint_angle_cdeg) if status.state == SequencerState.DONE else []
    )
    if held_joints:
        return _not_at_start_pose(
            held_joints,
            "is held",
            Advice(
                NextStep("disarm"),
                " lets the servos go. Then bring the joint to 0 deg by hand or with ",
                NextStep("jog"),
                ", and arm again.",
            ),
        )
    away = joints_off_start_pose(joints_cdeg or ())
    return _not_at_start_pose(away, "is") if away else None


def joints_off_start_pose(joints_cdeg: Sequence[int]) -> list[tuple[int, int]]:
    """(joint, angle_cdeg) of the joints that ARM would not call at their start pose; joint 1 comes first."""
    return [
        (joint, angle_cdeg)
        for joint, angle_cdeg in enumerate(joints_cdeg, 1)
        if abs(angle_cdeg) > START_POSE_TOLERANCE_CDEG
    ]


def _refusal(
    code: ErrorCode, what: str | None = None, next_step: str | None = None, *, detail: int = -1
) -> BoardError:
    """Build the board's own refusal, reworded if the host knows more than the board would say."""
    return board_error(ErrorReply(ArmRequest.TYPE, code, detail)).with_words(what=what, next_step=next_step)


def _not_at_start_pose(
    away: Sequence[tuple[int, int]], verb: str, next_step: str | None = None
) -> BoardError:
    where = ", ".join(f"joint {joint} {verb} at {angle_cdeg / 100:g} deg" for joint, angle_cdeg in away)
    allowed = f"0 ± {START_POSE_TOLERANCE_CDEG / 100:g} deg"
    return _refusal(ErrorCode.NOT_AT_START_POSE, f"The start pose is {allowed}, but {where}.", next_step)


def fault_latched(fault: ErrorCode) -> BoardError:
    """Build the board's refusal while it has latched a fault."""
    what, _, cure = REMEDIES[fault]
    return _refusal(
        ErrorCode.FAULT_LATCHED,
        f"A fault is latched: {what[:1].lower()}{what[1:]}",
        Advice(cure, " Only ", NextStep("disarm"), " clears the fault."),
    )


def store_defects(stores_damaged: int) -> dict[str, ErrorCode]:
    """Return why ARM is refused for each store, by its name in STORES; NONE for a sound store."""
    defects = dict.fromkeys(STORES, ErrorCode.NONE)
    # Two bits a kind of defect, one for each store; of several kinds the last in _WORDS is told.
    for pair, code in enumerate(_WORDS):
        for index, store in enumerate(STORES):
            if stores_damaged >> (2 * pair + index) & 1:
                defects[store] = code
    return defects


def first_defect(stores_damaged: int) -> ErrorCode:
    """Return the reason that the board gives, NONE without one; it looks at the maneuver first."""
    return next((code for code in store_defects(stores_damaged).values() if code), ErrorCode.NONE)


def describe_defects(stores_damaged: int) -> str:
    """Describe each kind of defect in a sentence."""
    defects = store_defects(stores_damaged)
    sentences = []
    for code in dict.fromkeys(code for code in defects.values() if code):
        names = [STORES[store] for store, defect in defects.items() if defect == code]
        singular, plural, what = _WORDS[code]
        verb = plural if names != [STORES["maneuver"]] else singular
        subject = " and ".join(names)
        sentences.append(f"{subject[:1].upper()}{subject[1:]} {verb} {what}.")
    return " ".join(sentences)
