"""Maneuvers to try: valid ones by construction, and raw ones that only look like it."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from tfsat_host.maneuver import Maneuver, Schedule, Stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.framing import crc16
from tfsat_host.protocol.messages import (
    ManeuverBeginRequest,
    ManeuverCommitRequest,
    ManeuverStrokeRequest,
)
from tfsat_host.protocol.record import Payload


@dataclass(frozen=True)
class RawManeuver:
    """What an upload carries, checked by nobody: (joint, angle_cdeg, start_us) of each stroke."""

    speed_cdeg_s: int
    strokes: tuple[tuple[int, int, int], ...]

    @classmethod
    def of(cls, schedule: Schedule) -> RawManeuver:
        strokes = tuple((stroke.joint, stroke.angle_cdeg, stroke.t_us) for stroke in schedule.strokes)
        return cls(schedule.speed_cdeg_s, strokes)

    def canonical(self) -> bytes:
        """Return the bytes that the commit's CRC covers."""
        text = bytes([len(self.strokes)]) + self.speed_cdeg_s.to_bytes(2, "little")
        for joint, angle_cdeg, start_us in self.strokes:
            text += bytes([joint]) + angle_cdeg.to_bytes(2, "little", signed=True)
            text += start_us.to_bytes(4, "little")
        return text

    def requests(self) -> list[Payload]:
        """Begin, strokes, commit."""
        strokes = [ManeuverStrokeRequest(i, *stroke) for i, stroke in enumerate(self.strokes)]
        begin = ManeuverBeginRequest(len(self.strokes), self.speed_cdeg_s)
        return [begin, *strokes, ManeuverCommitRequest(crc16(self.canonical()))]


