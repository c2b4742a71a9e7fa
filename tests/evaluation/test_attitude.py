"""Rates integrated to attitudes, and bodies' frames from rates and angle sensors."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.rehearsal.days import rehearse_drop
from tests.sdlog.motion import FALL_S, RATE_COUNTS, REST_S, moving_log
from tfsat_host.evaluation.body_frames import body_frames
from tfsat_host.evaluation.motion.attitude import integrate_rates, reorientation_deg
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropEvent, DropLog, load
from tfsat_host.sdlog.export_mcap import FrameTrack


def rates(t_s: np.ndarray) -> np.ndarray:
    """About an axis that wanders: turns about different axes do not commute."""
    return np.column_stack([3.0 * np.sin(4.0 * t_s), 2.0 * np.cos(3.0 * t_s), 1.0 + t_s])


def end(samples: int) -> Rotation:
    t_s = np.linspace(0.0, 2.0, samples)
    return integrate_rates(t_s, rates(t_s))[-1]


def test_a_constant_axis_is_exact_however_coarse_and_uneven_the_samples() -> None:
    t_s = np.array([0.0, 0.1, 0.5, 0.7, 1.2])
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    attitudes = integrate_rates(t_s, (0.3 + 0.8 * t_s)[:, None] * axis)
    # The rate is linear in time and about a fixed axis: its integral is exact.
    turned = 0.3 * t_s + 0.4 * t_s**2
    assert attitudes.as_rotvec() == pytest.approx(turned[:, None] * axis, abs=1e-12)


def plain(samples: int) -> Rotation:
    """Integrate the attitude from the mean of consecutive rates alone."""
    t_s = np.linspace(0.0, 2.0, samples)
    rate = rates(t_s)
    attitude = Rotation.identity()
    # No correction for an axis that moves within a step: what the integrator's error is compared with.
    for step in Rotation.from_rotvec(0.5 * (rate[1:] + rate[:-1]) * np.diff(t_s)[:, None]):
        attitude = attitude * step
    return attitude


def test_the_error_falls_with_the_square_of_the_step() -> None:
    """Attitude error falls with the square of the step.

    The remaining error comes from rates not being linear between samples; non-commuting rotations are
    corrected for.
    """
    best = end(40_001)
    errors = [reorientation_deg(best, end(samples)) for samples in (201, 401, 801)]
    # Second order: halving the step quarters the error.
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)
    # At the same step the correction for rotations that do not commute removes more than 40 % of the error.
    assert errors[1] < 0.6 * reorientation_deg(best, plain(401))


def test_every_attitude_is_the_product_of_all_steps_before_it() -> None:
    t_s = np.linspace(0.0, 1.0, 38)
    attitudes = integrate_rates(t_s, rates(t_s))
    for row in (1, 2, 7, 16, 37):
        assert (
            reorientation_deg(attitudes[row], integrate_rates(t_s[: row + 1], rates(t_s[: row + 1]))[-1])
            < 1e-9
        )


MODEL = load_robot()


@pytest.fixture
def log(tmp_path: Path) -> DropLog:
    return moving_log(tmp_path / "SD.bin")


def tracks(log: DropLog) -> dict[str, FrameTrack]:
    return {track.child: track for track in body_frames(log, MODEL).tracks}


def change_columns(log: DropLog, **columns: Any) -> DropLog:
    """Return the log with other columns, without values cached from the old ones."""
    return replace(log, **columns)


def test_attitude_is_the_gyro_less_its_rest_from_the_release_to_the_landing(log: DropLog) -> None:
    base = tracks(log)["body_3"]
    assert base.parent == "world"
    # From the first sample at or after the release; samples are 3.6 ms apart.
    assert base.t_us[0] >= log.origin_us > base.t_us[0] - 4000
    assert base.t_us[-1] < log.origin_us + FALL_S * 1e6 <= base.t_us[-1] + 4000
    # 65.5 counts per deg/s: the gyro at its 500 deg/s range.
    rate_rad_s = np.radians(np.array(RATE_COUNTS) / 65.5)
    turned = rate_rad_s * ((base.t_us - base.t_us[0]) / 1e6)[:, None]
    expected = Rotation.from_rotvec(turned)
    assert (Rotation.from_quat(base.quaternion_xyzw) * expected.inv()).magnitude().max() < 1e-9
    # The base is the frame of the world: it has no translation.
    assert not base.translation_m.any()


def test_the_gyro_s_mounting_is_the_robot_file_s(log: DropLog) -> None:
    # An orientation that exchanges axes and is no right angle, so that a transposed matrix shows.
    mounting = Rotation.from_euler("zy", [90, 30], degrees=True)
    imus = list(MODEL.imus)
    imus[2] = replace(imus[2], sensor_to_body=mounting.as_matrix())
    base = body_frames(log, replace(MODEL, imus=tuple(imus))).tracks[0]
    turned = np.radians(np.array(RATE_COUNTS) / 65.5) * (base.t_us[-1] - base.t_us[0]) / 1e6
    expected = Rotation.from_rotvec(mounting.apply(turned))
    assert (Rotation.from_quat(base.quaternion_xyzw[-1]) * expected.inv()).magnitude() < 1e-9


@pytest.mark.parametrize(
    ("child", "parent", "origin_mm", "turn_deg"),
    [
        # By hand, each joint at 90 deg: hinge + the arm from it, turned. Signs as the paper's joints open.
        ("body_2", "body_3", (102, 0, 202), (0, 90, 0)),
        ("body_1", "body_2", (0, -2, 102), (90, 0, 0)),
        ("body_4", "body_3", (0, 137, 15), (-90, 0, 0)),
    ],
)
def test_bodies_turn_about_their_hinges(
    log: DropLog, child: str, parent: str, origin_mm: tuple[float, ...], turn_deg: tuple[float, ...]
) -> None:
    track = tracks(log)[child]
    assert track.parent == parent
    first, last = Rotation.from_quat(track.quaternion_xyzw[[0, -1]])
    assert first.magnitude() == pytest.approx(0.0, abs=1e-9)
    assert np.rad2deg(last.as_rotvec()) == pytest.approx(turn_deg, abs=1e-6)
    assert track.translation_m[-1] * 1e3 == pytest.approx(origin_mm, abs=1e-6)


def test_one_sensor_of_a_joint_is_enough_and_none_leaves_its_body_out(log: DropLog) -> None:
    valid = log.angle_valid.copy()
    # Joint 1 loses one sensor throughout and the other one from 1.5 s on; joint 3 loses both.
    valid[:, 0] = False
    lost = int(np.searchsorted(log.t_s, 1.5))
    valid[lost:, 1] = False
    valid[:, 4:6] = False
    frames = body_frames(change_columns(log, angle_valid=valid), MODEL)
    assert {track.child for track in frames.tracks} == {"body_3", "body_2", "body_1"}
    joint_1 = next(track for track in frames.joints if track.name == "joint_1")
    # The angle is known up to the last valid sample.
    assert joint_1.t_us[-1] == log.t_us[lost - 1]
    assert any("No angle of joint 3" in note for note in frames.notes)


def test_angle_sensors_may_pass_their_zero(log: DropLog) -> None:
    """Counted from a rest a hair below the wrap, with noise across it."""
    # Counts jump between 4095 and 0 at rest: a difference must be taken modulo a turn.
    counts = (log.angle_counts.astype(int) + 4095 - log.angle_counts[0].astype(int)) % 4096
    counts[::2] = (counts[::2] + 2) % 4096
    wrapped = tracks(change_columns(log, angle_counts=counts.astype(np.uint16)))
    for child, track in tracks(log).items():
        turned = Rotation.from_quat(wrapped[child].quaternion_xyzw)
        away = (turned * Rotation.from_quat(track.quaternion_xyzw).inv()).magnitude()
        assert np.rad2deg(away.max()) < 0.2


def test_a_hole_ends_the_attitude_unless_it_is_short(log: DropLog) -> None:
    release = int(np.searchsorted(log.t_us, log.origin_us))
    short, long = log.imu_valid.copy(), log.imu_valid.copy()
    # Four samples of 3.6 ms can be interpolated, twenty cannot.
    short[release + 100 : release + 104, 2] = False
    long[release + 100 : release + 120, 2] = False
    full_track = tracks(log)["body_3"]
    bridged = tracks(change_columns(log, imu_valid=short))["body_3"]
    assert len(bridged.t_us) == len(full_track.t_us) - 4
    np.testing.assert_allclose(bridged.quaternion_xyzw[-1], full_track.quaternion_xyzw[-1], atol=1e-9)
    frames = body_frames(change_columns(log, imu_valid=long), MODEL)
    assert len(frames.tracks[0].t_us) == 100
    assert any("The attitude ends" in note and "hole" in note for note in frames.notes)


def test_the_landing_that_the_logger_saw_ends_it(log: DropLog) -> None:
    landed_us = log.origin_us + 1_500_000
    events = (*log.events, DropEvent(landed_us, "landing", 0, 1, 9000))
    for track in body_frames(change_columns(log, events=events), MODEL).tracks:
        assert landed_us - 4000 <= track.t_us[-1] < landed_us


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (lambda _: {"release": None}, "no release"),
        # A rest of only half a second gives no bias.
        (lambda log: {"imu_valid": log.imu_valid & (log.t_s[:, None] > -0.5)}, "No attitude: less than 1 s"),
        (lambda log: {"imu_valid": log.imu_valid & (log.t_s[:, None] < 0)}, "gave nothing in the fall"),
        (lambda log: {"clipped": log.clipped | (log.t_s[:, None] > 1.0)}, "are clipped"),
    ],
)
def test_what_cannot_be_told_is_said(log: DropLog, columns: Any, words: str) -> None:
    frames = body_frames(change_columns(log, **columns(log)), MODEL)
    assert any(words in note for note in frames.notes)
    missing = "clipped" not in words
    assert ("body_3" in {track.child for track in frames.tracks}) is not missing


def test_a_robot_that_was_handled_before_its_release_is_doubtful(log: DropLog) -> None:
    counts = log.imu_counts.copy()
    rest = np.flatnonzero((log.t_s > -REST_S) & (log.t_s < -0.2))
    # 1000 counts on every second sample: 15 deg/s of noise while the robot should hang still.
    counts[rest[::2], 2, 4] += 1000
    assert any(
        "moved before the release" in note
        for note in body_frames(change_columns(log, imu_counts=counts), MODEL).notes
    )


def test_the_emulated_robot_s_bodies_are_where_they_truly_were(tmp_path: Path) -> None:
    """Recover the true attitudes of the emulated robot's bodies.

    Its IMUs are misaligned by up to some degrees, which turns the axis of the base's rotation, not its angle.
    """
    flight = rehearse_drop(schedule_maneuver(four_stroke(59.0, 70.0)), seed=4)
    (tmp_path / "SD.bin").write_bytes(flight.card)
    log = load(tmp_path / "SD.bin")
    body_tracks = tracks(log)
    at_s = 1.465  # joints 1 and 2 are open, and the second has just stopped
    row = int(np.argmin(np.abs(body_tracks["body_3"].t_us - log.origin_us - at_s * 1e6)))
    turned = {child: Rotation.from_quat(track.quaternion_xyzw[row]) for child, track in body_tracks.items()}

    # The truth runs on the emulator's clock; its release is time zero.
    clock_s = flight.truth[:, 0] - flight.released_s
    release, now = (int(np.argmin(np.abs(clock_s - t_s))) for t_s in (0.0, at_s))
    truth = [Rotation.from_quat(flight.truth[:, 4 * body : 4 * body + 4]) for body in range(1, 5)]
    base = truth[2][release].inv() * truth[2][now]
    assert np.rad2deg(base.magnitude()) > 50.0
    # The rotation angle does not depend on a misalignment, the axis does.
    assert np.rad2deg(turned["body_3"].magnitude() - base.magnitude()) == pytest.approx(0.0, abs=0.1)
    assert np.rad2deg((turned["body_3"].inv() * base).magnitude()) < 5.0

    chains = {0: ("body_2", "body_1"), 1: ("body_2",), 3: ("body_4",)}
    for body, chain in chains.items():
        # A body's attitude in the base's frame comes from the joints between them.
        in_base = truth[2][now].inv() * truth[body][now]
        chain_attitude = Rotation.identity()
        for child in chain:
            chain_attitude = chain_attitude * turned[child]
        assert np.rad2deg((chain_attitude.inv() * in_base).magnitude()) < 0.3, chain
