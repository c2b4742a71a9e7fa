"""The release velocity of an emulated drop: true motion cast on the walls, the turning from the card's gyro."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.fixtures.emulated_drop import OF_THE_PAPER, releaser
from tfsat_host.emulated.emulated_robot import SETTLE_US, US_PER_S
from tfsat_host.evaluation.camera import LaserTracks, read_tracks
from tfsat_host.evaluation.laser_spots import LASERS, UP, BodyRotation, Reading, possible_readings
from tfsat_host.evaluation.laser_velocity import LaserError, ReleaseVelocity, release_velocity, windows_of
from tfsat_host.evaluation.motion.attitude import integrate_rates
from tfsat_host.evaluation.stages import com_in_bodies_m
from tfsat_host.plan.facility import load_tower
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog, load
from tfsat_host.units import STANDARD_GRAVITY_M_S2

MODEL = load_robot()
PUSH_M_S = (0.006, -0.004, -0.045)
RATE_RAD_S = tuple(np.deg2rad([-0.73, -0.48, -0.77]))
FRAME_US = 16_667
BODY_2_ATTITUDE = slice(8, 12)


def cast(com_m: np.ndarray, angles_rad: np.ndarray, attitude: Rotation, number: int) -> tuple[float, float]:
    """Compute where a laser's ray meets its wall, along and up, in mm.

    Places in the world are taken relative to the falling capsule.
    """
    laser = LASERS[number - 1]
    start = com_m + attitude.apply(laser.exit_m - com_in_bodies_m(MODEL, angles_rad)[1])
    ray = attitude.apply(laser.ray)
    wall = laser.ray @ (laser.exit_m + MODEL.origin_m[1]) + laser.wall_m
    spot = start + ray * (wall - laser.ray @ start) / (laser.ray @ ray)
    return 1e3 * float(laser.along @ spot), 1e3 * float(spot[2])


@pytest.fixture(scope="module")
def drop(tmp_path_factory: pytest.TempPathFactory) -> tuple[DropLog, LaserTracks]:
    """Return the log of a drop and its laser tracks as typed in, to half a millimetre."""
    folder = tmp_path_factory.mktemp("drop")
    frames = []
    with releaser(seed=6) as (robot, sequencer, logger):
        sequencer.upload(OF_THE_PAPER)
        logger.start_recording()
        robot.advance(3 * US_PER_S)
        sequencer.arm()
        robot.record_truth(1000)
        let_go_s = robot.now_us / US_PER_S
        robot.drop(RATE_RAD_S, com_velocity_m_s=PUSH_M_S)
        while robot.falling:
            robot.advance(FRAME_US)
            now_s = robot.now_us / US_PER_S
            # The capsule falls, too: places are taken relative to it.
            fallen_m = STANDARD_GRAVITY_M_S2 * (now_s - let_go_s) ** 2 / 2  # the capsule, and its walls
            frames.append((now_s, robot.com_position_m() + fallen_m * UP))
        released_s = robot.released_us / US_PER_S
        robot.advance(SETTLE_US)
        logger.stop_recording()
        (folder / "SD.bin").write_bytes(robot.card())
        truth = robot.truth()
    lines = ["t_s,spot,along_mm,up_mm"]
    for now_s, com_m in frames:
        row = truth[np.argmin(np.abs(truth[:, 0] - now_s))]
        for number in (1, 2):
            along, up = cast(com_m, row[1:4], Rotation.from_quat(row[BODY_2_ATTITUDE]), number)
            # Read to half a millimetre, as a person types them.
            lines.append(f"{now_s - released_s:.4f},{number},{round(2 * along) / 2},{round(2 * up) / 2}")
    (folder / "tracks.csv").write_text("\n".join(lines))
    return load(folder / "SD.bin"), read_tracks(folder / "tracks.csv")


def turning_by_gyro(log: DropLog) -> BodyRotation:
    """Body 2's, less its rest before; mounted as designed."""
    rate, fall = log.rate_rad_s[:, 1], (log.t_s >= 0) & (log.t_s < 2.4)
    attitudes = integrate_rates(log.t_s[fall], rate[fall] - rate[log.t_s < -0.2].mean(axis=0))
    angles_rad = log.sensor_angle_rad[fall][:, ::2] - log.sensor_angle_rad[log.t_s < -0.2][:, ::2].mean(
        axis=0
    )
    com_m = np.array([com_in_bodies_m(MODEL, angles)[1] for angles in angles_rad])
    return BodyRotation(log.t_s[fall], attitudes.as_matrix(), np.full(3, np.deg2rad(0.05)), com_m)


