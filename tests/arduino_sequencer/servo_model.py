"""Servo settings in exact arithmetic, by the protocol's words: pulse widths, and what makes no sense."""

from __future__ import annotations

from tfsat_host.protocol.limits import (
    JOINT_ANGLE_MAX_CDEG,
    MOVING_AT_ONCE,
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
from tfsat_host.protocol.messages import ServoSetting, SettingsWriteRequest

TICK_NS = 500
FACTORY_SERVO = ServoSetting(SERVO_FACTORY_ZERO_US, SERVO_FACTORY_NS_PER_DEG, 0, 0, JOINT_ANGLE_MAX_CDEG)
FACTORY_SETTINGS = SettingsWriteRequest(SERVO_FRAME_US, (FACTORY_SERVO,) * 3, MOVING_AT_ONCE)


def pulse_centi_ns(servo: ServoSetting, angle_cdeg: int) -> int:
    """Pulse width in 0.01 ns: a whole number."""
    change = angle_cdeg * servo.ns_per_deg
    return servo.zero_us * 100_000 + (-change if servo.reversed else change)


def width_ns(servo: ServoSetting, angle_cdeg: int) -> int:
    """Return the pulse width in ns, rounded to the nearest whole tick."""
    # Rounded to the nearest tick: half a tick is added.
    return (pulse_centi_ns(servo, angle_cdeg) + 50 * TICK_NS) // (100 * TICK_NS) * TICK_NS


def settings_defect(settings: SettingsWriteRequest) -> int | None:
    """Index of the first joint whose setting makes no sense; 3 for the frame, 4 for the joints at once."""
    for index, servo in enumerate(settings.servo):
        ends = (servo.min_cdeg, servo.max_cdeg)
        if not (
            SERVO_NS_PER_DEG_MIN <= servo.ns_per_deg <= SERVO_NS_PER_DEG_MAX
            and servo.reversed in (0, 1)
            # 0 is always the start pose: another minimum makes no sense.
            and 0 == servo.min_cdeg < servo.max_cdeg <= JOINT_ANGLE_MAX_CDEG
            and all(
                100_000 * SERVO_PULSE_MIN_US <= pulse_centi_ns(servo, end) <= 100_000 * SERVO_PULSE_MAX_US
                for end in ends
            )
        ):
            return index
    if not SERVO_FRAME_MIN_US <= settings.frame_us <= SERVO_FRAME_MAX_US:
        return 3
    # 0 is what an earlier firmware stored: one.
    return None if settings.moving_at_once <= 3 else 4
