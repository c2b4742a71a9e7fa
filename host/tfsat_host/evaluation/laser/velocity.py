"""The velocity with which the robot left the release mechanism, from two laser spots on graph paper.

Two lasers on body 2 point at right angles to one another at two side walls (the paper, sections "Design of the
transformable robot" and "Arrangement in the inner capsule"). A spot moves with the robot, and by the distance to the
wall times the angle by which body 2 turns; the gyro's share is taken off first. Until the first stroke the CoM moves
evenly, but for what remains of gravity.

Frame: body 2's axes at the release; z up, so the robot, pushed off downwards, has a *downward* velocity above zero.
Velocities are relative to the capsule.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.laser.geometry import BodyTurning, LaserGeometry, spot_equations
from tfsat_host.evaluation.laser.straight_path import StraightPath, fit_straight_path
from tfsat_host.evaluation.laser.tracks import LaserTracks
from tfsat_host.plan.facility import DropTower, permissible_transversal_velocity_mm_s
from tfsat_host.units import STANDARD_GRAVITY_M_S2

FloatArray = NDArray[np.float64]

PUSHED_OFF_S = 0.15
"""Until then the levers of the switches may still push: when they snap back they have 4.0 mm to go (SS-5GL: FP less
RP), which takes 0.13 s at 30 mm/s."""
RATE_STD_RAD_S = np.deg2rad(1.0)
"""Of a body that nobody measured after the release: the paper's turned by 0.5 to 0.8 deg/s about each axis."""
CONFIDENCE = 0.95
PAPER_RADIUS_MM = 100.0
"""Of the robot over the whole maneuver (section "Design of the release mechanism")."""
_LEAST_SAMPLES = 4
_LEAST_SPAN_S = 0.1

Judgement = Literal["within", "outside", "uncertain"]


_MOST_LEFT_OUT = 0.25
"""Of all places."""


class LaserError(TfsatError):
    """The tracks do not hold what a velocity needs (exit code 1)."""


@dataclass(frozen=True, slots=True)
class VelocityWindows:
    """What the facility permits, mm/s: the downward velocity from, to; the transversal speed up to."""

    downward_mm_s: tuple[float, float]
    transversal_mm_s: float


def windows_of(tower: DropTower, radius_mm: float = PAPER_RADIUS_MM) -> VelocityWindows:
    """Of a facility, for a robot that reaches `radius_mm` from its CoM over its maneuver."""
    sideways = permissible_transversal_velocity_mm_s(tower.envelope_radius_mm, radius_mm, tower.fall_s)
    return VelocityWindows(tower.release_velocity_window_mm_s, sideways)


@dataclass(frozen=True, slots=True)
class Velocity:
    """A velocity with its standard deviation and 95 % interval (Student)."""

    value_mm_s: float
    std_mm_s: float
    low_mm_s: float
    high_mm_s: float

    def judged(self, low_mm_s: float, high_mm_s: float) -> Judgement:
        """Whether all of the interval lies within a window, none of it, or some."""
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
        notes: What was assumed or is missing, one sentence each.
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
    com_m: FloatArray,
    windows: VelocityWindows,
    *,
    first_stroke_s: float,
    turning: BodyTurning | None = None,
    geometry: LaserGeometry | None = None,
    from_s: float = PUSHED_OFF_S,
    residual_acceleration_g: float = 1e-3,
) -> ReleaseVelocity:
    """The velocity at the end of the push, from places between `from_s` and `first_stroke_s`.

    Args:
        tracks: Times after the release, see `LaserTracks.after_release`.
        com_m: (3,) the robot's CoM in body 2's frame, see `arms.com_in_bodies_m`.
        windows: What is permitted.
        first_stroke_s: When the first stroke began, after the release.
        turning: Of body 2, by its gyro; None: it is taken to have turned at 0 ± 1 deg/s about each axis.
        geometry: Of the lasers; None: the assumed one.
        from_s: When the release mechanism has let go, after the release.
        residual_acceleration_g: The most that remains of gravity: an acceleration up to this, up or down, is
            fitted along.

    Raises:
        LaserError: too few places in that time, or too many that contradict the others.
    """
    notes = []
    if turning is None:
        turning = BodyTurning.steady(np.zeros(3), np.full(3, RATE_STD_RAD_S), first_stroke_s)
        notes.append(
            "Body 2 was taken not to turn after the release, give or take 1 deg/s: no rates were given."
        )
    kept = _chosen(tracks, max(from_s, float(turning.t_s[0])), min(first_stroke_s, float(turning.t_s[-1])))
    geometry = geometry or LaserGeometry()
    acceleration_std = residual_acceleration_g * STANDARD_GRAVITY_M_S2 / 3**0.5
    path = _path(kept, turning.at(kept.t_s), geometry, com_m, acceleration_std)
    _require_agreement(kept, path)
    covariance = path.covariance + _of_parameters(kept, turning, geometry, com_m, acceleration_std, path)
    for spot, axis in ((2, "x"), (1, "y")):
        if not (kept.spot == spot).any():
            notes.append(
                f"The velocity along {axis} is unknown: there is no place of spot {spot} in that time."
            )
    student = float(stdtrit(path.degrees_of_freedom, 0.5 + CONFIDENCE / 2))
    x, y, up = (_component(path, covariance, axis, student) for axis in range(3))
    speed = _speed(path.velocity_m_s[:2], covariance[:2, :2], student)
    down = Velocity(-up.value_mm_s, up.std_mm_s, -up.high_mm_s, -up.low_mm_s)
    return ReleaseVelocity(
        downward=down,
        transversal_x=x if np.isfinite(x.value_mm_s) else None,
        transversal_y=y if np.isfinite(y.value_mm_s) else None,
        transversal_speed=speed,
        downward_judged=down.judged(*windows.downward_mm_s),
        transversal_judged=speed.judged(0.0, windows.transversal_mm_s) if speed else None,
        samples=len(kept.t_s) - path.left_out,
        samples_left_out=path.left_out,
        scatter_mm=1e3 * path.scatter_m,
        from_s=float(kept.t_s.min()),
        until_s=float(kept.t_s.max()),
        notes=tuple(notes),
    )


