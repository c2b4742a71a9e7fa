"""The biases and zero points that were in force when a motion was recorded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from datetime import datetime
from functools import partial
from typing import TypeVar

from tfsat_host.calibration.bias import BiasEstimate, estimate_biases, with_bias
from tfsat_host.calibration.replacements import NEVER_REPLACED, Specimens
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensors_by_design
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.calibration.zero import ZeroEstimate, estimate_zero, with_zero
from tfsat_host.protocol.limits import IMU_COUNT
from tfsat_host.robot import RobotModel

Estimate = TypeVar("Estimate")


class Baseline:
    """The biases and zero points of some evidence: for a motion count those that were the newest when it was recorded.

    A sensor that is fastened at another angle, warms up or is replaced does not change what an earlier recording says.

    Args:
        evidence: In any order.
        model: For the sensors' places in the log.
        specimens: Which specimen of each sensor was in place when.

    Raises:
        CalibrationError: one of the rests or zeros is not what it should be.
    """

    def __init__(
        self, evidence: Iterable[Evidence], model: RobotModel, specimens: Specimens = NEVER_REPLACED
    ) -> None:
        self._specimens = specimens
        by_time = sorted(evidence, key=lambda entry: entry.recorded_at)
        self._rests = [
            # An IMU that the robot did not have then has biases of other days.
            (entry, {bias.body: bias for bias in estimate_biases(entry.recording, entry.bodies_sensed)})
            for entry in by_time
            if entry.step.kind == StepKind.REST
        ]
        zeros = [entry for entry in by_time if entry.step.kind == StepKind.ZERO]
        # A zero of all joints counts for each of them; every joint keeps its own history.
        self._zeros = [
            [
                (entry, estimate_zero(entry.recording, entry.counts.angle_valid, sensors, model))
                for entry in zeros
                if entry.step.joint in (None, sensors.joint) and not sensors.absent
            ]
            for sensors in (sensors_by_design(model, joint) for joint in range(1, model.n_joints + 1))
        ]

    def gyros(
        self, gyros: Sequence[GyroCalibration], at: datetime | None = None
    ) -> tuple[GyroCalibration, ...]:
        """Return the gyros with the biases in force at `at`; the newest ones if it is None."""
        rests = [self._rest(gyro.body, at) for gyro in gyros]
        return tuple(
            gyro if rest is None or gyro.absent else with_bias(gyro, rest[1][gyro.body], rest[0].recorded_at)
            for gyro, rest in zip(gyros, rests, strict=True)
        )

    def joints(self, joints: Sequence[JointSensors], at: datetime | None = None) -> tuple[JointSensors, ...]:
        """Return the angle sensors with the zero points in force at `at`; the newest ones if it is None."""
        zeros = [self._zero(sensors.joint, at) for sensors in joints]
        return tuple(
            sensors if zero is None else with_zero(sensors, zero[1], zero[0].recorded_at)
            for sensors, zero in zip(joints, zeros, strict=True)
        )

    def evidence_in_force(self, at: Iterable[datetime]) -> list[Evidence]:
        """Return the evidence behind the newest values and those in force at these times."""
        evidence = [
            pair[0]
            for when in (None, *at)
            for pair in (
                *(self._rest(body, when) for body in range(1, IMU_COUNT + 1)),
                *(self._zero(joint, when) for joint in range(1, len(self._zeros) + 1)),
            )
            if pair is not None
        ]
        # One rest may serve several motions: name it once.
        return list({entry.recorded_at: entry for entry in evidence}.values())

    def _rest(self, body: int, at: datetime | None) -> tuple[Evidence, dict[int, BiasEstimate]] | None:
        rests = [rest for rest in self._rests if body in rest[1]]
        return _at(rests, at, partial(self._specimens.gyro, body))

    def _zero(self, joint: int, at: datetime | None) -> tuple[Evidence, ZeroEstimate] | None:
        return _at(self._zeros[joint - 1], at, partial(self._specimens.zero, joint))


def _at(
    by_time: Sequence[tuple[Evidence, Estimate]],
    at: datetime | None,
    specimen: Callable[..., int],
) -> tuple[Evidence, Estimate] | None:
    """Find the last estimate not after `at`, or the first if there is none; the newest if `at` is None.

    Only those count that are of the specimen that was in place then.
    """
    of_it = [pair for pair in by_time if specimen(at=pair[0].recorded_at) == specimen(at=at)]
    before = [pair for pair in of_it if at is None or pair[0].recorded_at <= at]
    return before[-1] if before else of_it[0] if of_it else None
