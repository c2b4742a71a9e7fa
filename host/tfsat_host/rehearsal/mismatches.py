"""How a hidden robot can be another one than its file and its certificate say: the mismatches of `faults.toml`.

Files and certificate stay as they are. Where several numbers go wrong, the size is one standard deviation of each, as
in a robot file's `[uncertainty]`; signs, directions and bodies follow from the day's seed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.emulated_certificate import worse_certificate
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.truth import CORRECTED_BODIES, Truth
from tfsat_host.robot import RobotModel, Uncertainty
from tfsat_host.robot.model import UNCERTAIN

Random = np.random.Generator
PERCENT, MM, MS, DEG = 1e-2, 1e-3, 1e-3, np.pi / 180.0
RINGS_AFTER_DEG_S2 = 1000.0
"""Change of a body's angular acceleration that the size of the mounts' ringing is given for."""
_FASTEST_BODIES = (0, 2, 3)
"""Indices: rates of the others stay below 100 deg/s in the paper's maneuver."""


def _model(truth: Truth, **fields: Any) -> Truth:
    return replace(truth, model=replace(truth.model, **fields))


def _sensors(truth: Truth, **fields: Any) -> Truth:
    return replace(truth, imperfections=replace(truth.imperfections, **fields))


def _masses(truth: Truth, percent: float, random: Random) -> Truth:
    mass = truth.model.mass_kg
    # Log-normal: no draw makes a mass negative.
    return _model(truth, mass_kg=mass * np.exp(PERCENT * percent * random.standard_normal(mass.shape)))


def _inertias(truth: Truth, percent: float, random: Random) -> Truth:
    strain = PERCENT * percent * random.standard_normal((truth.model.n_bodies, 3, 3))
    # (E + E^T) / sqrt 2 of independent normals: symmetric, with a distribution that favours no axes.
    pairs = zip(truth.model.inertia_kg_m2, (strain + strain.swapaxes(1, 2)) / 2.0**0.5, strict=True)
    return _model(truth, inertia_kg_m2=np.array([strained_inertia(*pair) for pair in pairs]))


def strained_inertia(inertia_kg_m2: FloatArray, strain: FloatArray) -> FloatArray:
    """Inertia tensor (3, 3) of a body with the second moments S' = L e^E L^T, where those of `inertia_kg_m2` are L L^T.

    S' is positive definite with S = tr(I) / 2 1 - I, so that no moment is negative or greater than the other two
    together: the body can exist (Wensing, Kim, Slotine, IEEE RA-L 3, 2018).

    Args:
        inertia_kg_m2: (3, 3) about the center of mass.
        strain: E, (3, 3), symmetric.

    Raises:
        numpy.linalg.LinAlgError: no body has `inertia_kg_m2`.
    """
    # L of the second moments S = L L^T; fails for a tensor that no distribution of mass has.
    root = np.linalg.cholesky(_complement(inertia_kg_m2))
    values, axes = np.linalg.eigh(strain)
    # e^E - 1, so that no strain leaves the tensor as it was to the last bit.
    change = root @ (axes * np.expm1(values)) @ axes.T @ root.T
    # From second moments to inertia: I = tr(S) 1 - S, which is linear, so it holds for the change.
    return np.asarray(inertia_kg_m2 + np.trace(change) * np.eye(3) - change)


def _complement(inertia: FloatArray) -> FloatArray:
    return np.asarray(np.trace(inertia) / 2.0 * np.eye(3) - inertia)


def _square_to_axes(model: RobotModel, std: float, random: Random) -> FloatArray:
    """(n - 1, 3) normal in both directions across each joint's axis."""
    # Take out the component along the axis: to shift or scale a hinge along itself changes no motion.
    deviations = std * random.standard_normal(model.joint_axis.shape)
    return np.asarray(
        deviations - np.sum(deviations * model.joint_axis, axis=1, keepdims=True) * model.joint_axis
    )


def _hinge_points(truth: Truth, mm: float, random: Random) -> Truth:
    moved = _square_to_axes(truth.model, MM * mm, random)
    return _model(truth, joint_point_m=truth.model.joint_point_m + moved)


def _hinge_axes(truth: Truth, deg: float, random: Random) -> Truth:
    leaning = truth.model.joint_axis + _square_to_axes(truth.model, DEG * deg, random)
    return _model(truth, joint_axis=leaning / np.linalg.norm(leaning, axis=1, keepdims=True))


def _centers(first: int, end: int) -> Callable[[Truth, float, Random], Truth]:
    def moved(truth: Truth, mm: float, random: Random) -> Truth:
        com = truth.model.com_m.copy()
        com[first:end] += MM * mm * random.standard_normal(com[first:end].shape)
        return _model(truth, com_m=com)

    return moved


