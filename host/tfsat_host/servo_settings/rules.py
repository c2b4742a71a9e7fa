"""Which settings a servo can follow: the board's own rules, joint by joint in its order, with words.

The board repeats them on what it receives (firmware/arduino_sequencer/src/core/settings.cpp).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from tfsat_host.protocol.limits import (
    JOINT_ANGLE_MAX_CDEG,
    JOINT_ANGLE_MIN_CDEG,
    JOINT_COUNT,
    SERVO_FRAME_MAX_US,
    SERVO_FRAME_MIN_US,
    SERVO_NS_PER_DEG_MAX,
    SERVO_NS_PER_DEG_MIN,
    SERVO_PULSE_MAX_US,
    SERVO_PULSE_MIN_US,
)
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings.errors import SettingsDefect
from tfsat_host.servo_settings.settings import NS_PER_US, ServoSettings, pulse_ns
from tfsat_host.units import CDEG_PER_DEG

FRAME: Final = JOINT_COUNT
"""The index at which the board reports a frame that makes no sense; joints come before it, from 0."""


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
    for index, servo in enumerate(settings.servos):
        finding = _slope(index, servo) or _limits(index, servo) or _pulses(index, servo)
        if finding is not None:
            return finding
    if SERVO_FRAME_MIN_US <= settings.frame_us <= SERVO_FRAME_MAX_US:
        return None
    least, most = SERVO_FRAME_MIN_US / NS_PER_US, SERVO_FRAME_MAX_US / NS_PER_US
    return Finding(
        SettingsDefect.FRAME_RANGE,
        FRAME,
        "frame_ms",
        f"{settings.frame_us / NS_PER_US:g} ms is outside {least:g} to {most:g} ms",
        f"Give {most:g} for an analog servo; down to {least:g} for a digital one whose data sheet allows it.",
    )


def _slope(index: int, servo: ServoSetting) -> Finding | None:
    if SERVO_NS_PER_DEG_MIN <= servo.ns_per_deg <= SERVO_NS_PER_DEG_MAX:
        return None
    least, most = SERVO_NS_PER_DEG_MIN / NS_PER_US, SERVO_NS_PER_DEG_MAX / NS_PER_US
    return Finding(
        SettingsDefect.SLOPE_RANGE,
        index,
        "us_per_deg",
        f"{servo.ns_per_deg / NS_PER_US:g} us/deg is outside {least:g} to {most:g} us/deg",
        "Give the change of pulse width for one degree, without a sign (11.111 for a usual servo); "
        "reversed = true turns the direction.",
    )


def _limits(index: int, servo: ServoSetting) -> Finding | None:
    if servo.min_cdeg == JOINT_ANGLE_MIN_CDEG and servo.min_cdeg < servo.max_cdeg <= JOINT_ANGLE_MAX_CDEG:
        return None
    low, high = JOINT_ANGLE_MIN_CDEG / CDEG_PER_DEG, JOINT_ANGLE_MAX_CDEG / CDEG_PER_DEG
    return Finding(
        SettingsDefect.JOINT_LIMITS,
        index,
        "limits_deg",
        f"{limits_text(servo)} deg cannot be a joint's range: it begins at {low:g}, the start pose, "
        f"and ends above it, at {high:g} at most",
        f"Write limits_deg = [{low:g}, {high:g}], or a smaller second number.",
    )


def _pulses(index: int, servo: ServoSetting) -> Finding | None:
    for angle_cdeg in (servo.min_cdeg, servo.max_cdeg):
        width_ns = pulse_ns(servo, angle_cdeg)
        if not SERVO_PULSE_MIN_US * NS_PER_US <= width_ns <= SERVO_PULSE_MAX_US * NS_PER_US:
            return Finding(
                SettingsDefect.PULSE_RANGE,
                index,
                "zero_us" if angle_cdeg == 0 else "us_per_deg",
                f"{angle_cdeg / CDEG_PER_DEG:g} deg would need a pulse of {width_ns / NS_PER_US:.10g} us, "
                f"outside {SERVO_PULSE_MIN_US} to {SERVO_PULSE_MAX_US} us",
                "Correct zero_us, us_per_deg or reversed, or narrow limits_deg: "
                "pulses must stay within what a servo takes over the whole range.",
            )
    return None


def limits_text(servo: ServoSetting) -> str:
    """Such as `0 to 90`, without the unit (deg)."""
    return f"{servo.min_cdeg / CDEG_PER_DEG:g} to {servo.max_cdeg / CDEG_PER_DEG:g}"
