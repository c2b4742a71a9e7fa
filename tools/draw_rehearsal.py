#!/usr/bin/env python3
"""Draw the README's picture from a rehearsal: what the card recorded, and the truth behind it.

    tools/draw_rehearsal.py RUN PICTURE.png

Needs the extra `figures` (matplotlib).
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from scipy.spatial.transform import Rotation

mpl.use("Agg")
import matplotlib.pyplot as plt

from tfsat_host.evaluation.motion.attitude import integrate_rates
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog, load

# Okabe & Ito's palette: told apart by every kind of colour vision.
COLOURS = ("#0072B2", "#D55E00", "#009E73")


def draw(run: Path, picture: Path) -> None:
    """Three panels over the fall: joint angles, rates of body 1, its attitude beside the truth."""
    log = load(run / "SD.bin")
    truth = np.loadtxt(run / "truth.csv", delimiter=",", skiprows=1)
    figure, (joints, rates, attitude) = plt.subplots(1, 3, figsize=(13, 3.9), layout="constrained")
    in_window = (log.t_s > -0.25) & (log.t_s < 2.7)
    _draw_joints(joints, log, in_window)
    _draw_rates(rates, log, in_window)
    _draw_attitude(attitude, log, truth)
    for axes in (joints, rates, attitude):
        for event in log.events:
            if event.name == "stroke":
                axes.axvline(log.seconds(event.t_us), color="0.75", lw=0.8, zorder=0)
        axes.axvline(0.0, color="0.4", lw=0.8, ls=":")
        axes.set_xlabel("time after release / s")
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(picture, dpi=130)


def _draw_joints(axes: Any, log: DropLog, in_window: Any) -> None:
    model = load_robot()
    angles = np.unwrap(log.sensor_angle_rad, axis=0)
    rest = angles[log.t_s < -0.2].mean(axis=0)
    for joint in range(3):
        sensor = model.angle_sensors[2 * joint]
        change = np.rad2deg(sensor.direction * (angles[:, 2 * joint] - rest[2 * joint]))
        axes.plot(log.t_s[in_window], change[in_window], color=COLOURS[joint], label=f"joint {joint + 1}")
    axes.set(title="joint angles, from the card", ylabel="deg")
    axes.legend(frameon=False)


def _draw_rates(axes: Any, log: DropLog, in_window: Any) -> None:
    for axis, name in enumerate("xyz"):
        rate = np.rad2deg(log.rate_rad_s[:, 0, axis])
        axes.plot(log.t_s[in_window], rate[in_window], color=COLOURS[axis], lw=0.9, label=name)
    axes.set(title="angular rate of body 1, from the card", ylabel="deg/s")
    axes.legend(frameon=False)


def _draw_attitude(axes: Any, log: DropLog, truth: Any) -> None:
    fall = (log.t_s >= 0.0) & (log.t_s <= 2.45)
    bias = log.rate_rad_s[log.t_s < -0.2, 0].mean(axis=0)
    measured = integrate_rates(log.t_s[fall], log.rate_rad_s[fall, 0] - bias)
    real = (truth[:, 0] >= 0.0) & (truth[:, 0] <= 2.45)
    attitudes = Rotation.from_quat(truth[real, 4:8])
    true = attitudes[0].inv() * attitudes
    axes.plot(truth[real, 0], np.rad2deg(true.magnitude()), color="0.55", lw=4, label="truth")
    axes.plot(log.t_s[fall], np.rad2deg(measured.magnitude()), color="k", lw=1, label="from the card")
    axes.set(title="body 1 turned by", ylabel="deg")
    axes.legend(frameon=False)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.argv[2]))
