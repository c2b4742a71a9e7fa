"""Whether a recording for a calibration is all there."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.recording import Recording

MOST_LOST_FRACTION = 0.01
"""More lost samples than this, and the rest may not stand for the motion."""
LONGEST_GAP_S = 0.05
"""A straight line over more would cut a corner of a motion."""


def check_complete(recording: Recording, bodies: Iterable[int]) -> None:
    """The clock ran on, nearly every sample arrived, and the gyros of `bodies` (1 to 4) gave all of theirs.

    Raises:
        CalibrationError: they did not.
    """
    if np.any(np.diff(recording.t_s) <= 0):
        raise CalibrationError(
            what="The logger's clock went backwards during the measurement: the logger restarted.",
            meaning="The samples do not belong together; nothing was kept.",
            next_step="Check the logger's supply and cable with tfsat-host status, and run this command again.",
        )
    if recording.samples_lost > MOST_LOST_FRACTION * (len(recording.t_s) + recording.samples_lost):
        raise CalibrationError(
            what=f"{recording.samples_lost} of {len(recording.t_s) + recording.samples_lost} samples "
            "never reached this computer.",
            meaning=f"More than {100 * MOST_LOST_FRACTION:g} % is missing: bias and axis would be doubtful.",
            next_step="Plug the logger in without a hub, close other programs, and run this command again.",
        )
    gap_s = float(np.diff(recording.t_s).max()) if len(recording.t_s) > 1 else 0.0
    if gap_s > LONGEST_GAP_S:
        raise CalibrationError(
            what=f"{1e3 * gap_s:.0f} ms of the measurement are missing in one piece.",
            meaning="What the gyros turned meanwhile is not known, and scale factors rest on it.",
            next_step="Plug the logger in without a hub, close other programs, and run this command again.",
        )
    for body in bodies:
        clipped = int(recording.clipped[:, body - 1].sum())
        if clipped:
            raise CalibrationError(
                what=f"The sensor on body {body} was at its full scale in {clipped} of "
                f"{len(recording.t_s)} samples.",
                meaning="A clipped rate is a lower bound; an axis or a scale factor from it would be wrong.",
                next_step="Move slower than 500 deg/s and knock nothing against the frame, and run this "
                "command again.",
            )
        missing = int((~recording.imu_valid[:, body - 1]).sum())
        if missing:
            raise CalibrationError(
                what=f"{missing} of {len(recording.t_s)} samples of the gyro on body {body} are invalid.",
                meaning="An axis fitted to the rest would be doubtful.",
                next_step="Check the gyro and its cable with tfsat-host status, and run this command again.",
            )
