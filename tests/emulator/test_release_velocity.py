"""The velocity that the robot leaves the releaser with."""

from __future__ import annotations

import numpy as np
import pytest

from tfsat_host.emulated.emulated_robot import PUSH_OFF_M_S, SETTLE_US, EmulatedRobot
from tfsat_host.emulated.imperfections import ideal

FALL_US = 1_500_000
GRAVITY_M_S2 = 9.80665


SIDEWAYS_M_S = (0.02, -0.03, -0.1)


@pytest.mark.parametrize(
    ("drop_options", "velocity_m_s"), [({}, PUSH_OFF_M_S), ({"com_velocity_m_s": SIDEWAYS_M_S}, SIDEWAYS_M_S)]
)
def test_the_center_of_mass_falls_from_the_velocity_it_was_given(
    drop_options: dict[str, tuple[float, ...]], velocity_m_s: tuple[float, ...]
) -> None:
    with EmulatedRobot(imperfections=ideal(), seed=1) as robot:
        robot.advance(SETTLE_US)
        hung_m = robot.com_position_m()
        bodies = robot.model
        by_design_m = bodies.mass_kg @ (bodies.origin_m + bodies.com_m) / bodies.mass_kg.sum()
        assert hung_m == pytest.approx(by_design_m, abs=1e-12)
        robot.drop((0.1, 0.2, 0.3), fall_s=2.0, **drop_options)
        robot.advance(FALL_US)
        fallen_m = robot.com_position_m() - hung_m
    t_s = FALL_US * 1e-6
    assert fallen_m == pytest.approx(
        np.array(velocity_m_s) * t_s + [0, 0, -GRAVITY_M_S2 / 2 * t_s**2], abs=1e-9
    )


def test_a_vector_of_another_length_is_refused_before_anything_moves() -> None:
    with EmulatedRobot(imperfections=ideal(), seed=1) as robot:
        robot.advance(SETTLE_US)
        with pytest.raises(ValueError, match="3 components, not 2"):
            robot.drop((0.1, 0.2))
        assert not robot.falling


def test_a_closed_robot_answers_no_more() -> None:
    with EmulatedRobot(imperfections=ideal(), seed=1) as robot:
        robot.advance(SETTLE_US)
    with pytest.raises(TypeError):
        robot.eeprom()
