"""The joints just before the release: every maneuver begins with them at the pose at which the servos hold them."""

from __future__ import annotations

import numpy as np

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.evaluation.checks.check import Check, judged, not_possible
from tfsat_host.evaluation.checks.hanging import angles_at_rest
from tfsat_host.protocol.limits import START_POSE_TOLERANCE_CDEG
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

START_POSE = "start pose"
TOLERANCE_RAD = np.deg2rad(START_POSE_TOLERANCE_CDEG / 100.0)
"""What ARM and the preflight allow: an uncalibrated servo's scale, its play, and a joint that sags, as the paper's
joint 1 by 6 deg, stay within it."""
LOOKED_AT_S = 0.5
BEFORE_RELEASE_S = 0.02
"""The releaser's springs may move a joint that is on its way out."""


def start_pose_check(log: DropLog, calibration: Calibration, model: RobotModel) -> Check:
    """Of one drop, by the medians of the last half second before the release.

    Args:
        log: The recording.
        calibration: That it is evaluated with. A joint without a zero point of its own tells nothing here: it is taken
            to have hung where its servo starts.
        model: Joints, sensors, and the servos' starts.
    """
    rows = (log.t_s >= -LOOKED_AT_S) & (log.t_s < -BEFORE_RELEASE_S)
    if not rows.any():
        return not_possible(
            START_POSE, "deg", "No sample was recorded in the half second before the release."
        )
    angles = angles_at_rest(log, rows, calibration, model)
    measured = np.array([sensors.zero_taken is not None for sensors in calibration.joints])
    off_deg = np.rad2deg(angles - np.array([servo.start_rad for servo in model.servos]))
    told = np.flatnonzero(measured & np.isfinite(off_deg))
    if not len(told):
        return not_possible(
            START_POSE,
            "deg",
            "No joint has a calibrated angle sensor that tells where it stood at the release.",
        )
    worst = int(told[np.abs(off_deg[told]).argmax()])
    std_deg = np.rad2deg(np.sqrt(calibration.joints[worst].zero_covariance.max()))
    start_deg, limit_deg = float(np.rad2deg(model.servos[worst].start_rad)), float(np.rad2deg(TOLERANCE_RAD))
    at = f"{start_deg + off_deg[worst]:+.2f} ± {max(std_deg, 0.01):.2f} deg"
    pose = f"{start_deg:g} ± {limit_deg:g} deg"
    sentence = (
        f"Just before the release joint {worst + 1} stood at {at}, the farthest from the start pose ({pose})."
    )
    if abs(off_deg[worst]) > limit_deg:
        sentence = (
            f"Wrong start pose: just before the release joint {worst + 1} stood at {at} instead of {pose}. The strokes "
            "began elsewhere than the maneuver means."
        )
    check = judged(START_POSE, float(abs(off_deg[worst])), limit_deg, "deg", sentence)
    return check.caused_by(
        f"servo of joint {worst + 1}: it turns the other way, did not hold its joint, or was not calibrated; or the "
        "zero point of the joint's angle sensors is another one",
        f"Without a drop: tfsat-host jog --joint {worst + 1} --from 0 --to 5 shows which way it turns; "
        f"then tfsat-host calibrate zero --joint {worst + 1}",
    )
