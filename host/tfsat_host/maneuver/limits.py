"""What bounds a maneuver: what the sequencer takes, or, in a study without it, what a robot can do."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.protocol.limits import (
    FALL_US,
    JOINT_ANGLE_MAX_CDEG,
    JOINT_ANGLE_MIN_CDEG,
    JOINT_COUNT,
    MAX_STROKES,
    PAUSE_MIN_US,
    SPEED_MAX_CDEG_S,
    SPEED_MIN_CDEG_S,
)


@dataclass(frozen=True, slots=True)
class Limits:
    """What a maneuver is checked against.

    Attributes:
        joint_ranges_cdeg: Least and greatest angle of each joint, 0.01 deg.
        start_cdeg: Angle of each joint at the start, 0.01 deg.
        speed_range_cdeg_s: Least and greatest joint speed, 0.01 deg/s.
        strokes_min: Fewest strokes.
        strokes_max: Most strokes; None: as many as one likes.
        pause_min_us: Earliest start of a stroke after the release.
        end_max_us: Latest end of a stroke after the release; None: whenever.
        numbering: How joints are numbered; half a sentence for errors.
    """

    joint_ranges_cdeg: tuple[tuple[int, int], ...]
    start_cdeg: tuple[int, ...]
    speed_range_cdeg_s: tuple[int, int]
    strokes_min: int
    strokes_max: int | None
    pause_min_us: int
    end_max_us: int | None
    numbering: str

    @property
    def joint_count(self) -> int:
        """Number of joints."""
        return len(self.joint_ranges_cdeg)


SEQUENCER = Limits(
    joint_ranges_cdeg=((JOINT_ANGLE_MIN_CDEG, JOINT_ANGLE_MAX_CDEG),) * JOINT_COUNT,
    start_cdeg=(0,) * JOINT_COUNT,
    speed_range_cdeg_s=(SPEED_MIN_CDEG_S, SPEED_MAX_CDEG_S),
    strokes_min=1,
    strokes_max=MAX_STROKES,
    pause_min_us=PAUSE_MIN_US,
    end_max_us=FALL_US,
    numbering="joint i joins body i and body i+1",
)
"""The numbers that the board holds, from the protocol specification."""
