"""The paper's expected performance on orbit, number by number."""

from __future__ import annotations

import pytest

from tfsat_host.plan.grid import DROP_TEST_CORRECTED_ERROR_DEG, average_rate, expected_error, slew_time_s


def test_average_rate() -> None:
    assert average_rate(30.0, 0.1092) == pytest.approx(3.28, abs=0.005)


def test_time_for_90_deg() -> None:
    assert slew_time_s(90.0, 3.28) == pytest.approx(27.4, abs=0.05)
    assert slew_time_s(-90.0, 3.28) == slew_time_s(90.0, 3.28)


def test_expected_errors_of_90_deg() -> None:
    assert expected_error(90.0) == pytest.approx(1.21, abs=0.005)
    assert expected_error(90.0, error_deg=DROP_TEST_CORRECTED_ERROR_DEG) == pytest.approx(0.92, abs=0.005)


def test_what_has_no_answer() -> None:
    with pytest.raises(ValueError, match="reaches no target"):
        slew_time_s(90.0, 0.0)
    with pytest.raises(ValueError, match="no measure"):
        expected_error(90.0, at_deg=0.0)
