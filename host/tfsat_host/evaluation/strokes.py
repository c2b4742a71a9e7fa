"""Each stroke as it was flown: how far, when, how fast, how it arrived; and joints that moved when they should stand.

By the fused joint angles and rates, with their uncertainty; `quick_look` reads one angle sensor. A motion's ends are
read off its rate: a servo that speeds up at its limit gives the rate a straight edge, whose line meets zero where the
motion began. No threshold of the rate is then in the result, and no low-pass's rounding of the corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.motion.joints import JointMotion
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.maneuver import Schedule, count_moving
from tfsat_host.next_step import NextStep

WINDOW = 8
"""Samples averaged for an angle at rest: 29 ms at 280 Hz."""
EARLY_S = 0.03
"""A motion is looked for from so long before its command."""
ARRIVED_S = 0.1
"""So long after the end of a motion its joint is taken to have come to rest."""
MOVING_RAD_S = np.deg2rad(5.0)
"""A joint slower than that at its fastest did not make a stroke."""
NOISES = 6.0
"""Nor did one that is not so many times faster than the rate's noise."""
CAME_BACK_SHARE = 0.1
"""Nor did one that ended so near to where it began, as a share of how far it went."""
SETTLING_BAND = 0.02
"""Of the stroke's size: the band of the settling time, as usual for step responses."""
_UNKNOWN = float("nan")
_BROKEN_OFF = "It was still on its way when what can be evaluated ended: its size is that so far."


@dataclass(frozen=True, slots=True)
class FlownStroke:
    """One commanded stroke; NaN where the log does not tell a number.

    Attributes:
        number: From 1, in the schedule's order.
        joint: 1 to 3.
        scheduled_s: After the release, on the sequencer's clock.
        logged_s: When the logger saw the stroke line rise, after the release.
        commanded_rad: Change of the joint's angle.
        moved: The joint made a motion of its own within the stroke's time.
        remark: What is missing or wrong, one sentence or more; empty if nothing is.
        size_rad: Change from just before the stroke to just before the same joint's next, or the end; so far, if
            `unfinished`.
        size_std_rad: Its standard deviation.
        start_s: Of the motion, after the release.
        start_std_s: Its standard deviation.
        dead_time_s: From the logged rise to the start.
        end_s: Of the motion.
        mean_rate_rad_s: Between start and end, signed.
        peak_rate_rad_s: Signed; over three samples.
        overshoot_rad: How far it was beyond where it came to rest; 0 or more.
        settling_s: From the start until it stays within 2 % of the size around where it came to rest.
        unfinished: It was on its way when what can be evaluated ended: nothing is known of how it arrived.
    """

    number: int
    joint: int
    scheduled_s: float
    logged_s: float
    commanded_rad: float
    moved: bool
    remark: str
    size_rad: float = _UNKNOWN
    size_std_rad: float = _UNKNOWN
    start_s: float = _UNKNOWN
    start_std_s: float = _UNKNOWN
    dead_time_s: float = _UNKNOWN
    end_s: float = _UNKNOWN
    mean_rate_rad_s: float = _UNKNOWN
    peak_rate_rad_s: float = _UNKNOWN
    overshoot_rad: float = _UNKNOWN
    settling_s: float = _UNKNOWN
    unfinished: bool = False

    def withheld(self) -> FlownStroke:
        """Nothing that its joint's sensors told is given: NaN, and no remark."""
        commanded = (self.number, self.joint, self.scheduled_s, self.logged_s, self.commanded_rad, self.moved)
        return FlownStroke(*commanded, remark="", unfinished=self.unfinished)

    @property
    def short_rad(self) -> float:
        """How much smaller than commanded the stroke was; negative if it was larger."""
        return float(np.sign(self.commanded_rad)) * (self.commanded_rad - self.size_rad)


