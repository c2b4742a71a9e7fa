"""Where the lasers are on body 2 and what they point at, and how body 2 turns: how a spot moves with the robot."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from tfsat_host.evaluation.laser.tracks import LaserTracks

FloatArray = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])
"""z of every body in the releaser."""


@dataclass(frozen=True, eq=False)
class Laser:
    """One laser, and the wall that it points at.

    Attributes:
        ray: (3,) unit vector in body 2's frame; horizontal in the releaser, and the normal of its wall.
        along: (3,) unit vector of the wall's horizontal coordinate, body 2's axes in the releaser.
        exit_m: (3,) where the ray leaves the laser, body 2's frame.
        wall_m: From there to the wall in the releaser, along the ray.
        wall_std_m: Standard deviation of `wall_m`.
    """

    ray: FloatArray
    along: FloatArray
    exit_m: FloatArray
    wall_m: float
    wall_std_m: float


def _default_lasers() -> tuple[Laser, Laser]:
    x, y = np.eye(3)[:2]
    return (
        Laser(ray=x, along=y, exit_m=np.array([0.100, 0.050, 0.056]), wall_m=0.2, wall_std_m=0.03),
        Laser(ray=y, along=x, exit_m=np.array([0.050, 0.100, 0.056]), wall_m=0.2, wall_std_m=0.03),
    )


@dataclass(frozen=True, eq=False)
class LaserGeometry:
    """Both lasers. The paper says of them only: mounted orthogonally on body 2, graph paper on the side walls.

    | | spot 1 | spot 2 | |
    |---|---|---|---|
    | ray | +x of body 2 | +y of body 2 | assumed |
    | `along_mm` grows towards | +y | +x | by definition of the file |
    | laser at | (100, 50, 56) mm | (50, 100, 56) mm | assumed: the middle of a side of body 2 |
    | to the wall | 200 ± 30 mm | 200 ± 30 mm | assumed: half of the space's 500 mm, less half of body 2 |

    The distance matters only as far as body 2 turns: 30 mm are 0.4 mm/s at the paper's 0.8 deg/s.

    Attributes:
        lasers: Of spot 1 and spot 2.
    """

    lasers: tuple[Laser, Laser] = field(default_factory=_default_lasers)


@dataclass(frozen=True, eq=False)
class BodyTurning:
    """How body 2 turned after the release, by its gyro.

    Attributes:
        t_s: (n,) ascending, after the release; 2 at least.
        rotation: (n, 3, 3) from body 2's axes to where these were at the release.
        rate_std_rad_s: (3,) standard deviation of the rate that it was integrated from, constant in time.
    """

    t_s: FloatArray
    rotation: FloatArray
    rate_std_rad_s: FloatArray

    @classmethod
    def steady(cls, rate_rad_s: FloatArray, rate_std_rad_s: FloatArray, until_s: float) -> BodyTurning:
        """At a constant rate (3,), body 2's axes, from the release until `until_s`: before anything moves."""
        turned = Rotation.from_rotvec(np.outer([0.0, until_s], rate_rad_s))
        return cls(np.array([0.0, until_s]), turned.as_matrix(), np.asarray(rate_std_rad_s, dtype=np.float64))

    def at(self, t_s: FloatArray) -> FloatArray:
        """(m, 3, 3) rotations at times between the first and the last."""
        between: FloatArray = Slerp(self.t_s, Rotation.from_matrix(self.rotation))(t_s).as_matrix()
        return between


@dataclass(frozen=True, eq=False)
class SpotEquations:
    """Places of spots as linear functions of the path of the robot's CoM: `place = toward @ path + turned`, but for a
    constant of each spot and coordinate. 2 m rows for m places, along first, then up.

    Attributes:
        t_s: (2 m,) after the release.
        series: (2 m,) 0 to 3: which spot and coordinate.
        place_m: (2 m,) as read.
        std_m: (2 m,) of it.
        toward: (2 m, 3) what a step of the CoM does to the place, body 2's axes at the release.
        turned_m: (2 m,) what the turning of body 2 does to it.
    """

    t_s: FloatArray
    series: NDArray[np.int64]
    place_m: FloatArray
    std_m: FloatArray
    toward: FloatArray
    turned_m: FloatArray


def spot_equations(
    tracks: LaserTracks, rotation: FloatArray, geometry: LaserGeometry, com_m: FloatArray
) -> SpotEquations:
    """A ray from exit p along u meets the wall n x = D at p + u (D - n p) / (n u); both p and u turn with body 2.

    Args:
        tracks: m places, times after the release.
        rotation: (m, 3, 3) of body 2 at these times.
        geometry: Of both lasers.
        com_m: (3,) the robot's CoM in body 2's frame, the joints as at the release.
    """
    toward = np.empty((2, len(tracks.t_s), 3))
    turned = np.empty((2, len(tracks.t_s)))
    for number, laser in enumerate(geometry.lasers, 1):
        rows = tracks.spot == number
        ray, arm = rotation[rows] @ laser.ray, rotation[rows] @ (laser.exit_m - com_m)
        wall = laser.ray @ (laser.exit_m - com_m) + laser.wall_m
        for index, axis in enumerate((laser.along, UP)):
            slant = (ray @ axis) / (ray @ laser.ray)
            toward[index, rows] = axis - slant[:, None] * laser.ray
            turned[index, rows] = np.einsum("mi,mi->m", toward[index, rows], arm) + slant * wall
    series = np.concatenate([2 * (tracks.spot - 1), 2 * (tracks.spot - 1) + 1])
    return SpotEquations(
        t_s=np.tile(tracks.t_s, 2),
        series=series,
        place_m=np.concatenate([tracks.along_m, tracks.up_m]),
        std_m=np.tile(tracks.std_m, 2),
        toward=toward.reshape(-1, 3),
        turned_m=turned.ravel(),
    )
