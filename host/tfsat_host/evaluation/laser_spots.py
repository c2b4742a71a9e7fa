"""Two laser spots on the walls: where they are for a path of the robot and a rotation of body 2.

Frame: body 2's axes at the release; z up, so the robot, pushed off downwards, has a *downward* velocity above zero.
Velocities are relative to the capsule. The paper states of the lasers only: mounted orthogonally on body 2, graph paper
on the side walls.

| | spot 1 | spot 2 | |
|---|---|---|---|
| ray | +x of body 2 | +y of body 2 | assumed |
| `along_mm` grows towards | +y | +x | by definition of the file |
| laser at | (100, 50, 56) mm | (50, 100, 56) mm | assumed: the middle of a side of body 2 |
| to the wall | 200 ± 30 mm | 200 ± 30 mm | assumed: half of the space's 500 mm, less half of body 2 |

The distance matters only as far as body 2 turns: 30 mm are 0.4 mm/s at the paper's 0.8 deg/s.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.evaluation.camera import LaserTracks
from tfsat_host.units import STANDARD_GRAVITY_M_S2

UP = np.array([0.0, 0.0, 1.0])
"""z of every body in the releaser."""
ACCELERATION_STD_M_S2 = 1e-3 * STANDARD_GRAVITY_M_S2 / 3**0.5
"""What remains of gravity is up to a thousandth, up or down: an acceleration within it is fitted along."""


class Laser(NamedTuple):
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
    wall_m: float = 0.2
    wall_std_m: float = 0.03


LASERS = (
    Laser(np.eye(3)[0], np.eye(3)[1], np.array([0.100, 0.050, 0.056])),
    Laser(np.eye(3)[1], np.eye(3)[0], np.array([0.050, 0.100, 0.056])),
)
"""Of spot 1 and spot 2; see the module's table."""


class BodyRotation(NamedTuple):
    """How body 2 turned after the release, by its gyro.

    Attributes:
        t_s: (n,) ascending, after the release; 2 at least.
        rotation: (n, 3, 3) from body 2's axes to where these were at the release.
        rate_std_rad_s: (3,) standard deviation of the rate that it was integrated from, constant in time.
        com_m: (n, 3) the robot's CoM in body 2's frame, which moves as the joints do; (3,) while they stand.
    """

    t_s: FloatArray
    rotation: FloatArray
    rate_std_rad_s: FloatArray
    com_m: FloatArray

    def at(self, t_s: FloatArray) -> FloatArray:
        """(m, 3, 3) rotations at times between the first and the last."""
        # Interpolate along the arc: a blend of matrices is no rotation.
        return np.asarray(Slerp(self.t_s, Rotation.from_matrix(self.rotation))(t_s).as_matrix())

    def com_at(self, t_s: FloatArray) -> FloatArray:
        """(m, 3) the CoM at such times."""
        com = np.broadcast_to(self.com_m, (len(self.t_s), 3))
        return np.column_stack([np.interp(t_s, self.t_s, column) for column in com.T])

    def angle_rad(self) -> FloatArray:
        """(n,) by how much the body has turned."""
        return np.asarray(Rotation.from_matrix(self.rotation).magnitude())


class Equations(NamedTuple):
    """Places of spots as linear functions of the path of the robot's CoM: `place = toward @ path + turned`, but for a
    constant of each spot and coordinate. 2 m rows for m places, along first, then up.

    Attributes:
        t_s: (2 m,) after the release.
        series: (2 m,) 0 to 3: which spot and coordinate.
        place_m: (2 m,) as read, less what the turning of body 2 does to it.
        std_m: (2 m,) of it.
        toward: (2 m, 3) what a step of the CoM does to the place, body 2's axes at the release.
    """

    t_s: FloatArray
    series: IntArray
    place_m: FloatArray
    std_m: FloatArray
    toward: FloatArray


def equations_of(tracks: LaserTracks, turning: BodyRotation, lasers: Sequence[Laser]) -> Equations:
    """Build the equations of the laser spots' places on the walls.

    A ray from exit p along u meets the wall n x = D at p + u (D - n p) / (n u); both p and u turn with body 2.
    """
    rotation, com_m = turning.at(tracks.t_s), turning.com_at(tracks.t_s)
    at_release_m = turning.com_at(turning.t_s[:1])[0]
    toward = np.empty((2, len(tracks.t_s), 3))
    turned = np.empty((2, len(tracks.t_s)))
    for number, laser in enumerate(lasers, 1):
        rows = tracks.spot == number
        ray = rotation[rows] @ laser.ray
        # (m, 3) from the CoM to the laser's exit, in the axes of the release.
        arm = np.einsum("mij,mj->mi", rotation[rows], laser.exit_m - com_m[rows])
        # Distance of the wall's plane from the CoM at the release, along its normal: D.
        wall = laser.ray @ (laser.exit_m - at_release_m) + laser.wall_m
        for index, axis in enumerate((laser.along, UP)):
            # How far the spot slides along the wall for each metre that the wall is away: (u axis) / (n u).
            slant = (ray @ axis) / (ray @ laser.ray)
            # Linear in the path: a step along the normal counts by the slant, one along the wall in full.
            toward[index, rows] = axis - slant[:, None] * laser.ray
            # What is left is due to the turning alone, which the gyro tells: a known offset of the place.
            turned[index, rows] = np.einsum("mi,mi->m", toward[index, rows], arm) + slant * wall
    return Equations(
        np.tile(tracks.t_s, 2),
        # Series 0 and 1 are spot 1's along and up, 2 and 3 those of spot 2.
        np.concatenate([2 * (tracks.spot - 1), 2 * (tracks.spot - 1) + 1]),
        np.concatenate([tracks.along_m, tracks.up_m]) - turned.ravel(),
        np.tile(tracks.std_m, 2),
        toward.reshape(-1, 3),
    )
