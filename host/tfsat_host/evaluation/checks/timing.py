"""Whether the gyros are as late as their low-pass makes them: a clock slip or another setting shows here."""

from __future__ import annotations

import numpy as np

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.evaluation.checks.check import Check, judged, not_possible
from tfsat_host.evaluation.checks.stated_errors import LONGEST_HOLE_S
from tfsat_host.evaluation.motion.lag import DELAY_STD_S
from tfsat_host.evaluation.motion.motion import Motion

LAG = "lag of the gyros"
LAG_STDS = 3.0
"""Of what a chip may be from its sheet, and its readings from their time stamps: settings are 1 to 5 ms apart."""


def lag_check(motion: Motion, calibration: Calibration) -> Check:
    """Measured against the angle sensors, beside the data sheet for the setting in the header."""
    lag = motion.lag
    if np.diff(motion.t_s[motion.samples.fall]).max() > LONGEST_HOLE_S:
        return not_possible(LAG, "ms", "Across a hole in the samples nothing tells how late the gyros are.")
    if not lag.measured and lag.implausible_s is None:
        return not_possible(
            LAG, "ms", "No joint with angle sensors moved far enough to tell how late the gyros are."
        )
    if any(sensors.zero_taken is None for sensors in calibration.joints):
        return not_possible(
            LAG, "ms", "Angle sensors without a calibrated zero do not tell how late the gyros are."
        )
    delay_s = lag.delay_s if lag.implausible_s is None else lag.implausible_s
    off_ms = 1e3 * (delay_s - lag.expected_s)
    sentence = (
        f"The gyros are {1e3 * delay_s:.2f} ms behind the angle sensors; "
        f"their low-pass accounts for {1e3 * lag.expected_s:.2f} ms."
    )
    return judged(LAG, abs(off_ms), 1e3 * LAG_STDS * DELAY_STD_S, "ms", sentence)
