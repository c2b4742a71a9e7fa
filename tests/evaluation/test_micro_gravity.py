"""Release, landing and quality of the fall by the accelerometers: by hand, and from an emulated robot's card."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.calibration.some_calibration import whole_calibration
from tests.evaluation.clock_log import log_with
from tests.rehearsal.days import WholeDrop, rehearse_drop
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.apply import CalibratedSamples, apply_calibration
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import by_design
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.fall_instants import fall_instants, landing_felt, release_felt
from tfsat_host.evaluation.micro_gravity import (
    MicroGravity,
    QuietWindow,
    expected_specific_force,
    micro_gravity,
    quiet_windows,
)
from tfsat_host.evaluation.stages import sensor_arms_m
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog, load

MODEL = load_robot()
G_M_S2 = 9.80665
RATE_HZ = 280.0
LANDED_S = 2.5
ARMS_M = sensor_arms_m(MODEL, np.zeros(3))
WINDOWS = quiet_windows(0.7, 2.23, LANDED_S, ARMS_M, ARMS_M)
OFFSET_STD_G = np.array([0.05, 0.05, 0.08]) / 3**0.5
T_S = np.arange(-2.0, 3.5, 1 / RATE_HZ)


def fallen(
    *,
    offset_g: FloatArray | float = 0.0,
    scale: float = 1.0,
    noise_g: float = 0.003,
    residual_g: FloatArray | float = 0.0,
    rate_rad_s: FloatArray | None = None,
    seed: int = 0,
) -> CalibratedSamples:
    """Hangs upright, falls from t = 0 to the landing, bounces for 50 ms at 30 g and lies."""
    rng = np.random.default_rng(seed)
    rate = np.zeros(3) if rate_rad_s is None else rate_rad_s
    falling, bounce = (T_S >= 0) & (T_S < LANDED_S), (T_S >= LANDED_S) & (T_S < LANDED_S + 0.05)
    force = np.tile([0.0, 0.0, 1.0], (len(T_S), 4, 1))
    force[falling] = np.cross(rate, np.cross(rate, ARMS_M)) / G_M_S2
    force[falling] += residual_g
    force[bounce] = [0.0, 0.0, 30.0]
    force = scale * force + np.asarray(offset_g) + noise_g * rng.normal(size=force.shape)
    rates = np.zeros_like(force)
    rates[falling] = rate
    n = len(T_S)
    return CalibratedSamples(
        t_s=T_S + 10.0,
        rate_rad_s=rates,
        rate_covariance=np.zeros((n, 4, 3, 3)),
        rate_jacobian=np.zeros((n, 4, 3, 12)),
        parameter_covariance=np.zeros((4, 12, 12)),
        shared=np.zeros((4, 12, 12)),
        specific_force_m_s2=np.clip(force, -16, 16) * G_M_S2,
        specific_force_std_m_s2=np.hypot(OFFSET_STD_G, 0.03 / 3**0.5 * np.clip(force, -16, 16)) * G_M_S2,
        joint_angle_rad=np.zeros((n, 3)),
        joint_angle_std_rad=np.zeros((n, 3)),
        clipped=(np.abs(force) >= 16).any(axis=2),
    )


def quality(samples: CalibratedSamples) -> MicroGravity:
    return micro_gravity(samples, T_S, WINDOWS)


# ---- what turning makes


@given(st.integers(0, 2**32))
def test_the_expected_force_is_the_acceleration_of_the_point(seed: int) -> None:
    """Expected specific force equals the second derivative of the point's position.

    The point is on a body whose rate grows linearly about a fixed axis.
    """
    rng = np.random.default_rng(seed)
    axis, arm = rng.normal(size=(2, 3))
    axis /= np.linalg.norm(axis)
    rate, acceleration = rng.normal(size=2)
    step_s = 1e-3
    angles = rate * np.array([-step_s, 0, step_s]) + acceleration * step_s**2 / 2 * np.array([1, 0, 1])
    before, now, after = Rotation.from_rotvec(np.outer(angles, axis)).apply(arm)
    numeric = (before - 2 * now + after) / step_s**2
    assert expected_specific_force(rate * axis, acceleration * axis, arm) == pytest.approx(numeric, abs=1e-4)


def test_turning_is_taken_off() -> None:
    rate = np.array([2.0, -1.0, 3.0])
    assessment = quality(fallen(rate_rad_s=rate, noise_g=1e-4))
    assert len(assessment.windows) == 2
    for window in assessment.windows:
        for body in window.bodies:
            assert np.linalg.norm(body.mean_g) > 0.01
            assert body.residual_g == pytest.approx(0.0, abs=1e-4)


# ---- quality


def test_a_good_fall() -> None:
    assessment = quality(fallen())
    assert assessment.findings == () and assessment.notes == ()
    for window in assessment.windows:
        assert [body.body for body in window.bodies] == [1, 2, 3, 4]
        for body in window.bodies:
            assert body.rms_g == pytest.approx(0.003 * 3**0.5, rel=0.25)
            assert body.motion_rms_g < 0.003
            # Nobody can say more of the mean than the data sheet does of the zero-g output.
            assert body.residual_std_g == pytest.approx(OFFSET_STD_G, rel=0.01)
    assert assessment.changes_g == pytest.approx(0.0, abs=0.003)


def test_the_zero_g_output_is_in_both_windows_and_in_gravity() -> None:
    offset_g = np.array([0.04, -0.03, 0.07])
    assessment = quality(fallen(offset_g=offset_g, scale=1.02))
    assert assessment.findings == ()
    body = assessment.windows[0].bodies[1]
    assert body.residual_g == pytest.approx(offset_g, abs=0.001)
    assert (np.abs(assessment.changes_g) < 4 * assessment.changes_std_g).all()
    for check in assessment.gravity:
        assert check.norm_g == pytest.approx(np.linalg.norm(offset_g + np.array([0, 0, 1.02])), abs=0.002)
        assert check.less_fall_norm_g == pytest.approx(1.02, abs=0.002)
        assert check.less_fall_std_g == pytest.approx(0.0175, rel=0.05)
        assert check.norm_std_g > 2 * check.less_fall_std_g
        assert check.passes


def test_a_change_of_a_milli_g_between_the_windows_is_seen() -> None:
    growing = np.where(T_S[(T_S >= 0) & (T_S < LANDED_S)] > 2.0, 0.005, 0.0)[:, None, None] * [0, 0, 1.0]
    assessment = quality(fallen(offset_g=np.array([0.04, -0.03, 0.07]), residual_g=growing))
    assert assessment.changes_g[:, 2] == pytest.approx(0.005, abs=0.002)
    assert (assessment.changes_g[:, 2] > 3 * assessment.changes_std_g[:, 2]).all()
    assert assessment.findings == (), "within what the zero-g output may be"


def test_stated_noise_is_the_scatter_of_the_change() -> None:
    z = []
    for seed in range(60):
        assessment = quality(fallen(seed=seed))
        z.append(assessment.changes_g / assessment.changes_std_g)
    assert np.std(z) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("scale", [0.9, 2.0])
def test_a_wrong_scale_shows_in_gravity(scale: float) -> None:
    assessment = quality(fallen(scale=scale))
    assert not any(check.passes for check in assessment.gravity)
    assert sum("scale is wrong" in finding for finding in assessment.findings) == 4
    # 10 % are within what the zero-g output may be; only the difference to the fall tells.
    how = "0.900 g more before the release than in the fall" if scale == 0.9 else "2.000 g before the release"
    assert all(f"felt {how}" in finding for finding in assessment.findings)


def test_a_robot_that_hung_on_did_not_float() -> None:
    assessment = quality(fallen(residual_g=np.array([0.0, 0.0, 0.4])))
    assert sum("the robot did not float" in finding for finding in assessment.findings) == 8


def test_a_robot_that_touched_something_was_shaken() -> None:
    rng = np.random.default_rng(1)
    falling = (T_S >= 0) & (T_S < LANDED_S)
    assessment = quality(fallen(residual_g=0.05 * rng.normal(size=(int(falling.sum()), 4, 3))))
    shaken = [finding for finding in assessment.findings if ": vibration 0.0" in finding]
    assert len(shaken) == 8


def test_dead_sensors_and_short_windows_are_left_out_and_said() -> None:
    samples = fallen()
    samples.specific_force_m_s2[:, 2] = np.nan
    samples.rate_rad_s[:, 0] = np.nan
    short = QuietWindow("at the end", 2.49, 2.5, ARMS_M)
    assessment = micro_gravity(samples, T_S, (WINDOWS[0], short))
    assert [body.body for body in assessment.windows[0].bodies] == [1, 2, 4]
    assert assessment.windows[1].bodies == ()
    assert [check.body for check in assessment.gravity] == [1, 2, 4]
    assert np.isnan(assessment.changes_g).all()
    assert (
        "Body 1's gyro gave nothing before the first stroke: its turning was not taken off."
        in assessment.notes
    )
    assert "Body 3 has 0 valid forces before the first stroke: too few to judge." in assessment.notes
    assert any(
        "Body 3's accelerometer gave too little before the release" in note for note in assessment.notes
    )


def test_without_a_gyro_what_the_turning_makes_is_unknown_and_not_zero() -> None:
    samples = fallen()
    samples.rate_rad_s[T_S < 1.0, 0] = np.nan
    assessment = quality(samples)
    before, after = (window.bodies[0] for window in assessment.windows)
    assert np.isnan(before.rotation_g).all() and np.isfinite(after.rotation_g).all()
    assert before.residual_g.tolist() == before.mean_g.tolist()
    assert np.isnan(assessment.changes_g[0]).all() and np.isfinite(assessment.changes_g[1:]).all()
    assert assessment.findings == ()


def test_a_rate_at_full_scale_is_no_rate() -> None:
    samples, reference = fallen(), quality(fallen())
    rows = np.flatnonzero((T_S > 0.3) & (T_S < 0.5))[::5]
    samples.clipped[rows, 0] = True
    samples.rate_rad_s[rows, 0] = 8.7
    ours, expected = (
        assessment.windows[0].bodies[0].rotation_g for assessment in (quality(samples), reference)
    )
    np.testing.assert_allclose(ours, expected, atol=1e-5)


# ---- instants


@pytest.mark.parametrize("dlpf_cfg", range(7))
def test_instants_do_not_depend_on_the_low_pass(dlpf_cfg: int) -> None:
    """Release and landing times do not depend on the low-pass filter.

    The filter is modeled as a single pole of the delay; the stated standard deviation covers a real one's
    deviation from that.
    """
    samples, delay_s = fallen(offset_g=0.05), LowPass(dlpf_cfg).accel_delay_s
    fine_s = np.arange(-2.0, 3.5, 1e-4)
    fine = np.where((fine_s >= 0) & (fine_s < LANDED_S), 0.0, 1.0)
    fine[(fine_s >= LANDED_S) & (fine_s < LANDED_S + 0.05)] = 30.0
    if delay_s:
        pole = np.exp(-1e-4 / delay_s)
        for row in range(1, len(fine)):
            fine[row] = pole * fine[row - 1] + (1 - pole) * fine[row]
    samples.specific_force_m_s2[:, :, 2] = np.interp(T_S, fine_s, fine)[:, None] * G_M_S2
    force = samples.specific_force_m_s2
    release = release_felt(T_S, force, LowPass(dlpf_cfg))
    landing = landing_felt(T_S, force, np.zeros_like(samples.clipped), LowPass(dlpf_cfg))
    assert release is not None and landing is not None
    assert abs(release.t_s) < 3 * release.std_s
    assert release.std_s < 7e-3
    # A tenth of the shock is there long before its middle.
    assert -delay_s - 4e-3 < landing.t_s - LANDED_S < 4e-3


def test_no_fall_and_no_landing_are_none() -> None:
    hung = fallen()
    hung.specific_force_m_s2[:] = [0.0, 0.0, G_M_S2]
    assert release_felt(T_S, hung.specific_force_m_s2, LowPass(3)) is None
    assert landing_felt(T_S, hung.specific_force_m_s2, np.zeros_like(hung.clipped), LowPass(3)) is None
    blind = np.full_like(hung.specific_force_m_s2, np.nan)
    assert release_felt(T_S, blind, LowPass(3)) is None


def test_a_body_that_is_dead_is_nan_and_the_others_tell() -> None:
    samples = fallen()
    samples.specific_force_m_s2[:, 1] = np.nan
    release = release_felt(T_S, samples.specific_force_m_s2, LowPass(0))
    assert release is not None
    assert np.isnan(release.by_body_s).tolist() == [False, True, False, False]
    assert abs(release.t_s) < 2 / RATE_HZ


def test_a_sensor_at_the_end_of_its_range_felt_a_shock() -> None:
    """Detect a shock by a sensor's saturation: at ±2 g it never shows the shock's 3 g."""
    samples = fallen()
    force = np.clip(samples.specific_force_m_s2, -2 * G_M_S2, 2 * G_M_S2)
    full = np.asarray((np.abs(force) >= 2 * G_M_S2).any(axis=2))
    landing = landing_felt(T_S, force, full, LowPass(0))
    assert landing is not None and landing.t_s == pytest.approx(LANDED_S, abs=1 / RATE_HZ)
    assert landing_felt(T_S, force, np.zeros_like(full), LowPass(0)) is None


def delay_forces(log: DropLog, samples: CalibratedSamples, by_s: float) -> CalibratedSamples:
    """Return the samples with the forces delayed by `by_s`."""
    rows = np.clip(np.arange(len(log)) - round(by_s * log.header.rate_hz), 0, len(log) - 1)
    return replace(
        samples, specific_force_m_s2=samples.specific_force_m_s2[rows], clipped=samples.clipped[rows]
    )


# ---- an emulated drop


def as_designed() -> Calibration:
    """Nobody measured anything: that is enough for accelerometers."""
    gyros = tuple(by_design(body, MODEL.imus[body - 1].sensor_to_body) for body in range(1, 5))
    return replace(whole_calibration(), gyros=gyros)


@pytest.fixture(scope="module")
def drop(tmp_path_factory: pytest.TempPathFactory) -> tuple[WholeDrop, DropLog, CalibratedSamples]:
    flight = rehearse_drop(schedule_maneuver(four_stroke(59, 70)), seed=4)
    card = tmp_path_factory.mktemp("card") / "SD.bin"
    card.write_bytes(flight.card)
    log = load(card)
    return flight, log, apply_calibration(Counts.from_log(log), as_designed(), MODEL)


def test_the_emulated_drop_s_instants(drop: tuple[WholeDrop, DropLog, CalibratedSamples]) -> None:
    flight, log, samples = drop
    instants = fall_instants(log, samples)
    assert instants.findings == ()
    assert (
        instants.release is not None
        and instants.landing is not None
        and instants.landing_logged_s is not None
    )
    # The switches' contacts open within a millisecond or two of being let go.
    assert abs(instants.release.t_s) < 3 * instants.release.std_s
    landed_s = flight.landed_s - flight.released_s
    assert instants.landing.t_s == pytest.approx(landed_s, abs=3 * instants.landing.std_s)
    assert instants.landing_logged_s > instants.landing.t_s


def test_the_emulated_drop_s_quality(drop: tuple[WholeDrop, DropLog, CalibratedSamples]) -> None:
    _, log, samples = drop
    assessment = micro_gravity(samples, log.t_s, WINDOWS)
    assert assessment.findings == () and assessment.notes == ()
    for window in assessment.windows:
        assert max(np.abs(body.residual_g).max() for body in window.bodies) < 0.003
    assert all(check.less_fall_norm_g == pytest.approx(1.0, abs=0.003) for check in assessment.gravity)


def test_what_does_not_agree_is_said(drop: tuple[WholeDrop, DropLog, CalibratedSamples]) -> None:
    _, log, samples = drop
    late = fall_instants(log, delay_forces(log, samples, 0.2)).findings
    assert re.search("(199|200|201) ms after the switches opened: the robot hung on", late[0])
    assert re.search(r"The landing was felt at 2\.(699|700) s, but the logger noted it at 2\.5[01]", late[1])
    early = fall_instants(log, delay_forces(log, samples, -0.2)).findings
    assert "ms before the switches opened: the magnet held the robot" in early[0]
    soft = replace(
        samples, specific_force_m_s2=0.15 * samples.specific_force_m_s2, clipped=samples.clipped & False
    )
    assert any("felt no landing" in finding for finding in fall_instants(log, soft).findings)


def test_a_log_without_forces_says_so(tmp_path: Path) -> None:
    log = log_with(tmp_path / "SD.bin", [])
    samples = apply_calibration(Counts.from_log(log), whole_calibration(), MODEL)
    instants = fall_instants(log, samples)
    assert instants.release is None and instants.landing is None and instants.landing_logged_s is None
    assert len(instants.findings) == 2
