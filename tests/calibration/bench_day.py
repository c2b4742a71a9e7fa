"""The steps of one emulated robot's calibration, each recorded when it is first asked for; and faults to put in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import timedelta
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.calibration.emulated_day import DAY_BEGINS, all_steps, record_step
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.acceptance import check_step
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.sensors.gyro import skews_of
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import Step, StepKind, rest, sweeps, swings, turn, zero
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import Imperfections, draw_as_built
from tfsat_host.emulated.manual_motion import Leg, Motion, Operator
from tfsat_host.robot import RobotModel, load_robot

MODEL = load_robot()
TRUTH = draw_as_built(3)
HANDS = replace(Operator.human(3), pace=0.8)
"""A person who takes care, and who is quick."""
STEPS = all_steps()
REST, ZERO, TURN = rest(), zero(None), turn("z", 360.0)
SWINGS = tuple(step for joint in (1, 2, 3) for step in swings(joint))
SWEEPS = tuple(step for joint in (1, 2, 3) for step in sweeps(joint))
GYRO, ACCEL = slice(4, 7), slice(0, 3)
COUNTS_PER_DEG_S, COUNTS_PER_TURN = 65.5, 4096

Change = Callable[[Counts], Counts]


class Doing(EmulatedOperator):
    """Who does something else than what the step says."""

    def __init__(
        self, robot: EmulatedRobot, hands: Operator, motion: Callable[[EmulatedRobot], None], last_s: float
    ) -> None:
        super().__init__(robot, hands)
        self._motion, self._bench, self._last_s = motion, robot, last_s

    def begin(self, step: Step) -> None:  # noqa: ARG002 - that is the point
        self._motion(self._bench)

    def duration_s(self, step: Step) -> float:  # noqa: ARG002
        return self._last_s


def record(
    step: Step,
    *,
    truth: Imperfections = TRUTH,
    hands: Operator = HANDS,
    motion: Callable[[EmulatedRobot], None] | None = None,
    last_s: float = 0.0,
    seed: int = 7,
) -> Evidence:
    """Record one step on a robot of its own.

    With `motion`, this is done for `last_s` instead of the step's own motion.
    """
    with EmulatedRobot(MODEL, imperfections=truth, seed=seed) as robot:
        # The boards start and the logger takes its first samples.
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        operator = EmulatedOperator(robot, hands) if motion is None else Doing(robot, hands, motion, last_s)
        evidence = record_step(robot, logger, operator, step)
    # One step a minute in the order of the day: a step is checked against what was recorded before it.
    minutes = STEPS.index(step) if step in STEPS else len(STEPS)
    return replace(evidence, recorded_at=DAY_BEGINS + timedelta(minutes=minutes))


@cache
def record_good_step(step: Step) -> Evidence:
    """Record the step performed well."""
    return record(step)


def day(*left_out: StepKind) -> list[Evidence]:
    """Return all steps performed well, except those of some kinds."""
    return [record_good_step(step) for step in STEPS if step.kind not in left_out]


def before(step: Step) -> list[Evidence]:
    """Return the evidence recorded before a step on a good day."""
    return [record_good_step(earlier_step) for earlier_step in STEPS[: STEPS.index(step)]]


def prepend_rest_zero(*evidence: Evidence) -> list[Evidence]:
    """Bias and zero points, then these."""
    return [record_good_step(REST), record_good_step(ZERO), *evidence]


def change_counts(evidence: Evidence, *changes: Change) -> Evidence:
    """Return the step with its counts changed."""
    counts = evidence.counts
    for change in changes:
        counts = change(counts)
    return replace(evidence, counts=counts)


def accept(evidence: Evidence, earlier: Sequence[Evidence], model: RobotModel = MODEL) -> None:
    """Check and solve a step just recorded, as a campaign does."""
    check_step(evidence, earlier, model)
    # Solving may refuse what the step's own check took: steps that contradict each other.
    solve([*earlier, evidence], model)


def expect_refusal(
    evidence: Evidence, earlier: Sequence[Evidence], model: RobotModel = MODEL
) -> CalibrationError:
    """Return the error with which a campaign refuses a step."""
    with pytest.raises(CalibrationError) as caught:
        accept(evidence, earlier, model)
    error = caught.value
    assert error.meaning
    assert error.next_step.endswith(("again.", "monitor.", "--anew", ".", "bias", "360"))
    return error


def hands_move(
    joint: int, held_bodies: Sequence[int], stops_deg: Sequence[float], leg_s: float, rest_s: float
) -> tuple[Callable[[EmulatedRobot], None], float]:
    """Through these stops from where the joint is, by steady hands; and how long that takes."""
    legs = tuple(Leg(float(np.deg2rad(stop)), leg_s, rest_s) for stop in stops_deg)
    motion = Motion(legs, Operator.steady(), 1)

    def move(robot: EmulatedRobot) -> None:
        robot.hold((4,))
        robot.operator.put_joint(joint)
        robot.hold(tuple(held_bodies))
        robot.operator.move_joint(joint, motion)

    # One second more than the motion, so that it ends at rest.
    return move, motion.duration_s + 1.0


def hands_turn(
    angles_deg: Sequence[float], leg_s: float, rest_s: float, about: Sequence[float] = (0.0, 0.0, 1.0)
) -> tuple[Callable[[EmulatedRobot], None], float]:
    """Return a motion that turns the closed robot through these angles by steady hands, and its duration."""
    legs = tuple(Leg(float(np.deg2rad(angle)), leg_s, rest_s) for angle in angles_deg)
    motion = Motion(legs, Operator.steady(), 1)

    def move(robot: EmulatedRobot) -> None:
        robot.hold((4,))
        for joint in (1, 2, 3):
            robot.operator.put_joint(joint)
        robot.hold((1, 2, 3, 4))
        robot.operator.turn(np.asarray(about, dtype=np.float64), motion)

    return move, motion.duration_s + 1.0


# Faults


def exchange_gyros(first: int, second: int) -> Change:
    """Return a change that exchanges the cables of two bodies' IMUs."""

    def change(counts: Counts) -> Counts:
        order = list(range(4))
        order[first - 1], order[second - 1] = order[second - 1], order[first - 1]
        return replace(
            counts,
            imu_counts=counts.imu_counts[:, order],
            # The flags belong to the cable, too.
            imu_valid=counts.imu_valid[:, order],
            clipped=counts.clipped[:, order],
        )

    return change


