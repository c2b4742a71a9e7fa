"""Certificates for the tests: any, drawn from a seed, or a whole one that holds for the next drop."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration, Landing, Recording, Subject
from tfsat_host.calibration.sensors.gyro import SHARED, GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.servos.dynamics_fit import MeasuredDynamics
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.robot import load_robot

MEASURED = datetime(2026, 7, 1, 9, 30, tzinfo=UTC)
SERIAL = b"12345678".hex()
WHO_AM_I = "68686868"
SUBJECT = Subject("Drop-tower robot", SERIAL, WHO_AM_I, emulated=False)


def spread(rng: np.random.Generator, size: int, scale: float) -> FloatArray:
    """(size, size) of a covariance of correlated errors."""
    # Any square root gives a valid covariance: root times its transpose is positive.
    root = scale * rng.normal(size=(size, size))
    return np.asarray(root @ root.T)


def drawn_calibration(seed: int) -> Calibration:
    """Whatever can be: some things measured, others not."""
    rng = np.random.default_rng(seed)

    def when() -> datetime:
        return MEASURED + timedelta(microseconds=int(rng.integers(10**12)))

    def some_axes() -> dict[str, datetime]:
        return {axis: when() for axis in "xyz" if rng.random() < 0.5}

    def perhaps() -> datetime | None:
        return when() if rng.random() < 0.5 else None

    gyros = []
    for body in range(1, 5):
        # Some bodies never rested: their noise and temperature are NaN.
        rested = rng.random() < 0.5
        gyros.append(
            GyroCalibration(
                body,
                rng.normal(size=3),
                Rotation.random(rng=rng).as_matrix(),
                rng.uniform(0.9, 1.1, 3),
                rng.uniform(-0.02, 0.02, 3),
                spread(rng, 12, 10.0 ** rng.uniform(-6, 0)),
                rng.uniform(0.0, 0.01, 3) if rested else np.full(3, np.nan),
                float(rng.normal()) if rested else float("nan"),
                some_axes(),
                some_axes(),
                perhaps(),
                # Biases have nothing in common: their rows are not in the file.
                np.vstack([np.zeros((3, SHARED)), 0.001 * rng.normal(size=(9, SHARED))])
                if rng.random() < 0.5
                else np.zeros((12, SHARED)),
            )
        )
    joints = [
        JointSensors(
            joint,
            rng.choice([-1.0, 1.0], 2),
            rng.uniform(0.0, 2 * np.pi, 2),
            spread(rng, 2, 0.01),
            0.001 * rng.normal(size=(2, 4)),
            spread(rng, 8, 0.001),
            rng.uniform(0.0, 0.01, 2) if rng.random() < 0.5 else np.full(2, np.nan),
            perhaps(),
            perhaps(),
        )
        for joint in (1, 2, 3)
    ]
    measured = [joint for joint in (1, 2, 3) if rng.random() < 0.5]
    return Calibration(
        # Quotes, a Greek letter and a backslash: all must survive TOML.
        Subject('robot "1" µ\\', f"{rng.integers(2**32):08x}", WHO_AM_I, bool(rng.random() < 0.5)),
        tuple(gyros),
        tuple(joints),
        tuple(servo_map(rng, joint, when()) for joint in measured),
        tuple(Recording(f"step-{n}", when(), f"step-{n}.npz", f"{n:064x}") for n in range(rng.integers(4))),
        tuple(
            sorted(
                (Landing(when(), f"recording {n}") for n in range(rng.integers(3))),
                key=lambda landing: landing.at,
            )
        ),
        when(),
        logger_image=f"{rng.integers(2**32):08x}" if rng.random() < 0.5 else None,
        servo_dynamics=tuple(
            servo_dynamics(rng, joint, way, when()) for joint in measured for way in (1, -1)
        ),
    )


def servo_dynamics(rng: np.random.Generator, joint: int, direction: int, when: datetime) -> MeasuredDynamics:
    """Draw how fast a servo moves its joint one way."""
    return MeasuredDynamics(
        max_rate_rad_s=rng.uniform(2.0, 4.0),
        acceleration_rad_s2=rng.uniform(20.0, 100.0),
        delay_s=rng.uniform(0.0, 0.02),
        covariance=spread(rng, 3, 1e-3),
        joint=joint,
        direction=direction,
        strokes=int(rng.integers(1, 9)),
        residual_rad=rng.uniform(0.0, 0.01),
        recorded_at=when,
    )


def servo_map(rng: np.random.Generator, joint: int, measured_at: datetime) -> ServoMap:
    """Draw the map of a servo that opens its joint with longer or with shorter pulses."""
    return ServoMap(
        joint,
        rng.uniform(1000.0, 2000.0),
        rng.uniform(0.0, 1.5),
        rng.choice([-1, 1]) * rng.uniform(0.001, 0.002),
        rng.uniform(0.0, 0.02),
        spread(rng, 3, 1e-4),
        rng.uniform(0.0, 0.01),
        int(rng.integers(1, 30)),
        rng.uniform(0.0, 0.01),
        int(rng.integers(3, 9)),
        (float(rng.uniform(900, 1000)), float(rng.uniform(1900, 2000))),
        ServoSetting(1000, 11111, int(rng.integers(2)), 0, 9000),
        measured_at,
    )


def whole_calibration(measured_at: datetime = MEASURED, subject: Subject = SUBJECT) -> Calibration:
    """Everything measured at `measured_at`, on the sensors of tests/sdlog; no landing is known."""
    rng = np.random.default_rng(7)
    random_calibration = drawn_calibration(3)
    mounted = [imu.sensor_to_body for imu in load_robot().imus]
    # Bias, misalignment, scale and skew, three each.
    deviations = np.repeat(np.radians([0.005, 0.02, 0.05, 0.05]), 3)
    return replace(
        random_calibration,
        subject=subject,
        gyros=tuple(
            replace(
                gyro,
                # 1.5 deg off its design, as a screw lets it be.
                rotation=nominal @ Rotation.from_rotvec(np.radians([0.0, 0.0, 1.5])).as_matrix(),
                covariance=np.diag(deviations**2),
                noise_rad_s=np.full(3, 0.001),
                temperature_c=25.0,
                axes=dict.fromkeys("xy", measured_at),
                scaled=dict.fromkeys("xyz", measured_at),
                bias_recorded_at=measured_at,
            )
            for gyro, nominal in zip(random_calibration.gyros, mounted, strict=True)
        ),
        joints=tuple(
            replace(joint, zero_recorded_at=measured_at, bend_recorded_at=measured_at)
            for joint in random_calibration.joints
        ),
        servo_maps=tuple(servo_map(rng, joint, measured_at) for joint in (1, 2, 3)),
        recordings=(),
        landings=(),
        written=measured_at,
    )
