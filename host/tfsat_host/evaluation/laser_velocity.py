"""The velocity with which the robot left the release mechanism, from two laser spots on graph paper.

Two lasers on body 2 point at right angles to one another at two side walls (the paper, sections "Design of the
transformable robot" and "Arrangement in the inner capsule"). A spot moves with the robot, and by the distance to the
wall times the angle by which body 2 turns; the gyro's share is taken off first. Until the first stroke the CoM moves
evenly, but for what remains of gravity.

`laser_spots` has the frame and what is assumed of the lasers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.special import stdtrit

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.camera import LaserTracks
from tfsat_host.evaluation.laser_spots import (
    ACCELERATION_STD_M_S2,
    LASERS,
    UP,
    BodyRotation,
    Equations,
    Identity,
    Laser,
    equations_of,
    identity_of,
)
from tfsat_host.plan.facility import DropTower, permissible_transversal_velocity_mm_s

PUSHED_OFF_S = 0.15
"""Until then the levers of the switches may still push: when they snap back they have 4.0 mm to go (SS-5GL: FP less
RP), which takes 0.13 s at 30 mm/s."""
CONFIDENCE = 0.95
PAPER_RADIUS_MM = 100.0
"""Of the robot over the whole maneuver (section "Design of the release mechanism")."""
_MIN_SAMPLES = 4
_MIN_SPAN_S = 0.1
_MAX_LEFT_OUT = 0.25
"""Of all places: wrong ones are few; where many seem wrong, something else is."""
_UNIT_FACTOR = 5.0
"""Between a mistaken unit, 10 or more, and a velocity that is outside by itself."""
_ROUNDS = 30
_SETTLED = 1e-6
"""Relative change of the scatter after which another round would change nothing."""
_HUBER = 1.5
"""A residual beyond so many deviations weighs less while the good places are looked for."""
_LEFT_OUT = 5.0
"""A place beyond so many deviations is not used: of good ones, one in two million."""
_NORMAL_MAD = 1.4826
"""Standard deviation over median absolute deviation of a normal distribution."""
_FLOOR_M = 1e-6

Judgement = Literal["within", "outside", "uncertain"]


class LaserError(TfsatError):
    """The tracks do not hold what a velocity needs (exit code 1)."""


class VelocityWindows(NamedTuple):
    """What the facility permits, mm/s: the downward velocity from, to; the transversal speed up to."""

    downward_mm_s: tuple[float, float]
    transversal_mm_s: float


def windows_of(tower: DropTower) -> VelocityWindows:
    """Compute a facility's velocity windows for a robot with the reach of the paper's."""
    sideways = permissible_transversal_velocity_mm_s(tower.envelope_radius_mm, PAPER_RADIUS_MM, tower.fall_s)
    return VelocityWindows(tower.release_velocity_window_mm_s, sideways)


@dataclass(frozen=True, slots=True)
class Velocity:
    """A velocity with its standard deviation and 95 % interval (Student)."""

    value_mm_s: float
    std_mm_s: float
    low_mm_s: float
    high_mm_s: float

    def judge(self, low_mm_s: float, high_mm_s: float) -> Judgement:
        """Judge whether the interval lies entirely within a window, entirely outside it, or partly."""
        if low_mm_s <= self.low_mm_s and self.high_mm_s <= high_mm_s:
            return "within"
        return "outside" if self.high_mm_s < low_mm_s or self.low_mm_s > high_mm_s else "uncertain"


@dataclass(frozen=True, slots=True)
class ReleaseVelocity:
    """How the robot left the release mechanism.

    Attributes:
        downward: Positive away from the releaser.
        transversal_x: Along x of body 2 at the release; None without spot 2, which alone shows it.
        transversal_y: Along y; None without spot 1.
        transversal_speed: Length of both; None if one is missing.
        downward_judged: Against the facility's window.
        transversal_judged: Likewise; None without `transversal_speed`.
        samples: Places of a spot that were used.
        samples_left_out: Places that lie off the others, such as another light taken for the spot.
        scatter_mm: Root mean square of what the fit leaves of a coordinate.
        from_s, until_s: What was used, after the release.
        notes: What is missing, one sentence each.
    """

    downward: Velocity
    transversal_x: Velocity | None
    transversal_y: Velocity | None
    transversal_speed: Velocity | None
    downward_judged: Judgement
    transversal_judged: Judgement | None
    samples: int
    samples_left_out: int
    scatter_mm: float
    from_s: float
    until_s: float
    notes: tuple[str, ...]


def release_velocity(
    tracks: LaserTracks,
    windows: VelocityWindows,
    *,
    first_stroke_s: float,
    turning: BodyRotation,
) -> ReleaseVelocity:
    """Estimate the velocity at the end of the push from places between it and the first stroke.

    Args:
        tracks: Times after the release, see `LaserTracks.after_release`; places in the first stroke help to
            tell the spots apart.
        windows: The permitted velocities.
        first_stroke_s: When the first stroke began, after the release.
        turning: Of body 2, by its gyro.

    Raises:
        LaserError: too few places in that time, or too many that contradict the others, or body 2's turning
            indicates that the spots are exchanged or mirrored.
    """
    # Between push and first stroke the CoM moves evenly; use it where the gyro tells body 2's turning.
    usable_tracks = _chosen(
        tracks, max(PUSHED_OFF_S, float(turning.t_s[0])), min(first_stroke_s, float(turning.t_s[-1]))
    )
    # Exchanged or mirrored spots would give another velocity: hold the file against the gyro first.
    identity = identity_of(tracks, turning, PUSHED_OFF_S)
    if identity.better is not None:
        raise LaserError(
            what=f"{tracks.path}: the spots move as body 2 turned only if {identity.better.words()}.",
            meaning="The velocity would be another one: none is given.",
            next_step="Look at the video which wall is which and which way the places grow (docs/evaluation.md has a "
            "sketch), and correct the file.",
        )
    path = _straight_path(usable_tracks, turning, LASERS)
    # A few outliers are misread places; many mean exchanged spots, wrong units or a wrong clock.
    if path.left_out > _MAX_LEFT_OUT * len(usable_tracks.t_s):
        raise LaserError(
            what=f"{tracks.path}: {path.left_out} of {len(usable_tracks.t_s)} places do not lie on one even motion.",
            meaning="The spots contradict each other or body 2's gyro: no velocity follows from them.",
            next_step="See that spots 1 and 2 are not exchanged, that along and up are millimetres on the paper, and "
            "that the times count from the release.",
        )
    # A component that no spot shows is NaN: as zero it adds nothing to the covariance.
    velocity = np.nan_to_num(path.velocity_m_s)
    # An error of the clock's rate scales all components alike: they are fully correlated.
    of_clock = np.outer(velocity, velocity) * tracks.rate_std**2
    covariance = path.covariance + _of_parameters(usable_tracks, turning, path) + of_clock
    # The scatter is estimated from few places: Student's two-sided quantile, not the normal one.
    student = float(stdtrit(path.degrees_of_freedom, 0.5 + CONFIDENCE / 2))
    x, y, up = (_velocity(path.velocity_m_s[axis], covariance[axis, axis], student) for axis in range(3))
    # Downward is minus z: the ends of the interval change places.
    down = Velocity(-up.value_mm_s, up.std_mm_s, -up.high_mm_s, -up.low_mm_s)
    speed = None
    if np.isfinite(path.velocity_m_s[:2]).all():
        # The deviation along the worst direction: near zero the velocity's own tells nothing.
        length, worst = np.linalg.norm(path.velocity_m_s[:2]), np.linalg.eigvalsh(covariance[:2, :2])[-1]
        speed = _velocity(float(length), float(worst), student, least_mm_s=0.0)
    return ReleaseVelocity(
        downward=down,
        transversal_x=x if np.isfinite(x.value_mm_s) else None,
        transversal_y=y if np.isfinite(y.value_mm_s) else None,
        transversal_speed=speed,
        downward_judged=down.judge(*windows.downward_mm_s),
        transversal_judged=speed.judge(0.0, windows.transversal_mm_s) if speed else None,
        samples=len(usable_tracks.t_s) - path.left_out,
        samples_left_out=path.left_out,
        scatter_mm=1e3 * path.scatter_m,
        from_s=float(usable_tracks.t_s.min()),
        until_s=float(usable_tracks.t_s.max()),
        notes=tuple(
            f"The velocity along {axis} is unknown: there is no place of spot {spot} in that time."
            for spot, axis in ((2, "x"), (1, "y"))
            if not (usable_tracks.spot == spot).any()
        )
        + _untold(identity)
        + _doubt_units(down, windows),
    )


def _doubt_units(down: Velocity, windows: VelocityWindows) -> tuple[str, ...]:
    """Format a sentence where sign or size of the velocity look like a mistake in the file's sign or unit."""
    low, high = windows.downward_mm_s
    if down.high_mm_s < 0.0:
        return ("By the file the robot left upwards: see that up_mm grows upwards on the wall.",)
    if not low / _UNIT_FACTOR < abs(down.value_mm_s) < _UNIT_FACTOR * high:
        return (
            "The velocity is far from what the facility permits: see that along_mm and up_mm are millimetres.",
        )
    return ()