def strokes_flown(
    motion: Motion, schedule: Schedule, logged_s: Sequence[float] = ()
) -> tuple[FlownStroke, ...]:
    """Measure how each commanded stroke was flown.

    `logged_s`: when the logger saw each stroke's line rise (`Clocks.stroke_s`), NaN where it did not; empty:
    all NaN.

    Raises:
        ValueError: there is a logged time for some strokes only.
    """
    strokes = schedule.strokes
    if len(logged_s) not in (0, len(strokes)):
        raise ValueError(
            f"{len(logged_s)} logged times for {len(strokes)} strokes; give NaN for those without one"
        )
    logged_times_s = (
        np.array(logged_s, dtype=np.float64) if len(logged_s) else np.full(len(strokes), _UNKNOWN)
    )
    # A stroke whose line was not seen to rise is looked for at its scheduled time.
    begins = np.where(np.isfinite(logged_times_s), logged_times_s, [stroke.t_s for stroke in strokes])
    flown_strokes = []
    for i, stroke in enumerate(strokes):
        again = [begins[k] for k in range(i + 1, len(strokes)) if strokes[k].joint == stroke.joint]
        commanded = float(np.deg2rad(stroke.angle_deg))
        flown_stroke = FlownStroke(
            i + 1, stroke.joint, stroke.t_s, float(logged_times_s[i]), commanded, False, ""
        )
        flown_strokes.append(
            _classify_stroke(motion, flown_stroke, float(begins[i]), float(min([*again, motion.t_s[-1]])))
        )
    _explain_stop(flown_strokes, count_moving(strokes))
    return tuple(flown_strokes)


def _explain_stop(strokes: list[FlownStroke], moving: Sequence[int]) -> None:
    """Remark at the first stroke from which on none began what joints that moved at once may have done.

    `moving`: joints that move when each stroke has begun.
    """
    stop = max(
        (number for number, stroke in enumerate(strokes, 1) if np.isfinite(stroke.logged_s)), default=0
    )
    if 0 < stop < len(strokes) and max(moving[:stop]) > 1:
        strokes[stop] = replace(
            strokes[stop],
            remark=f"{strokes[stop].remark} The sequencer stopped after {max(moving[:stop])} joints had moved at once: "
            f"its supply may have dipped. Its last start tells: {NextStep('status')}. Then fly with fewer at once "
            "(moving_at_once), or fit a supply that carries them.",
        )


