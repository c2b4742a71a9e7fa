"""Emulated drops with a hidden truth, each flown and evaluated once a run, and how far an evaluation is from it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import cache

import numpy as np
import pytest
from _pytest.mark import ParameterSet

from tests.fixtures.emulated_drop import DLPF_42_HZ, Drop, drop
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.devices.logger_configuration import FACTORY
from tfsat_host.emulated.emulated_certificate import careful_certificate
from tfsat_host.emulated.imperfections import Imperfections, draw_as_built
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, fit_model
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples, flown_of
from tfsat_host.evaluation.com_fit.offsets import Offsets, model_offsets
from tfsat_host.evaluation.motion.motion import Motion, motion_of
from tfsat_host.evaluation.motion.samples import samples_of
from tfsat_host.evaluation.rest import rest_before_release
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.sdlog import DropLog

MORNING = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)
DROPPED = MORNING + timedelta(hours=1)
MODEL = load_robot()
RATE_RAD_S = tuple(np.deg2rad([-0.73, -0.48, -0.77]).tolist())
"""Of the paper's robot after its release."""
RAMPS_DEG = 0.03
"""What two moments of a low-pass leave of a servo's ramp in a joint's angle."""
STDS = 4.0


def few_of(first: object, *others: object, least: int = 1) -> list[ParameterSet]:
    """Parameters of a test: `make test` takes the first (`least` of them), `make prove` the others."""
    rows = [case if isinstance(case, tuple) else (case,) for case in (first, *others)]
    # The first `least` cases run always, the others only with `-m prove`.
    marks: list[tuple[pytest.MarkDecorator, ...]] = [
        () if at < least else (pytest.mark.prove,) for at in range(len(rows))
    ]
    return [pytest.param(*row, marks=mark) for row, mark in zip(rows, marks, strict=True)]


def com_offsets(model: RobotModel) -> Offsets:
    """Return the paper's nine offsets alone, all else taken for exact."""
    return model_offsets(model).alone


def with_com_offsets(model: RobotModel, offsets_m: FloatArray) -> RobotModel:
    """Return the robot with the centers of mass of bodies 1 to 3 moved by (3, 3)."""
    com = model.com_m.copy()
    # The fit has the offsets of bodies 1 to 3: body 4 stays as filed.
    com[:3] += offsets_m
    return replace(model, com_m=com)


def calibrated_from_truth(model: RobotModel, truth: Imperfections, seed: int) -> Calibration:
    """Build the certificate of a careful calibration from the truth."""
    return careful_certificate(model, truth, seed, MORNING)


def moved_centers(seed: int) -> RobotModel:
    """Return the drop tower's robot with centers of mass up to 10 mm off."""
    return with_com_offsets(MODEL, np.random.default_rng(seed).uniform(-0.010, 0.010, (3, 3)))


@cache
def fly_drop(
    seed: int,
    dlpf_cfg: int = DLPF_42_HZ,
    *,
    robot: int | None = None,
    parts: bytes = b"",
    bus_khz: int = FACTORY.bus_khz,
    rate_rad_s: tuple[float, ...] = RATE_RAD_S,
) -> Drop:
    """Drop the robot drawn from `robot` (else from `seed`) with the paper's maneuver.

    `parts` are its IMUs.
    """
    robot = seed if robot is None else robot
    built = draw_as_built(robot)
    if parts:
        built = replace(built, imu_who_am_i=parts)
    return drop(
        moved_centers(robot),
        built,
        model=MODEL,
        seed=seed,
        dlpf_cfg=dlpf_cfg,
        bus_khz=bus_khz,
        rate_rad_s=rate_rad_s,
    )


@cache
def certificate(drop: Drop, seed: int) -> Calibration:
    """Return the certificate of a careful calibration of the dropped robot."""
    return calibrated_from_truth(drop.model, drop.imperfections, seed)


def estimate_motion(log: DropLog, calibration: Calibration, model: RobotModel = MODEL) -> Motion:
    """Estimate the robot's motion from a log."""
    densities = rest_before_release(log).densities_rad_s_rthz
    samples = samples_of(log, calibration, model)
    return motion_of(samples, calibration, model, densities, LowPass.of(log.header))


@cache
def motion(seed: int, dlpf_cfg: int = DLPF_42_HZ, *, robot: int | None = None) -> Motion:
    """Estimate the motion of a drop of `flown`, carefully calibrated."""
    drop = fly_drop(seed, dlpf_cfg, robot=robot)
    return estimate_motion(drop.log, certificate(drop, seed if robot is None else robot))


@dataclass(frozen=True, eq=False)
class Fitted:
    """One drop with what follows from it: what drives the model, and the fit of the nine offsets."""

    drop: Drop
    motion: Motion
    flown: FallSamples
    fit: ModelFit


@cache
def fit_drop(seed: int, dlpf_cfg: int = DLPF_42_HZ, *, robot: int | None = None) -> Fitted:
    """Fit the model to a drop of `flown`, carefully calibrated."""
    estimate = motion(seed, dlpf_cfg, robot=robot)
    driven = flown_of(estimate)
    return Fitted(
        fly_drop(seed, dlpf_cfg, robot=robot), estimate, driven, fit_model(com_offsets(MODEL), driven)
    )


@dataclass(frozen=True, slots=True)
class TurnOff:
    """A body's last attitude.

    Attributes:
        error_deg: From the truth.
        std_deg: As stated, in the direction that is known least.
        stds: The error by its whole covariance.
    """

    error_deg: float
    std_deg: float
    stds: float


def turn_off(drop: Drop, motion: Motion, body: int, from_s: float | None = None) -> TurnOff:
    """Compute the rotation error of body 1 to 4 since the first sample of the fall, or since `from_s`."""
    track = motion.bodies[body - 1]
    true = drop.true_turn(body, float(track.t_s[0]) if from_s is None else from_s, float(track.t_s[-1]))
    # Left-multiplied error: in the frame in which the covariance is stated.
    error = (track.attitude[-1] * true.inv()).as_rotvec()
    covariance = track.covariance()
    return TurnOff(
        float(np.rad2deg(np.linalg.norm(error))),
        float(np.rad2deg(np.sqrt(np.linalg.eigvalsh(covariance).max()))),
        # Mahalanobis distance: the error in its own standard deviations.
        float(np.sqrt(error @ np.linalg.solve(covariance, error))),
    )


def angle_off_deg(drop: Drop, motion: Motion, joint: int) -> tuple[FloatArray, FloatArray]:
    """(m,) errors of the angle of joint 1 to 3 in the fall, and (m,) their stated standard deviations."""
    fall = motion.samples.fall
    error = (motion.angles_rad - drop.true_angles_rad(motion.t_s))[fall, joint - 1]
    return np.rad2deg(error), np.rad2deg(motion.joints[joint - 1].std_rad()[fall])


def assert_angle_holds(drop: Drop, motion: Motion, joint: int, widest_deg: float) -> None:
    """Assert that the true angle lies within its stated uncertainty, and that this is below `widest_deg`."""
    error, std = angle_off_deg(drop, motion, joint)
    # A low-pass delays and bends the servo's ramp: RAMPS_DEG allows for what remains after compensation.
    assert (np.abs(error) < STDS * std + RAMPS_DEG).all(), np.abs(error).max()
    assert std.max() < widest_deg