def test_the_push_comes_back(drop: tuple[DropLog, LaserTracks], tmp_path: Path) -> None:
    log, tracks = drop
    windows = windows_of(load_tower())
    velocity = release_velocity(tracks, windows, first_stroke_s=0.7, turning=turning_by_gyro(log))
    parts = (velocity.transversal_x, velocity.transversal_y, velocity.downward)
    for part, true_m_s in zip(parts, (0.006, -0.004, 0.045), strict=True):
        assert part is not None
        # Inside of the interval that is stated, and this is small.
        assert part.low_mm_s < 1e3 * true_m_s < part.high_mm_s
        assert part.std_mm_s < 2.0
    assert velocity.transversal_speed is not None
    assert velocity.transversal_speed.value_mm_s == pytest.approx(7.2, abs=1.0)
    assert velocity.downward_judged == velocity.transversal_judged == "within"
    assert velocity.notes == ()


def measure_release(log: DropLog, tracks: LaserTracks) -> ReleaseVelocity:
    return release_velocity(
        tracks, windows_of(load_tower()), first_stroke_s=0.7, turning=turning_by_gyro(log)
    )


@pytest.mark.parametrize(
    "reading", possible_readings({1, 2})[1:], ids=lambda spot_reading: spot_reading.words()
)
def test_spots_that_are_exchanged_or_mirrored_give_no_velocity(
    drop: tuple[DropLog, LaserTracks], reading: Reading
) -> None:
    """Tracked over the whole fall, body 2's turning tells which of the eight readings is right."""
    log, tracks = drop
    with pytest.raises(LaserError, match="the spots move as body 2 turned only if ") as refused:
        measure_release(log, reading.of(tracks))
    # The reading that undoes the exchange has the mirrors swapped.
    undone = Reading(reading.exchanged, reading.mirrored[::-1] if reading.exchanged else reading.mirrored)
    assert f"only if {undone.words()}." in refused.value.what


def test_a_part_of_a_stroke_tells_which_spot_is_which(drop: tuple[DropLog, LaserTracks]) -> None:
    log, tracks = drop
    # A part of a stroke is enough to tell which spot is which.
    early = tracks.between(-1.0, 0.9)
    with pytest.raises(LaserError, match="only if spots 1 and 2 are exchanged"):
        measure_release(log, Reading(True, (False, False)).of(early))
    (note,) = measure_release(log, early).notes
    assert "exchanged" not in note and "mirrored" in note


def test_where_the_turning_cannot_tell_it_is_said(drop: tuple[DropLog, LaserTracks]) -> None:
    log, tracks = drop
    velocity = measure_release(log, tracks.between(-1.0, 0.7))
    (note,) = velocity.notes
    assert note.startswith("Body 2's turning cannot tell whether") and "mirrored" in note
    assert velocity.transversal_speed is not None
    assert velocity.transversal_speed.value_mm_s == pytest.approx(7.2, abs=1.0)


def test_places_that_are_wrong_now_and_then_hide_nothing(drop: tuple[DropLog, LaserTracks]) -> None:
    log, tracks = drop
    random, along = np.random.default_rng(1), tracks.along_m.copy()
    # Five places in a hundred are 5 cm off.
    along[random.random(len(along)) < 0.05] += 0.05
    assert measure_release(log, replace(tracks, along_m=along)).notes == ()
