"""Servo settings as the board holds them, in whole microseconds, nanoseconds per degree and 0.01 deg, and its rules.

The board repeats the rules on what it receives (firmware/arduino_sequencer/src/core/settings.cpp): which settings a
servo can follow, joint by joint in its order; and that a maneuver stays within the joints' limits, or ARM refuses.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.limits import (
    JOINT_ANGLE_MAX_CDEG,
    JOINT_ANGLE_MIN_CDEG,
    JOINT_COUNT,
    SERVO_FACTORY_NS_PER_DEG,
    SERVO_FACTORY_ZERO_US,
    SERVO_FRAME_MAX_US,
    SERVO_FRAME_MIN_US,
    SERVO_FRAME_US,
    SERVO_NS_PER_DEG_MAX,
    SERVO_NS_PER_DEG_MIN,
    SERVO_PULSE_MAX_US,
    SERVO_PULSE_MIN_US,
)
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.units import CDEG_PER_DEG

NOTHING_CHANGED = "Nothing was sent to the robot; its settings are as they were."
NS_PER_US = 1000
FRAME: Final = JOINT_COUNT
"""The index at which the board reports a frame that makes no sense; joints come before it, from 0."""


class SettingsDefect(StrEnum):
    """Stable names, as in `error.code` of `--json`; the others are config's `Fault`s."""

    FRAME_RANGE = "frame-range"
    SLOPE_RANGE = "slope-range"
    JOINT_LIMITS = "joint-limits"
    PULSE_RANGE = "pulse-range"
    FILE_JOINTS = "file-joints"


class SettingsError(TfsatError):
    """The settings' file cannot be understood, or no servo can follow it; `code` is a SettingsDefect or a Fault."""


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """The settings of all servos.

    Attributes:
        frame_us: From pulse to pulse.
        servos: Of joints 1 to 3, in order.
    """

    frame_us: int
    servos: tuple[ServoSetting, ...]

    def of(self, joint: int) -> ServoSetting:
        """The setting of a joint, 1 to 3."""
        return self.servos[joint - 1]


def pulse_ns(servo: ServoSetting, angle_cdeg: int) -> int:
    """Pulse width that holds an angle from 0 deg, as the board computes it: the fraction of a nanosecond is cut."""
    change_ns = angle_cdeg * servo.ns_per_deg // CDEG_PER_DEG
    return servo.zero_us * NS_PER_US + (-change_ns if servo.reversed else change_ns)


FACTORY = ServoSettings(
    SERVO_FRAME_US,
    (
        ServoSetting(
            SERVO_FACTORY_ZERO_US, SERVO_FACTORY_NS_PER_DEG, 0, JOINT_ANGLE_MIN_CDEG, JOINT_ANGLE_MAX_CDEG
        ),
    )
    * JOINT_COUNT,
)
"""What a board uses that never received settings."""


@dataclass(frozen=True, slots=True)
class Finding:
    """What makes no sense.

    Attributes:
        code: Which rule.
        index: Of the joint from 0, or FRAME: what the board's refusal carries as its detail.
        key: Of the file's entry that is to be corrected.
        problem: What is wrong, to follow the name of the entry.
        cure: What to do.
    """

    code: SettingsDefect
    index: int
    key: str
    problem: str
    cure: str


def find_defect(settings: ServoSettings) -> Finding | None:
    """The first defect that the board would find, or None: it would accept the settings."""
    return next(_defects(settings), None)


