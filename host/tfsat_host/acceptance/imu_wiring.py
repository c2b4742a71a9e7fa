"""Which IMU sits on which body, and how it is turned: from a rest, three joints moved by hand, and a turn.

A joint that is moved turns the bodies on one side of it: joint 1 body 1, joint 2 bodies 1 and 2, joint 3 body 4. The
joints that an IMU turns with are therefore the signature of the body that it sits on.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations, product

import numpy as np

from tfsat_host.acceptance.wires import BUS_PINS, name_imu
from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.steps.step import PATTERNS
from tfsat_host.preflight.preflight_check import PreflightCheck, judge, no_go
from tfsat_host.protocol.limits import IMU_COUNT, IMUS_PER_BUS
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import bodies_with_imu, describe_imus
from tfsat_host.units import STANDARD_GRAVITY_M_S2

MAX_NOISE_DEG_S = 0.5
"""Standard deviation of a sample of a gyro at rest: five times the data sheet's at 42 Hz (PS-MPU-6000A, 6.1)."""
MAX_BIAS_DEG_S = 20.0
"""PS-MPU-6000A rev. 3.4, section 6.1."""
MAX_FORCE_ERROR_G = 0.1
"""Of the specific force at rest."""
TEMPERATURES_C = (0.0, 50.0)
MAX_TEMPERATURE_SPREAD_C = 15.0
MIN_ANSWERED_SHARE = 0.99
MIN_TURNED_RAD = np.deg2rad(30.0)
"""An IMU that turned more was moved: hands that hold a body turn it by a few degrees."""
MAX_HANDS_DEG = 10.0
"""What all IMUs show alike beyond it was hands."""
MAX_TILT_DEG = 15.0
"""Between a sensor's axis and the body axis that is nearest to it."""
MOVED_WITH = tuple(next(moved for joint, moved, _ in PATTERNS if joint == number) for number in (1, 2, 3))
"""Bodies (from 1) that a hand moves about joints 1 to 3."""
_RIGHT_ANGLED = [
    rotation
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3))
    if np.linalg.det(rotation := np.eye(3)[list(order)] * np.array(signs)[:, None]) > 0
]
"""The 24 rotations from sensor to body whose axes lie along axes."""
_REPLUG = "Correct the wiring, then repeat the step."


def turned_rad(samples: SensorSamples) -> FloatArray:
    """(4, 3) rotation vector of each IMU in its own axes, at the moment when the farthest had turned most.

    The motion ends where it began: a constant bias is what its mean rate shows.
    """
    rates = samples.rate_rad_s - samples.rate_rad_s.mean(axis=0)
    path = np.cumsum(rates * np.gradient(samples.t_s)[:, None, None], axis=0)
    farthest = np.linalg.norm(path, axis=2).max(axis=1).argmax()
    return np.asarray(path[farthest])


def answering(samples: SensorSamples) -> BoolArray:
    """(4,) which IMUs answer."""
    return np.asarray(samples.imu_valid.mean(axis=0) > MIN_ANSWERED_SHARE)


