"""Samples taken for a calibration, in SI units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.units import STANDARD_GRAVITY_M_S2

_ACCEL, _TEMPERATURE, _GYRO = slice(0, 3), 3, slice(4, 7)


@dataclass(frozen=True, eq=False)
class SensorSamples:
    """n samples of all sensors, each at its sample's time: when a sensor was really read, and that low-passes of
    different parts are late by different times, is taken into account here.

    Attributes:
        t_s: (n,) seconds on the logger's clock.
        rate_rad_s: (n, 4, 3) angular rates in sensor axes, as read, bias included.
        accel_m_s2: (n, 4, 3) specific forces in sensor axes, as read.
        temperature_c: (n, 4) of the IMUs' dies.
        sensor_angle_rad: (n, 6) absolute angle sensors, 0 to 2 pi: the middle of the count, for a converter cuts off.
        imu_valid: (n, 4) the IMU answered and did not clip.
        clipped: (n, 4) a value of the IMU is at its full scale.
        samples_lost: Samples that the logger took and that never arrived.
        angle_step_rad: One count of an angle sensor.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    accel_m_s2: FloatArray
    temperature_c: FloatArray
    sensor_angle_rad: FloatArray
    imu_valid: NDArray[np.bool_]
    clipped: NDArray[np.bool_]
    samples_lost: int
    angle_step_rad: float

    @classmethod
    def from_counts(cls, counts: Counts) -> SensorSamples:
        """Convert counts to SI units by the scales that came with them."""
        scales, low_pass = counts.scales, counts.scales.low_pass
        step_rad = 2 * np.pi / scales.angle_counts_per_turn
        t_s = np.asarray(counts.t_us * 1e-6, dtype=np.float64)
        # The logger reads the sensors one after the other; it states how long after the sample's time.
        imu_s, angle_s = 1e-6 * np.array(scales.imu_offset_us), 1e-6 * np.array(scales.angle_offset_us)
        rates = np.deg2rad(counts.imu_counts[:, :, _GYRO] / scales.gyro_lsb_per_deg_s)
        forces = counts.imu_counts[:, :, _ACCEL] * np.float64(STANDARD_GRAVITY_M_S2 / scales.accel_lsb_per_g)
        # A converter cuts off: half a count puts the reading in the middle of its step.
        angles_rad = np.asarray((counts.angle_counts + 0.5) * step_rad, dtype=np.float64)
        # A clipped value is only a bound: no slope may rest on it.
        answered = counts.imu_valid & ~counts.clipped
        # A longer low-pass shows an older motion: its extra lag counts against the time of reading.
        return cls(
            t_s=t_s,
            rate_rad_s=at_sample_times(t_s, rates, imu_s - low_pass.gyros_later_s, answered),
            accel_m_s2=at_sample_times(t_s, forces, imu_s - low_pass.accels_later_s, answered),
            temperature_c=scales.temperature_c(counts.imu_counts[:, :, _TEMPERATURE]),
            sensor_angle_rad=at_sample_times(t_s, angles_rad, angle_s, counts.angle_valid, angles=True),
            imu_valid=answered,
            clipped=counts.clipped,
            samples_lost=counts.samples_lost,
            angle_step_rad=step_rad,
        )


def at_sample_times(
    t_s: FloatArray,
    values: FloatArray,
    offset_s: FloatArray,
    valid: NDArray[np.bool_],
    *,
    angles: bool = False,
) -> FloatArray:
    """Correct sensor readings to the samples' times: each reading less its offset times its slope.

    The slope is that between the neighbouring readings, so that the noise variance of a sample grows by at most
    (offset / period)^2 / 4. A sensor with fewer than two valid readings stays as it is.

    Args:
        t_s: (n,) the samples' times, increasing.
        values: (n, k, ...) of k sensors.
        offset_s: (k,) from a sample's time to each sensor's reading (LogHeader.imu_offset_us, angle_offset_us).
        valid: (n, k); others are left as they are, and no slope uses them.
        angles: The values are angles in [0, 2 pi), rad, and wrap.
    """
    moved = values.copy()
    for k in np.flatnonzero(offset_s):
        rows = np.flatnonzero(valid[:, k])
        if len(rows) > 1:
            # Unwrapped, for across 0 the slope would be that of a whole turn.
            readings = np.unwrap(values[rows, k], axis=0) if angles else values[rows, k]
            # First-order Taylor step back to the sample's time.
            at_sample = readings - offset_s[k] * np.gradient(readings, t_s[rows], axis=0)
            moved[rows, k] = at_sample % (2 * np.pi) if angles else at_sample
    return moved


MIN_DURATION_S = 0.35
SWEEP_SHARE = 0.08
"""A hand that rests trembles; at a sweep's rests gyro and angle sensors are averaged over the same samples."""
TURN_SHARE = 0.02
"""A turn's angle is known where it ends, not on the way there."""
_MARGIN_S = 0.1
"""Left out at either end: the low-pass settles."""