def _gyro_scale(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections
    scale = was.gyro_scale.copy()
    # The same magnitude on all axes of one gyro, with a sign for each.
    scale[random.integers(IMU_COUNT)] *= 1.0 + PERCENT * percent * random.choice([-1.0, 1.0], 3)
    # It changed after the calibration: the certificate is of the sensors before.
    return replace(_sensors(truth, gyro_scale=scale), calibrated=truth.calibrated or was)


def _g_sensitivity(truth: Truth, deg_s_g: float, random: Random) -> Truth:
    was = truth.imperfections.gyro_g_sensitivity_rad_s_g
    return _sensors(truth, gyro_g_sensitivity_rad_s_g=was + DEG * deg_s_g * random.standard_normal(was.shape))


def _cross_axis(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections.gyro_cross_axis
    deviations = PERCENT * percent * random.standard_normal(was.shape)
    # Off the diagonal only: on it would be the scale factor, which calibration finds.
    return _sensors(truth, gyro_cross_axis=was + deviations * (1.0 - np.eye(3)))


def _late(truth: Truth, ms: float, random: Random) -> Truth:
    return _sensors(truth, imu_late_s=_of_one(random.integers(IMU_COUNT), MS * ms))


def _own_clocks(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections.imu_clock_ppm
    # 1 % is 1e4 ppm; every IMU has an oscillator of its own.
    return _sensors(truth, imu_clock_ppm=was + 1e4 * percent * random.uniform(-1.0, 1.0, was.shape))


def _front_end(truth: Truth, deg_s: float, random: Random) -> Truth:
    return _sensors(truth, gyro_front_end_limit_rad_s=_of_one(random.choice(_FASTEST_BODIES), DEG * deg_s))


def _of_one(body: np.signedinteger[Any], value: float) -> FloatArray:
    return np.where(np.arange(IMU_COUNT) == body, value, 0.0)


def _ripple(truth: Truth, deg_s: float, _: Random) -> Truth:
    return _sensors(truth, mount_ripple_s=deg_s / RINGS_AFTER_DEG_S2)


def _as_file_allows(truth: Truth, times: float, random: Random) -> Truth:
    """Change every parameter for which the robot file states an uncertainty.

    Centers of mass that are drawn anyway are left out.
    """
    stated = (truth.model.uncertainty or Uncertainty()).figures()
    for key, change in _OF_FILE.items():
        if stated[key]:
            truth = change(truth, times * stated[key] * _SHOWN[key], random)
    return truth


_OF_FILE: Mapping[str, Callable[[Truth, float, Random], Truth]] = {
    "mass_relative": _masses,
    "inertia_relative": _inertias,
    "joint_point_mm": _hinge_points,
    "joint_axis_deg": _hinge_axes,
    "com_mm": _centers(CORRECTED_BODIES, IMU_COUNT),
}
"""By the key of `[uncertainty]`."""
_SHOWN = {key: 1.0 / PERCENT if key.endswith("_relative") else 1.0 for key in UNCERTAIN}


def _bias_step(day: Day, deg_s: float, random: Random) -> None:
    towards = random.standard_normal(3)
    body = int(random.integers(IMU_COUNT)) + 1
    # A normalized Gaussian vector: the step's size is as asked for, its direction anywhere.
    day.robot.faults.gyro_bias_step(body, DEG * deg_s * towards / np.linalg.norm(towards))


def _slip(day: Day, deg: float, random: Random) -> None:
    index = int(random.integers(ANGLE_SENSOR_COUNT)) + 1
    day.robot.faults.angle_sensor(index, "turned", float(deg * random.choice([-1.0, 1.0])))


def _certificate(day: Day, times: float, random: Random) -> None:
    day.calibration = worse_certificate(day.calibration, times, random)


BUILT: Mapping[str, Callable[[Truth, float, Random], Truth]] = {
    "wrong-masses": _masses,
    "wrong-inertias": _inertias,
    "wrong-hinge-points": _hinge_points,
    "wrong-hinge-axes": _hinge_axes,
    "wrong-com-of-body-4": _centers(CORRECTED_BODIES, IMU_COUNT),
    "wrong-coms": _centers(0, CORRECTED_BODIES),
    "robot-file-uncertain": _as_file_allows,
    "gyro-scale-changed": _gyro_scale,
    "gyro-g-sensitive": _g_sensitivity,
    "gyro-cross-axis": _cross_axis,
    "imu-late": _late,
    "imu-clocks": _own_clocks,
    "gyro-saturated-unflagged": _front_end,
    "mount-ripple": _ripple,
}
"""By the fault's name: the robot that flies, given another, the size and where to draw from."""
SIZED_STRIKES: Mapping[str, Callable[[Day, float, Random], None]] = {
    "gyro-bias-step": _bias_step,
    "angle-sensor-crept": _slip,
    "certificate-wrong": _certificate,
}
"""Those that strike on the day."""
