"""The motions of the misalignment calibration (paper, tab. misal)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MotionPattern:
    """One joint is turned by hand; the bodies on one side move, the others are held on the bench.

    Attributes:
        joint: 1 to 3.
        moved: Bodies whose gyros see the motion.
        held: Bodies fixed on the bench.
    """

    joint: int
    moved: tuple[int, ...]
    held: tuple[int, ...]


# Where the paper moves bodies 2 and 3 about joint 1, body 4 hangs on body 3 and moves along.
PATTERNS = (
    MotionPattern(1, moved=(1,), held=(2, 3, 4)),
    MotionPattern(1, moved=(2, 3), held=(1,)),
    MotionPattern(2, moved=(1, 2), held=(3, 4)),
    MotionPattern(2, moved=(3, 4), held=(1, 2)),
    MotionPattern(3, moved=(4,), held=(1, 2, 3)),
)


def patterns_of_joint(joint: int) -> tuple[MotionPattern, ...]:
    """The paper's patterns for one joint."""
    return tuple(pattern for pattern in PATTERNS if pattern.joint == joint)
