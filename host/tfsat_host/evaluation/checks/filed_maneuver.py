"""Whether the strokes that were flown can be those of the maneuver file: their times, and which joint moved.

The sequencer keeps its times to microseconds, so a stroke line that rises where the file has no stroke, or 20 ms off,
contradicts the file; a stroke that is missing, short, or goes the wrong way does not: servos and boards fail like that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.checks.check import Check, judged, not_possible
from tfsat_host.evaluation.clocks.clocks import RESONATOR_PPM, stroke_edges
from tfsat_host.evaluation.clocks.stroke_matching import MOST_EDGES
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.strokes.strokes_flown import FlownStroke, at_rest, change_of
from tfsat_host.sdlog import DropLog

FloatArray = NDArray[np.float64]

MANEUVER = "maneuver as filed"
OFF_TIME_S = 5e-3
"""Nothing on the board delays a stroke by so much; to this comes what clocks and a lost release edge leave open."""
OTHER_JOINT_RAD = np.deg2rad(5.0)
"""A joint that went so far in place of the one that was commanded was commanded itself."""
MOVED_RAD = np.deg2rad(1.0)


@dataclass(frozen=True, slots=True)
class _Rise:
    """One rise of the stroke line, and what moved then; joint 0: nothing did."""

    t_s: float
    joint: int
    size_rad: float
    std_rad: float

    def __str__(self) -> str:
        moved = "no joint"
        if self.joint:
            size, std = np.rad2deg([self.size_rad, self.std_rad])
            moved = f"joint {self.joint} by {size:+.2f} ± {max(std, 0.01):.2f} deg"
        return f"{self.t_s:.3f} s {moved}"


def maneuver_check(log: DropLog, motion: Motion, strokes: Sequence[FlownStroke]) -> Check:
    """Of one drop.

    Args:
        log: The recording.
        motion: Of the joints.
        strokes: As filed, and what became of each; none: no file says.
    """
    if not strokes:
        return not_possible(MANEUVER, "strokes", "No file says what was to be flown.")
    edges_s = stroke_edges(log)
    if len(edges_s) > MOST_EDGES:
        return not_possible(MANEUVER, "strokes", "The stroke line chatters: no stroke can be told from it.")
    wrong = _off_time(log, strokes) | _other_joint(motion, strokes)
    surplus = [t_s for t_s in edges_s if not any(abs(one.logged_s - t_s) < 1e-6 for one in strokes)]
    unseen = {one.number for one in strokes if not np.isfinite(one.logged_s)}
    if surplus and unseen:
        wrong |= unseen
    sentence = "Nothing says that another maneuver was flown than the file's."
    if wrong:
        flown = "; ".join(map(str, _rises(motion, edges_s)))
        filed = "; ".join(
            f"{one.scheduled_s:.3f} s joint {one.joint} by {np.rad2deg(one.commanded_rad):+.2f} deg"
            for one in strokes
        )
        sentence = (
            f"Another maneuver was flown than the file says. The file: {filed}. Flown, by the stroke line and the "
            f"angle sensors: {flown}. What is said of single strokes compares these two."
        )
    check = judged(MANEUVER, float(len(wrong)), 0.0, "strokes", sentence)
    return check.caused_by(
        "the file is not the one that was uploaded last, or the cables of two servos are exchanged",
        "Evaluate again with the file that was uploaded: --maneuver FILE",
    )


def _off_time(log: DropLog, strokes: Sequence[FlownStroke]) -> set[int]:
    """Numbers of strokes whose line rose where no clock would have it."""
    release_s = 0.0 if log.release is None else (log.release.latest_us - log.release.earliest_us) / 1e6
    return {
        one.number
        for one in strokes
        if abs(one.logged_s - one.scheduled_s)
        > OFF_TIME_S + RESONATOR_PPM * 1e-6 * one.scheduled_s + release_s
    }


def _other_joint(motion: Motion, strokes: Sequence[FlownStroke]) -> set[int]:
    """Numbers of strokes at which another joint moved than the one that was to."""
    begins = [one.logged_s if np.isfinite(one.logged_s) else one.scheduled_s for one in strokes]
    untils = [*begins[1:], float(motion.t_s[-1])]
    return {
        one.number
        for one, begin_s, until_s in zip(strokes, begins, untils, strict=True)
        if not one.moved
        and np.isfinite(one.size_rad)
        and _mover(motion, begin_s, until_s, OTHER_JOINT_RAD) not in (0, one.joint)
    }


def _rises(motion: Motion, edges_s: FloatArray) -> list[_Rise]:
    """Each with the joint that moved most before the next, and how far that went until it moved again or to the end."""
    t, end_s = motion.t_s, float(motion.t_s[-1])
    untils_s = [*edges_s[1:].tolist(), end_s]
    movers = [_mover(motion, t_s, until_s) for t_s, until_s in zip(edges_s.tolist(), untils_s, strict=True)]
    found = []
    for i, (t_s, joint) in enumerate(zip(edges_s.tolist(), movers, strict=True)):
        again = (k for k in range(i + 1, len(movers)) if movers[k] == joint)
        before, after = (
            at_rest(t, t_s),
            at_rest(t, edges_s[k] if (k := next(again, None)) is not None else end_s),
        )
        if not joint or before is None or after is None:
            found.append(_Rise(t_s, 0, 0.0, 0.0))
        else:
            found.append(_Rise(t_s, joint, *change_of(motion.joints[joint - 1], before, after)))
    return found


def _mover(motion: Motion, from_s: float, until_s: float, least_rad: float = MOVED_RAD) -> int:
    """The joint that moved most between two times; 0: none did by more than so much."""
    before, after = at_rest(motion.t_s, from_s), at_rest(motion.t_s, until_s)
    if before is None or after is None:
        return 0
    changes = [change_of(joint, before, after) for joint in motion.joints]
    size, std = max(changes, key=lambda change: abs(change[0]))
    moved = abs(size) > max(3.0 * std, least_rad)
    return 1 + [change[0] for change in changes].index(size) if moved else 0
