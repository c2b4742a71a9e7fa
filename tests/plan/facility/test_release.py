"""The paper's numbers of the release, by the functions they come from; and what holds beyond them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.plan.facility import (
    LeverSwitch,
    switch_energy_mj,
    vertical_travel_mm,
)

SS_5GL = LeverSwitch(0.49, 0.06, 1.2, 0.8, 13.6, (8.0, 9.6))


def test_the_way_down_the_test_space() -> None:
    """Check the vertical travel in the test space.

    The other numbers of the paper are in docs/paper-numbers.md, which a test computes again.
    """
    # Two and a half seconds at 100 mm/s: the whole test space.
    assert vertical_travel_mm(100.0, 2.5) == pytest.approx(250.0)  # the fastest release that is permitted
    assert vertical_travel_mm(0.0, 2.5, 1e-3) == pytest.approx(30.6, abs=0.1)  # a thousandth of gravity


@given(st.floats(8.0, 9.6))
def test_the_energy_is_the_area_under_the_force_of_the_returning_lever(op_mm: float) -> None:
    """Summed strip by strip: an independent reading of the figure."""
    pre_mm, strips = SS_5GL.free_position_mm - op_mm, 20_000
    total_mm = SS_5GL.overtravel_mm + pre_mm
    kink_mm = SS_5GL.overtravel_mm + SS_5GL.movement_differential_mm
    area = 0.0
    for k in range(strips):
        # The middle of each strip, as a rule of quadrature.
        x_mm = (k + 0.5) * total_mm / strips
        falling_n = 0.49 + (0.06 - 0.49) * x_mm / kink_mm
        pressing_n = 0.49 * (total_mm - x_mm) / pre_mm
        area += (falling_n if x_mm < kink_mm else pressing_n) * total_mm / strips
    assert switch_energy_mj(SS_5GL, op_mm) == pytest.approx(area, rel=1e-3)


@given(st.floats(8.0, 9.5), st.floats(1e-3, 0.1))
def test_a_lower_operating_position_stores_more(op_mm: float, lower_mm: float) -> None:
    assert switch_energy_mj(SS_5GL, op_mm - lower_mm) > switch_energy_mj(SS_5GL, op_mm)
