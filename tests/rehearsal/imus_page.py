"""docs/imus.md: the same robots, dropped with the IMU that they have and with the paper's candidate for orbit.

python -m tests.rehearsal.imus_page [--runs N]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence

import numpy as np

from tests.paths import DOCS
from tests.rehearsal.days import SCHEDULE, preflight
from tfsat_host.emulated.imperfections import GYRO_WANDER_S
from tfsat_host.emulated.imu_part import ImuPart, load_imu, wander_std_deg_s
from tfsat_host.rehearsal.series import RehearsedDrop, Series, fly_many
from tfsat_host.rehearsal.truth_comparison import EstimateAndTruth
from tfsat_host.robot import load_robot

PAGE = DOCS / "imus.md"
IMUS = ("mpu6050", "adis16465_2")
RUNS = 40
SHOWN = 5
"""Robots that are told one by one."""
_SEED = 1
ORBIT_S = 600.0
_QUANTITIES = (
    ("reorientation", "deg", "reorientation"),
    ("initial rates", "deg/s", "initial rate"),
    ("strokes", "deg", "stroke"),
    ("centers of mass", "mm", "body"),
)

_HEAD = """# Another IMU: errors compared

Written by `python -m tests.rehearsal.imus_page`; do not edit. The same robots and drops (59/70), with
either part on all four bodies; the paper proposes an ADIS16465-2 for orbit.

    tfsat-host rehearse 59 70 --runs {runs}
    tfsat-host rehearse 59 70 --runs {runs} --imu adis16465_2
    tfsat-host rehearse 59 70 --imu mine.toml

`--imu` takes a shipped part or a file like `host/tfsat_host/emulated/imus/mpu6050.toml`, which cites each figure.
Some of the ADIS16465-2's are assumed; its file says which.

## In the drop tower

"""
_BETWEEN = """
Error: found less true, over robots and axes or strokes; stated std: the median; last, the share of 95 % intervals
that hold the truth. The first robots' reorientation, error and stated standard deviation:

"""
_WORDS = """
Each robot was calibrated on the bench. Remaining errors: g-sensitivity, which the bias on the bench contains and that
in the fall does not; warming of the chips; random walk of the biases; noise.

**Not** modelled, as the registers are those of an MPU-6050:

- **Resolution.** Both show steps of 1/65.5 deg/s, less than their noise; the ADIS16465-2 has 32 bits.
- **Bandwidth.** Both go through the logger's low-pass; the ADIS16465-2's own is wider (550 Hz, assumed, against 256
  Hz).
- **Its own certificate.** Uncertainties are those of calibrated MPU-6050s ([the proof](calibration-proof.md)), and so
  is the drift with temperature: what is stated of a quieter part would be less.

## In orbit

From the parts' figures, one axis integrated over 10 min that nothing else corrects, standard deviations in deg:

"""
_FORMULAS = """
White noise of the one-sided density d integrates to the angle random walk d sqrt(t / 2) (IEEE Std 952-1997, annex C);
the data sheet's deg/sqrt(h) is 60 d / sqrt(2). The bias instability is a first-order Gauss-Markov process whose
greatest Allan deviation is the part's figure, B = 0.618 s (the same annex), with a correlation time T of 100 s,
assumed; its integral has the variance 2 s² T² (t / T - 1 + exp(-t / T)). The last two grow with t. The bias that
gravity takes along must be measured in orbit, by a star tracker or a sun sensor, whatever the IMU.
"""


def page(runs: int) -> str:
    """Render the page's text."""
    drops_by_imu = fly(runs)
    return "".join(
        (
            _HEAD.format(runs=runs),
            *_table(drops_by_imu, runs),
            _BETWEEN,
            *robots_table({imu: outcomes[:SHOWN] for imu, outcomes in drops_by_imu.items()}),
            _WORDS,
            *orbit_rows([load_imu(imu) for imu in IMUS]),
            _FORMULAS,
        )
    )


Fly = Callable[[Series, int], tuple[RehearsedDrop, ...]]


def fly(runs: int, fly_series: Fly = fly_many) -> dict[str, tuple[RehearsedDrop, ...]]:
    """Fly the first robots with each IMU.

    The day is the one that the command makes of their seeds, including the preflight.
    """
    filed = load_robot()
    series = {
        imu: Series(SCHEDULE, filed, _SEED, part=load_imu(imu), preflight=preflight(despite=False))
        for imu in IMUS
    }
    return {imu: fly_series(imu_series, runs) for imu, imu_series in series.items()}


