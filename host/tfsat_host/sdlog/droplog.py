"""A decoded recording."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import BoolArray, FloatArray, IntArray
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, JOINT_COUNT
from tfsat_host.protocol.messages import LogFooter, LogHeader
from tfsat_host.units import STANDARD_GRAVITY_M_S2

from .events import DropEvent
from .header import MIN_WALL_CLOCK_US, temperature_scales
from .ledger import Gap
from .recordings import ChosenBy, Recording, SetAside
from .release import Release

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Verdict = Literal["complete", "truncated", "damaged"]
EVENT_COLUMNS = ("t_us", "t_s", "event", "index", "arg", "value")
"""In every file of events."""
SENSORS_PER_JOINT = ANGLE_SENSOR_COUNT // JOINT_COUNT
_ACCEL, _TEMPERATURE, _GYRO = slice(0, 3), 3, slice(4, 7)
_BY_SAMPLE = (
    "sample_index",
    "t_us",
    "imu_counts",
    "angle_counts",
    "imu_valid",
    "angle_valid",
    "switch_open",
    "clipped",
)


@dataclass(frozen=True, eq=False)
class DropLog:
    """One recording of the robot's sensors; n samples, in the sensors' own frames, uncalibrated.

    A value of a sensor that was not valid at a sample is NaN in every physical column. Physical columns
    are computed when first asked for and kept. Treat all arrays as read-only.

    Attributes:
        path: The file.
        session: Random id of the recording.
        other_sessions: Ids of other recordings in the file.
        recordings: All recordings of the file by a first look, this one too.
        chosen_by: Why this one of them was decoded: `only one`, `asked for`, `time of day` (the newest by
            the headers), `place` (the first of the file) or `header` (the first of the file that has one).
        header: Scales, ranges, sensors, versions (`tfsat_host.protocol.messages.LogHeader`); who_am_i of an IMU that
            did not answer when the recording began is what it answered later on.
        header_is_copy: The first block was lost and a repetition of the header was used.
        header_time_us: The logger's clock when that header was written.
        footer: Written at a clean stop; None without one.
        sample_index: (n,) int64, number of each sample in the recording, lost ones counted.
        t_us: (n,) int64, the logger's clock, µs since power-up; the raw times.
        release: When the robot was released, and how far that is certain; None if it was not recorded.
        imu_counts: (n, 4, 7) int16, per body accel x y z, temperature, gyro x y z; raw.
        angle_counts: (n, 6) uint16, angle sensors; raw.
        imu_valid: (n, 4) bool, the IMU answered in time, was not frozen, and is the part that the header names.
        angle_valid: (n, 6) bool.
        switch_open: (n, 2) bool, release switches.
        clipped: (n, 4) bool, a value of the IMU is at its full scale.
        events: By time.
        gaps: Where something is missing.
        late_rows: (m,) int64, rows of samples that came more than one and a half sampling periods after
            the one before although none is lost between them: they were never taken.
        set_aside: Blocks of the file that are no part of the recording.
        samples_lost: Samples known to be lost, on the card or before it; not what lies before a late start.
        blocks_lost: Blocks known to be lost, likewise.
        doubts: Contradictions inside the recording, in words.
        verdict: `complete`: header, footer and everything between. `truncated`: everything from one point
            to another, but not the start, the end or both. `damaged`: something inside is missing or
            contradictory.
    """

    path: Path
    session: int
    other_sessions: tuple[int, ...]
    recordings: tuple[Recording, ...]
    chosen_by: ChosenBy
    header: LogHeader
    header_is_copy: bool
    header_time_us: int
    footer: LogFooter | None
    sample_index: IntArray
    t_us: IntArray
    release: Release | None
    imu_counts: NDArray[np.int16]
    angle_counts: NDArray[np.uint16]
    imu_valid: BoolArray
    angle_valid: BoolArray
    switch_open: BoolArray
    clipped: BoolArray
    events: tuple[DropEvent, ...]
    gaps: tuple[Gap, ...]
    late_rows: IntArray
    set_aside: SetAside
    samples_lost: int
    blocks_lost: int
    doubts: tuple[str, ...]
    verdict: Verdict

    def __len__(self) -> int:
        return len(self.t_us)

    def __repr__(self) -> str:
        return (
            f"<DropLog {self.session:08x}: {self.verdict}, {len(self)} samples at {self.rate_hz:.2f} Hz, "
            f"{self.samples_lost} lost, {str(self.path)!r}>"
        )

    def to_dataframe(self) -> pd.DataFrame:
        """See `frames.to_dataframe`. Raises MissingExtraError."""
        from .frames import to_dataframe

        return to_dataframe(self)

    def to_xarray(self) -> xr.Dataset:
        """See `frames.to_xarray`. Raises MissingExtraError."""
        from .frames import to_xarray

        return to_xarray(self)

    @property
    def is_emulated(self) -> bool:
        """Whether an emulated robot's logger recorded it, which runs no image."""
        return self.header.image_crc == 0

    @property
    def late_start(self) -> Gap | None:
        """What lies before the file's first block, if the file begins later than the recording."""
        return self.gaps[0] if self.gaps and self.gaps[0].late_start else None

    @property
    def release_us(self) -> int | None:
        """The logger's clock at release; None if no release was recorded."""
        return self.release.t_us if self.release else None

    @property
    def release_uncertainty_us(self) -> int | None:
        """The most by which `release_us` can be wrong; 0 if its edges give it, None without a release."""
        return self.release.uncertainty_us if self.release else None

    @property
    def t_s_origin(self) -> str:
        """What t_s = 0 is: `release`, `release (doubtful)` or `first sample`."""
        if self.release is None:
            return "first sample"
        # Within one sampling period an uncertain t = 0 moves no sample by a whole row.
        doubtful = self.release.touches_gap or self.release.uncertainty_us > 1e6 / self.header.rate_hz
        return "release (doubtful)" if doubtful else "release"

    @property
    def unix_offset_us(self) -> int | None:
        """Unix time less the logger's clock; None if no host had told the logger the time, or one without a clock."""
        told_us = self.header.wall_clock_us
        return told_us - self.header_time_us if told_us >= MIN_WALL_CLOCK_US else None

    @property
    def maneuver_crc(self) -> int | None:
        """Of the maneuver that the sequencer held when the recording was started; None: the header does not tell."""
        return self.header.maneuver_crc if self.header.maneuver_known else None

    @property
    def origin_us(self) -> int:
        """The logger's clock at t_s = 0: the release, or without one the first sample."""
        return int(self.t_us[0]) if self.release_us is None else self.release_us

    @cached_property
    def t_s(self) -> FloatArray:
        """(n,) time after release, s; after the first sample if no release was recorded."""
        # Subtract as integers first: a long uptime then costs a short time none of its digits.
        return np.asarray((self.t_us - self.origin_us) / np.float64(1e6))

    @cached_property
    def rate_rad_s(self) -> FloatArray:
        """(n, 4, 3) angular rate of bodies 1 to 4 about their sensor's x, y, z, rad/s."""
        return self._imu_columns(_GYRO, np.pi / 180 / self.header.gyro_lsb_per_deg_s)

    @cached_property
    def specific_force_m_s2(self) -> FloatArray:
        """(n, 4, 3) specific force at the sensor along its x, y, z, m/s² (0 in free fall)."""
        return self._imu_columns(_ACCEL, STANDARD_GRAVITY_M_S2 / self.header.accel_lsb_per_g)

    @cached_property
    def temperature_c(self) -> FloatArray:
        """(n, 4) die temperature of each IMU, °C."""
        # Parts differ in scale and zero: (4,) each, broadcast over (n, 4) counts.
        lsb_per_c, offset_c = np.array(temperature_scales(self.header)).T
        return np.asarray(self._imu_columns(_TEMPERATURE, 1.0) * (1 / lsb_per_c) + offset_c)

    @cached_property
    def sensor_angle_rad(self) -> FloatArray:
        """(n, 6) absolute angle sensors, rad in [0, 2π), the middle of a count, for the converter cuts off.

        Joint j has columns 2 (j - 1) and the next.
        """
        per_count = 2 * np.pi / self.header.angle_counts_per_turn
        angle = np.asarray((self.angle_counts + 0.5) * per_count, np.float64)
        # An invalid sensor reads 0, a real angle: only NaN keeps it out of every later computation.
        angle[~self.angle_valid] = np.nan
        return angle

    @property
    def duration_s(self) -> float:
        """From the first sample to the last."""
        return int(self.t_us[-1] - self.t_us[0]) / 1e6

    @property
    def rate_hz(self) -> float:
        """Sampling rate achieved, lost samples counted; NaN when there is no time between samples."""
        if self.duration_s <= 0:
            return float("nan")
        return int(self.sample_index[-1] - self.sample_index[0]) / self.duration_s

    def event_rows(self) -> list[tuple[int, float, str, int, int, int]]:
        """Return a row of `EVENT_COLUMNS` for each event, by time."""
        return [
            (event.t_us, self.seconds(event.t_us), event.name, event.index, event.arg, event.value)
            for event in self.events
        ]

    def seconds(self, time_us: int) -> float:
        """Convert a time of the logger's clock to the scale of `t_s`."""
        return (time_us - self.origin_us) / 1e6

    def _imu_columns(self, columns: slice | int, scale: float) -> FloatArray:
        values: FloatArray = np.multiply(self.imu_counts[:, :, columns], scale, dtype=np.float64)
        # The (n, 4) mask blanks all axes of an IMU at once.
        values[~self.imu_valid] = np.nan
        return values


