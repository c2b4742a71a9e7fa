"""The release velocity from laser spots, against rays that a test of its own cuts with the walls."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.camera import LaserFileError, LaserTracks, read_tracks
from tfsat_host.evaluation.clock_fit import Pair, fit_clock
from tfsat_host.evaluation.laser_spots import BodyRotation
from tfsat_host.evaluation.laser_velocity import (
    LaserError,
    ReleaseVelocity,
    Velocity,
    VelocityWindows,
    release_velocity,
    windows_of,
)
from tfsat_host.evaluation.stages import com_in_bodies_m, sensor_arms_m
from tfsat_host.plan.facility import load_tower
from tfsat_host.robot import load_robot

MODEL = load_robot()
COM_M = com_in_bodies_m(MODEL, np.zeros(3))[1]
WINDOWS = windows_of(load_tower())
PAUSE_S = 0.7
PAPER_RATE_RAD_S = np.deg2rad([-0.73, -0.48, -0.77])
PATH = Path("tracks.csv")


@dataclass
class Drop:
    """Flown by plain geometry: a point on body 2, a ray from it, a plane 200 mm away."""

    velocity_mm_s: FloatArray
    rate_rad_s: FloatArray
    wall_m: tuple[float, float] = (0.2, 0.2)
    acceleration_m_s2: float = 0.0

    def tracks(self, rng: np.random.Generator, noise_m: float, rate_hz: float = 60.0) -> LaserTracks:
        # Two lasers on body 2, one along x, one along y; the walls are 200 mm away.
        exits, rays, along = np.array([[0.1, 0.05, 0.056], [0.05, 0.1, 0.056]]), np.eye(3)[:2], (1, 0)
        t_s = np.arange(0.0, 1.0, 1 / rate_hz)
        attitude = Rotation.from_rotvec(np.outer(t_s, self.rate_rad_s))
        path = 1e-3 * np.outer(t_s, self.velocity_mm_s)
        path[:, 2] += self.acceleration_m_s2 * t_s**2 / 2
        rows = []
        for spot in (0, 1):
            start = COM_M + path + attitude.apply(exits[spot] - COM_M)
            ray = attitude.apply(rays[spot])
            # Where the ray meets the wall, by its distance from it.
            way = (exits[spot, spot] + self.wall_m[spot] - start[:, spot]) / ray[:, spot]
            hit = start + ray * way[:, None]
            rows.append(np.column_stack([t_s, np.full(len(t_s), spot + 1), hit[:, along[spot]], hit[:, 2]]))
        t, spots, sideways, up = np.concatenate(rows).T
        places = np.stack([sideways, up]) + noise_m * rng.normal(size=(2, len(t)))
        return LaserTracks(PATH, t, spots.astype(int), places[0], places[1], np.full(len(t), 5e-4), False)


def measure_release(tracks: LaserTracks, rate_rad_s: FloatArray, std_rad_s: float = 0.0) -> ReleaseVelocity:
    turning = steady(rate_rad_s, std_rad_s)
    return release_velocity(tracks, WINDOWS, first_stroke_s=PAUSE_S, turning=turning)


def steady(rate_rad_s: FloatArray, std_rad_s: float) -> BodyRotation:
    """Return a body turning at a constant rate until a second after the release."""
    turned = Rotation.from_rotvec(np.outer([0.0, 1.0], rate_rad_s))
    return BodyRotation(np.array([0.0, 1.0]), turned.as_matrix(), np.full(3, std_rad_s), COM_M)


def values(velocity: ReleaseVelocity) -> list[float]:
    assert velocity.transversal_x is not None and velocity.transversal_y is not None
    return [
        velocity.transversal_x.value_mm_s,
        velocity.transversal_y.value_mm_s,
        velocity.downward.value_mm_s,
    ]


def test_the_windows_are_the_paper_s() -> None:
    assert VelocityWindows((20.0, 100.0), 26.0) == WINDOWS


@given(st.tuples(*[st.floats(-60, 60)] * 3), st.tuples(*[st.floats(-0.05, 0.05)] * 3), st.floats(-5e-3, 5e-3))
def test_exact_places_give_the_exact_velocity(
    velocity: tuple[float, ...], rate: tuple[float, ...], acceleration_m_s2: float
) -> None:
    drop = Drop(np.array(velocity), np.array(rate), acceleration_m_s2=acceleration_m_s2)
    release_velocity = measure_release(drop.tracks(np.random.default_rng(0), 0.0), np.array(rate))
    # The spots are exact: the velocity must be, too.
    assert values(release_velocity) == pytest.approx([velocity[0], velocity[1], -velocity[2]], abs=0.02)
    assert release_velocity.samples_left_out == 0


def test_down_is_positive_and_judged_by_the_window() -> None:
    # The facility's window is 20 to 100 mm/s.
    for down_mm_s, judged in [(40.0, "within"), (120.0, "outside"), (20.0, "uncertain"), (-40.0, "outside")]:
        rng = np.random.default_rng(0)
        velocity = measure_release(
            Drop(np.array([5, 5, -down_mm_s]), np.zeros(3)).tracks(rng, 5e-4), np.zeros(3)
        )
        assert velocity.downward.value_mm_s == pytest.approx(down_mm_s, abs=4 * velocity.downward.std_mm_s)
        assert velocity.downward_judged == judged
    rng = np.random.default_rng(0)
    fast = measure_release(Drop(np.array([30, -30, -40]), np.zeros(3)).tracks(rng, 5e-4), np.zeros(3))
    assert fast.transversal_judged == "outside"
    assert fast.transversal_speed is not None
    assert fast.transversal_speed.value_mm_s == pytest.approx(42.4, abs=2)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """Noise, a gyro's error, walls that are not where they are said to be, and what remains of gravity."""
    rng = np.random.default_rng(7)
    # 160 drops with random walls, random remaining gravity and random gyro errors.
    coverage = []
    for _ in range(160):
        velocity = rng.normal(0, 8, 3) - np.array([0, 0, 40])
        walls = (0.2 + 0.03 * rng.normal(), 0.2 + 0.03 * rng.normal())
        drop = Drop(velocity, PAPER_RATE_RAD_S, walls, rng.uniform(-1, 1) * 9.8e-3)
        rate_std = np.deg2rad(0.2)
        release_velocity = measure_release(
            drop.tracks(rng, 5e-4), PAPER_RATE_RAD_S + rate_std * rng.normal(size=3), rate_std
        )
        speed = float(np.hypot(*velocity[:2]))
        truths = [velocity[0], velocity[1], -velocity[2], speed]
        stated = [
            release_velocity.transversal_x,
            release_velocity.transversal_y,
            release_velocity.downward,
            release_velocity.transversal_speed,
        ]
        coverage.append(
            [
                interval is not None and interval.low_mm_s <= t <= interval.high_mm_s
                for interval, t in zip(stated, truths, strict=True)
            ]
        )
    share = np.mean(coverage, axis=0)
    # A 95 % interval holds at least 91 % of the time, and the three velocities not always.
    assert (share > 0.91).all() and (share[:3] < 0.995).all(), share