def _untold(identity: Identity) -> tuple[str, ...]:
    """Format a sentence on the other readings of the file that body 2's turning cannot exclude, if any."""
    if not identity.possible:
        return ()
    single = [
        variant for variant in identity.possible if variant.exchanged + sum(variant.mirrored) == 1
    ] or identity.possible[:1]
    return (
        f"Body 2's turning cannot tell whether {' or '.join(variant.words() for variant in single)}: the file "
        "is believed. Places from a stroke on, and behind the last one, tell it.",
    )


def _chosen(tracks: LaserTracks, from_s: float, until_s: float) -> LaserTracks:
    rows = (tracks.t_s >= from_s) & (tracks.t_s <= until_s)
    often = [spot for spot in (1, 2) if (rows & (tracks.spot == spot)).sum() >= _MIN_SAMPLES]
    rows &= np.isin(tracks.spot, often)
    if not often or np.ptp(tracks.t_s[rows]) < _MIN_SPAN_S:
        raise LaserError(
            what=f"{tracks.path} has too few places of a spot {from_s:.2f} s to {until_s:.2f} s after the release.",
            meaning=f"A velocity takes {_MIN_SAMPLES} places of one spot over {_MIN_SPAN_S:g} s at least.",
            next_step="Track the spots from the release to the first stroke; see that times count from the release.",
        )
    return tracks.only(rows)


