"""Parts that may be IMUs: register-compatible with the MPU-6050.

Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ImuPart:
    """One kind of IMU. The comments below name the data sheets.

    Attributes:
        name: Type.
        who_am_i: Register 0x75.
        temperature_lsb_per_c: Counts a deg C of the die.
        temperature_offset_c: At zero counts.
        gyro_delay_us: (7,) of the gyros' low-pass, by DLPF_CFG.
        accel_delay_us: (7,) the same of the accelerometers.
    """

    name: str
    who_am_i: int
    temperature_lsb_per_c: float
    temperature_offset_c: float
    gyro_delay_us: tuple[int, ...]
    accel_delay_us: tuple[int, ...]


IMU_PARTS = {
    # RM-MPU-6000A-00 rev. 4.2, registers 26, 65 and 117.
    0x68: ImuPart(
        "MPU-6050",
        0x68,
        340.0,
        36.53,
        (980, 1900, 2800, 4800, 8300, 13400, 18600),
        (0, 2000, 3000, 4900, 8500, 13800, 19000),
    ),
    # RM-MPU-6500A-00 rev. 2.1, registers 26 and 117; PS-MPU-6500A-01, 3.3; accelerometer as the MPU-9250.
    0x70: ImuPart(
        "MPU-6500",
        0x70,
        333.87,
        21.0,
        (970, 2900, 3900, 5900, 9900, 17850, 33480),
        (1880, 1880, 2880, 4880, 8870, 16830, 32480),
    ),
    # RM-MPU-9250A-00 rev. 1.6, registers 26, 29, 65 and 117.
    0x71: ImuPart(
        "MPU-9250",
        0x71,
        333.87,
        21.0,
        (970, 2900, 3900, 5900, 9900, 17850, 33480),
        (1880, 1880, 2880, 4880, 8870, 16830, 32480),
    ),
    # As the MPU-9250, but for register 117.
    0x73: ImuPart(
        "MPU-9255",
        0x73,
        333.87,
        21.0,
        (970, 2900, 3900, 5900, 9900, 17850, 33480),
        (1880, 1880, 2880, 4880, 8870, 16830, 32480),
    ),
    # DS-000143, registers 65 and 117. Delays, which it does not tell: assumed as the MPU-9250.
    0x98: ImuPart(
        "ICM-20689",
        0x98,
        326.8,
        25.0,
        (970, 2900, 3900, 5900, 9900, 17850, 33480),
        (1880, 1880, 2880, 4880, 8870, 16830, 32480),
    ),
}
"""By register 0x75, WHO_AM_I; the MPU-6050 first."""
