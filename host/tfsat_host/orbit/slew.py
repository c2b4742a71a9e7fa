"""How fast and how exactly loops reorient, in proportion: paper, section "Expected on-orbit performance"."""

from __future__ import annotations

# Errors of the drop test's reorientation, paper, section "Result": before and after its model was corrected.
DROP_TEST_REORIENTATION_DEG = 23.3
DROP_TEST_ERROR_DEG = 0.314
DROP_TEST_CORRECTED_ERROR_DEG = 0.237


def average_rate(joint_rate: float, efficiency: float) -> float:
    """Average rate of reorientation, in the unit of the joint rate: loops follow one another without pause.

    30 deg/s with an efficiency of 0.1092 make 3.28 deg/s.
    """
    return joint_rate * efficiency


def slew_time_s(target_deg: float, rate_deg_s: float) -> float:
    """Time to turn by `target_deg` at an average rate: 27.4 s for 90 deg at 3.28 deg/s.

    Raises:
        ValueError: the rate is not above zero.
    """
    if not rate_deg_s > 0.0:
        raise ValueError(f"an average rate of {rate_deg_s:g} deg/s reaches no target")
    return abs(target_deg) / rate_deg_s


def expected_error(
    target_deg: float,
    *,
    error_deg: float = DROP_TEST_ERROR_DEG,
    at_deg: float = DROP_TEST_REORIENTATION_DEG,
) -> float:
    """Error in deg of a reorientation without feedback, if a known one of `at_deg` had `error_deg`.

    In proportion to the angle, as the paper takes it: 1.21 deg for 90 deg, and with the corrected model 0.92 deg.

    Raises:
        ValueError: the known reorientation is not above zero.
    """
    if not at_deg > 0.0:
        raise ValueError(f"a reorientation of {at_deg:g} deg is no measure")
    return abs(target_deg) * error_deg / at_deg