def test_places_that_mostly_contradict_the_gyro_are_refused() -> None:
    """Refuse spot positions that mostly contradict the gyro, without stating a velocity.

    The gyro shows another rotation than the spots, which a few wrong positions would not explain.
    """
    drop = Drop(np.array([3.0, -4.0, -40.0]), np.deg2rad([20.0, -30.0, 25.0]))
    tracks = drop.tracks(np.random.default_rng(3), 1e-7)
    with pytest.raises(LaserError, match="places do not lie on one even motion"):
        measure_release(tracks, np.zeros(3), 1e-4)


def test_another_light_taken_for_the_spot_is_left_out() -> None:
    rng = np.random.default_rng(3)
    tracks = Drop(np.array([7.0, -3.0, -40.0]), np.zeros(3)).tracks(rng, 3e-4)
    in_use = np.flatnonzero((tracks.t_s > 0.15) & (tracks.t_s < PAUSE_S))
    wrong = rng.choice(in_use, 12, replace=False)
    up_m = tracks.up_m.copy()
    # Twelve places are 2 to 30 cm wrong.
    up_m[wrong] += rng.uniform(0.02, 0.3, 12)
    velocity = measure_release(replace(tracks, up_m=up_m), np.zeros(3))
    assert velocity.samples_left_out == 12
    assert values(velocity) == pytest.approx([7, -3, 40], abs=2)
    assert velocity.scatter_mm == pytest.approx(0.3, abs=0.06)


@pytest.mark.parametrize(("spot", "missing"), [(1, "x"), (2, "y")])
def test_one_spot_tells_the_fall_and_one_side(spot: int, missing: str) -> None:
    tracks = Drop(np.array([7.0, -3.0, -40.0]), np.zeros(3)).tracks(np.random.default_rng(4), 3e-4)
    rows = tracks.spot == spot
    columns = {name: getattr(tracks, name)[rows] for name in ("t_s", "spot", "along_m", "up_m", "std_m")}
    velocity = measure_release(replace(tracks, **columns), np.zeros(3))
    assert velocity.downward.value_mm_s == pytest.approx(40, abs=3)
    sides = {"x": velocity.transversal_x, "y": velocity.transversal_y}
    # Without the other spot there is nothing to tell the missing side.
    assert sides.pop(missing) is None
    (side,) = sides.values()
    assert side is not None and side.value_mm_s == pytest.approx({1: -3, 2: 7}[spot], abs=2)
    assert velocity.transversal_speed is None and velocity.transversal_judged is None
    assert f"along {missing} is unknown: there is no place of spot {3 - spot}" in velocity.notes[0]


