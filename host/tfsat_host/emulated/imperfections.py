"""What is not ideal about one emulated robot: drawn from a seed, so that calibration has work to do."""

from __future__ import annotations

from dataclasses import dataclass, field
from hashlib import sha256

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.sensors.gyro import response_matrix
from tfsat_host.units import STANDARD_GRAVITY_M_S2

_GYRO_NOISE_DEG_S_RTHZ = 0.005  # PS-MPU-6000A rev. 3.4, section 6.1
_ACCEL_NOISE_G_RTHZ = 400e-6  # PS-MPU-6000A rev. 3.4, section 6.2
GYRO_WANDER_S = 100.0
"""Correlation time of a gyro's wandering bias; assumed."""
MAX_DELAY_S = 0.01
"""kMostLate_s of low_pass.h."""
_CRYSTAL_STD_PPM = 20.0
_CRYSTAL_MOST_PPM = 50.0


@dataclass(frozen=True, eq=False)
class Imperfections:
    """The hidden truth of one robot's sensors, servos and clocks; by default all is exact.

    Attributes:
        mounting: (4, 3, 3) rotation of each IMU from where the design puts it, in body axes.
        gyro_bias_rad_s: (4, 3) in sensor axes.
        gyro_scale: (4, 3) reading over truth.
        gyro_noise_rad_s_rthz: White noise density.
        accel_noise_m_s2_rthz: White noise density.
        angle_zero_rad: (6,) added to the design's zero offsets.
        angle_nonlinearity_rad: (6, 4) a1, b1, a2, b2: with phi = zero + direction * joint angle a sensor shows
            phi + a1 sin phi + b1 cos phi + a2 sin 2 phi + b2 cos 2 phi, as for a magnet off its centre.
        angle_noise_rad: Standard deviation of a reading.
        servo_gain: (3,) the joint's angle for a pulse is offset + gain * (the pulse's angle by the robot file).
        servo_offset_rad: (3,) see there.
        servo_backlash_rad: (3,) a motion ends half of it short of its target, on the side where it came from; the
            joint follows a turn back only when the play is used up.
        servo_repeat_rad: (3,) standard deviation of where a motion ends, drawn again when the command changes
            after 0.3 s of standing, when it turns back, and after the servo was limp. It takes effect over
            the first 5 deg of the way, so that small steps of a jog have no jumps.
        servo_overshoot_rad: (3,) a motion that gets to the servo's full rate runs so far beyond where it ends, others
            as the square of the rate they get to; its farthest comes when the braking is over, and after as long
            again the joint is back. A mechanical stop ends it. The joint stands, play and all, where it would without.
        servo_delay_s: (3,) from the end of a pulse to the first motion of a joint at rest.
        servo_closing_share: (3,) of the servo's greatest rate that it reaches towards smaller angles.
        sequencer_clock_ppm: By how much the sequencer's time runs faster than true time, up to 20,000 either way.
            Its strokes come earlier and its servo pulses are shorter by that.
        logger_clock_ppm: The same of the logger: its samples, and the times that it notes.
        gyro_g_sensitivity_rad_s_g: (4, 3, 3) rate that a specific force of 1 g makes a gyro show, all in sensor axes.
        gyro_bias_slope_rad_s_c: (4, 3) by how much the bias changes with each deg C that the die gets warmer.
        warming_c: By how much the dies get warmer in the end than at power-up: warming_c (1 - exp(-t / warming_s)).
        warming_s: See there.
        gyro_wander_rad_s: Standard deviation of what each bias has on top, which changes over GYRO_WANDER_S
            (a first-order Gauss-Markov process): the in-run bias stability.
        gyro_shock_limit_g: A blow harder than this drives the gyros' proof masses against their stops: all axes show
            the ends of their ranges as long as it lasts. At 0 none does.
        gyro_bend_s: (4, 3) what each scale factor gains with the magnitude of the rate about its axis, per rad/s.
        gyro_cross_axis: (4, 3, 3) share of the rate about an axis (column) that another one (row) shows on top.
        gyro_front_end_limit_rad_s: (4,) what a gyro's front end shows at most, before the low-pass, so that no count
            is at its end; 0: no such limit.
        imu_late_s: (4,) all that an IMU shows comes so much later, at most `MAX_DELAY_S`.
        imu_clock_ppm: (4,) by how much an IMU's own oscillator runs fast, and with it conversions and filters; the
            logger reads the last output that it finished.
        mount_ripple_s: What each IMU stands on rings at 30 Hz: rate (rad/s) about an axis after its body's angular
            acceleration changed by 1 rad/s^2 at once.
        imu_who_am_i: Which part each IMU is, by its register 0x75: an MPU-6050, or one of `IMU_PARTS`.
        logger_serial: 8 bytes that the logger gives as its serial number: robots of other errors are other robots.
    """

    mounting: FloatArray = field(default_factory=lambda: np.tile(np.eye(3), (4, 1, 1)))
    gyro_bias_rad_s: FloatArray = field(default_factory=lambda: np.zeros((4, 3)))
    gyro_scale: FloatArray = field(default_factory=lambda: np.ones((4, 3)))
    gyro_noise_rad_s_rthz: float = 0.0
    accel_noise_m_s2_rthz: float = 0.0
    angle_zero_rad: FloatArray = field(default_factory=lambda: np.zeros(6))
    angle_nonlinearity_rad: FloatArray = field(default_factory=lambda: np.zeros((6, 4)))
    angle_noise_rad: float = 0.0
    servo_gain: FloatArray = field(default_factory=lambda: np.ones(3))
    servo_offset_rad: FloatArray = field(default_factory=lambda: np.zeros(3))
    servo_backlash_rad: FloatArray = field(default_factory=lambda: np.zeros(3))
    servo_repeat_rad: FloatArray = field(default_factory=lambda: np.zeros(3))
    servo_overshoot_rad: FloatArray = field(default_factory=lambda: np.zeros(3))
    servo_delay_s: FloatArray = field(default_factory=lambda: np.zeros(3))
    servo_closing_share: FloatArray = field(default_factory=lambda: np.ones(3))
    sequencer_clock_ppm: float = 0.0
    logger_clock_ppm: float = 0.0
    gyro_g_sensitivity_rad_s_g: FloatArray = field(default_factory=lambda: np.zeros((4, 3, 3)))
    gyro_bias_slope_rad_s_c: FloatArray = field(default_factory=lambda: np.zeros((4, 3)))
    warming_c: float = 0.0
    warming_s: float = 180.0
    gyro_wander_rad_s: float = 0.0
    gyro_shock_limit_g: float = 0.0
    gyro_bend_s: FloatArray = field(default_factory=lambda: np.zeros((4, 3)))
    gyro_cross_axis: FloatArray = field(default_factory=lambda: np.zeros((4, 3, 3)))
    gyro_front_end_limit_rad_s: FloatArray = field(default_factory=lambda: np.zeros(4))
    imu_late_s: FloatArray = field(default_factory=lambda: np.zeros(4))
    imu_clock_ppm: FloatArray = field(default_factory=lambda: np.zeros(4))
    mount_ripple_s: float = 0.0
    imu_who_am_i: bytes = b"\x68\x68\x68\x68"
    logger_serial: bytes = b"emuLATED"

    @property
    def gyro_response(self) -> FloatArray:
        """(4, 3, 3) reading of a rate, sensor axes."""
        return np.eye(3) * self.gyro_scale[:, None] + self.gyro_cross_axis


