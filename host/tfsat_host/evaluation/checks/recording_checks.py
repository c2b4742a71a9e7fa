"""What the recording lacks, and whether it is of the maneuver in the file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet
from itertools import combinations, pairwise

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.evaluation.checks.check import Check, Kind
from tfsat_host.evaluation.checks.consistency import sensor_name
from tfsat_host.evaluation.checks.momentum_checks import QUIET_RAD_S
from tfsat_host.evaluation.checks.stated_errors import MAX_HOLE_S
from tfsat_host.evaluation.clocks import MAX_EDGES, RESONATOR_PPM, stroke_edges
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.strokes import ARRIVED_S, FlownStroke, at_rest, change_of
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import ignore_absent
from tfsat_host.sdlog import DropLog

MISSING_SHARE = 0.01
"""Of a sensor's readings; so many are bridged by its neighbours without a trace in any result."""

SERVO_DEG_S2 = 4000.0
"""As a servo speeds up; over a hole of h the trapezoid then misses this times h^2 / 12."""
_NEXT_S = 1e-4
"""A sample so near to the end of a hole is the one that ends it."""


def completeness_checks(log: DropLog, motion: Motion, model: RobotModel) -> Iterator[Check]:
    """Check that the recording is complete from the release to just before the landing."""
    fall = (log.t_s >= 0.0) & (log.t_s <= motion.samples.until_s)
    yield _check_full_scale(log, fall)
    yield _check_answers(log, fall, model)
    yield _holes(log, fall, motion)


def _check_full_scale(log: DropLog, fall: BoolArray) -> Check:
    count = (log.clipped & log.imu_valid)[fall].sum(axis=0)
    bodies = _numbers(count > 0)
    sentence = "No IMU was at full scale in the fall."
    if count.any():
        sentence = (
            f"{int(count.sum())} readings of the IMU of body {bodies} were at full scale and were not used."
        )
    return _FULL_SCALE.judge(float(count.sum()), 0.0, sentence).caused_by(
        f"a knock, or a range that is too small, at the IMU of body {bodies}",
        Advice("Compare the ranges with the strokes' rates: ", NextStep("logger-settings")),
    )


def _check_answers(log: DropLog, fall: BoolArray, model: RobotModel) -> Check:
    log = ignore_absent(log, model, missed=False)
    # IMUs first, then angle sensors: the worst column tells which of them it is.
    valid = np.concatenate([log.imu_valid[fall], log.angle_valid[fall]], axis=1)
    missing = 100.0 * (1.0 - valid.mean(axis=0))
    worst = int(missing.argmax())
    imus = log.imu_valid.shape[1]
    name, bridged = f"IMU of body {worst + 1}", "its neighbours and the angle sensors bridge it"
    if worst >= imus:
        joint = model.angle_sensors[worst - imus].joint
        pair = sensor_columns(model, joint + 1)
        name = sensor_name(joint, pair.index(worst - imus))
        silent = ~log.angle_valid[fall][:, pair].any(axis=1)
        bridged = "the joint's other sensor and the gyros go on without it"
        if silent.any():
            bridged = f"in {100.0 * silent.mean():.1f} % neither of the joint's did, and its gyros alone tell its angle"
    others = int((missing > 100.0 * MISSING_SHARE).sum()) - 1
    others_text = f" {others} more did not answer in over {100.0 * MISSING_SHARE:g} %." if others > 0 else ""
    sentence = "All sensors answered throughout the fall."
    if missing[worst] > 0.0:
        sentence = f"The {name} did not answer in {missing[worst]:.1f} % of the fall; {bridged}.{others_text}"
    check = _ANSWERS.judge(float(missing[worst]), 100.0 * MISSING_SHARE, sentence)
    watch = Advice("Watch the sensor live: ", NextStep("monitor"))
    return check.caused_by(f"{name}: cable, connector or bus", watch)


