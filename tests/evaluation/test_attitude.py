"""Rates integrated to attitudes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tfsat_host.evaluation.motion.attitude import integrate_rates, reorientation_deg


def rates(t_s: np.ndarray) -> np.ndarray:
    """About an axis that wanders: turns about different axes do not commute."""
    return np.column_stack([3.0 * np.sin(4.0 * t_s), 2.0 * np.cos(3.0 * t_s), 1.0 + t_s])


def end(samples: int) -> Rotation:
    t_s = np.linspace(0.0, 2.0, samples)
    return integrate_rates(t_s, rates(t_s))[-1]


def test_a_constant_axis_is_exact_however_coarse_and_uneven_the_samples() -> None:
    t_s = np.array([0.0, 0.1, 0.5, 0.7, 1.2])
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    found = integrate_rates(t_s, (0.3 + 0.8 * t_s)[:, None] * axis)
    turned = 0.3 * t_s + 0.4 * t_s**2
    assert found.as_rotvec() == pytest.approx(turned[:, None] * axis, abs=1e-12)


def plain(samples: int) -> Rotation:
    """By the mean of two rates alone."""
    t_s = np.linspace(0.0, 2.0, samples)
    rate = rates(t_s)
    attitude = Rotation.identity()
    for step in Rotation.from_rotvec(0.5 * (rate[1:] + rate[:-1]) * np.diff(t_s)[:, None]):
        attitude = attitude * step
    return attitude


def test_the_error_falls_with_the_square_of_the_step() -> None:
    """What is left is that the rates are not straight between samples; that turns do not commute is taken off."""
    best = end(40_001)
    errors = [reorientation_deg(best, end(samples)) for samples in (201, 401, 801)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)
    assert errors[1] < 0.6 * reorientation_deg(best, plain(401))


def test_every_attitude_is_the_product_of_all_steps_before_it() -> None:
    t_s = np.linspace(0.0, 1.0, 38)
    found = integrate_rates(t_s, rates(t_s))
    for row in (1, 2, 7, 16, 37):
        assert (
            reorientation_deg(found[row], integrate_rates(t_s[: row + 1], rates(t_s[: row + 1]))[-1]) < 1e-9
        )