def ideal() -> Imperfections:
    """Sensors without any error but their resolution, exact servos and exact clocks."""
    return Imperfections()


def draw(seed: int) -> Imperfections:
    """Draw a plausible robot with gyro biases and mounting errors but exact scale factors.

    Standard deviations are 1 deg/s for the biases and 1.5 deg per axis for the mounting. The scale factors are
    exact because the paper does not calibrate them, and its evaluation starts from that.
    """
    random = np.random.default_rng(seed)
    return Imperfections(
        mounting=_rotations(np.deg2rad(1.5) * random.standard_normal((4, 3))),
        gyro_bias_rad_s=np.deg2rad(1.0) * random.standard_normal((4, 3)),
        gyro_noise_rad_s_rthz=np.deg2rad(_GYRO_NOISE_DEG_S_RTHZ),
        accel_noise_m_s2_rthz=_ACCEL_NOISE_G_RTHZ * STANDARD_GRAVITY_M_S2,
        angle_zero_rad=np.deg2rad(5.0) * random.standard_normal(6),
        angle_noise_rad=np.deg2rad(0.05),
    )


def draw_as_built(seed: int) -> Imperfections:
    """Draw a robot before its calibration: every parameter that calibration estimates is off.

    The gyros' biases lie within a quarter of the data sheet's tolerance, their scale factors and skews within all
    of it (PS-MPU-6000A rev. 3.4, section 6.1: 20 deg/s, 3 %, 2 %); the angle sensors sit on their axes at any
    angle; the boards have crystals, not ceramic resonators.
    """
    random = np.random.default_rng(seed)
    towards = random.standard_normal((4, 3))
    # Normalized Gaussians point in all directions alike; the angle about them is drawn apart.
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    return Imperfections(
        mounting=_rotations(np.deg2rad(random.uniform(0.0, 5.0, (4, 1))) * towards),
        gyro_bias_rad_s=np.deg2rad(random.uniform(-5.0, 5.0, (4, 3))),
        gyro_scale=random.uniform(0.97, 1.03, (4, 3)),
        gyro_noise_rad_s_rthz=np.deg2rad(_GYRO_NOISE_DEG_S_RTHZ),
        accel_noise_m_s2_rthz=_ACCEL_NOISE_G_RTHZ * STANDARD_GRAVITY_M_S2,
        angle_zero_rad=random.uniform(0.0, 2 * np.pi, 6),
        angle_nonlinearity_rad=np.deg2rad(0.05) * random.standard_normal((6, 4)),
        angle_noise_rad=np.deg2rad(0.05),
        servo_gain=0.95 + 0.02 * random.standard_normal(3),
        servo_offset_rad=np.deg2rad(1.0) * random.standard_normal(3),
        servo_backlash_rad=np.deg2rad(random.uniform(0.0, 1.0, 3)),
        servo_repeat_rad=np.deg2rad(random.uniform(0.1, 0.3, 3)),
        sequencer_clock_ppm=_crystal_ppm(random),
        logger_clock_ppm=_crystal_ppm(random),
        gyro_cross_axis=skewed(_skews(random)),
        logger_serial=_serial_as_built(seed),
    )


