"""Hypotheses of a gyro whose numbers are not its certificate's: bias, scale, small turns of its mounting."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.hypothesis import Hypothesis
from tfsat_host.evaluation.checks.stated_errors import StatedErrors

FloatArray = NDArray[np.float64]


def changed_gyros(of: Consistency, stated: StatedErrors) -> Iterator[Hypothesis]:
    """Three numbers each."""
    for body in range(4):
        gyro = f"gyro of body {body + 1}"
        taken = of.calibration.gyros[body].bias_taken
        since = f" since {taken:%Y-%m-%d %H:%M} UTC" if taken else ""

        def biased(numbers: FloatArray, gyro: str = gyro, since: str = since) -> str:
            return f"{gyro}: stale calibration, its bias has changed by {_listed(np.rad2deg(numbers))} deg/s{since}"

        def jumped(numbers: FloatArray, gyro: str = gyro) -> str:
            return f"{gyro}: its bias jumped by {_listed(np.rad2deg(numbers))} deg/s at the release"

        def scaled(numbers: FloatArray, gyro: str = gyro) -> str:
            # The columns were taken at the rates as shown, which are too large by the very factor.
            percent = _listed(100.0 * numbers / (1.0 - numbers))
            return f"{gyro}: its scale factor is {percent} % beside the calibrated one"

        def turned(numbers: FloatArray, gyro: str = gyro) -> str:
            angle = np.rad2deg(np.linalg.norm(numbers))
            return f"{gyro}: stale calibration, its mounting has turned by {angle:.2f} deg"

        columns = stated.by_gyros[:, body]
        number = str(body)
        left = of.own_vector
        yield Hypothesis(("bias", number), left, columns[:, :3], biased, "tfsat-host calibrate bias")
        in_fall = columns[:, :3].copy()
        in_fall[of.at_rest(body)] = 0.0
        yield Hypothesis(
            ("jump", number), left, in_fall, jumped, "Leave this gyro out: it did not bear the release"
        )
        yield Hypothesis(
            ("mounting", number), left, columns[:, 3:6], turned, "tfsat-host calibrate misalignment"
        )
        again = "tfsat-host calibrate scale"
        yield Hypothesis(("scale", number), left, columns[:, 6:], scaled, again)
        # Where the reading as a whole is scaled, as by a wrong range, its bias is too.
        calibrated = of.calibration.gyros[body]
        whole = columns[:, 6:] + columns[:, :3] * (calibrated.bias_rad_s / calibrated.scale)
        yield Hypothesis(("scale", number), left, whole, scaled, again)


def _listed(numbers: FloatArray) -> str:
    # Adding zero takes the sign off a zero.
    return "/".join(f"{round(float(number), 2) + 0.0:+.2f}" for number in numbers) + " (x/y/z)"