def _defects(settings: ServoSettings) -> Iterator[Finding]:
    for index, servo in enumerate(settings.servos):
        if not SERVO_NS_PER_DEG_MIN <= servo.ns_per_deg <= SERVO_NS_PER_DEG_MAX:
            least, most = SERVO_NS_PER_DEG_MIN / NS_PER_US, SERVO_NS_PER_DEG_MAX / NS_PER_US
            yield Finding(
                SettingsDefect.SLOPE_RANGE,
                index,
                "us_per_deg",
                f"{servo.ns_per_deg / NS_PER_US:g} us/deg is outside {least:g} to {most:g} us/deg",
                "Give the change of pulse width for one degree, without a sign (11.111 for a usual servo); "
                "reversed = true turns the direction.",
            )
        if not JOINT_ANGLE_MIN_CDEG == servo.min_cdeg < servo.max_cdeg <= JOINT_ANGLE_MAX_CDEG:
            low, high = JOINT_ANGLE_MIN_CDEG / CDEG_PER_DEG, JOINT_ANGLE_MAX_CDEG / CDEG_PER_DEG
            yield Finding(
                SettingsDefect.JOINT_LIMITS,
                index,
                "limits_deg",
                f"{limits_text(servo)} deg cannot be a joint's range: it begins at {low:g}, the start pose, "
                f"and ends above it, at {high:g} at most",
                f"Write limits_deg = [{low:g}, {high:g}], or a smaller second number.",
            )
        for angle_cdeg in (servo.min_cdeg, servo.max_cdeg):
            width_us = pulse_ns(servo, angle_cdeg) / NS_PER_US
            if not SERVO_PULSE_MIN_US <= width_us <= SERVO_PULSE_MAX_US:
                yield Finding(
                    SettingsDefect.PULSE_RANGE,
                    index,
                    "zero_us" if angle_cdeg == 0 else "us_per_deg",
                    f"{angle_cdeg / CDEG_PER_DEG:g} deg would need a pulse of {width_us:.10g} us, "
                    f"outside {SERVO_PULSE_MIN_US} to {SERVO_PULSE_MAX_US} us",
                    "Correct zero_us, us_per_deg or reversed, or narrow limits_deg: "
                    "pulses must stay within what a servo takes over the whole range.",
                )
    if not SERVO_FRAME_MIN_US <= settings.frame_us <= SERVO_FRAME_MAX_US:
        least, most = SERVO_FRAME_MIN_US / NS_PER_US, SERVO_FRAME_MAX_US / NS_PER_US
        yield Finding(
            SettingsDefect.FRAME_RANGE,
            FRAME,
            "frame_ms",
            f"{settings.frame_us / NS_PER_US:g} ms is outside {least:g} to {most:g} ms",
            f"Give {most:g} for an analog servo; down to {least:g} for a digital one whose data sheet allows it.",
        )


def limits_text(servo: ServoSetting) -> str:
    """Such as `0 to 90`, without the unit (deg)."""
    return f"{servo.min_cdeg / CDEG_PER_DEG:g} to {servo.max_cdeg / CDEG_PER_DEG:g}"


def find_misfit(moves: Iterable[tuple[int, int]], settings: ServoSettings) -> str | None:
    """What the first stroke that leaves its joint's limits would do, and what is allowed; None: none does.

    Follows each joint from the start pose, 0 deg.

    Args:
        moves: (joint, angle_cdeg) of each stroke, in order.
        settings: Whose limits.
    """
    pose_cdeg = dict.fromkeys(range(1, len(settings.servos) + 1), 0)
    for number, (joint, angle_cdeg) in enumerate(moves, 1):
        pose_cdeg[joint] += angle_cdeg
        servo = settings.of(joint)
        if not servo.min_cdeg <= pose_cdeg[joint] <= servo.max_cdeg:
            reached = f"stroke {number} takes joint {joint} to {pose_cdeg[joint] / CDEG_PER_DEG:g} deg"
            allowed = f"its servo settings allow {limits_text(servo)} deg"
            return f"{reached}, but {allowed}"
    return None


def insist_on_fit(moves: Iterable[tuple[int, int]], settings: ServoSettings) -> None:
    """Raises RefusedError for a maneuver that leaves a joint's limits: the board would store it and refuse to arm."""
    misfit = find_misfit(moves, settings)
    if misfit is not None:
        raise RefusedError(
            what=f"{misfit[:1].upper()}{misfit[1:]}.",
            meaning="The servo would be driven against its stop, so the board would refuse to arm. Nothing was sent.",
            next_step="Choose smaller angles, or correct the limits. "
            "They are shown by: tfsat-host upload-servos --show",
            code=ErrorCode.SETTINGS_DO_NOT_FIT,
        )
