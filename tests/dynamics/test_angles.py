"""Angles that differ by whole turns are one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.angles import wrap_angle


@given(st.lists(st.floats(-1e4, 1e4), min_size=1))
def test_the_same_angle_within_half_a_turn_of_zero(angles: list[float]) -> None:
    before = np.array(angles)
    wrapped_angles = wrap_angle(before)
    assert (wrapped_angles >= -np.pi).all() and (wrapped_angles <= np.pi).all()
    turns = (before - wrapped_angles) / (2.0 * np.pi)
    # Whole turns only: the angle stays the same up to them.
    assert turns == pytest.approx(np.round(turns), abs=1e-9)


def test_an_angle_that_nobody_knows_stays_unknown() -> None:
    assert np.isnan(wrap_angle(np.array([np.nan, 1.0]))).tolist() == [True, False]