def skewed(skews: FloatArray) -> FloatArray:
    """(n, 3, 3) symmetric cross-axis sensitivities of skews (n, 3): of y and z, z and x, x and y.

    What is not symmetric in a chip's cross-axis sensitivity is a rotation of its axes, and a part of the mounting.
    """
    return np.array([response_matrix(np.zeros(3), skew) for skew in skews])


def _skews(random: np.random.Generator) -> FloatArray:
    """(4, 3) half the sum of what two axes show of each other; drawn after everything else, as `_crystal_ppm`."""
    return np.asarray(random.uniform(-0.02, 0.02, (2, 4, 3)).mean(axis=0))


def _rotations(vectors_rad: FloatArray) -> FloatArray:
    """(n, 3, 3) of (n, 3) rotation vectors, none of which is zero.

    As scipy's `Rotation` to the last bit, whose import takes twice as long as `status --emulated` otherwise.
    """
    angle = np.sqrt((vectors_rad**2).sum(axis=1))
    # (4, n) unit quaternions, and with (4, 4, n) the products of their components.
    xyzw = np.vstack([np.sin(angle / 2) / angle * vectors_rad.T, np.cos(angle / 2)])
    (xx, xy, xz, xw), (_, yy, yz, yw), (*_, zz, zw), (*_, ww) = xyzw[:, None] * xyzw
    rows = (
        (xx - yy - zz + ww, 2 * (xy - zw), 2 * (xz + yw)),
        (2 * (xy + zw), -xx + yy - zz + ww, 2 * (yz - xw)),
        (2 * (xz - yw), 2 * (yz + xw), -xx - yy + zz + ww),
    )
    # (3, 3, n) to (n, 3, 3).
    return np.moveaxis(np.array(rows), 2, 0)


def _crystal_ppm(random: np.random.Generator) -> float:
    """Drawn after everything else, so that a seed's other errors are those it always had."""
    return float(np.clip(_CRYSTAL_STD_PPM * random.standard_normal(), -_CRYSTAL_MOST_PPM, _CRYSTAL_MOST_PPM))


def _serial_as_built(seed: int) -> bytes:
    """8 bytes, another for each seed; the fourth is no ASCII, so it is never that of a robot as it comes."""
    digest = sha256(f"as built {seed}".encode()).digest()
    return b"emu" + bytes([digest[0] | 0x80]) + digest[1:5]