def turn_sensor(body: int, rotation: FloatArray) -> Change:
    """Return a change that mounts one IMU with `rotation` (3, 3), from its axes to those it should have."""

    def change(counts: Counts) -> Counts:
        values = counts.imu_counts.copy()
        bias = COUNTS_PER_DEG_S * np.rad2deg(
            TRUTH.gyro_bias_rad_s[body - 1]
        )  # it does not turn with the sensor
        for part, offset in ((ACCEL, np.zeros(3)), (GYRO, bias)):
            # Row vectors: from the axes that it should have to those of the sensor as mounted.
            turned = (values[:, body - 1, part] - offset) @ rotation + offset
            values[:, body - 1, part] = np.rint(turned)
        return replace(counts, imu_counts=values)

    return change


def slip_sensor(body: int, rotvec_deg: Sequence[float]) -> Change:
    """Return a change that rotates one IMU's mounting by an angle that a loose screw allows."""
    return turn_sensor(body, Rotation.from_rotvec(rotvec_deg, degrees=True).as_matrix())


def freeze_gyro(body: int) -> Change:
    """Return a change that freezes a body's gyro at its first value, with its valid flag unchanged."""

    def change(counts: Counts) -> Counts:
        values = counts.imu_counts.copy()
        # The valid flag stays: a register that repeats itself looks sound to the logger.
        values[:, body - 1, GYRO] = values[0, body - 1, GYRO]
        return replace(counts, imu_counts=values)

    return change


def exchange_angles(first: int, second: int) -> Change:
    """Return a change that exchanges the cables of two angle sensors, 1 to 6."""

    def change(counts: Counts) -> Counts:
        order = list(range(6))
        order[first - 1], order[second - 1] = order[second - 1], order[first - 1]
        return replace(
            counts, angle_counts=counts.angle_counts[:, order], angle_valid=counts.angle_valid[:, order]
        )

    return change


def freeze_angle(sensor: int) -> Change:
    """Return a change that freezes one of the six angle sensors at its first value."""

    def change(counts: Counts) -> Counts:
        values = counts.angle_counts.copy()
        values[:, sensor - 1] = values[0, sensor - 1]
        return replace(counts, angle_counts=values)

    return change


def add_angle(sensor: int, added_deg: Callable[[FloatArray], NDArray[Any]] | float) -> Change:
    """Return a change that adds an angle to one of the six sensors, in deg.

    It is a constant, or a function of the elapsed share of the step (n,).
    """

    def change(counts: Counts) -> Counts:
        values = counts.angle_counts.astype(np.int64)
        share = np.linspace(0.0, 1.0, len(values))
        deg = added_deg(share) if callable(added_deg) else np.full(len(values), added_deg)
        values[:, sensor - 1] += np.rint(deg / 360.0 * COUNTS_PER_TURN).astype(np.int64)
        # A turn has 4096 counts: the reading wraps.
        return replace(counts, angle_counts=np.mod(values, COUNTS_PER_TURN).astype(np.uint16))

    return change


def add_rate(body: int, added_deg_s: Callable[[FloatArray], FloatArray]) -> Change:
    """Return a change that adds a rate (n, 3) in deg/s to one gyro, as a function of the time (n,) in s."""

    def change(counts: Counts) -> Counts:
        values = counts.imu_counts.copy()
        t_s = (counts.t_us - counts.t_us[0]) * 1e-6
        values[:, body - 1, GYRO] += np.rint(COUNTS_PER_DEG_S * added_deg_s(t_s)).astype(np.int16)
        return replace(counts, imu_counts=values)

    return change


def silence_angle(sensor: int, share: float) -> Change:
    """Return a change by which one of the six angle sensors gives no value in a share of the samples."""

    def change(counts: Counts) -> Counts:
        valid = counts.angle_valid.copy()
        valid[: max(1, round(share * len(valid))), sensor - 1] = False
        return replace(counts, angle_valid=valid)

    return change


def later(evidence: Evidence, minutes: float) -> Evidence:
    return replace(evidence, recorded_at=evidence.recorded_at + timedelta(minutes=minutes))


def true_rotation(body: int) -> FloatArray:
    """(3, 3) from sensor to body axes."""
    return np.asarray(TRUTH.mounting[body - 1] @ MODEL.imus[body - 1].sensor_to_body)


def true_scale(body: int, axis: int) -> float:
    """Compute the reading over truth of a rotation about a body axis (0 to 2)."""
    along = true_rotation(body)[axis]
    return float(along @ TRUTH.gyro_response[body - 1] @ along)


def true_skew(body: int) -> FloatArray:
    """(3,) of y and z, z and x, x and y."""
    return skews_of(TRUTH.gyro_cross_axis[body - 1])
