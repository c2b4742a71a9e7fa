"""Which servo each pin moves, which way, and how far: small jogs from the middle of the range, then to the ends."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tfsat_host.acceptance.bench import Bench, Task
from tfsat_host.acceptance.wires import name_servo
from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.servos.tour import LoggedTour
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.devices.jog_path import JogTour
from tfsat_host.errors import TfsatError
from tfsat_host.preflight.preflight_check import PreflightCheck, judge
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.robot import RobotModel
from tfsat_host.units import CDEG_PER_DEG

JOG_DEG = 10.0
HOLD_S = 1.0
MIN_MOVED_DEG = 4.0
"""Of a jog of `JOG_DEG`: what moved less did not follow."""
MAX_END_ERROR_DEG = 10.0
"""Between a commanded end and where the joint comes to rest, before its servo is calibrated."""
NEAR_HALF_DEG = (33.0, 57.0)
"""Where a hand puts a joint half way: from there a servo that is reversed, or another's, turns it by that little."""
MAX_TRIES = 3


def check_servos(bench: Bench, closed_rad: Sequence[float]) -> list[PreflightCheck]:
    """Jog each joint by a little, then, if it followed, to its ends.

    Args:
        bench: With the servos' power on.
        closed_rad: Of each angle sensor, what it shows with its joint closed.

    Raises:
        BoardRefusal, JogError, JogRefused, PortError: see `JogClient.tour`; the joint was let go.
    """
    closed, wrong, ends = np.array(closed_rad), [], []
    _have_joints_half_open(bench, closed)
    for joint in range(len(bench.joints)):
        start_deg = joint_angles_deg(bench.read(0.5), closed, bench.robot)[joint]
        before, after = _rests_deg(bench, joint, (start_deg, start_deg + JOG_DEG), closed)
        finding = _of_jog(joint, after - before)
        if finding:
            wrong.append(finding)
            continue
        limits = bench.sequencer.settings().settings.of(joint + 1)
        here_deg = joint_angles_deg(bench.read(0.5), closed, bench.robot)[joint]
        told = (limits.max_cdeg / CDEG_PER_DEG, limits.min_cdeg / CDEG_PER_DEG)
        reached = _rests_deg(bench, joint, (here_deg, *told), closed)[1:, joint]
        ends += [
            f"joint {joint + 1} came to rest at {angle:.0f} deg, told {end:g}"
            for angle, end in zip(reached.tolist(), told, strict=True)
            if abs(angle - end) > MAX_END_ERROR_DEG
        ]
    return [
        judge(
            wrong,
            "Servos: {}.",
            "Correct the wiring or the servo settings, then repeat the step.",
            f"Servos: {len(bench.joints)} of {len(bench.joints)} move their own joint, the right way.",
        ),
        judge(
            ends,
            "End stops: {}.",
            "Find what blocks the joint, or correct the limits in the servo settings.",
            f"End stops: limits reached within {MAX_END_ERROR_DEG:g} deg.",
        ),
    ]


def _have_joints_half_open(bench: Bench, closed_rad: FloatArray) -> None:
    """Have all joints half open before the first order. Raises TfsatError: once too often they were not."""
    low, high = NEAR_HALF_DEG
    mistake = ""
    for _ in range(MAX_TRIES):
        if mistake:
            bench.note(f"  {mistake}. Once more:")
        bench.hands.do(Task.OPEN_HALF)
        angles = joint_angles_deg(bench.read(0.5), closed_rad, bench.robot)[: len(bench.joints)]
        if ((low <= angles) & (angles <= high)).all():
            return
        stand = ", ".join(f"{angle:.0f}" for angle in angles)
        mistake = f"The joints stand at {stand} deg; {low:g} to {high:g} deg are half open"
    raise TfsatError(what=f"{mistake}.", meaning="No servo was moved.", next_step="Repeat the step.")


def _of_jog(joint: int, moved_deg: FloatArray) -> str:
    """Judge a jog of one joint, from 0, towards larger angles by what each joint did, (3,) deg; empty: it is right."""
    farthest = int(np.abs(moved_deg).argmax())
    name = name_servo(joint)
    if abs(moved_deg[farthest]) < MIN_MOVED_DEG:
        return f"{name} does not move: its signal wire, plug or supply (S4)"
    if farthest != joint:
        return f"{name} moves joint {farthest + 1}: servo plugs exchanged"
    if moved_deg[joint] < 0:
        turned = f"{moved_deg[joint]:+.0f} deg, told {JOG_DEG:+g}"
        return f"{name} turns the wrong way ({turned}): reversed in the servo settings"
    return ""


def _rests_deg(bench: Bench, joint: int, stops_deg: Sequence[float], closed_rad: FloatArray) -> FloatArray:
    """(n, 3) angles of all joints at rest at each stop of a tour of one of them, from 0."""
    rests: list[FloatArray] = []

    def on_rest(counts: Counts) -> None:
        samples = SensorSamples.from_counts(counts)
        rests.append(joint_angles_deg(samples, closed_rad, bench.robot))

    stops = tuple(round(angle * CDEG_PER_DEG) for angle in stops_deg)
    with bench.logger.live() as scales:
        watch = LoggedTour(bench.logger.samples_of, scales, lambda _stop, _angle: None, on_rest)
        if not bench.sequencer.tour(JogTour(joint + 1, stops, HOLD_S), lambda: False, watch).held:
            # Ctrl-C: the tour has let the joint go.
            raise KeyboardInterrupt
    return np.array(rests)


def joint_angles_deg(samples: SensorSamples, closed_rad: FloatArray, robot: RobotModel) -> FloatArray:
    """(3,) each joint's angle by its two sensors, from their readings with the joint closed; the last 0.2 s count."""
    late = samples.t_s >= samples.t_s[-1] - 0.2
    shown = np.angle(np.exp(1j * samples.sensor_angle_rad[late]).mean(axis=0))
    directions = np.array([sensor.direction for sensor in robot.angle_sensors])
    angles = directions * np.asarray(wrap_angle(shown - closed_rad))
    return np.asarray(np.degrees(angles.reshape(JOINT_COUNT, 2).mean(axis=1)))


def closed_readings(starts_rad: Sequence[FloatArray]) -> list[float]:
    """Return of each sensor what it showed at the beginning of the motion of its own joint, closed, rad.

    What is not there shows 0 throughout.
    """
    shown = [starts_rad[sensor // 2][sensor] for sensor in range(2 * len(starts_rad))]
    shown += [0.0] * (2 * JOINT_COUNT - len(shown))
    return [float(math.remainder(angle, 2 * math.pi)) for angle in shown]
