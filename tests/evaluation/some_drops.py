"""Drops that several tests look at: each is flown once a process."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from tests.evaluation.drops import DLPF_42_HZ, Drop, calibrated_from_truth, drop, with_com_offsets
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.evaluation.fall.rest import rest_before_release
from tfsat_host.evaluation.motion.motion import Motion, motion_of
from tfsat_host.evaluation.motion.samples import samples_of
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.sdlog import DropLog

RATE_RAD_S = tuple(np.deg2rad((-0.73, -0.48, -0.77)))
"""Of the paper's robot after its release."""


@cache
def flown(seed: int, dlpf_cfg: int = DLPF_42_HZ) -> Drop:
    """A robot with centers of mass up to 10 mm off, dropped with the paper's maneuver."""
    model = load_robot()
    offsets = np.random.default_rng(seed).uniform(-0.010, 0.010, (3, 3))
    with tempfile.TemporaryDirectory() as folder:
        return drop(
            Path(folder),
            model,
            with_com_offsets(model, offsets),
            draw_as_built(seed),
            seed=seed,
            dlpf_cfg=dlpf_cfg,
            rate_rad_s=RATE_RAD_S,
        )


def certificate(one: Drop, seed: int) -> Calibration:
    """As a careful day on the bench would have it."""
    return calibrated_from_truth(one.model, one.imperfections, seed)


def moved(log: DropLog, calibration: Calibration, model: RobotModel) -> Motion:
    """What the robot did, by that log."""
    densities = rest_before_release(log).densities_rad_s_rthz
    return motion_of(
        samples_of(log, calibration, model), calibration, model, densities, LowPass.of(log.header)
    )
