"""How a hidden robot can be another one than its file and its certificate say: each way by a name and a size.

Files and certificate stay as they are. Where several numbers go wrong, the size is one standard deviation of each, as
in a robot file's `[uncertainty]`; signs, directions and bodies follow from the day's seed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.certificate import worse_certificate
from tfsat_host.emulated.imperfections import MOST_LATE_S
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.fault import Fault, Moment, Outcome, Size, during
from tfsat_host.rehearsal.truth import CORRECTED_BODIES, Truth, drawn_truth
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
    return _model(truth, mass_kg=mass * np.exp(PERCENT * percent * random.standard_normal(mass.shape)))


def _inertias(truth: Truth, percent: float, random: Random) -> Truth:
    strain = PERCENT * percent * random.standard_normal((truth.model.n_bodies, 3, 3))
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
    root = np.linalg.cholesky(_complement(inertia_kg_m2))
    values, axes = np.linalg.eigh(strain)
    # e^E - 1, so that no strain leaves the tensor as it was to the last bit.
    change = root @ (axes * np.expm1(values)) @ axes.T @ root.T
    return np.asarray(inertia_kg_m2 + np.trace(change) * np.eye(3) - change)


def _complement(inertia: FloatArray) -> FloatArray:
    return np.asarray(np.trace(inertia) / 2.0 * np.eye(3) - inertia)


def _square_to_axes(model: RobotModel, std: float, random: Random) -> FloatArray:
    """(n - 1, 3) normal in both directions across each joint's axis."""
    drawn = std * random.standard_normal(model.joint_axis.shape)
    return np.asarray(drawn - np.sum(drawn * model.joint_axis, axis=1, keepdims=True) * model.joint_axis)


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
    scale[random.integers(IMU_COUNT)] *= 1.0 + PERCENT * percent * random.choice([-1.0, 1.0], 3)
    return replace(_sensors(truth, gyro_scale=scale), calibrated=truth.calibrated or was)


def _g_sensitivity(truth: Truth, deg_s_g: float, random: Random) -> Truth:
    was = truth.imperfections.gyro_g_sensitivity_rad_s_g
    return _sensors(truth, gyro_g_sensitivity_rad_s_g=was + DEG * deg_s_g * random.standard_normal(was.shape))