def _velocity(
    value_m_s: float, variance: float, student: float, least_mm_s: float = float("-inf")
) -> Velocity:
    value, std = 1e3 * float(value_m_s), 1e3 * float(np.sqrt(variance))
    return Velocity(value, std, max(least_mm_s, value - student * std), value + student * std)


def _of_parameters(tracks: LaserTracks, turning: BodyRotation, path: _StraightPath) -> FloatArray:
    """(3, 3) of the velocity, from the gyro's error and that of the distances: each moved by its deviation."""
    moved = []
    # A constant rate error per axis: the angle that it has grown to tilts the whole rotation history.
    for axis, std in enumerate(turning.rate_std_rad_s):
        angle = np.outer(turning.t_s, std * np.eye(3)[axis])
        # (n, 3, 3) identity plus the skew matrix of a small angle: column j is angle x e_j.
        error = np.eye(3) + np.cross(np.eye(3)[None], -angle[:, None, :]).transpose(0, 2, 1)
        off = turning._replace(rotation=turning.rotation @ error)
        # Keep the places of the nominal fit: a shift must not come from another selection.
        moved.append(_straight_path(tracks, off, LASERS, path.kept))
    for number, laser in enumerate(LASERS):
        lasers = list(LASERS)
        lasers[number] = laser._replace(wall_m=laser.wall_m + laser.wall_std_m)
        moved.append(_straight_path(tracks, turning, lasers, path.kept))
    # Independent errors, each shifting the velocity by one deviation: their outer products add up.
    shifts = np.nan_to_num(np.array([other.velocity_m_s - path.velocity_m_s for other in moved]))
    return np.asarray(shifts.T @ shifts)


class _StraightPath(NamedTuple):
    """The CoM's velocity at the release, extrapolated evenly.

    Attributes:
        velocity_m_s: (3,) NaN where no place shows it.
        covariance: (3, 3) of it from the scatter of the places; 0 where the velocity is NaN.
        degrees_of_freedom: Of the scatter.
        scatter_m: Root mean square of the residuals.
        kept: (2 m,) rows of the equations that were used.
        left_out: Places that were not.
    """

    velocity_m_s: FloatArray
    covariance: FloatArray
    degrees_of_freedom: int
    scatter_m: float
    kept: BoolArray
    left_out: int