def _chosen(tracks: LaserTracks, from_s: float, until_s: float) -> LaserTracks:
    rows = (tracks.t_s >= from_s) & (tracks.t_s <= until_s)
    often = [spot for spot in (1, 2) if (rows & (tracks.spot == spot)).sum() >= _LEAST_SAMPLES]
    rows &= np.isin(tracks.spot, often)
    if not often or np.ptp(tracks.t_s[rows]) < _LEAST_SPAN_S:
        raise LaserError(
            what=f"{tracks.path} has too few places of a spot {from_s:.2f} s to {until_s:.2f} s after the release.",
            meaning=f"A velocity takes {_LEAST_SAMPLES} places of one spot over {_LEAST_SPAN_S:g} s at least.",
            next_step="Track the spots from the release to the first stroke; see that times count from the release.",
        )
    return replace(
        tracks,
        t_s=tracks.t_s[rows],
        spot=tracks.spot[rows],
        along_m=tracks.along_m[rows],
        up_m=tracks.up_m[rows],
        std_m=tracks.std_m[rows],
    )


def _require_agreement(tracks: LaserTracks, path: StraightPath) -> None:
    """Wrong places are few; where many seem wrong, something else is."""
    if path.left_out > _MOST_LEFT_OUT * len(tracks.t_s):
        raise LaserError(
            what=f"{tracks.path}: {path.left_out} of {len(tracks.t_s)} places do not lie on one even motion.",
            meaning="The spots contradict each other or body 2's gyro: no velocity follows from them.",
            next_step="See that spots 1 and 2 are not exchanged, that along and up are millimetres on the paper, and "
            "that the times count from the release.",
        )


def _path(
    tracks: LaserTracks,
    rotation: FloatArray,
    geometry: LaserGeometry,
    com_m: FloatArray,
    acceleration_std: float,
    keep: NDArray[np.bool_] | None = None,
) -> StraightPath:
    return fit_straight_path(spot_equations(tracks, rotation, geometry, com_m), acceleration_std, keep)


def _of_parameters(
    tracks: LaserTracks,
    turning: BodyTurning,
    geometry: LaserGeometry,
    com_m: FloatArray,
    acceleration_std: float,
    path: StraightPath,
) -> FloatArray:
    """(3, 3) of the velocity, from the gyro's error and that of the distances: each moved by its deviation."""
    rotation = turning.at(tracks.t_s)
    moved = []
    for axis, std in enumerate(turning.rate_std_rad_s):
        angle = np.outer(tracks.t_s, std * np.eye(3)[axis])
        error = np.eye(3) + np.cross(np.eye(3)[None], -angle[:, None, :]).transpose(0, 2, 1)
        moved.append(_path(tracks, rotation @ error, geometry, com_m, acceleration_std, path.kept))
    for number, laser in enumerate(geometry.lasers):
        lasers = list(geometry.lasers)
        lasers[number] = replace(laser, wall_m=laser.wall_m + laser.wall_std_m)
        other = LaserGeometry((lasers[0], lasers[1]))
        moved.append(_path(tracks, rotation, other, com_m, acceleration_std, path.kept))
    shifts = np.nan_to_num(np.array([other.velocity_m_s - path.velocity_m_s for other in moved]))
    covariance: FloatArray = shifts.T @ shifts
    return covariance


def _component(path: StraightPath, covariance: FloatArray, axis: int, student: float) -> Velocity:
    value, std = 1e3 * float(path.velocity_m_s[axis]), 1e3 * float(np.sqrt(covariance[axis, axis]))
    return Velocity(value, std, value - student * std, value + student * std)


def _speed(velocity_m_s: FloatArray, covariance: FloatArray, student: float) -> Velocity | None:
    """The length, with the deviation along the worst direction: near zero the velocity's own tells nothing."""
    if not np.isfinite(velocity_m_s).all():
        return None
    value = 1e3 * float(np.linalg.norm(velocity_m_s))
    std = 1e3 * float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    return Velocity(value, std, max(0.0, value - student * std), value + student * std)
