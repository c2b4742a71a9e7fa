"""What an IMU's errors integrate to where nothing corrects them: from a part's figures alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tfsat_host.emulated.imperfections import GYRO_WANDER_S
from tfsat_host.emulated.imu_part import ImuPart, wander_std_deg_s

ORBIT_S = 600.0


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
            f"| {what} | " + " | ".join(f"{one:.2g}" for one in figures) + " |\n"
            for what, figures in rows.items()
        ),
    ]
