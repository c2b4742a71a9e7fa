"""What the mountings of two gyros have in common where they were measured by the same axes."""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.apply import split_shared
from tfsat_host.calibration.misalignment import Misalignment, solve_misalignment
from tfsat_host.calibration.response import TILT_STD_RAD, Response, across
from tfsat_host.calibration.sensors.gyro import SHARED

HINGES = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
HINGE_STD_RAD = np.deg2rad(0.5)
NOISE_RAD = np.deg2rad(0.05)
DRAWS = 600


def solve_mounting(rng: np.random.Generator, tilts: FloatArray, hinges: tuple[int, ...]) -> Misalignment:
    """Calibrate a gyro, mounted as designed, by swings about joints and a turn by hand about z.

    Args:
        rng: Of the noise.
        tilts: (6, 3) rotation vectors of the axes, in the order of `SHARED`.
        hinges: Joints that move it, from 0.
    """
    responses = []
    for axis, number in [*((HINGES[joint], joint) for joint in hinges), (np.array([0.0, 0.0, 1.0]), 5)]:
        noise = across(axis) @ (NOISE_RAD * rng.standard_normal(3))
        reading = axis + np.cross(tilts[number], axis) + noise
        responses.append(
            Response(axis, reading / np.linalg.norm(reading), NOISE_RAD**2 * across(axis), False, number)
        )
    return solve_misalignment(responses, np.eye(3), HINGES, HINGE_STD_RAD)


def test_errors_of_two_gyros_hang_together_as_stated() -> None:
    rng = np.random.default_rng(5)
    axes = np.vstack([HINGES, np.eye(3)])
    std = np.repeat([HINGE_STD_RAD, TILT_STD_RAD], 3)
    off, fits = [], list[Misalignment]()
    for _ in range(DRAWS):
        # A tilt about the axis itself tilts nothing.
        tilts = std[:, None] * rng.standard_normal((6, 3))
        tilts -= (tilts * axes).sum(axis=1, keepdims=True) * axes
        fits = [solve_mounting(rng, tilts, hinges) for hinges in ((0, 1), (1, 2))]
        off.append(np.concatenate([Rotation.from_matrix(fit.rotation.T).as_rotvec() for fit in fits]))
    stated = block_diag(*(fit.covariance[:3, :3] for fit in fits))
    stated[:3, 3:] = fits[0].shared[:3] @ fits[1].shared[:3].T
    stated[3:, :3] = stated[:3, 3:].T
    # The mountings themselves are exact here: their prior is in the stated covariance, and hardly counts.
    found = np.cov(np.array(off), rowvar=False)
    scale = np.sqrt(np.outer(np.diag(stated), np.diag(stated)))
    assert np.abs((found - stated) / scale).max() < 0.15
    # About y the turn and the second joint's tilt are common, about x the joints are others.
    assert np.abs(stated[:3, 3:] / scale[:3, 3:]).max() > 0.6


def test_what_is_shared_is_counted_once() -> None:
    rng = np.random.default_rng(6)
    shared = 0.1 * rng.standard_normal((4, 12, SHARED))
    own = np.array([np.diag(rng.uniform(0.5, 1.0, 12)) for _ in range(4)])
    by_tilts, covariance = split_shared(own + shared @ shared.swapaxes(1, 2), shared)
    flat = shared.reshape(48, SHARED)
    whole = block_diag(*own) + flat @ flat.T
    assert np.allclose(covariance + by_tilts @ by_tilts.T, whole)
    nothing, all_of_it = split_shared(own + shared @ shared.swapaxes(1, 2), shared, exact_axes=True)
    assert not nothing.any() and np.allclose(all_of_it, whole)