def defect(raw: RawManeuver) -> tuple[ErrorCode, int]:
    """Return the protocol's error code and the stroke it concerns, in exact arithmetic, not the board's.

    The order of the checks is part of the contract: the first defect of the first bad stroke.
    """
    if not 1 <= len(raw.strokes) <= 16:
        return ErrorCode.TOO_MANY_STROKES, len(raw.strokes)
    if not 1000 <= raw.speed_cdeg_s <= 40000:
        return ErrorCode.SPEED_OUT_OF_RANGE, -1
    angle_cdeg, arrives_us = {1: 0, 2: 0, 3: 0}, {1: 0, 2: 0, 3: 0}
    before_us = None
    for index, (joint, change_cdeg, start_us) in enumerate(raw.strokes):
        if joint not in angle_cdeg:
            return ErrorCode.JOINT_UNKNOWN, index
        angle_cdeg[joint] += change_cdeg
        if change_cdeg == 0 or not 0 <= angle_cdeg[joint] <= 9000:
            return ErrorCode.ANGLE_OUT_OF_RANGE, index
        if start_us < 700_000:
            return ErrorCode.TOO_EARLY, index
        # Two begin at the same time, or 10 ms apart.
        if before_us is not None and not (start_us == before_us or start_us >= before_us + 10_000):
            return ErrorCode.STARTS_TOO_CLOSE, index
        if start_us < arrives_us[joint]:
            return ErrorCode.STROKES_OVERLAP, index
        before_us = start_us
        arrives_us[joint] = start_us - (-abs(change_cdeg) * 1_000_000 // raw.speed_cdeg_s)  # rounded up
        if arrives_us[joint] > 2_500_000:
            return ErrorCode.TOO_LONG, index
    return ErrorCode.NONE, -1


@st.composite
def flyable(draw: st.DrawFn) -> Maneuver:
    """Strokes between angles of the joints' range for as long as the fall lasts, one at a time; times by the rule."""
    speed_deg_s = draw(st.sampled_from([170.0, 400.0, 100.0]) | st.floats(60, 400).map(lambda v: round(v, 2)))
    pose_cdeg = {1: 0, 2: 0, 3: 0}
    strokes: list[Stroke] = []
    # 1.8 s: from the first stroke's earliest time to the end of the fall.
    left_us = 1_800_000
    for _ in range(draw(st.integers(1, 16))):
        joint = draw(st.integers(1, 3))
        target_cdeg = draw(st.integers(0, 9000) | st.sampled_from([0, 1, 9000]))
        change_cdeg = target_cdeg - pose_cdeg[joint]
        taken_us = abs(change_cdeg) * 10_000 / speed_deg_s + 10_000
        # Skipped: a stroke of no angle, and one for which the fall has no time left.
        if change_cdeg == 0 or taken_us > left_us:
            continue
        left_us -= round(taken_us)
        pose_cdeg[joint] = target_cdeg
        strokes.append(Stroke(joint, change_cdeg / 100))
    return Maneuver(tuple(strokes) or (Stroke(1, 5.0),), speed_deg_s=speed_deg_s)


@st.composite
def overlapping(draw: st.DrawFn) -> Maneuver:
    """Strokes of up to three joints that begin together, or while others are under way, or after them."""
    speed_deg_s = draw(st.sampled_from([170.0, 400.0, 100.0]))
    pose_cdeg, arrives_us = {1: 0, 2: 0, 3: 0}, {1: 0, 2: 0, 3: 0}
    strokes: list[Stroke] = []
    start_us = 700_000
    for _ in range(draw(st.integers(1, 16))):
        joint = draw(st.integers(1, 3))
        target_cdeg = draw(st.integers(0, 9000) | st.sampled_from([0, 1, 9000]))
        change_cdeg = target_cdeg - pose_cdeg[joint]
        later_us = 10_000 * draw(st.sampled_from([0, 0, 1, 2, 15]))
        # On the grid, and not before the joint has ended its stroke before.
        starts_us = max(start_us + later_us, -(-arrives_us[joint] // 10_000) * 10_000)
        end_us = starts_us - (-abs(change_cdeg) * 10_000 // speed_deg_s)
        if change_cdeg == 0 or end_us > 2_500_000:
            continue
        start_us, pose_cdeg[joint], arrives_us[joint] = starts_us, target_cdeg, round(end_us)
        strokes.append(Stroke(joint, change_cdeg / 100, start_us / 1e6))
    return Maneuver(tuple(strokes) or (Stroke(1, 5.0, 0.7),), speed_deg_s=speed_deg_s)


LIMITS = (
    [0, 1, 2, 3, 4, 255],
    [0, 9000, 9001, -9000, 32767, -32768],
    [0, 699_999, 700_000, 2_499_999, 2_500_000, 2_500_001, 2**31, 2**32 - 1],
)
"""Of joint, angle_cdeg and start_us: what is just allowed, just not, and the ends of the wire."""


@st.composite
def raw_maneuvers(draw: st.DrawFn) -> RawManeuver:
    """Draw a flyable maneuver with a few fields replaced by any values that fit the wire format."""
    raw = RawManeuver.of(schedule_maneuver(draw(flyable() | overlapping())))
    speed = draw(st.just(raw.speed_cdeg_s) | st.sampled_from([0, 1, 999, 1000, 40_000, 40_001, 65_535]))
    strokes = [list(stroke) for stroke in raw.strokes]
    near = st.integers(-2, 2) | st.integers(-20_001, 20_001)
    for _ in range(draw(st.integers(0, 3))):
        stroke = strokes[draw(st.integers(0, len(strokes) - 1))]
        field = draw(st.integers(0, 2))
        limits = draw(st.sampled_from(LIMITS[field]))
        # Limits twice as often as a small change: the edges are where the board decides.
        stroke[field] = draw(st.sampled_from([limits, limits, stroke[field] + draw(near)]))
    # What the wire's types can carry: the board must answer to any of it.
    on_wire = (
        (joint % 256, max(-32768, min(angle_cdeg, 32767)), max(0, min(start_us, 2**32 - 1)))
        for joint, angle_cdeg, start_us in strokes
    )
    return RawManeuver(speed, tuple(on_wire))
