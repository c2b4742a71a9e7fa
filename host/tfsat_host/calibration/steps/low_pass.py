"""The low-pass of a robot's IMUs: how late their readings are by the data sheets of the parts that are fitted."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.protocol.imus import ImuPart
from tfsat_host.protocol.limits import IMU_COUNT
from tfsat_host.protocol.messages import LiveReply, LogHeader
from tfsat_host.sdlog.header import MPU_6050, parts_of

# Gyros are renewed at 8 kHz with DLPF_CFG 0, else at 1 kHz (RM-MPU-6000A rev. 4.2).
_OUTPUT_PERIOD_S = (125e-6, *[1e-3] * 6)


@dataclass(frozen=True, slots=True)
class LowPass:
    """A setting, and the parts that have it; delays are the data sheets' (`protocol.imus` names them).

    Delays are those of the part that most IMUs are. Readings of the others are given for the time at which that part
    would have shown them (`SensorSamples.from_counts`), so that one lag holds for all.

    Attributes:
        dlpf_cfg: As the logger has set it, 0 to 6.
        who_am_i: Register 0x75 of each IMU; 0 where none answered.
    """

    dlpf_cfg: int
    who_am_i: tuple[int, ...] = (MPU_6050,) * IMU_COUNT

    @classmethod
    def of(cls, stated: LogHeader | LiveReply) -> LowPass:
        """Build the low-pass that the logger states."""
        return cls(stated.dlpf_cfg, tuple(stated.who_am_i))

    @property
    def parts(self) -> tuple[ImuPart, ...]:
        """What each IMU is."""
        return parts_of(self.who_am_i)

    @property
    def gyro_delay_s(self) -> float:
        """From the motion to the gyros' output."""
        return 1e-6 * self._commonest.gyro_delay_us[self.dlpf_cfg]

    @property
    def accel_delay_s(self) -> float:
        """The same of the accelerometers."""
        return 1e-6 * self._commonest.accel_delay_us[self.dlpf_cfg]

    @property
    def output_period_s(self) -> float:
        """The chip renews its registers so often: what is read is on average half of it old."""
        return _OUTPUT_PERIOD_S[self.dlpf_cfg]

    @property
    def gyros_later_s(self) -> FloatArray:
        """(4,) by how much more than `gyro_delay_s` each gyro is late."""
        return np.array([1e-6 * part.gyro_delay_us[self.dlpf_cfg] for part in self.parts]) - self.gyro_delay_s

    @property
    def accels_later_s(self) -> FloatArray:
        """(4,) the same of the accelerometers."""
        return (
            np.array([1e-6 * part.accel_delay_us[self.dlpf_cfg] for part in self.parts]) - self.accel_delay_s
        )

    @property
    def _commonest(self) -> ImuPart:
        return Counter(self.parts).most_common(1)[0][0]
