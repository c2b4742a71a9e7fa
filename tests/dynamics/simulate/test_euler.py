"""Euler angles z-y-x, up to the attitudes where they lock."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tfsat_host.angles import wrap_angle
from tfsat_host.dynamics.euler import euler_zyx_by_turn, euler_zyx_rad


def test_they_are_scipys_intrinsic_zyx() -> None:
    turns = Rotation.random(200, rng=np.random.default_rng(1))
    assert euler_zyx_rad(turns.as_matrix()) == pytest.approx(turns.as_euler("ZYX"), abs=1e-12)


@pytest.mark.parametrize("y_deg", [90.0, -90.0, 89.9999999999])
def test_where_z_and_x_turn_about_one_axis_they_still_give_the_rotation(y_deg: float) -> None:
    turn = Rotation.from_euler("ZYX", [30.0, y_deg, -50.0], degrees=True)
    angles = euler_zyx_rad(turn.as_matrix())
    assert angles[2] == 0.0
    # There z and x turn about one axis: the angle about x is set to zero.
    assert Rotation.from_euler("ZYX", angles).as_matrix() == pytest.approx(turn.as_matrix(), abs=1e-9)


@given(
    st.tuples(
        st.floats(-np.pi, np.pi),
        st.floats(-1.0, 1.0).map(lambda part: part * np.deg2rad(89.0)),
        st.floats(-np.pi, np.pi),
    )
)
def test_how_they_grow_with_a_small_turn_is_their_numerical_derivative(
    zyx: tuple[float, float, float],
) -> None:
    attitude = Rotation.from_euler("ZYX", zyx)
    step, columns = 1e-6, []
    for axis in np.eye(3):
        after, before = (
            (Rotation.from_rotvec(sign * step * axis) * attitude).as_euler("ZYX") for sign in (1.0, -1.0)
        )
        # Central differences of a small rotation about each axis.
        columns.append(wrap_angle(after - before) / (2.0 * step))
    near_lock = 1.0 / np.cos(zyx[1])
    derivative = euler_zyx_by_turn(attitude.as_matrix())
    # Near the lock the derivative grows with the cosine's inverse.
    assert derivative == pytest.approx(np.column_stack(columns), abs=1e-8 * near_lock**3)


def test_how_they_grow_is_told_of_many_attitudes_at_once() -> None:
    turns = Rotation.random(12, rng=np.random.default_rng(2)).as_matrix().reshape(3, 4, 3, 3)
    derivatives = euler_zyx_by_turn(turns)
    assert derivatives.shape == (3, 4, 3, 3)
    assert derivatives[2, 1] == pytest.approx(euler_zyx_by_turn(turns[2, 1]))


@pytest.mark.parametrize("y_deg", [90.0, -90.0])
def test_where_z_and_x_turn_about_one_axis_a_turn_about_it_counts_for_z_alone(y_deg: float) -> None:
    turn = Rotation.from_euler("ZYX", [30.0, y_deg, -50.0], degrees=True)
    by_turn = euler_zyx_by_turn(turn.as_matrix())
    assert by_turn @ [0.0, 0.0, 1.0] == pytest.approx([1.0, 0.0, 0.0])
    # The other rotations count for nothing there.
    assert np.abs(by_turn).max() <= 1.0
