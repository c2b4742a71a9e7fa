"""Which bias and which zero points hold for a recorded motion: those that were the newest when it was recorded.

A sensor that is fastened anew, or that warms up, does not change what an earlier recording says.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import datetime
from typing import TypeVar

from tfsat_host.calibration.gyros.bias import BiasEstimate, estimate_biases
from tfsat_host.calibration.joints.zero import ZeroEstimate, estimate_zero, with_zero
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensors_by_design
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.robot import RobotModel

Estimate = TypeVar("Estimate")


class InForce:
    """The rests and zeros of some evidence.

    Args:
        evidence: In any order.
        model: For the sensors' places in the log.

    Raises:
        CalibrationError: one of them is not what it should be.
    """

    def __init__(self, evidence: Iterable[Evidence], model: RobotModel) -> None:
        in_time = sorted(evidence, key=lambda one: one.taken)
        self._rests = [
            (one, estimate_biases(Recording.from_counts(one.counts)))
            for one in in_time
            if one.step.kind == StepKind.REST
        ]
        self._zeros = [
            [(one, _zero_of(one, joint, model)) for one in in_time if _is_zero_of(one, joint)]
            for joint in range(1, model.n_joints + 1)
        ]

    def gyros(self, gyros: Sequence[GyroCalibration], at: datetime | None = None) -> list[GyroCalibration]:
        """The gyros with the biases of that time; with the newest without one."""
        rest = _at(self._rests, at)
        if rest is None:
            return list(gyros)
        one, biases = rest
        return [_with_bias(gyro, bias, one.taken) for gyro, bias in zip(gyros, biases, strict=True)]

    def joints(self, joints: Sequence[JointSensors], at: datetime | None = None) -> list[JointSensors]:
        """The angle sensors with the zero points of that time; with the newest without one."""
        held = []
        for sensors, zeros in zip(joints, self._zeros, strict=True):
            zero = _at(zeros, at)
            held.append(sensors if zero is None else with_zero(sensors, zero[1], zero[0].taken))
        return held

    def used(self, at: Iterable[datetime]) -> list[Evidence]:
        """What the newest values, and those of these times, rest on; in order of time."""
        found: dict[datetime, Evidence] = {}
        for when in (None, *at):
            for one in (_at(self._rests, when), *(_at(zeros, when) for zeros in self._zeros)):
                if one is not None:
                    found[one[0].taken] = one[0]
        return [found[taken] for taken in sorted(found)]


def _at(
    of_time: Sequence[tuple[Evidence, Estimate]], at: datetime | None
) -> tuple[Evidence, Estimate] | None:
    """The last one before, the first one where there is none."""
    before = [one for one in of_time if at is None or one[0].taken <= at]
    return before[-1] if before else of_time[0] if of_time else None


def _is_zero_of(one: Evidence, joint: int) -> bool:
    return one.step.kind == StepKind.ZERO and one.step.joint in (None, joint)


def _zero_of(one: Evidence, joint: int, model: RobotModel) -> ZeroEstimate:
    return estimate_zero(
        Recording.from_counts(one.counts), one.counts.angle_valid, sensors_by_design(model, joint), model
    )


def _with_bias(gyro: GyroCalibration, bias: BiasEstimate, taken: datetime) -> GyroCalibration:
    covariance = gyro.covariance.copy()
    covariance[:3, :3] = bias.covariance
    return replace(
        gyro,
        bias_rad_s=bias.bias_rad_s,
        covariance=covariance,
        noise_rad_s=bias.noise_rad_s,
        temperature_c=bias.temperature_c,
        bias_taken=taken,
    )