def _straight_path(
    tracks: LaserTracks,
    turning: BodyRotation,
    lasers: Sequence[Laser],
    keep: BoolArray | None = None,
) -> _StraightPath:
    """Velocity, vertical acceleration and a zero of each spot and coordinate, by robust weighted least squares.

    `keep` (2 m,) are the rows to use; None: all but those that lie off the others.
    """
    equations = equations_of(tracks, turning, lasers)
    design, is_observable = _design(equations)
    # Unit weights where a place is as good as stated; the scatter then scales them all.
    design, target = design / equations.std_m[:, None], equations.place_m / equations.std_m
    prior = np.zeros(design.shape[1])
    # Over a short time a free acceleration would trade with the velocity: bound it by residual gravity.
    prior[3] = 1.0 / ACCELERATION_STD_M_S2
    if keep is None:
        keep = _good(design, target, prior)
    design, target, unit_weights = design[keep], target[keep], np.ones(int(keep.sum()))
    # The acceleration is held by its prior and not counted as a fitted parameter.
    free = max(len(unit_weights) - int(is_observable.sum()) + 1, 1)
    scale = 1.0
    solution, inverse = _solve(design, target, unit_weights, prior)
    for _ in range(_ROUNDS):  # what the prior weighs depends on the scatter, a little
        before, residual = scale, target - design @ solution
        # The floor keeps a perfect fit from claiming a velocity without error.
        scale = max(float(np.sqrt(residual @ residual / free)), _FLOOR_M / float(equations.std_m.max()))
        solution, inverse = _solve(design, target, unit_weights, scale * prior)
        if abs(scale - before) <= _SETTLED * before:
            break
    covariance = scale**2 * inverse[:3, :3]
    covariance[~is_observable[:3]] = covariance[:, ~is_observable[:3]] = 0.0
    residual = (target - design @ solution) * equations.std_m[keep]
    velocity = np.where(is_observable[:3], solution[:3], np.nan)
    # Rows hold all along, then all up: the first half has one row for each place.
    out = int((~keep[: len(keep) // 2]).sum())
    return _StraightPath(velocity, covariance, free, float(np.sqrt(np.mean(residual**2))), keep, out)


def _design(equations: Equations) -> tuple[FloatArray, BoolArray]:
    """(2 m, 8) of velocity, vertical acceleration and four zeros; (8,) whether any place shows a column."""
    time = equations.t_s[:, None]
    zeros = (equations.series[:, None] == np.arange(4)).astype(np.float64)
    falling = (equations.toward @ UP)[:, None] * time**2 / 2.0
    # Each spot and coordinate has a zero of its own: the graph paper's origin is free.
    design = np.hstack([equations.toward * time, falling, zeros])
    # Spot 1's places move with x only by the slant of its ray: of x, nothing that is worth a number.
    first, second = np.isin(np.arange(2), equations.series // 2)
    is_observable = np.array([second, first, True, True, first, first, second, second])
    design[:, ~is_observable] = 0.0
    return design, is_observable


def _solve(
    design: FloatArray, target: FloatArray, weight: FloatArray, prior: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Solve a least-squares problem; return the solution and the inverse of the normal matrix.

    A column of zeros gets the solution zero.
    """
    normal = design.T @ (weight[:, None] * design) + np.diag(prior**2)
    # The pseudo-inverse, for the columns of what no spot shows are zero.
    inverse = np.asarray(np.linalg.pinv(normal, hermitian=True), dtype=np.float64)
    return inverse @ (design.T @ (weight * target)), inverse


def _good(design: FloatArray, target: FloatArray, prior: FloatArray) -> BoolArray:
    """(2 m,) both coordinates of the places that agree, by iteratively reweighted least squares (Huber)."""
    weight, residual, scale = np.ones(len(target)), target, 1.0
    for _ in range(_ROUNDS):
        solution, _ = _solve(design, target, weight, scale * prior)
        residual = np.abs(target - design @ solution)
        before, scale = scale, max(_NORMAL_MAD * float(np.median(residual)), 1e-9)
        # Huber's weights: full within the bound, falling as 1 / |residual| beyond.
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(residual, 1e-12))
        if abs(scale - before) <= _SETTLED * before:
            break
    # Drop a place as a whole: both coordinates come of the same reading.
    off = (residual > _LEFT_OUT * scale).reshape(2, -1).any(axis=0)
    return np.tile(~off, 2)