def rows_of(log: DropLog, rows: slice) -> DropLog:
    """Some rows of a log's columns, on the same scale of time; what holds for all of it stays."""
    columns: dict[str, Any] = {name: getattr(log, name)[rows] for name in _BY_SAMPLE}
    part = replace(log, **columns)
    # Without a release a log counts from its own first sample.
    part.__dict__["t_s"] = (part.t_us - log.origin_us) / np.float64(1e6)
    return part


@dataclass(frozen=True, eq=False)
class CountColumn:
    """A physical column, as people read it, that is a linear function of raw counts.

    Attributes:
        name: With the unit.
        counts: (n,) int16 or uint16.
        scale: Physical units per count.
        offset: Physical value at zero counts.
        decimals: Enough that different counts have different texts.
        valid: (n,) bool; elsewhere there is no value.
    """

    name: str
    counts: NDArray[np.int16] | NDArray[np.uint16]
    scale: float
    offset: float
    decimals: int
    valid: BoolArray

    def values(self, rows: slice | NDArray[np.intp]) -> FloatArray:
        """Convert the counts of these rows to physical units, whether valid or not."""
        return np.asarray(self.counts[rows] * np.float64(self.scale) + self.offset)


def physical_columns(log: DropLog) -> list[CountColumn]:
    """Degrees, m/s² and °C: by body the rates, specific forces and temperature, then the angle sensors."""
    header = log.header
    per_deg_s, per_g = 1 / header.gyro_lsb_per_deg_s, STANDARD_GRAVITY_M_S2 / header.accel_lsb_per_g
    per_turn = 360 / header.angle_counts_per_turn
    columns = []
    for body, (lsb_per_c, offset_c) in enumerate(temperature_scales(header)):
        # Name, column of the raw counts, scale, offset, decimals.
        readings = (
            *((f"rate_{axis}_deg_s", _GYRO.start + i, per_deg_s, 0.0, 4) for i, axis in enumerate("xyz")),
            *((f"specific_force_{axis}_m_s2", i, per_g, 0.0, 5) for i, axis in enumerate("xyz")),
            ("temperature_c", _TEMPERATURE, 1 / lsb_per_c, offset_c, 3),
        )
        counts, valid = log.imu_counts[:, body], log.imu_valid[:, body]
        columns += [
            CountColumn(f"imu{body + 1}_{name}", counts[:, at], scale, offset, decimals, valid)
            for name, at, scale, offset, decimals in readings
        ]
    for index in range(ANGLE_SENSOR_COUNT):
        joint, sensor = divmod(index, SENSORS_PER_JOINT)
        name = f"joint{joint + 1}_sensor{sensor + 1}_angle_deg"
        angles, valid = log.angle_counts[:, index], log.angle_valid[:, index]
        # The middle of the count.
        columns.append(CountColumn(name, angles, per_turn, per_turn / 2, 4, valid))
    return columns


def flag_columns(log: DropLog) -> dict[str, BoolArray]:
    """Switches and clipping, (n,) each, by name. Validity shows as missing values."""
    switches = {f"switch{i + 1}_open": column for i, column in enumerate(log.switch_open.T)}
    return switches | {f"imu{i + 1}_clipped": column for i, column in enumerate(log.clipped.T)}
