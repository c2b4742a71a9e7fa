"""Raw counts of all sensors, live or from a recording: what is kept, and what a calibration is applied to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT, SWITCH_COUNT
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.messages import LiveReply, LiveSampleStream, LogHeader
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.header import MPU_6050, parts_of

COLUMNS = ("t_us", "imu_counts", "angle_counts", "imu_valid", "angle_valid", "clipped")
"""What `Counts` has of each sample."""
# A sample's flags, from bit 0: IMUs valid, angle sensors valid, switches, IMUs clipped.
_FLAG_ENDS = np.cumsum([IMU_COUNT, ANGLE_SENSOR_COUNT, SWITCH_COUNT, IMU_COUNT])


@dataclass(frozen=True, slots=True)
class Scales:
    """What a count stands for.

    Attributes:
        rate_hz: Sampling rate as commanded.
        gyro_lsb_per_deg_s: Of all gyros.
        accel_lsb_per_g: Of all accelerometers.
        angle_counts_per_turn: Of all angle sensors.
        imu_offset_us, angle_offset_us: From a sample's time to the reading of each sensor; 0 where it is unknown.
        dlpf_cfg: Setting of the IMUs' low-pass.
        who_am_i: Register 0x75 of each IMU: which part it is; 0 where none answered.
    """

    rate_hz: float
    gyro_lsb_per_deg_s: float
    accel_lsb_per_g: float
    angle_counts_per_turn: int
    imu_offset_us: tuple[int, ...] = (0,) * IMU_COUNT
    angle_offset_us: tuple[int, ...] = (0,) * ANGLE_SENSOR_COUNT
    dlpf_cfg: int = 0
    who_am_i: tuple[int, ...] = (MPU_6050,) * IMU_COUNT

    @classmethod
    def of(cls, stated: LogHeader | LiveReply) -> Scales:
        """Build the scales that the logger states."""
        values = {field.name: getattr(stated, field.name) for field in fields(cls)}
        return cls(**values | {"who_am_i": tuple(stated.who_am_i)})

    @property
    def low_pass(self) -> LowPass:
        """Of the IMUs."""
        return LowPass(self.dlpf_cfg, self.who_am_i)

    def temperature_c(self, counts: NDArray[np.int16]) -> NDArray[np.float64]:
        """(n, 4) of the dies, °C, from counts (n, 4)."""
        parts = parts_of(self.who_am_i)
        # IMUs of different parts may be mixed: each has its own scale and offset.
        scale = np.array([part.temperature_lsb_per_c for part in parts])
        return np.asarray(counts / scale + [part.temperature_offset_c for part in parts])


@dataclass(frozen=True, eq=False)
class Counts:
    """n samples as the sensors gave them.

    Attributes:
        t_us: (n,) int64, the logger's clock since power-up.
        imu_counts: (n, 4, 7) int16, per body accelerometer x y z, temperature, gyro x y z.
        angle_counts: (n, 6) uint16.
        imu_valid: (n, 4) bool, the IMU answered and was not frozen.
        angle_valid: (n, 6) bool.
        clipped: (n, 4) bool, a value of the IMU is at its full scale.
        samples_lost: Samples that the logger took and that are not here.
        scales: What a count stands for.
    """

    t_us: NDArray[np.int64]
    imu_counts: NDArray[np.int16]
    angle_counts: NDArray[np.uint16]
    imu_valid: NDArray[np.bool_]
    angle_valid: NDArray[np.bool_]
    clipped: NDArray[np.bool_]
    samples_lost: int
    scales: Scales

    @classmethod
    def from_live(cls, samples: Sequence[LiveSample], reply: LiveReply) -> Counts:
        """Build counts from live samples, at least one, with the scales that the logger states."""
        # One structured view of all payloads, instead of decoding sample by sample.
        stream = np.frombuffer(b"".join(sample.payload for sample in samples), LiveSampleStream.dtype())
        sample, imu = stream["sample"], stream["sample"]["imu"]
        # (n, 1) flags shifted by (bits,) positions make a matrix of booleans.
        bits = sample["flags"][:, None] >> np.arange(_FLAG_ENDS[-1]) & 1 > 0
        imu_valid, angle_valid, _, clipped, _ = np.split(bits, _FLAG_ENDS, axis=1)
        return cls(
            t_us=stream["time_us"].astype(np.int64),
            imu_counts=np.concatenate([imu["accel"], imu["temperature"][..., None], imu["gyro"]], axis=2),
            angle_counts=sample["angle"].copy(),
            imu_valid=imu_valid,
            angle_valid=angle_valid,
            clipped=clipped,
            # Gaps in the logger's running index between the first sample and the last.
            samples_lost=samples[-1].index - samples[0].index + 1 - len(samples),
            scales=Scales.of(reply),
        )

    @classmethod
    def from_log(cls, log: DropLog) -> Counts:
        """Build counts from a decoded recording."""
        return cls(
            log.t_us,
            log.imu_counts,
            log.angle_counts,
            log.imu_valid,
            log.angle_valid,
            log.clipped,
            log.samples_lost,
            Scales.of(log.header),
        )

    def part(self, rows: slice) -> Counts:
        """Some of the samples, none of which were lost."""
        columns: dict[str, Any] = {name: getattr(self, name)[rows] for name in COLUMNS}
        return replace(self, **columns, samples_lost=0)

    @classmethod
    def join(cls, parts: Sequence[Counts]) -> Counts:
        """Parts that came one after the other; for a look at them, not for keeping: gaps are not counted."""
        columns: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS
        }
        return replace(parts[0], **columns)
