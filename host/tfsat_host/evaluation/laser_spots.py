"""Two laser spots on the walls: where they are for a path of the robot and a rotation of body 2, and which is which.

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

Which spot is which, and which way `along_mm` grows, is held against the rotation that body 2's gyro measured
(`identity_of`). A spot moves with the robot, evenly, and with body 2's turning, which the gyro tells: differently on
either wall, up and along. Each way to read the file (spots exchanged or not, each spot's `along_mm` mirrored or not) is
fitted with an even motion, the distances of the walls and the video's zero as nuisance parameters, and an error of a
place that has Student's distribution. The slow turn before the first stroke tells little, a part of a stroke which spot
is which, and places behind the last stroke, where the body has turned about the vertical, which way `along_mm` grows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
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


EVIDENCE = 2.0 * float(np.log(100.0))
"""Difference of twice the log-likelihoods from which one reading is believed against another: a hundred to one."""
MAX_TURN_RAD = 0.6
"""So far a ray still meets its own wall: places of other times are not looked at."""
_MAX_SCATTER = 4.0
"""In units of what is stated of a place: where no reading comes nearer, something else is wrong."""
_FREEDOM = 4.0
"""Of Student's distribution: a wrong place now and then decides nothing."""
_ROUNDS = 20
_ZERO_STD_S = 0.01
"""Of the video's zero."""
# Steps of the differences by which the nuisances enter the design matrix.
_STEP_M, _STEP_S, _STEP_RAD_S = 1e-3, 1e-3, 1e-4
_MIN_RATE_STD_RAD_S = 1e-6


class Reading(NamedTuple):
    """A way to read a file of tracks."""

    exchanged: bool
    mirrored: tuple[bool, bool]

    def of(self, tracks: LaserTracks) -> LaserTracks:
        """Return the tracks as this reading interprets them."""
        spot = 3 - tracks.spot if self.exchanged else tracks.spot
        # Mirrored are the file's spots: index by its numbers, before the exchange.
        sign = np.where(np.array(self.mirrored)[tracks.spot - 1], -1.0, 1.0)
        return replace(tracks, spot=spot, along_m=sign * tracks.along_m)

    def words(self) -> str:
        """Format how this reading differs from the file."""
        changes = ["spots 1 and 2 are exchanged"] if self.exchanged else []
        changes += [f"along_mm of spot {n} is mirrored" for n in (1, 2) if self.mirrored[n - 1]]
        return " and ".join(changes)


AS_FILED = Reading(exchanged=False, mirrored=(False, False))


class Identity(NamedTuple):
    """What the turning of body 2 says.

    Attributes:
        better: The reading that suits far better than the file's; None: there is none.
        possible: Other readings that suit the turning not much worse.
    """

    better: Reading | None
    possible: tuple[Reading, ...]


def identity_of(tracks: LaserTracks, turning: BodyRotation, from_s: float) -> Identity:
    """Compares all readings of tracks whose times count from the release; those before `from_s` are not used."""
    usable_tracks = tracks.between(max(from_s, float(turning.t_s[0])), float(turning.t_s[-1]))
    usable_tracks = usable_tracks.only(
        np.interp(usable_tracks.t_s, turning.t_s, turning.angle_rad()) <= MAX_TURN_RAD
    )
    # Mirroring a spot without places changes nothing: such readings would tie with others.
    readings = possible_readings(set(usable_tracks.spot.tolist()))
    # First with the errors as stated; the best reading's residuals tell how good the places really are.
    costs, scales = np.array([_cost(variant.of(usable_tracks), turning, 1.0) for variant in readings]).T
    scale = float(scales[int(np.argmin(costs))])
    # No reading fits: the turning neither confirms nor contradicts the file.
    if scale > _MAX_SCATTER:
        return Identity(None, ())
    # With places worse than stated, the likelihoods would overstate the evidence: compare again, scaled.
    if scale > 1.0:
        costs = np.array([_cost(variant.of(usable_tracks), turning, scale)[0] for variant in readings])
    best = int(np.argmin(costs))
    if costs[best] < costs[0] - EVIDENCE:
        return Identity(readings[best], ())
    # Readings that the turning does not exclude: the file is believed, but the caller says so.
    near = costs < costs[0] + EVIDENCE
    return Identity(
        None, tuple(variant for variant, is_near in zip(readings[1:], near[1:], strict=True) if is_near)
    )


