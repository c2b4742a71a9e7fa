"""What a motion could not use, and what stood in for it, in sentences."""

from __future__ import annotations

from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.sdlog.summary import single_misses


def notes_of(motion: Motion) -> list[str]:
    """Of one drop."""
    notes = []
    fall = motion.samples.fall
    answered = motion.samples.answered[fall]
    for body, bridged in enumerate((~answered).sum(axis=0), 1):
        if not single_misses(answered[:, body - 1]):
            share = 100.0 * bridged / fall.sum()
            notes.append(
                f"The gyro of body {body} lacks {bridged} of {int(fall.sum())} samples ({share:.0f} %): they are "
                "bridged from its neighbours and the angle sensors, and its uncertainty is larger."
            )
    notes += [
        f"No angle sensor of joint {joint.joint} answered: its angle is counted from where its servo starts."
        for joint in motion.joints
        if not joint.sensed
    ]
    notes += [
        f"Angle sensor {sensed.distrusted + 1} of joint {sensed.sensors.joint} contradicts the other one, which agrees "
        "better with the gyros, or with where the servo held the joint: it is not used."
        for sensed in motion.fusion.joints
        if sensed.distrusted is not None
    ]
    if motion.lag.implausible_s is not None:
        notes.append(
            f"The strokes tell a delay of {1e3 * motion.lag.implausible_s:.1f} ms for the gyros, which no chip has "
            "with this low-pass: the data sheet's is taken off instead. The gyros contradict the angle sensors."
        )
    if motion.contradicted:
        notes.append(
            "The sensors would have the gyros farther off than their calibration allows: one of them is wrong, and "
            "none was corrected by another."
        )
    if motion.lag.implausible_s is None and not motion.lag.measured:
        notes.append("No joint moved far enough to measure the gyros' delay: the data sheet's is taken off.")
    return notes
