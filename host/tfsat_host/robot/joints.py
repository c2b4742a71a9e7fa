"""A joint's entries: axis, limits and servo."""

from __future__ import annotations

import math
import sys

import numpy as np

from tfsat_host.config import Table
from tfsat_host.robot.model import FloatArray, PulseMap, Servo

JOINT = "name inner outer axis point_mm limits_deg servo"
_SERVO = "average_rate_deg_s max_rate_deg_s acceleration_deg_s2 start_deg"
_PULSE_KEYS = ("pulse_range_us", "reference", "pulse_us_per_deg")
# Below it, components that matter would be subnormal: too few of their digits remain.
_SHORTEST_AXIS = sys.float_info.min / sys.float_info.epsilon


def axis(joint: Table) -> FloatArray:
    """The joint's axis (3,) as a unit vector. Raises RobotFileError if it has no direction."""
    direction = joint.array("axis", 3)
    largest = np.abs(direction).max()
    cure = "Give the axis a direction, e.g. [1, 0, 0]."
    if largest == 0.0:
        joint.fail("axis", "has no direction", cure)
    if largest < _SHORTEST_AXIS:
        joint.fail("axis", f"{largest:g} is so small that the direction is lost in rounding", cure)
    # By a power of two, which rounds nothing; squares of the numbers as given could leave the range of floats.
    scaled = np.ldexp(direction, -np.frexp(largest)[1])
    return np.asarray(scaled / np.linalg.norm(scaled), dtype=np.float64)


def limits_rad(joint: Table) -> tuple[float, float]:
    """Least and greatest angle. Raises RobotFileError if they are no range."""
    low, high = joint.numbers("limits_deg", 2)
    if not low < high:
        joint.fail("limits_deg", f"{low:g} is not below {high:g}", "Write the smaller angle first.")
    return math.radians(low), math.radians(high)


def servo(joint: Table, limits: tuple[float, float]) -> Servo:
    """The servo of a joint with these limits (rad).

    Raises:
        RobotFileError: it contradicts itself or the limits.
    """
    entry = joint.table("servo", " ".join((_SERVO, *_PULSE_KEYS)))
    found = Servo(
        average_rate_rad_s=math.radians(entry.number("average_rate_deg_s", above=0)),
        max_rate_rad_s=math.radians(entry.number("max_rate_deg_s", above=0)),
        acceleration_rad_s2=math.radians(entry.number("acceleration_deg_s2", above=0)),
        start_rad=math.radians(entry.number("start_deg")),
        pulses=_pulses(entry),
    )
    low, high = limits
    if found.average_rate_rad_s > found.max_rate_rad_s:
        entry.fail("average_rate_deg_s", "is above max_rate_deg_s", "Give an average of at most the maximum.")
    if not low <= found.start_rad <= high:
        entry.fail("start_deg", "is outside the joint's limits", "Choose a start pose inside limits_deg.")
    if found.pulses is not None:
        _check_reach(entry, found.pulses, limits)
    return found


def _pulses(entry: Table) -> PulseMap | None:
    missing = [key for key in _PULSE_KEYS if not entry.has(key)]
    if len(missing) == len(_PULSE_KEYS):
        return None
    if missing:
        cure = f"Add {' and '.join(missing)}, or leave out all three: {', '.join(_PULSE_KEYS)}."
        entry.fail(missing[0], "is missing beside the others that say what pulses do", cure)
    low_us, high_us = entry.numbers("pulse_range_us", 2)
    if not 0.0 < low_us < high_us:
        entry.fail("pulse_range_us", "is not a range above zero", "Write the shorter pulse first, in us.")
    slope = entry.number("pulse_us_per_deg")
    if slope == 0.0:
        entry.fail(
            "pulse_us_per_deg", "is zero", "Give the change of pulse width per degree; the sign is free."
        )
    reference = entry.table("reference", "pulse_us angle_deg")
    return PulseMap(
        range_us=(low_us, high_us),
        reference_pulse_us=reference.number("pulse_us", above=0),
        reference_angle_rad=math.radians(reference.number("angle_deg")),
        pulse_us_per_rad=math.degrees(slope),
    )


def _check_reach(entry: Table, pulses: PulseMap, limits: tuple[float, float]) -> None:
    for angle in limits:
        pulse = pulses.pulse_us(angle)
        if not pulses.range_us[0] - 1e-6 <= pulse <= pulses.range_us[1] + 1e-6:
            entry.fail(
                "pulse_range_us",
                f"the joint's limit {math.degrees(angle):g} deg would take a pulse of {pulse:.1f} us",
                "Correct reference, pulse_us_per_deg or the joint's limits_deg.",
            )
