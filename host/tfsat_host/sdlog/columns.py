"""The columns that a person reads: names with units, and how many decimals carry all of the sensor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT, SWITCH_COUNT
from tfsat_host.units import STANDARD_GRAVITY_M_S2

from .droplog import DropLog
from .header import temperature_scales

_AXES = "xyz"


@dataclass(frozen=True, eq=False)
class CountColumn:
    """A physical column that is a linear function of raw counts.

    Attributes:
        name: With the unit.
        counts: (n,) int16 or uint16.
        scale: Physical units per count.
        offset: Physical value at zero counts.
        decimals: Enough that different counts have different texts.
        valid: (n,) bool; elsewhere the field is empty.
    """

    name: str
    counts: NDArray[np.int16] | NDArray[np.uint16]
    scale: float
    offset: float
    decimals: int
    valid: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class FlagColumn:
    """A column of 0 and 1; `values` is (n,) bool."""

    name: str
    values: NDArray[np.bool_]


def physical_columns(log: DropLog) -> list[CountColumn]:
    """Degrees, m/s² and °C: by body the rates, specific forces and temperature, then the angle sensors."""
    header = log.header
    columns = []
    for body in range(IMU_COUNT):
        counts, valid = log.imu_counts[:, body], log.imu_valid[:, body]
        lsb_per_c, offset_c = temperature_scales(header)[body]
        per_g = STANDARD_GRAVITY_M_S2 / header.accel_lsb_per_g
        name = f"imu{body + 1}"
        columns += [
            CountColumn(
                f"{name}_rate_{axis}_deg_s", counts[:, 4 + i], 1 / header.gyro_lsb_per_deg_s, 0, 4, valid
            )
            for i, axis in enumerate(_AXES)
        ]
        columns += [
            CountColumn(f"{name}_specific_force_{axis}_m_s2", counts[:, i], per_g, 0, 5, valid)
            for i, axis in enumerate(_AXES)
        ]
        columns.append(
            CountColumn(
                f"{name}_temperature_c",
                counts[:, 3],
                1 / lsb_per_c,
                offset_c,
                3,
                valid,
            )
        )
    for joint in range(JOINT_COUNT):
        for sensor in range(2):
            index = 2 * joint + sensor
            columns.append(
                CountColumn(
                    f"joint{joint + 1}_sensor{sensor + 1}_angle_deg",
                    log.angle_counts[:, index],
                    360 / header.angle_counts_per_turn,
                    180 / header.angle_counts_per_turn,  # the middle of the count
                    4,
                    log.angle_valid[:, index],
                )
            )
    return columns


def flag_columns(log: DropLog) -> list[FlagColumn]:
    """Switches and clipping. Validity shows as empty fields."""
    switches = [FlagColumn(f"switch{i + 1}_open", log.switch_open[:, i]) for i in range(SWITCH_COUNT)]
    return switches + [FlagColumn(f"imu{i + 1}_clipped", log.clipped[:, i]) for i in range(IMU_COUNT)]