def _holes(log: DropLog, fall: BoolArray, motion: Motion) -> Check:
    """Times without any gyro: a sample is lost, or none of the IMUs answered to it."""
    samples = motion.samples
    edges = np.concatenate([[0.0], samples.t_s[samples.fall], [samples.until_s]])
    holes = np.diff(edges)
    worst = int(holes.argmax())
    hole_s, from_s = float(holes[worst]), float(edges[worst])
    sentence = f"The longest time without any gyro is {1e3 * hole_s:.1f} ms, at {from_s:.2f} s."
    if hole_s > MAX_HOLE_S:
        sentence += f" {_cost(motion, from_s, from_s + hole_s)}"
    check = _HOLES.judge(1e3 * hole_s, 1e3 * MAX_HOLE_S, sentence)
    # Samples inside the hole that no IMU answered to: the logger ran.
    within = fall & (log.t_s > from_s + _NEXT_S) & (log.t_s < from_s + hole_s - _NEXT_S)
    if within.any():
        return check.caused_by(
            "no IMU answered although the logger sampled: what all IMUs share, their bus or their supply",
            Advice("Watch the IMUs live: ", NextStep("monitor")),
        )
    if any(gap.samples for gap in log.gaps):
        return check.caused_by(
            "blocks of the recording are lost",
            Advice("Fetch the recording's second copy: ", NextStep("log fetch")),
        )
    return check.caused_by("the logger took its samples late", Advice(NextStep("log list")))


def _cost(motion: Motion, from_s: float, until_s: float) -> str:
    """Format the effect that a hole in the recording has on the results."""
    ends = np.searchsorted(motion.t_s, [from_s, until_s]).clip(0, len(motion.t_s) - 1)
    rates = np.abs(motion.fused.joint_rate_rad_s[ends]).max(axis=0)
    turning = rates > QUIET_RAD_S
    if not turning.any():
        return "No joint moved at its ends: rates are taken to have changed evenly in it."
    # The trapezoid's error over one step, by the servo's acceleration.
    off_deg = SERVO_DEG_S2 * (until_s - from_s) ** 2 / 12.0
    return (
        f"Joint {_numbers(turning)} moved at its ends: a servo that sped up or slowed down in it leaves its angle, "
        f"and every attitude from then on, off by up to {off_deg:.2f} deg where no angle sensor tells it."
    )


def _numbers(chosen: BoolArray) -> str:
    return ", ".join(str(b + 1) for b in np.flatnonzero(chosen))


MANEUVER = Kind("maneuver as filed", "strokes", ())
_FULL_SCALE = Kind("full scale in the fall", "readings", ())
_ANSWERS = Kind("answers in the fall", "%", ())
_HOLES = Kind("holes in the fall", "ms", ())
OFF_TIME_S = 5e-3
"""Nothing on the board delays a stroke by so much; to this comes what clocks and a lost release edge leave open."""
OTHER_JOINT_RAD = np.deg2rad(5.0)
"""A joint that went so far in place of the one that was commanded was commanded itself."""
MOVED_RAD = np.deg2rad(1.0)


def maneuver_check(log: DropLog, motion: Motion, strokes: Sequence[FlownStroke]) -> Check:
    """Check that the maneuver flown is the one in the file; `strokes` are as filed, empty if no file is known."""
    if not strokes:
        return MANEUVER.not_possible("No file says what was to be flown.")
    edges_s = stroke_edges(log)
    if len(edges_s) > MAX_EDGES:
        return MANEUVER.not_possible("The stroke line chatters: no stroke can be identified by it.")
    wrong = _off_time(log, strokes) | _other_joint(motion, strokes)
    # A rise that no stroke accounts for, and a stroke without a rise: another schedule was flown.
    surplus = [t_s for t_s in edges_s if not any(abs(stroke.logged_s - t_s) < 1e-6 for stroke in strokes)]
    unseen = {stroke.number for stroke in strokes if not np.isfinite(stroke.logged_s)}
    if surplus and unseen:
        wrong |= unseen
    sentence = "Stroke line and joints agree with the file."
    if wrong:
        # Of joints that move together no size is told apart by the line's rises alone.
        rises = "the line rose at " + ", ".join(f"{t_s:.3f}" for t_s in edges_s) + " s"
        flown_text = rises if _overlap(strokes) else "; ".join(_describe_rises(motion, edges_s))
        filed = "; ".join(
            f"{stroke.scheduled_s:.3f} s joint {stroke.joint} by {np.rad2deg(stroke.commanded_rad):+.2f} deg"
            for stroke in strokes
        )
        sentence = (
            f"Another maneuver was flown than the file says. The file: {filed}. Flown, by the stroke line and the "
            f"angle sensors: {flown_text}. Single strokes are compared with the file."
        )
    return MANEUVER.judge(float(len(wrong)), 0.0, sentence).caused_by(
        "the file is not the one that was uploaded last, or the cables of two servos are exchanged",
        "Evaluate again with the file that was uploaded: --maneuver FILE",
    )


