"""The misalignment calibration against the emulated robot's hidden truth, and what it refuses."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import pytest

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.bias import estimate_biases
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.findings import axis_rows
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence, Origin
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.steps.step import PATTERNS, Step, StepKind, rest, swings, zero
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.bench import EmulatedOperator
from tfsat_host.emulated.robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.protocol.messages import LiveSampleStream

ORIGIN = Origin("", "", True, "", "")


class Bench:
    """One emulated robot on a bench, its logger connected."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self.robot = robot
        self.logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        self.operator = EmulatedOperator(robot)

    def record(self, duration_s: float) -> SensorSamples:
        return SensorSamples.from_counts(self.counts(duration_s))

    def counts(self, duration_s: float) -> Counts:
        samples: list[LiveSampleStream] = []
        with self.logger.live() as scales:
            while not samples or samples[-1].time_us - samples[0].time_us < duration_s * 1e6:
                samples += self.logger.live_samples()
        return Counts.from_live(samples, scales)

    def evidence(self, step: Step, duration_s: float) -> Evidence:
        """A step as it should be done."""
        self.operator.begin(step)
        return Evidence(step, self.counts(duration_s), datetime.now(UTC), ORIGIN)

    def true_axis(self, joint: int, body: int) -> FloatArray:
        """The joint's axis in the sensor frame of the gyro on `body`, from the hidden mounting."""
        model = self.robot.model
        mounted = self.robot.imperfections.mounting[body - 1] @ model.imus[body - 1].sensor_to_body
        axis: FloatArray = mounted.T @ model.joint_axis[joint - 1]
        return axis


@pytest.fixture
def bench() -> Bench:
    robot = EmulatedRobot(seed=5)
    robot.advance(SETTLE_US)
    return Bench(robot)


def test_patterns_are_the_papers_table() -> None:
    assert [(joint, moved) for joint, moved, _ in PATTERNS] == [
        (1, (1,)),
        (1, (2, 3)),
        (2, (1, 2)),
        (2, (3, 4)),
        (3, (4,)),
    ]
    covered = {(body, joint % 2) for joint, moved, _ in PATTERNS for body in moved}
    assert covered == {(body, axis) for body in (1, 2, 3, 4) for axis in (0, 1)}  # two axes for each gyro


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("joint", [1, 2, 3])
def test_axis_and_bias_of_every_moved_gyro(seed: int, joint: int) -> None:
    robot = EmulatedRobot(seed=seed)
    robot.advance(SETTLE_US)
    bench = Bench(robot)
    known = [bench.evidence(rest(), 5.0), bench.evidence(zero(None), 2.0)]
    swung = [bench.evidence(step, 10.0) for step in swings(joint)]
    solution = solve([*known, *swung], robot.model)
    found = np.array([gyro.bias_rad_s for gyro in solution.gyros])
    assert np.rad2deg(np.abs(found - robot.imperfections.gyro_bias_rad_s)).max() < 0.02
    for one in swung:
        rows = axis_rows(solution.gyros, one, robot.model)
        assert [row["body"] for row in rows] == list(one.step.moved)
        for row in rows:
            axis, std_deg = row["axis_sensor"], row["std_deg"]
            true = bench.true_axis(joint, row["body"])
            assert axis @ true > 0, "the sign is the joint's opening direction"
            assert np.rad2deg(np.linalg.norm(np.cross(axis, true))) < 4.0 * std_deg < 1.2
            true_angle = np.rad2deg(np.arccos(true @ row["nominal_sensor"]))
            assert row["angle_deg"] == pytest.approx(true_angle, abs=4.0 * std_deg)
            assert row["rms_rate_deg_s"] > 20.0


def test_a_robot_that_moves_has_no_bias(bench: Bench) -> None:
    bench.operator.swing(Step(StepKind.SWING, 1, (1,), (2, 3, 4)))
    with pytest.raises(CalibrationError, match="Body 1 was not still"):
        estimate_biases(bench.record(3.0))


def test_stated_intervals_hold_the_truth_of_emulated_robots() -> None:
    inside, off_deg_s = [], []
    for seed in range(1, 9):
        robot = EmulatedRobot(seed=seed)
        robot.advance(SETTLE_US)
        bench = Bench(robot)
        bench.operator.rest()
        for estimate in estimate_biases(bench.record(3.0)):
            off = estimate.bias_rad_s - robot.imperfections.gyro_bias_rad_s[estimate.body - 1]
            inside += list(np.abs(off) < 1.96 * np.sqrt(np.diag(estimate.covariance)))
            off_deg_s += list(np.degrees(off))
            assert estimate.temperature_c == pytest.approx(25.0, abs=0.5)
        robot.close()
    assert np.sqrt(np.mean(np.square(off_deg_s))) < 0.02
    assert 0.88 <= np.mean(inside) <= 0.99  # of 96