def test_the_push_and_the_strokes_are_not_looked_at() -> None:
    tracks = Drop(np.array([7.0, -3.0, -40.0]), np.zeros(3)).tracks(np.random.default_rng(5), 3e-4)
    # Before 0.15 s the robot is still pushed, behind 0.7 s its joints move.
    moved = np.where((tracks.t_s < 0.15) | (tracks.t_s > PAUSE_S), 0.1, 0.0)
    velocity, plain = (
        measure_release(replace(tracks, up_m=tracks.up_m + moved), np.zeros(3)),
        measure_release(tracks, np.zeros(3)),
    )
    assert velocity == plain
    assert 0.15 <= velocity.from_s < velocity.until_s <= PAUSE_S


def test_too_few_places_are_no_velocity() -> None:
    tracks = Drop(np.array([7.0, -3.0, -40.0]), np.zeros(3)).tracks(np.random.default_rng(6), 3e-4)
    with pytest.raises(LaserError, match="too few places") as refused:
        # Twelve seconds late: none of the places is of this drop.
        measure_release(replace(tracks, t_s=tracks.t_s + 12.0), np.zeros(3))
    assert "count from the release" in refused.value.next_step


def test_a_window_s_verdict() -> None:
    assert Velocity(30, 1, 28, 32).judge(20, 100) == "within"
    assert Velocity(30, 1, 28, 32).judge(29, 100) == "uncertain"
    assert Velocity(30, 1, 28, 32).judge(33, 100) == "outside"


# ---- the file


def test_the_file_of_tracks(tmp_path: Path) -> None:
    file = tmp_path / "tracks.csv"
    file.write_text("video_t_s,spot,along_mm,up_mm,std_mm\n13.0,2,1.5,-20,\n12.5,1,-3,4,0.25\n")
    tracks = read_tracks(file)
    assert tracks.t_s.tolist() == [12.5, 13.0] and tracks.spot.tolist() == [1, 2]
    assert tracks.along_m == pytest.approx([-3e-3, 1.5e-3]) and tracks.up_m == pytest.approx([4e-3, -20e-3])
    assert tracks.std_m == pytest.approx([2.5e-4, 5e-4])
    with pytest.raises(LaserFileError, match="nothing ties to the release"):
        tracks.after_release(None)
    fit = fit_clock("video", [Pair("release", 12.4, 0.0, 1e-3), Pair("landing", 14.9, 2.5, 1e-3)])
    # Two events tie the video to the release: 12.4 s is zero.
    assert tracks.after_release(fit).t_s == pytest.approx([0.1, 0.6], abs=1e-6)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("t_s,spot,along_mm\n0,1,0\n", 1, "no column up_mm"),
        ("spot,along_mm,up_mm\n1,0,0\n", 1, "neither t_s nor video_t_s"),
        ("t_s,video_t_s,spot,along_mm,up_mm\n0,0,1,0,0\n", 1, "both t_s and video_t_s"),
        ("t_s,spot,along_mm,up_mm\n0,1,0,0\n0.1,3,0,0\n", 3, "the spot is '3'"),
        ("t_s,spot,along_mm,up_mm\n0,1,0\n", 2, "up_mm is missing"),
        ("t_s,spot,along_mm,up_mm\n0,1,nan,0\n", 2, "along_mm is 'nan'"),
        ("t_s,spot,along_mm,up_mm,std_mm\n0,1,0,0,-1\n", 2, "must be above 0"),
        ("t_s,spot,along_mm,up_mm\n", None, "no place of a spot"),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str, line: int | None, words: str) -> None:
    file = tmp_path / "tracks.csv"
    file.write_text(text)
    with pytest.raises(LaserFileError) as refused:
        read_tracks(file)
    assert words in refused.value.what
    assert refused.value.what.startswith(f"{file}:{line}: " if line else f"{file}: ")


# ---- arms


def test_the_com_in_a_body_s_frame() -> None:
    robot_com_m = MODEL.mass_kg @ (MODEL.origin_m + MODEL.com_m) / MODEL.mass_kg.sum()
    assert com_in_bodies_m(MODEL, np.zeros(3)) == pytest.approx(robot_com_m - MODEL.origin_m)
    # Joint 1 opened by a right angle about +x: what the other bodies see moves by body 1's share.
    opened = com_in_bodies_m(MODEL, np.array([np.pi / 2, 0, 0]))
    hinge = MODEL.joint_point_m[0]
    body_1 = MODEL.origin_m[0] + MODEL.com_m[0] - hinge
    swung = np.array([body_1[0], -body_1[2], body_1[1]]) - body_1
    # Angle 1 is that of body 1, the outer one, against body 2.
    moved = MODEL.mass_kg[0] / MODEL.mass_kg.sum() * swung
    assert opened[1] == pytest.approx(robot_com_m + moved - MODEL.origin_m[1])
    # Seen by body 1 itself: about the hinge, turned back.
    center = robot_com_m + moved - hinge
    assert opened[0] == pytest.approx(
        np.array([center[0], center[2], -center[1]]) + hinge - MODEL.origin_m[0]
    )
    arms = sensor_arms_m(MODEL, np.zeros(3))
    assert arms[2] == pytest.approx(MODEL.imus[2].position_m - robot_com_m)
