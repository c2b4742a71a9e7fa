"""Emulated drops of robots with hidden errors, evaluated as far as the fit of the model; each is made once a run."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from tests.evaluation.drops import DLPF_42_HZ, Drop, calibrated_from_truth, drop, with_com_offsets
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.evaluation.model_fit.fit import ModelFit, fit_model
from tfsat_host.evaluation.model_fit.momentum import Flown, flown_of
from tfsat_host.evaluation.model_fit.offsets import com_offsets
from tfsat_host.evaluation.motion.gyro_signal import noise_densities
from tfsat_host.evaluation.motion.motion import Motion, motion_of
from tfsat_host.evaluation.motion.samples import samples_of
from tfsat_host.robot import load_robot

MODEL = load_robot()
PAPER_RATE_RAD_S = tuple(np.deg2rad([-0.73, -0.48, -0.77]).tolist())
_REST_S = -1.5


@dataclass(frozen=True, eq=False)
class Fitted:
    """One drop with what follows from it.

    Attributes:
        drop: With its truth.
        motion: Of all bodies.
        flown: What drives the model.
        fit: Of the nine offsets.
    """

    drop: Drop
    motion: Motion
    flown: Flown
    fit: ModelFit


@cache
def moved(
    seed: int,
    *,
    robot: int | None = None,
    dlpf_cfg: int = DLPF_42_HZ,
    angles_deg: tuple[float, float] = (59.0, 70.0),
) -> tuple[Drop, Motion]:
    """A drop of the robot that `robot` (or else `seed`) draws, and its motion."""
    robot = seed if robot is None else robot
    imperfections = draw_as_built(robot)
    true_model = with_com_offsets(MODEL, np.random.default_rng(robot).uniform(-0.01, 0.01, (3, 3)))
    with tempfile.TemporaryDirectory() as folder:
        flown = drop(
            Path(folder),
            MODEL,
            true_model,
            imperfections,
            seed=seed,
            dlpf_cfg=dlpf_cfg,
            rate_rad_s=PAPER_RATE_RAD_S,
            angles_deg=angles_deg,
        )
    calibration = calibrated_from_truth(MODEL, imperfections, robot)
    rest = flown.log.t_s < _REST_S
    densities = noise_densities(flown.log.t_s[rest], flown.log.rate_rad_s[rest])
    samples = samples_of(flown.log, calibration, MODEL)
    return flown, motion_of(samples, calibration, MODEL, densities, LowPass(dlpf_cfg))


@cache
def fitted(seed: int, *, robot: int | None = None, dlpf_cfg: int = DLPF_42_HZ) -> Fitted:
    """The same, with the model fitted."""
    flown, motion = moved(seed, robot=robot, dlpf_cfg=dlpf_cfg)
    driven = flown_of(motion)
    return Fitted(flown, motion, driven, fit_model(com_offsets(MODEL), driven))
