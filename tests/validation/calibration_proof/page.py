"""docs/calibration-proof.md: how far calibrations were from the truth, and whether they knew it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tests.validation.calibration_proof.robots import QUANTITIES, Errors

UNITS = {"bias": "deg/s", "misalignment": "deg", "scale": "%", "zero": "deg"}
TARGETS = {"bias": 0.02, "misalignment": 0.1, "scale": 0.2, "zero": 0.1}
COVERED = (0.90, 0.99)
"""So often must a 95 % interval hold the truth."""
_NORMAL_95 = 1.959964

Results = Mapping[int, Mapping[str, Errors]]

_HEAD = """# What the calibration was measured to do

Written by `make calibration-report`; do not edit. {robots} emulated robots, each calibrated once from nothing by the
steps of [calibration](calibration.md), through the logger's own firmware. Each robot, drawn from its number:

- biases within 5 deg/s, scale factors within 3 %, misalignments to 5 deg, on a mounting turned by right angles;
- noise, steps and low-pass (5 Hz) of an MPU-6050;
- angle sensors: zero points anywhere, noise 0.05 deg, 4096 steps a turn, four amplitudes of bend of 0.05 deg each;
- hands: tremor 1 to 5 deg/s rms, sway 0.2 to 1 deg/s rms of what they hold, which gives way by up to 1 %; swings up
  to 1.5 times slower than asked; turns 0.1 deg rms off their edge, about an axis 0.1 deg rms off.

Mountings are measured against the hinges, which are here as the robot file has them, and the file says so. Where it
says that they may lean, a mounting is known no better than they are: [evaluation-proof](evaluation-proof.md).

| quantity | values | rms error | largest | wanted rms | stated std, median | 95 % intervals that hold the truth |
| --- | --: | --: | --: | --: | --: | --: |
"""
_TAIL = """
Errors of every axis of every sensor. Wanted of the intervals: 90 to 99 %. Each robot's root mean squares are in
[robots.csv](calibration-proof/robots.csv); the tests calibrate some of them again and compare.
"""


def page(results: Results) -> str:
    """The text of the page."""
    summary = [_summary_row(results, name) for name in QUANTITIES]
    return _HEAD.format(robots=len(results)) + "\n".join(summary) + "\n" + _TAIL


def robots_csv(results: Results) -> str:
    """A row for each robot: the root mean square over its sensors of each quantity's errors."""
    rows = [
        ",".join((str(seed), *(f"{errors[name].rms:.5f}" for name in QUANTITIES)))
        for seed, errors in sorted(results.items())
    ]
    heads = (f"{name} ({UNITS[name]})" for name in QUANTITIES)
    return "\n".join((",".join(("robot", *heads)), *rows)) + "\n"


def rms(results: Results, name: str) -> float:
    """Over all robots."""
    return float(np.sqrt(np.mean(np.concatenate([errors[name].error for errors in results.values()]) ** 2)))


def covered(results: Results, name: str) -> float:
    """Share of the values whose 95 % interval holds the truth."""
    off = [np.abs(errors[name].error) / errors[name].std for errors in results.values()]
    return float((np.concatenate(off) < _NORMAL_95).mean())


def _summary_row(results: Results, name: str) -> str:
    error = np.concatenate([errors[name].error for errors in results.values()])
    std = np.concatenate([errors[name].std for errors in results.values()])
    unit = UNITS[name]
    cells = (
        name,
        str(len(error)),
        f"{rms(results, name):.4f} {unit}",
        f"{np.abs(error).max():.4f} {unit}",
        f"{TARGETS[name]:g} {unit}",
        f"{np.median(std):.4f} {unit}",
        f"{100 * covered(results, name):.1f} %",
    )
    return "| " + " | ".join(cells) + " |"