def check_answers(samples: SensorSamples, model: RobotModel) -> PreflightCheck:
    """Check that each IMU that the robot file has answers."""
    answers, wrong = answering(samples), []
    expected = [body - 1 for body in bodies_with_imu(model)]
    for bus, pins in enumerate(BUS_PINS):
        imus = [imu for imu in expected if imu // IMUS_PER_BUS == bus]
        # Both of a bus at once: rather its two wires, or its supply, than two chips.
        if len(imus) > 1 and not answers[imus].any():
            numbers = " and ".join(str(imu + 1) for imu in imus)
            wrong.append(f"neither IMU {numbers} answers: the bus at Teensy pins {pins}, or its supply")
        else:
            wrong += [f"{name_imu(imu)} does not answer" for imu in imus if not answers[imu]]
    return judge(
        wrong,
        "IMUs: {}.",
        "Check plug, supply and AD0 of what is silent, then repeat the step.",
        describe_imus(model, "answer"),
        answered_share=samples.imu_valid.mean(axis=0).tolist(),
    )


def answering_throughout(motions: Sequence[SensorSamples]) -> tuple[PreflightCheck | None, BoolArray]:
    """Return (4,) the IMUs that answered in all motions; and a finding where one did so in some of them only."""
    answered = np.array([answering(samples) for samples in motions])
    loose = [name_imu(imu) for imu in np.flatnonzero(answered.any(axis=0) & ~answered.all(axis=0)).tolist()]
    if not loose:
        return None, np.asarray(answered.all(axis=0))
    check = no_go(
        f"IMUs when moved: silent in some motions: {'; '.join(loose)}.",
        "Check its plug and cable, then repeat the step.",
    )
    return check, np.asarray(answered.all(axis=0))


def check_rest(samples: SensorSamples, answers: BoolArray) -> PreflightCheck:
    """Check noise, bias, specific force and temperature of the IMUs that answer, the robot at rest."""
    noise = np.rad2deg(samples.rate_rad_s.std(axis=0)).max(axis=1)
    bias = np.rad2deg(np.abs(samples.rate_rad_s.mean(axis=0))).max(axis=1)
    force_g = np.linalg.norm(samples.accel_m_s2.mean(axis=0), axis=1) / STANDARD_GRAVITY_M_S2
    warm = samples.temperature_c.mean(axis=0)
    typical = float(np.median(warm[answers])) if answers.any() else 0.0
    wrong = []
    for imu in np.flatnonzero(answers).tolist():
        name = f"IMU {imu + 1}"
        if noise[imu] > MAX_NOISE_DEG_S:
            wrong.append(f"{name} noise {noise[imu]:.2f} deg/s (limit {MAX_NOISE_DEG_S:g})")
        if bias[imu] > MAX_BIAS_DEG_S:
            wrong.append(f"{name} shows {bias[imu]:.1f} deg/s at rest (limit {MAX_BIAS_DEG_S:g})")
        if abs(force_g[imu] - 1.0) > MAX_FORCE_ERROR_G:
            wrong.append(f"{name} feels {force_g[imu]:.2f} g at rest (1 ± {MAX_FORCE_ERROR_G:g})")
        if (
            not TEMPERATURES_C[0] <= warm[imu] <= TEMPERATURES_C[1]
            or abs(warm[imu] - typical) > MAX_TEMPERATURE_SPREAD_C
        ):
            wrong.append(f"{name} at {warm[imu]:.0f} °C (others {typical:.0f} °C)")
    shown = noise[answers].max(initial=0.0)
    return judge(
        wrong,
        "IMUs at rest: {}.",
        "Keep hands off and repeat the step; if it stays, change that IMU.",
        f"IMUs at rest: noise up to {shown:.2f} deg/s, {typical:.0f} °C.",
        noise_deg_s=noise.tolist(),
        bias_deg_s=bias.tolist(),
        force_g=force_g.tolist(),
        temperature_c=warm.tolist(),
    )


def check_places(turned: Sequence[FloatArray], answers: BoolArray) -> PreflightCheck:
    """Check that each IMU turned with the joints that its body turns with.

    Args:
        turned: Of each joint that is there, what `turned_rad` gave.
        answers: (4,) IMUs that count.
    """
    angles = np.linalg.norm(np.array(turned), axis=2)
    # (3, 4) by joint and IMU.
    moved = (angles > MIN_TURNED_RAD) & answers
    # Body (from 0) by the joints that it turns with.
    bodies = range(len(turned) + 1)
    signatures = {tuple(body + 1 in moved for moved in MOVED_WITH[: len(turned)]): body for body in bodies}
    body_of = {imu: signatures.get(tuple(moved[:, imu].tolist())) for imu in np.flatnonzero(answers).tolist()}
    wrong = []
    for imu, body in body_of.items():
        if body is None:
            joints = " and ".join(str(joint + 1) for joint, row in enumerate(moved) if row[imu]) or "none"
            wrong.append(
                f"IMU {imu + 1} turned with joints {joints}, as no body does: hold what should lie still"
            )
        elif body != imu and body_of.get(body) == imu:
            if imu < body:
                wrong.append(_swapped(imu, body))
        elif body != imu:
            wrong.append(f"IMU {imu + 1} answers where IMU {body + 1} belongs, on body {body + 1}")
    return judge(
        wrong,
        "IMUs by body: {}.",
        _REPLUG,
        "IMUs by body: each turned with its own body.",
        turned_deg=np.rad2deg(angles).tolist(),
        body=[None if (body := body_of.get(imu)) is None else body + 1 for imu in range(IMU_COUNT)],
    )


def _swapped(imu: int, other: int) -> str:
    same_bus = imu // IMUS_PER_BUS == other // IMUS_PER_BUS
    where = "their AD0 pins" if same_bus else f"their buses, Teensy pins {BUS_PINS[0]} and {BUS_PINS[1]}"
    return (
        f"IMU {imu + 1} answers where IMU {other + 1} belongs, and IMU {other + 1} where IMU {imu + 1} belongs: "
        f"exchange {where}"
    )


def check_axes(
    up_m_s2: FloatArray, turned_about_x_rad: FloatArray, answers: BoolArray, model: RobotModel
) -> PreflightCheck:
    """Check each IMU's axes against the robot file.

    Args:
        up_m_s2: (4, 3) specific force, sensor axes, the robot upright: along body z.
        turned_about_x_rad: (4, 3) `turned_rad` of a turn of the whole robot about +x.
        answers: (4,) IMUs that count.
        model: The robot by design.
    """
    wrong, tilts, turns = [], [], []
    for imu in np.flatnonzero(answers).tolist():
        up, about_x = (
            vectors[imu] / np.linalg.norm(vectors[imu]) for vectors in (up_m_s2, turned_about_x_rad)
        )
        # The right-angled mounting that puts both measured vectors nearest to body z and body x.
        mounted = max(_RIGHT_ANGLED, key=lambda rotation: (rotation @ up)[2] + (rotation @ about_x)[0])
        tilt = np.rad2deg(np.arccos(np.clip(min((mounted @ up)[2], (mounted @ about_x)[0]), -1.0, 1.0)))
        tilts.append(float(tilt))
        turns.append(mounted @ np.round(model.imus[imu].sensor_to_body).T)
        if not np.array_equal(mounted, np.round(model.imus[imu].sensor_to_body)):
            axes = ", ".join(
                f"its {axis} along body {_name_axis(mounted[:, k])}" for k, axis in enumerate("xyz")
            )
            rows = mounted.astype(int).tolist()
            wrong.append(
                f"IMU {imu + 1} is mounted otherwise than the robot file says: {axes} (sensor_to_body = {rows})"
            )
        elif tilt > MAX_TILT_DEG:
            wrong.append(f"IMU {imu + 1} is tilted by {tilt:.0f} deg (limit {MAX_TILT_DEG:g})")
    # All of them off alike: rather the hands' doing than four mountings'.
    aslant = min(tilts, default=0.0)
    if len(tilts) > 1 and aslant > MAX_HANDS_DEG:
        wrong = [
            f"all IMUs saw the robot stand or tilt aslant by {aslant:.0f} deg: begin upright, tilt about x"
        ]
    alike = len(turns) > 1 and all(np.array_equal(turns[0], turn) for turn in turns)
    if alike and not np.array_equal(turns[0], np.eye(3)):
        about = _name_axis(turns[0].T @ np.array([1.0, 0.0, 0.0]))
        wrong = [
            f"all IMUs saw the robot tilt about body {about}, not x: tilt it until its y axis points up; if it did, "
            "every sensor_to_body is off by that rotation"
        ]
    return judge(
        wrong,
        "IMU axes: {}.",
        "Repeat the step, begun upright. If it stays: mount it as designed, or write that sensor_to_body into the "
        "robot file.",
        f"IMU axes: as in the robot file, within {max(tilts, default=0.0):.0f} deg.",
        tilt_deg=tilts,
    )


def _name_axis(direction: FloatArray) -> str:
    axis = int(np.abs(direction).argmax())
    return f"{'-' if direction[axis] < 0 else ''}{'xyz'[axis]}"
