"""Joints between their strokes: drift, and motion that nothing commanded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.strokes import ARRIVED_S, EARLY_S, WINDOW, FlownStroke, at_rest, change_of

UNEXPECTED_RAD = np.deg2rad(1.0)
"""A standing joint that was so far from where it stood has moved."""
CREPT_STDS = 3.0
CREPT_RAD = np.deg2rad(0.05)
"""A drift above so many standard deviations and above this is creep."""


@dataclass(frozen=True, slots=True)
class JointRest:
    """One joint between two of its strokes, or before, after or without them.

    Attributes:
        joint: 1 to 3.
        from_s: After the release.
        until_s: After the release.
        drift_rad: Change of its angle from the first samples to the last.
        drift_std_rad: Its standard deviation.
        greatest_rad: Where it was farthest from its first samples, signed.
        greatest_at_s: When.
    """

    joint: int
    from_s: float
    until_s: float
    drift_rad: float
    drift_std_rad: float
    greatest_rad: float
    greatest_at_s: float

    @property
    def unexpected(self) -> bool:
        """It moved although nothing commanded it."""
        return bool(abs(self.greatest_rad) > UNEXPECTED_RAD)

    @property
    def crept(self) -> bool:
        """It drifted by more than the sensors' errors explain, but made no motion of its own."""
        significant = abs(self.drift_rad) > max(CREPT_STDS * self.drift_std_rad, CREPT_RAD)
        return bool(significant) and not self.unexpected

    @property
    def remark(self) -> str:
        """What is wrong, in words; empty if nothing is."""
        span = f"between {self.from_s:.2f} and {self.until_s:.2f} s"
        if self.unexpected:
            return (
                f"Joint {self.joint} moved by {np.rad2deg(self.greatest_rad):+.1f} deg {span}, "
                "where nothing commanded it."
            )
        if self.crept:
            drift, std = np.rad2deg([self.drift_rad, self.drift_std_rad])
            return f"Joint {self.joint} crept by {drift:+.2f} deg (± {std:.2f} deg) {span}."
        return ""


def standing_joints(
    motion: Motion, strokes: Sequence[FlownStroke], joints: Sequence[int] = (1, 2, 3)
) -> tuple[JointRest, ...]:
    """Measure some joints wherever it should stand long enough to tell, ordered by joint and time."""
    rests = []
    for joint in joints:
        from_s = 0.0
        for stroke in (s for s in strokes if s.joint == joint):
            begin_s = stroke.logged_s if np.isfinite(stroke.logged_s) else stroke.scheduled_s
            # The rest ends with the command or the motion, whichever came first.
            rests.append(_find_rest(motion, joint, from_s, min(begin_s, _started_s(stroke))))
            # On its way to the end of the data: infinity leaves no samples for the rest behind it.
            if stroke.unfinished:
                from_s = float("inf")
                break
            # Let the servo settle; a stroke that was not flown counts as over at its command.
            from_s = (stroke.end_s if stroke.moved else begin_s) + ARRIVED_S
        rests.append(_find_rest(motion, joint, from_s, float(motion.t_s[-1])))
    return tuple(standing for standing in rests if standing is not None)


def _started_s(stroke: FlownStroke) -> float:
    """Return a stroke's start, at most `EARLY_S` before its command; infinite if it was not flown."""
    early = stroke.scheduled_s - EARLY_S
    return max(stroke.start_s, early) if stroke.moved else float("inf")


def _find_rest(motion: Motion, joint: int, from_s: float, until_s: float) -> JointRest | None:
    t, joint_motion = motion.t_s, motion.joints[joint - 1]
    first = int(np.searchsorted(t, from_s))
    last = at_rest(t, min(until_s, float(t[-1])))
    # The windows of the two means must not overlap, or they share their noise.
    if last is None or last.start < first + WINDOW:
        return None
    begin = slice(first, first + WINDOW)
    drift, std = change_of(joint_motion, begin, last)
    off = joint_motion.angle_rad[first : last.stop] - joint_motion.angle_rad[begin].mean()
    worst = int(np.abs(off).argmax())
    return JointRest(
        joint,
        float(t[first]),
        float(t[last.stop - 1]),
        drift,
        std,
        float(off[worst]),
        float(t[first + worst]),
    )
