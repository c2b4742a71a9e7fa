"""docs/calibration-proof.md: how far a hundred calibrations were from the truth, and whether they knew it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tests.calibration_proof.robots import QUANTITIES, Errors

UNITS = {"bias": "deg/s", "misalignment": "deg", "scale": "%", "zero": "deg"}
TARGETS = {"bias": 0.02, "misalignment": 0.1, "scale": 0.2, "zero": 0.1}
COVERED = (0.90, 0.99)
"""So often must a 95 % interval hold the truth."""
_NORMAL_95 = 1.959964

Results = Mapping[int, Mapping[str, Errors]]

_HEAD = """# What the calibration was measured to do

Written by `make calibration-report`; do not edit. {robots} emulated robots were each calibrated once, from nothing, by
the steps of docs/calibration.md. The logger's own firmware sampled the sensors; the calibration saw its samples and the
robot file, and nothing else.

Each robot, drawn from its number:

- biases anywhere within 5 deg/s, scale factors within 3 %, misalignments of 0 to 5 deg about any axis, on top of a
  mounting turned by right angles as its robot file says;
- noise, steps and low-pass (5 Hz) of an MPU-6050;
- angle sensors with zero points anywhere in 360 deg, noise of 0.05 deg, 4096 steps a turn, and a bend of four
  amplitudes of 0.05 deg each;
- hands: tremor of 1 to 5 deg/s rms on what they move, 0.2 to 1 deg/s rms of sway in what they hold, which also gives
  way by up to 1 % of the joint's angle; swings up to 1.5 times slower than asked; a turn that ends 0.1 deg rms off its
  edge about an axis 0.1 deg rms off.

| quantity | values | rms error | largest | wanted rms | stated std, median | 95 % intervals that hold the truth |
| --- | --: | --: | --: | --: | --: | --: |
"""
_TAIL = """
Errors are those of every axis of every sensor by itself. Wanted of the intervals: 90 to 99 %.

## Robot by robot

Root mean square over each robot's sensors. The tests calibrate some of them anew and compare.

| robot | bias, deg/s | misalignment, deg | scale, % | zero, deg |
| --: | --: | --: | --: | --: |
"""


def page(results: Results) -> str:
    """The text of the page."""
    rows = [
        f"| {seed} | " + " | ".join(f"{errors[name].rms:.5f}" for name in QUANTITIES) + " |"
        for seed, errors in sorted(results.items())
    ]
    summary = [_summary_row(results, name) for name in QUANTITIES]
    return _HEAD.format(robots=len(results)) + "\n".join(summary) + "\n" + _TAIL + "\n".join(rows) + "\n"


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