def _classify_stroke(
    motion: Motion, flown_stroke: FlownStroke, begin_s: float, until_s: float
) -> FlownStroke:
    """Measure a stroke, of which nothing is measured yet, from its command to the same joint's next."""
    t, joint = motion.t_s, motion.joints[flown_stroke.joint - 1]
    # Due after the data's end: nothing is known, which is no fault of the servo.
    if begin_s >= t[-1] - EARLY_S:
        return replace(
            flown_stroke, remark="Not recorded: it was due after the end of what can be evaluated."
        )
    remarks = []
    if not np.isfinite(flown_stroke.logged_s):
        remarks.append("The stroke line did not rise: its time is the schedule's.")

    def with_remark(stroke: FlownStroke, *extra_remarks: str) -> FlownStroke:
        return replace(stroke, remark=" ".join([*remarks, *extra_remarks]))

    # The size is between two rests: before this command, and before the same joint's next.
    before, after = at_rest(t, begin_s), at_rest(t, until_s)
    if before is None or after is None or begin_s >= until_s - EARLY_S:
        return with_remark(flown_stroke, "It lies outside the time that can be evaluated.")
    size, size_std = change_of(joint, before, after)
    # Begin before the command, so that the rate's foot ahead of the rising edge is among the samples.
    own = (t >= begin_s - EARLY_S) & (t < until_s)
    # Turn every motion positive, so that one edge finder serves both directions.
    way = float(np.sign(size)) or 1.0
    times, rate = t[own], way * motion.fused.joint_rate_rad_s[own, flown_stroke.joint - 1]
    peak = float(average_neighbours(rate).max())
    # A stroke must stand out of the rate's noise as well as exceed a fixed rate.
    slowest = max(MOVING_RAD_S, NOISES * rate_noise(motion, flown_stroke.joint))
    farthest = float(np.abs(joint.angle_rad[own] - joint.angle_rad[before].mean()).max())
    left_s = float(t[-1]) - begin_s
    # So soon before the data's end a standing joint proves nothing: it may still start.
    if peak < slowest and left_s < ARRIVED_S:
        return with_remark(
            flown_stroke, f"Not recorded: what can be evaluated ends {1e3 * left_s:.0f} ms after its command."
        )
    measured = replace(flown_stroke, size_rad=size, size_std_rad=size_std)
    # Without a peak the joint stood; with one but no net change it came back.
    if peak < slowest or abs(size) < max(3.0 * size_std, CAME_BACK_SHARE * farthest):
        got, commanded_deg = np.rad2deg([size, flown_stroke.commanded_rad])
        how = "did not move" if peak < slowest else "moved and came back"
        return with_remark(
            measured, f"Joint {flown_stroke.joint} {how}: {got:+.2f} deg instead of {commanded_deg:+g} deg."
        )
    if size * flown_stroke.commanded_rad < 0.0:
        remarks.append("It went the wrong way.")
    # These samples lie before the command: the joint should stand in them.
    if abs(rate[:2]).max() > slowest:
        remarks.append("The joint was still moving when it was commanded.")
    # Extrapolate both edges of the rate to zero, so that no threshold enters the times.
    start, end = rising_edge(times, rate), falling_edge(times, rate)
    measured = replace(
        measured,
        moved=True,
        start_s=start.t_s,
        # The gyros' delay has been taken off; its uncertainty shifts every start.
        start_std_s=float(np.hypot(start.std_s, motion.lag.delay_std_s)),
        dead_time_s=start.t_s - flown_stroke.logged_s,
        peak_rate_rad_s=way * peak,
    )
    still_moving = abs(rate[-2:]).max() > slowest
    # Cut off by the end of the data: neither end, overshoot nor settling time can be given.
    if until_s >= t[-1] and still_moving:
        return with_remark(replace(measured, unfinished=True), _BROKEN_OFF)
    if still_moving or not end.whole:
        remarks.append("It had not come to rest when its time was over.")
    overshoot, settling = _arrival(times, way * joint.angle_rad[own], start.t_s, end.t_s, abs(size))
    first, last = np.interp([start.t_s, end.t_s], t, joint.angle_rad)
    return with_remark(
        replace(
            measured,
            end_s=end.t_s,
            mean_rate_rad_s=float((last - first) / (end.t_s - start.t_s)),
            overshoot_rad=overshoot,
            settling_s=settling,
        )
    )


def _arrival(
    t_s: FloatArray, angle_rad: FloatArray, start_s: float, end_s: float, size_rad: float
) -> tuple[float, float]:
    """Overshoot and settling time of a motion towards larger angles."""
    # Measure against where the joint came to rest, not the command: a steady error is no overshoot.
    rest = int(np.searchsorted(t_s, end_s + ARRIVED_S))
    window = slice(rest, rest + WINDOW) if rest + WINDOW <= len(t_s) else slice(-WINDOW, None)
    settled = float(angle_rad[window].mean())
    beyond = angle_rad[(t_s >= start_s) & (t_s <= t_s[window].mean())] - settled
    overshoot = max(0.0, float(beyond.max())) if len(beyond) else _UNKNOWN
    # Settled after the last exit from the band, as usual for step responses.
    outside = np.flatnonzero(np.abs(angle_rad - settled) > SETTLING_BAND * size_rad)
    if not len(outside) or outside[-1] + 1 >= len(t_s):
        return overshoot, _UNKNOWN
    last = int(outside[-1])
    # Where the straight line between the last sample outside the band and the first inside crosses its border.
    off = np.abs(angle_rad[last : last + 2] - settled) - SETTLING_BAND * size_rad
    crossing = t_s[last] + (t_s[last + 1] - t_s[last]) * off[0] / (off[0] - off[1])
    return overshoot, float(crossing - start_s)


def at_rest(t_s: FloatArray, before_s: float) -> slice | None:
    """Return the slice of the last samples before a time, for a mean; None if there are too few."""
    last = int(np.searchsorted(t_s, before_s))
    return slice(last - WINDOW, last) if last >= WINDOW else None