def robots_table(drops_by_imu: dict[str, tuple[RehearsedDrop, ...]]) -> list[str]:
    """Lines of Markdown, one a robot."""
    lines = ["| robot | seed | " + " | ".join(_name(load_imu(imu)) for imu in IMUS) + " |\n"]
    lines.append("| --- | --- |" + " --- |" * len(IMUS) + "\n")
    for outcomes in zip(*drops_by_imu.values(), strict=True):
        cells = [str(outcomes[0].number), str(outcomes[0].seed), *(_error(drop) for drop in outcomes)]
        lines.append("| " + " | ".join(cells) + " |\n")
    return lines


def _error(outcome: RehearsedDrop) -> str:
    comparison = next((row for row in outcome.compared if row.name == "reorientation"), None)
    return (
        "not evaluated"
        if comparison is None
        else f"{comparison.estimate - comparison.true:+.3f} ± {comparison.std:.3f} deg"
    )


def _table(drops_by_imu: dict[str, tuple[RehearsedDrop, ...]], runs: int) -> list[str]:
    lines = [f"| of {runs} robots | | " + " | ".join(_name(load_imu(imu)) for imu in IMUS) + " |\n"]
    lines.append("| --- | --- |" + " --- |" * len(IMUS) + "\n")
    for title, unit, name in _QUANTITIES:
        cells = [_figures(_of(outcomes, name), unit) for outcomes in drops_by_imu.values()]
        for row, label in enumerate(("error, rms", "stated std", "95 % hold")):
            lines.append(
                f"| {title if row == 0 else ''} | {label} | "
                + " | ".join(cell[row] for cell in cells)
                + " |\n"
            )
    good = [str(sum(drop.verdict == "good" for drop in outcomes)) for outcomes in drops_by_imu.values()]
    return [*lines, "| verdict | good | " + " | ".join(good) + " |\n"]


def _of(outcomes: Sequence[RehearsedDrop], name: str) -> list[EstimateAndTruth]:
    return [
        estimate for outcome in outcomes for estimate in outcome.compared if estimate.name.startswith(name)
    ]


def _figures(estimates: list[EstimateAndTruth], unit: str) -> tuple[str, str, str]:
    error = np.array([row.estimate - row.true for row in estimates])
    std = np.array([row.std for row in estimates])
    # 1.96 standard deviations hold 95 % of a normal distribution.
    coverage = float((np.abs(error) <= 1.96 * std).mean())
    return (
        f"{float(np.sqrt((error**2).mean())):.3f} {unit}",
        f"{float(np.median(std)):.3f} {unit}",
        f"{100.0 * coverage:.0f} %",
    )


def _name(part: ImuPart) -> str:
    return part.name.split()[-1]


def noise_deg(part: ImuPart, t_s: float) -> float:
    """Angle random walk: of white noise of one-sided density d, d sqrt(t / 2)."""
    return float(part.gyro_noise_deg_s_rthz * np.sqrt(t_s / 2.0))


def wander_deg(part: ImuPart, t_s: float) -> float:
    """Integral of a first-order Gauss-Markov process."""
    ratio = t_s / GYRO_WANDER_S
    return float(wander_std_deg_s(part) * GYRO_WANDER_S * np.sqrt(2.0 * (ratio - 1.0 + np.exp(-ratio))))


def orbit_rows(parts: Sequence[ImuPart]) -> list[str]:
    """Lines of Markdown."""
    rows = {
        "angle random walk": [noise_deg(part, ORBIT_S) for part in parts],
        "bias instability": [wander_deg(part, ORBIT_S) for part in parts],
        "bias taken at 1 g, never again": [part.gyro_g_sensitivity_std_deg_s_g * ORBIT_S for part in parts],
        "bias taken 1 °C colder, never again": [part.gyro_bias_slope_std_deg_s_c * ORBIT_S for part in parts],
    }
    return [
        "| after 10 min | " + " | ".join(part.name.split()[-1] for part in parts) + " |\n",
        "| --- |" + " --- |" * len(parts) + "\n",
        *(
            f"| {what} | " + " | ".join(f"{figure:.2g}" for figure in figures) + " |\n"
            for what, figures in rows.items()
        ),
    ]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS)
    PAGE.write_text(page(parser.parse_args().runs), encoding="utf-8")
