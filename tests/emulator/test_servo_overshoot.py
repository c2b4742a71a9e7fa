"""Servos that overshoot, in a drop: how far and how long the joints are beyond, and that the bodies answer to it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.fixtures.emulated_drop import OF_THE_PAPER, releaser
from tfsat_host.dynamics import Multibody, joint_momentum, locked_inertia
from tfsat_host.emulated.imperfections import draw, draw_as_built, ideal
from tfsat_host.rehearsal.truth import drawn_truth, truth_as_filed
from tfsat_host.robot import load_robot

BEYOND_DEG = (0.4, 0.3, 0.0)
ENDS_S = (0.70 + 0.345, 1.05 + 0.4)
"""Of the opening strokes by themselves: 59 and 70 deg at 200 deg/s, and 0.05 s of braking."""
TRUTH_US = 500
RATE_RAD_S = (-0.013, -0.008, 0.02)


@cache
def fly(clock_ppm: float = 0.0, beyond_deg: tuple[float, ...] = BEYOND_DEG) -> NDArray[np.float64]:
    """Truth of a drop, in seconds after the release."""
    wrong = replace(ideal(), servo_overshoot_rad=np.deg2rad(beyond_deg), sequencer_clock_ppm=clock_ppm)
    with releaser(imperfections=wrong) as (robot, board, _):
        board.upload(OF_THE_PAPER)
        board.arm()
        robot.advance(1_000_000)
        robot.record_truth(TRUTH_US)
        robot.drop(RATE_RAD_S)
        robot.advance(2_400_000)
        truth = robot.truth()
        truth[:, 0] -= robot.released_us * 1e-6
    return truth[truth[:, 0] > 0.0]


@pytest.mark.parametrize("clock_ppm", [0.0, 37.0, -20.0])
def test_opening_joints_run_beyond_their_angle_and_are_back_within_a_tenth_of_a_second(
    clock_ppm: float,
) -> None:
    """Opening joints overshoot and return within 0.1 s; closing joints end at their stops and do not.

    A clock error rounds each pulse differently.
    """
    truth, without = fly(clock_ppm), fly(clock_ppm, (0.0, 0.0, 0.0))
    more_deg = np.rad2deg(truth[:, 1:4] - without[:, 1:4])
    pulse_us = 20_000  # a stroke begins with the first pulse after its command
    for joint, end_s in enumerate(ENDS_S):
        assert more_deg[:, joint].max() == pytest.approx(BEYOND_DEG[joint], abs=2e-3)
        when = truth[more_deg[:, joint] > 1e-3, 0]
        assert when.min() > end_s - 0.05 and when.max() < end_s + 0.05 + 1e-6 * pulse_us
        assert np.ptp(when) == pytest.approx(0.09, abs=0.01)
        assert truth[:, 1 + joint].min() >= 0.0
    assert not more_deg[:, 2].any()
    assert more_deg[-1] == pytest.approx(0.0, abs=1e-4)


def test_the_bodies_momentum_is_conserved_by_rates_that_are_the_angles_derivatives() -> None:
    truth, model = fly(), load_robot()
    rates = truth[:, 20:32].reshape(-1, 4, 3)
    attitudes = [
        Rotation.from_quat(quaternions) for quaternions in truth[:, 4:20].reshape(-1, 4, 4).swapaxes(0, 1)
    ]
    # The angles' own differences: not what the servos say.
    joint_rates = np.gradient(truth[:, 1:4], truth[:, 0], axis=0)
    for joint, (inner, outer) in enumerate(zip(model.joint_inner, model.joint_outer, strict=True)):
        turning = attitudes[outer].apply(rates[:, outer]) - attitudes[inner].apply(rates[:, inner])
        along = attitudes[inner].apply(np.tile(model.joint_axis[joint], (len(truth), 1)))
        axis_rates = (turning * along).sum(axis=1)
        assert np.rad2deg(axis_rates - joint_rates[:, joint]) == pytest.approx(0.0, abs=0.8)
    body = Multibody.of(model)
    momentum = attitudes[model.base].apply(
        np.einsum("nij,nj->ni", locked_inertia(body, truth[:, 1:4]), rates[:, model.base])
        + np.einsum("nij,nj->ni", joint_momentum(body, truth[:, 1:4]), joint_rates)
    )
    # Differences are wrong where a servo's acceleration jumps, by 4000 deg/s^2 as the servos speed up and brake.
    acceleration = np.gradient(joint_rates, truth[:, 0], axis=0)
    jumps = np.abs(acceleration[2:] - acceleration[:-2]).max(axis=1) > np.deg2rad(300.0)
    smooth = ~np.convolve(jumps, np.ones(3, dtype=bool))
    assert smooth.mean() > 0.97
    off = np.linalg.norm(momentum - momentum[0], axis=1)[smooth]
    of_overshoot = np.linalg.norm(joint_momentum(body, truth[:, 1:4])[..., 0], axis=1).max() * np.deg2rad(
        16.0
    )
    assert off.max() < 5e-3 * of_overshoot


def test_who_overshoots() -> None:
    """Robots as they come, as built and as filed do not; drawn ones do, and are else who they always were."""
    filed = load_robot()
    exact = (ideal(), draw(1), draw_as_built(1), truth_as_filed(filed, 1).imperfections)
    assert not any(imperfections.servo_overshoot_rad.any() for imperfections in exact)
    truths = [drawn_truth(filed, seed) for seed in range(40)]
    beyond_deg = np.rad2deg([truth.imperfections.servo_overshoot_rad for truth in truths])
    assert beyond_deg.shape == (40, 3)
    assert 0.1 <= beyond_deg.min() < 0.12 and 0.48 < beyond_deg.max() <= 0.5
    assert truths[1].imperfections.servo_gain == pytest.approx([1.000564, 0.997024, 1.001813], abs=1e-6)
    assert np.rad2deg(truths[1].rate_rad_s) == pytest.approx([-0.135700, -0.347190, -0.522564], abs=1e-6)