def change_of(joint: JointMotion, before: slice, after: slice) -> tuple[float, float]:
    """Compute the angle's change between the means over two windows, and its standard deviation."""
    # Difference of the error bases: lasting errors that both windows share, as of a zero point, cancel.
    change = joint.basis[after].mean(axis=0) - joint.basis[before].mean(axis=0)
    variance = float(change @ joint.covariance @ change)
    for window in (before, after):
        variance += float(joint.angle_rad[window].var(ddof=1)) / WINDOW
    size = float(joint.angle_rad[after].mean() - joint.angle_rad[before].mean())
    return size, float(np.sqrt(variance))


def rate_noise(motion: Motion, joint: int) -> float:
    """Estimate the noise of one sample of a joint's rate, rad/s, from second differences.

    Their median represents the joint while it stands or coasts.
    """
    second = np.diff(motion.fused.joint_rate_rad_s[:, joint - 1], 2)
    # 0.6745 is the median of |x| for unit normal x; 6 the variance of twice differenced white noise.
    return float(np.median(np.abs(second)) / 0.6745 / np.sqrt(6.0))


FOOT, SHOULDER = 0.2, 0.8
"""Shares of the peak between which an edge is straight."""
_SMOOTHED = 3


@dataclass(frozen=True, slots=True)
class Edge:
    """Where the line through an edge meets zero.

    Attributes:
        t_s: On the samples' scale.
        std_s: Standard deviation by the scatter about the line; NaN with two samples on it.
        whole: The rate comes from below a fifth of its peak inside the samples; else it moved already at their end, and
            `t_s` is that end.
    """

    t_s: float
    std_s: float
    whole: bool


def average_neighbours(values: FloatArray) -> FloatArray:
    """(n,) means over three neighbours; the ends as they are."""
    if len(values) < _SMOOTHED:
        return values
    inner = np.convolve(values, np.full(_SMOOTHED, 1 / _SMOOTHED), mode="valid")
    return np.concatenate([values[:1], inner, values[-1:]])


def rising_edge(t_s: FloatArray, rate: FloatArray) -> Edge:
    """Find the first edge of a motion, whose rate (n,), in any unit, is positive at its peak; times (n,) ascend."""
    # Smooth only to find the edge; the line is fitted to raw samples, whose slope is not flattened.
    calm = average_neighbours(rate)
    peak = calm.max()
    shoulder = int(np.argmax(calm >= SHOULDER * peak))
    below = np.flatnonzero(calm[:shoulder] <= FOOT * peak)
    # In motion from the first sample on: the edge lies outside the data.
    if not len(below):
        return Edge(float(t_s[0]), float("nan"), whole=False)
    # Below the foot the low-pass has rounded the corner: those samples are not on the line.
    first = int(below[-1]) + 1
    if shoulder - first < 2:  # steeper than the samples lie: the foot helps
        first = int(below[-1])
    return _meets_zero(t_s[first : shoulder + 1], rate[first : shoulder + 1])


def falling_edge(t_s: FloatArray, rate: FloatArray) -> Edge:
    """Find the last edge of a motion; arguments as in `rising_edge`."""
    # Reversed in time, a falling edge is a rising one.
    mirrored = rising_edge(-t_s[::-1], rate[::-1])
    return Edge(-mirrored.t_s, mirrored.std_s, mirrored.whole)


def _meets_zero(t_s: FloatArray, rate: FloatArray) -> Edge:
    middle = float(t_s.mean())
    spread = float(((t_s - middle) ** 2).sum())
    slope = float((t_s - middle) @ rate) / spread
    if slope <= 0.0:  # a spike, of which the foot is as high as the shoulder
        return Edge(middle, float("nan"), whole=True)
    zero = -float(rate.mean()) / slope
    if len(t_s) < 3:
        return Edge(middle + zero, float("nan"), whole=True)
    off = rate - rate.mean() - slope * (t_s - middle)
    scatter = float(off @ off) / (len(t_s) - 2)
    # Variance of the zero crossing: that of the height, plus that of the slope over the distance.
    std = np.sqrt(scatter * (1.0 / len(t_s) + zero**2 / spread)) / abs(slope)
    return Edge(middle + zero, float(std), whole=True)