def possible_readings(spots: set[int]) -> list[Reading]:
    """Return all readings of a file with such spots, the file's own first."""
    readings = (Reading(exchanged, (a, b)) for exchanged, a, b in product((False, True), repeat=3))
    return [reading for reading in readings if all(n in spots for n in (1, 2) if reading.mirrored[n - 1])]


def _cost(tracks: LaserTracks, turning: BodyRotation, scale: float) -> tuple[float, float]:
    """Twice the negative log-likelihood, but for a constant; the residuals' scale in units of what was stated."""
    plain = equations_of(tracks, turning, LASERS)
    nuisances = list(_nuisances(tracks, turning))
    # Linearised nuisances: how far each place moves with one step of walls, time and rates.
    columns = [plain.place_m - equations_of(*moved).place_m for _, moved in nuisances]
    zeros = (plain.series[:, None] == np.arange(4)).astype(np.float64)
    falling = (plain.toward @ UP) * plain.t_s**2 / 2.0
    design = np.column_stack([plain.toward * plain.t_s[:, None], zeros, falling, *columns])
    of_nuisances = [share for share, _ in nuisances]
    # Path and zeros get a numerical prior only; acceleration and nuisances are held by their deviations.
    prior = np.array([*np.full(7, 1e-6), 1.0 / ACCELERATION_STD_M_S2, *of_nuisances])
    std = scale * plain.std_m
    design, target, weight = design / std[:, None], plain.place_m / std, np.ones(len(std))
    residual, solution = plain.place_m, prior
    for _ in range(_ROUNDS):
        normal = design.T @ (weight[:, None] * design) + np.diag(prior**2)
        solution = np.linalg.lstsq(normal, design.T @ (weight * target), rcond=None)[0]
        residual = target - design @ solution
        # Student's likelihood by iteratively reweighted least squares.
        weight = (_FREEDOM + 1.0) / (_FREEDOM + residual**2)
    # The priors of acceleration and nuisances count; the first seven are there for the solver alone.
    return _minus_twice_log(residual) + float(((prior * solution)[7:] ** 2).sum()), 1.4826 * float(
        np.median(np.abs(residual))
    )


def _nuisances(
    tracks: LaserTracks, turning: BodyRotation
) -> Iterator[tuple[float, tuple[LaserTracks, BodyRotation, list[Laser]]]]:
    """Yield a step of each nuisance: its share of the standard deviation, and the geometry with that step."""
    for number, laser in enumerate(LASERS):
        lasers = list(LASERS)
        lasers[number] = laser._replace(wall_m=laser.wall_m + _STEP_M)
        yield _STEP_M / laser.wall_std_m, (tracks, turning, lasers)
    # Keep within the gyro's times: its rotation is not extrapolated.
    later = np.clip(tracks.t_s + _STEP_S, turning.t_s[0], turning.t_s[-1])
    yield _STEP_S / _ZERO_STD_S, (replace(tracks, t_s=later), turning, list(LASERS))
    for axis, std in enumerate(turning.rate_std_rad_s):
        # A constant error of the rate is an angle that grows with time.
        error = Rotation.from_rotvec(np.outer(turning.t_s, _STEP_RAD_S * np.eye(3)[axis])).as_matrix()
        yield (
            _STEP_RAD_S / max(float(std), _MIN_RATE_STD_RAD_S),
            (tracks, turning._replace(rotation=turning.rotation @ error), list(LASERS)),
        )


def _minus_twice_log(residual: FloatArray) -> float:
    return float((_FREEDOM + 1.0) * np.log1p(residual**2 / _FREEDOM).sum())
