"""The paper's numbers of the release, by the functions they come from; and what holds beyond them."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.plan.facility import (
    LeverSwitch,
    pause_s,
    permissible_transversal_velocity_mm_s,
    push_off_energy_mj,
    release_velocity_mm_s,
    residual_force_n,
    switch_energy_mj,
    vertical_travel_mm,
)

SS_5GL = LeverSwitch(0.49, 0.06, 1.2, 0.8, 13.6, (8.0, 9.6))
MASS_KG = 2.847

positive = st.floats(1e-3, 1e3)


def test_residual_magnetism_holds_with_10_n() -> None:
    assert residual_force_n(200.0, 0.05) == pytest.approx(10.0)


def test_two_switches_give_2_35_to_3_12_mj() -> None:
    low, high = push_off_energy_mj(SS_5GL, 2)
    assert (round(low, 2), round(high, 2)) == (2.35, 3.12)
    assert (low, high) == pytest.approx((2.3544, 3.1160), abs=1e-4)


def test_the_robot_leaves_at_40_6_to_46_8_mm_s() -> None:
    """The paper rounds the energy before it takes the root: 2.3544 mJ itself would give 40.7."""
    assert round(release_velocity_mm_s(2.35, MASS_KG), 1) == 40.6
    assert round(release_velocity_mm_s(3.12, MASS_KG), 1) == 46.8
    low, high = push_off_energy_mj(SS_5GL, 2)
    assert release_velocity_mm_s(low, MASS_KG) == pytest.approx(40.67, abs=0.01)
    assert release_velocity_mm_s(high, MASS_KG) == pytest.approx(46.79, abs=0.01)


def test_the_pause_is_0_7_s_at_30_mm_s() -> None:
    assert pause_s(21.0, 30.0) == pytest.approx(0.70, abs=1e-12)


def test_the_permissible_transversal_velocity_is_26_mm_s() -> None:
    assert permissible_transversal_velocity_mm_s(165.0, 100.0, 2.5) == pytest.approx(26.0)


def test_the_fastest_permitted_release_falls_250_mm() -> None:
    assert vertical_travel_mm(100.0, 2.5) == pytest.approx(250.0)


def test_a_thousandth_of_gravity_moves_the_robot_by_31_mm() -> None:
    assert vertical_travel_mm(0.0, 2.5, 1e-3) == pytest.approx(30.6, abs=0.1)


@given(st.floats(8.0, 9.6))
def test_the_energy_is_the_area_under_the_force_of_the_returning_lever(op_mm: float) -> None:
    """Summed strip by strip: an independent reading of the figure."""
    pre_mm, strips = SS_5GL.free_position_mm - op_mm, 20_000
    total_mm = SS_5GL.overtravel_mm + pre_mm
    kink_mm = SS_5GL.overtravel_mm + SS_5GL.movement_differential_mm
    area = 0.0
    for k in range(strips):
        x_mm = (k + 0.5) * total_mm / strips
        falling_n = 0.49 + (0.06 - 0.49) * x_mm / kink_mm
        pressing_n = 0.49 * (total_mm - x_mm) / pre_mm
        area += (falling_n if x_mm < kink_mm else pressing_n) * total_mm / strips
    assert switch_energy_mj(SS_5GL, op_mm) == pytest.approx(area, rel=1e-3)


@given(st.floats(8.0, 9.5), st.floats(1e-3, 0.1))
def test_a_lower_operating_position_stores_more(op_mm: float, lower_mm: float) -> None:
    assert switch_energy_mj(SS_5GL, op_mm - lower_mm) > switch_energy_mj(SS_5GL, op_mm)


def test_a_switch_that_never_snaps_back_is_refused() -> None:
    with pytest.raises(ValueError, match="pre-travel"):
        switch_energy_mj(dataclasses.replace(SS_5GL, movement_differential_mm=4.1), 9.6)


@given(positive, positive)
def test_the_energy_is_all_in_the_motion(energy_mj: float, mass_kg: float) -> None:
    velocity_m_s = release_velocity_mm_s(energy_mj, mass_kg) * 1e-3
    assert mass_kg * velocity_m_s**2 / 2.0 == pytest.approx(energy_mj * 1e-3)


@pytest.mark.parametrize(
    ("energy_mj", "mass_kg"), [(2.35, 0.0), (2.35, -1.0), (-1.0, 2.847), (math.nan, 1.0), (1.0, math.nan)]
)
def test_what_no_energy_moves_is_refused(energy_mj: float, mass_kg: float) -> None:
    with pytest.raises(ValueError, match="cannot move"):
        release_velocity_mm_s(energy_mj, mass_kg)


@given(positive, positive)
def test_after_the_pause_the_robot_is_clear(clearance_mm: float, slowest_mm_s: float) -> None:
    travelled = vertical_travel_mm(slowest_mm_s, pause_s(clearance_mm, slowest_mm_s))
    assert travelled == pytest.approx(clearance_mm)


@pytest.mark.parametrize("slowest_mm_s", [0.0, -30.0, math.nan])
def test_a_robot_that_does_not_leave_has_no_pause(slowest_mm_s: float) -> None:
    with pytest.raises(ValueError, match="never leaves"):
        pause_s(21.0, slowest_mm_s)


@given(positive, positive, positive)
def test_at_the_permissible_velocity_the_robot_just_touches(
    wall_mm: float, radius_mm: float, time_s: float
) -> None:
    velocity = permissible_transversal_velocity_mm_s(wall_mm, radius_mm, time_s)
    assert radius_mm + velocity * time_s == pytest.approx(wall_mm)


@pytest.mark.parametrize("duration_s", [0.0, -1.0, math.nan])
def test_a_drift_takes_time(duration_s: float) -> None:
    with pytest.raises(ValueError, match="no velocity"):
        permissible_transversal_velocity_mm_s(165.0, 100.0, duration_s)