def _cross_axis(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections.gyro_cross_axis
    drawn = PERCENT * percent * random.standard_normal(was.shape)
    return _sensors(truth, gyro_cross_axis=was + drawn * (1.0 - np.eye(3)))


def _late(truth: Truth, ms: float, random: Random) -> Truth:
    return _sensors(truth, imu_late_s=_of_one(random.integers(IMU_COUNT), MS * ms))


def _own_clocks(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections.imu_clock_ppm
    return _sensors(truth, imu_clock_ppm=was + 1e4 * percent * random.uniform(-1.0, 1.0, was.shape))


def _front_end(truth: Truth, deg_s: float, random: Random) -> Truth:
    return _sensors(truth, gyro_front_end_limit_rad_s=_of_one(random.choice(_FASTEST_BODIES), DEG * deg_s))


def _of_one(body: np.signedinteger[Any], value: float) -> FloatArray:
    return np.where(np.arange(IMU_COUNT) == body, value, 0.0)


def _ripple(truth: Truth, deg_s: float, _: Random) -> Truth:
    return _sensors(truth, mount_ripple_s=deg_s / RINGS_AFTER_DEG_S2)


def _as_filed(truth: Truth, times: float, random: Random) -> Truth:
    """All that a robot file states an uncertainty of, but the centers of mass that are drawn anyway."""
    stated = (truth.model.uncertainty or Uncertainty()).stated()
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
    day.robot.faults.gyro_bias_step(body, DEG * deg_s * towards / np.linalg.norm(towards))


def _slip(day: Day, deg: float, random: Random) -> None:
    index = int(random.integers(ANGLE_SENSOR_COUNT)) + 1
    day.robot.faults.angle_sensor(index, "turned", float(deg * random.choice([-1.0, 1.0])))


def _certificate(day: Day, times: float, random: Random) -> None:
    day.calibration = worse_certificate(day.calibration, times, random)


def _built(
    name: str,
    what: str,
    size: Size,
    noticed: str,
    hidden: Callable[[Truth, float, Random], Truth],
    preflight: tuple[str, ...] = (),
) -> Fault:
    """The robot is so from the day's beginning."""
    outcomes = {Moment.POWERED: Outcome.FLIES}
    return Fault(
        name,
        what,
        Moment.POWERED,
        lambda *_: None,
        outcomes,
        noticed=noticed,
        preflight=preflight,
        size=size,
        hidden=hidden,
    )


def _happens(
    name: str, what: str, size: Size, noticed: str, strike: Callable[[Day, float, Random], None]
) -> Fault:
    """At a moment between the start of the recording and the landing."""
    outcomes = during(Moment.RECORDING, Moment.BEFORE_LANDING, Outcome.FLIES)
    return Fault(name, what, Moment.FALLING, strike, outcomes, noticed=noticed, size=size)


MODEL_MISMATCHES = (
    _built("wrong-masses", "Each body's mass is another.", Size(2.0, "%", 20.0), "masses", _masses),
    _built("wrong-inertias", "Each body's inertia is another.", Size(3.0, "%", 20.0), "inertias", _inertias),
    _built(
        "wrong-hinge-points", "Each hinge is elsewhere.", Size(0.5, "mm", 20.0), "hinge points", _hinge_points
    ),
    _built(
        "wrong-hinge-axes", "Each hinge's axis leans.", Size(0.5, "deg", 10.0), "axis of joint", _hinge_axes
    ),
    _built(
        "wrong-com-of-body-4",
        "Body 4's center of mass is elsewhere.",
        Size(3.0, "mm", 50.0),
        "CoM of body 4",
        _centers(CORRECTED_BODIES, IMU_COUNT),
    ),
    _built(
        "wrong-coms",
        "The centers of mass of bodies 1 to 3, which an evaluation corrects, are elsewhere once more.",
        Size(3.0, "mm", 50.0),
        "",
        _centers(0, CORRECTED_BODIES),
    ),
    _built(
        "robot-file-uncertain",
        "Masses, inertias, hinges and body 4's center of mass are all drawn from the robot file's [uncertainty].",
        Size(1.0, "times", 10.0),
        "",
        _as_filed,
    ),
)
SENSOR_MISMATCHES = (
    _built(
        "gyro-scale-changed",
        "One gyro's scale factors have changed since the calibration.",
        Size(1.0, "%", 20.0),
        "gyro of body",
        _gyro_scale,
    ),
    _built(
        "gyro-g-sensitive",
        "The gyros feel forces more than their data sheet says.",
        Size(0.5, "deg/s/g", 10.0),
        "g-sensitivity",
        _g_sensitivity,
    ),
    _built(
        "gyro-cross-axis",
        "Each axis of a gyro shows some of the rates about the others.",
        Size(1.0, "%", 20.0),
        "gyro of body",
        _cross_axis,
    ),
    _happens(
        "gyro-bias-step", "One gyro's bias jumps.", Size(0.3, "deg/s", 100.0), "gyro of body", _bias_step
    ),
    _happens(
        "angle-sensor-crept",
        "The magnet of an angle sensor slips a little.",
        Size(1.0, "deg", 180.0),
        "angle sensor of joint",
        _slip,
    ),
    _built(
        "imu-late",
        "All that one IMU shows comes late.",
        Size(2.0, "ms", 1e3 * MOST_LATE_S),
        "late",
        _late,
    ),
    _built(
        "imu-clocks",
        "Each IMU converts by an oscillator of its own, which is off by as much or less.",
        Size(1.0, "%", 5.0),
        "",
        _own_clocks,
    ),
    _built(
        "gyro-saturated-unflagged",
        "One gyro shows no rate beyond this, cut off before its low-pass, so that no count is at its end.",
        Size(100.0, "deg/s", 2000.0),
        "saturat",
        _front_end,
    ),
    Fault(
        "certificate-wrong",
        "Gyros and angle sensors are off from the certificate by so many times its own ± more.",
        Moment.POWERED,
        _certificate,
        {Moment.POWERED: Outcome.FLIES},
        noticed="certificate",
        preflight=(),
        part="calibration",
        size=Size(3.0, "times", 1000.0),
    ),
    _built(
        "mount-ripple",
        "What the IMUs stand on rings at 30 Hz after strokes: so fast after a change of 1000 deg/s².",
        Size(2.0, "deg/s", 100.0),
        "",
        _ripple,
    ),
)
MISMATCHES = (*MODEL_MISMATCHES, *SENSOR_MISMATCHES)


def draw_hidden(
    filed: RobotModel, seed: int, mismatches: Sequence[Fault] = (), uncertainty: Uncertainty | None = None
) -> Truth:
    """A robot that its file's `[uncertainty]` allows, all figures of it drawn together, with mismatches on top.

    Args:
        filed: As its file has it.
        seed: Of everything.
        mismatches: Of `MISMATCHES`, of any size; those that happen during a drop change nothing here.
        uncertainty: Instead of the file's.
    """
    stated = replace(filed, uncertainty=uncertainty or filed.uncertainty)
    truth = drawn_truth(stated, seed)
    (of_file,) = (one for one in MODEL_MISMATCHES if one.hidden is _as_filed)
    for one in (of_file, *mismatches):
        truth = one.flown(truth)
    return replace(truth, model=replace(truth.model, uncertainty=filed.uncertainty))