def _off_time(log: DropLog, strokes: Sequence[FlownStroke]) -> set[int]:
    """Numbers of strokes whose line rose where no clock would have it."""
    release_s = 0.0 if log.release is None else (log.release.latest_us - log.release.earliest_us) / 1e6
    return {
        stroke.number
        for stroke in strokes
        if abs(stroke.logged_s - stroke.scheduled_s)
        > OFF_TIME_S + RESONATOR_PPM * 1e-6 * stroke.scheduled_s + release_s
    }


def _other_joint(motion: Motion, strokes: Sequence[FlownStroke]) -> set[int]:
    """Numbers of strokes at which another joint moved than the one that was to."""
    begins = [stroke.logged_s if np.isfinite(stroke.logged_s) else stroke.scheduled_s for stroke in strokes]
    wrong = set()
    for stroke, begin_s in zip(strokes, begins, strict=True):
        if stroke.moved or not np.isfinite(stroke.size_rad):
            continue
        until_s = min((t_s for t_s in begins if t_s > begin_s), default=float(motion.t_s[-1]))
        # A joint that does its own stroke meanwhile did not move in this one's place.
        busy = {
            other.joint
            for other in strokes
            if _moves_within(other, begin_s, until_s) or other.start_s < begin_s < other.end_s
        }
        if _mover(motion, begin_s, until_s, OTHER_JOINT_RAD, busy) not in (0, stroke.joint):
            wrong.add(stroke.number)
    return wrong


def _moves_within(stroke: FlownStroke, from_s: float, until_s: float) -> bool:
    """Return whether a stroke was under way between two times for longer than a servo takes to settle."""
    return stroke.moved and min(stroke.end_s, until_s) - max(stroke.start_s, from_s) > ARRIVED_S


def _overlap(strokes: Sequence[FlownStroke]) -> bool:
    """Return whether two strokes that were flown overlap."""
    return any(
        _moves_within(other, stroke.start_s, stroke.end_s)
        for stroke, other in combinations(strokes, 2)
        if stroke.moved
    )


def _describe_rises(motion: Motion, edges_s: FloatArray) -> list[str]:
    """Format each rise of the stroke line with the joint that moved most before the next rise.

    The joint's travel is counted until it moves again, or to the end.
    """
    t, end_s, starts_s = motion.t_s, float(motion.t_s[-1]), edges_s.tolist()
    movers = [_mover(motion, t_s, until_s) for t_s, until_s in pairwise([*starts_s, end_s])]
    sentences = []
    for i, (t_s, joint) in enumerate(zip(starts_s, movers, strict=True)):
        again = (starts_s[k] for k in range(i + 1, len(movers)) if movers[k] == joint)
        before, after = at_rest(t, t_s), at_rest(t, next(again, end_s))
        moved = "no joint"
        if joint and before is not None and after is not None:
            size, std = np.rad2deg(change_of(motion.joints[joint - 1], before, after))
            moved = f"joint {joint} by {size:+.2f} ± {max(std, 0.01):.2f} deg"
        sentences.append(f"{t_s:.3f} s {moved}")
    return sentences


def _mover(
    motion: Motion,
    from_s: float,
    until_s: float,
    least_rad: float = MOVED_RAD,
    busy: AbstractSet[int] = frozenset(),
) -> int:
    """Find the joint that moved most between two times, those that are `busy` left out.

    Joints count from 1; 0 means that no joint moved significantly, by more than `least_rad`.
    """
    before, after = at_rest(motion.t_s, from_s), at_rest(motion.t_s, until_s)
    if before is None or after is None:
        return 0
    changes = {
        number: change_of(joint, before, after)
        for number, joint in enumerate(motion.joints, 1)
        if number not in busy
    }
    joint, (size, std) = max(changes.items(), key=lambda change: abs(change[1][0]), default=(0, (0.0, 0.0)))
    return joint if abs(size) > max(3.0 * std, least_rad) else 0