def find_rests(t_s: FloatArray, rate_rad_s: FloatArray, share: float = SWEEP_SHARE) -> list[slice]:
    """Stretches in which hardly anything turns, in order.

    Args:
        t_s: (n,) times.
        rate_rad_s: (n,) rate about the axis of the motion.
        share: Of the motion's speed; what is slower rests.
    """
    speed = np.abs(rate_rad_s)
    # Relative to the upper end of the speeds, so that slow and fast hands are judged alike.
    limit = max(np.deg2rad(1.5), share * float(np.quantile(speed, 0.95)))
    window = max(1, round(0.1 / float(np.median(np.diff(t_s)))))
    # Over 0.1 s: a single tremor must not split a rest.
    smooth = np.convolve(speed, np.full(window, 1.0 / window), mode="same")
    # Padded with False, so that a rest at either end of the recording has both its edges.
    quiet = np.concatenate([[False], smooth < limit, [False]])
    edges = np.flatnonzero(np.diff(quiet.astype(np.int8)))
    rests = []
    for begin, end in zip(edges[::2], edges[1::2] - 1, strict=True):
        if t_s[end] - t_s[begin] >= MIN_DURATION_S + 2 * _MARGIN_S:
            inside = np.searchsorted(t_s, [t_s[begin] + _MARGIN_S, t_s[end] - _MARGIN_S])
            rests.append(slice(int(inside[0]), int(inside[1])))
    return rests


MAX_LOST_FRACTION = 0.01
"""More lost samples than this, and the rest may not stand for the motion."""
MAX_GAP_S = 0.05
"""A straight line over more would cut a corner of a motion."""


def check_complete(recording: SensorSamples, bodies: Iterable[int]) -> None:
    """Check that the clock advanced, few samples were lost, and all of the gyros' samples are valid.

    The gyros are those of `bodies` (1 to 4).

    Raises:
        CalibrationError: one of these does not hold.
    """
    steps_s, lost, n = np.diff(recording.t_s), recording.samples_lost, len(recording.t_s)
    if np.any(steps_s <= 0):
        raise CalibrationError(
            what="The logger's clock went backwards during the measurement: the logger restarted.",
            meaning="The samples do not belong together; nothing was kept.",
            next_step=Advice(
                "Check the logger's supply and cable with ",
                NextStep("status"),
                ", and run this command again.",
            ),
        )
    if lost > MAX_LOST_FRACTION * (n + lost):
        raise CalibrationError(
            what=f"{lost} of {n + lost} samples never reached this computer.",
            meaning=f"More than {100 * MAX_LOST_FRACTION:g} % is missing: bias and axis would be doubtful.",
            next_step="Plug the logger in without a hub, close other programs, and run this command again.",
        )
    if (gap_s := steps_s.max(initial=0.0)) > MAX_GAP_S:
        raise CalibrationError(
            what=f"{1e3 * gap_s:.0f} ms of the measurement are missing in one piece.",
            meaning="What the gyros turned meanwhile is not known, and scale factors rest on it.",
            next_step="Plug the logger in without a hub, close other programs, and run this command again.",
        )
    # Clipping before silence: clipped samples are invalid as well, and have another cure.
    for body in bodies:
        if clipped := int(recording.clipped[:, body - 1].sum()):
            raise CalibrationError(
                what=f"The sensor on body {body} was at its full scale in {clipped} of {n} samples.",
                meaning="A clipped rate is a lower bound; an axis or a scale factor from it would be wrong.",
                next_step="Move slower than 500 deg/s and knock nothing against the frame, and run this command again.",
            )
        if missing := int((~recording.imu_valid[:, body - 1]).sum()):
            raise CalibrationError(
                what=f"{missing} of {n} samples of the gyro on body {body} are invalid.",
                meaning="An axis fitted to the rest would be doubtful.",
                next_step=Advice(
                    "Check the gyro and its cable with ", NextStep("status"), ", and run this command again."
                ),
            )


def check_answers(valid: NDArray[np.bool_], joint: int, most_silent: float) -> None:
    """Refuses samples (n, 2) of a joint's angle sensors of which more than the share `most_silent` are missing.

    Raises:
        CalibrationError: naming the sensor.
    """
    for index, answered in enumerate(valid.mean(axis=0), 1):
        if answered < 1.0 - most_silent:
            raise CalibrationError(
                what=f"Angle sensor {index} of joint {joint} gave no value in {100 * (1 - answered):.2g} % of the "
                "samples.",
                meaning="Without it the joint's angle is not known, now or in the drop.",
                next_step=Advice(
                    "Check its cable with ", NextStep("monitor"), ", and run this command again."
                ),
            )
