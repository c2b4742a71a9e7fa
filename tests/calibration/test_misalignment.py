"""The misalignment calibration against the emulated robot's hidden truth, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tfsat_host.calibration.bias import estimate_biases
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.misalignment import estimate_axes
from tfsat_host.calibration.patterns import PATTERNS, MotionPattern, patterns_of_joint
from tfsat_host.calibration.recording import Recording
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.bench import EmulatedOperator
from tfsat_host.emulated.robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.protocol.messages import LiveSampleStream

FloatArray = NDArray[np.float64]


class Bench:
    """One emulated robot on a bench, its logger connected."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self.robot = robot
        self.logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        self.operator = EmulatedOperator(robot)

    def record(self, duration_s: float) -> Recording:
        samples: list[LiveSampleStream] = []
        with self.logger.live() as scales:
            while not samples or samples[-1].time_us - samples[0].time_us < duration_s * 1e6:
                samples += self.logger.live_samples()
        return Recording.from_live(samples, scales)

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
    assert [(pattern.joint, pattern.moved) for pattern in PATTERNS] == [
        (1, (1,)),
        (1, (2, 3)),
        (2, (1, 2)),
        (2, (3, 4)),
        (3, (4,)),
    ]
    covered = {(body, pattern.joint % 2) for pattern in PATTERNS for body in pattern.moved}
    assert covered == {(body, axis) for body in (1, 2, 3, 4) for axis in (0, 1)}  # two axes for each gyro


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("joint", [1, 2, 3])
def test_axis_and_bias_of_every_moved_gyro(seed: int, joint: int) -> None:
    robot = EmulatedRobot(seed=seed)
    robot.advance(SETTLE_US)
    bench = Bench(robot)
    bench.operator.rest()
    bias = estimate_biases(bench.record(3.0))
    found = np.array([one.bias_rad_s for one in bias])
    assert np.rad2deg(np.abs(found - robot.imperfections.gyro_bias_rad_s)).max() < 0.02
    for pattern in patterns_of_joint(joint):
        bench.operator.swing(pattern)
        for axis in estimate_axes(pattern, bench.record(10.0), bias, robot.model):
            true = bench.true_axis(joint, axis.body)
            error_deg = np.rad2deg(np.linalg.norm(np.cross(axis.axis, true)))
            assert axis.axis @ true > 0, "the sign is the joint's opening direction"
            assert error_deg < 0.02
            true_angle = np.rad2deg(np.arccos(true @ axis.nominal))
            assert axis.angle_deg == pytest.approx(true_angle, abs=0.02)
            assert axis.std_deg < 0.01


def test_a_robot_that_moves_has_no_bias(bench: Bench) -> None:
    bench.operator.swing(MotionPattern(1, moved=(1,), held=(2, 3, 4)))
    with pytest.raises(CalibrationError, match="Body 1 was not still"):
        estimate_biases(bench.record(3.0))


def test_too_little_motion_is_refused(bench: Bench) -> None:
    pattern = PATTERNS[0]
    bench.operator.rest()
    bias = estimate_biases(bench.record(1.0))
    bench.robot.hold(pattern.held)
    bench.robot.swing(1, 1.0, 4.0, 3)
    with pytest.raises(CalibrationError, match="at least 5 are needed"):
        estimate_axes(pattern, bench.record(8.0), bias, bench.robot.model)


def test_a_held_body_that_moves_is_refused(bench: Bench) -> None:
    bench.operator.rest()
    bias = estimate_biases(bench.record(1.0))
    bench.operator.swing(PATTERNS[1])  # bodies 2 and 3 move
    with pytest.raises(CalibrationError, match="Body 2 was to be held"):
        # The operator was asked to hold them and to move body 1, which here stands still.
        estimate_axes(
            MotionPattern(1, moved=(3,), held=(1, 2, 4)), bench.record(8.0), bias, bench.robot.model
        )


def still_recording(samples_lost: int = 0) -> Recording:
    return Recording(
        t_s=np.arange(100) / 280.0,
        rate_rad_s=np.zeros((100, 4, 3)),
        accel_m_s2=np.broadcast_to([0.0, 0.0, 9.80665], (100, 4, 3)).copy(),
        temperature_c=np.full((100, 4), 25.0),
        sensor_angle_rad=np.zeros((100, 6)),
        imu_valid=np.ones((100, 4), dtype=bool),
        samples_lost=samples_lost,
    )


def test_samples_that_never_arrived_are_refused_above_one_percent() -> None:
    assert not any(one.bias_rad_s.any() for one in estimate_biases(still_recording(samples_lost=1)))
    with pytest.raises(CalibrationError, match="2 of 102 samples never reached"):
        estimate_biases(still_recording(samples_lost=2))


def test_a_logger_that_restarts_is_refused() -> None:
    recording = still_recording()
    recording.t_s[50:] -= recording.t_s[50]
    with pytest.raises(CalibrationError, match="the logger restarted"):
        estimate_biases(recording)


def test_invalid_samples_are_refused() -> None:
    recording = still_recording()
    recording.imu_valid[4, 1] = False
    with pytest.raises(CalibrationError, match="1 of 100 samples of the gyro on body 2"):
        estimate_biases(recording)
