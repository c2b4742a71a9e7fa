"""Each decoder, from its file to the same columns: (n,) times, (n, 28) IMU counts, (n, 6) angle counts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tests.validation.decode_bench.formats import ROW, Samples


def read_tfsat(path: Path) -> Samples:
    from tfsat_host.sdlog import load

    # Imports stand inside the functions: the environment of one decoder need not have the others' packages.
    log = load(path)
    assert log.blocks_lost == 0
    return Samples(log.t_us, log.imu_counts.reshape(len(log), 28), log.angle_counts)


def read_ulog(path: Path) -> Samples:
    from pyulog import ULog

    columns = ULog(str(path)).data_list[0].data
    imu = np.stack([columns[f"imu[{i}]"] for i in range(28)], axis=1)
    angle = np.stack([columns[f"angle[{i}]"] for i in range(6)], axis=1)
    return Samples(columns["timestamp"].astype(np.int64), imu, angle)


def read_mcap(path: Path) -> Samples:
    from mcap.reader import make_reader

    with path.open("rb") as file:
        messages = make_reader(file, validate_crcs=True).iter_messages(log_time_order=False)
        rows = np.frombuffer(b"".join(message.data for _, _, message in messages), ROW)
    return Samples(rows["t_us"].astype(np.int64), rows["imu"], rows["angle"])


def read_dataflash(path: Path) -> Samples:
    from pymavlink.DFReader import DFReader_binary

    reader = DFReader_binary(str(path))
    times, imu, angle = [], [], []
    while (message := reader.recv_match(type="DROP")) is not None:
        times.append(message.TimeUS)
        imu.append(message.Imu[:28])
        angle.append([message.A1, message.A2, message.A3, message.A4, message.A5, message.A6])
    return Samples(np.array(times, np.int64), np.array(imu, np.int16), np.array(angle, np.uint16))


def read_kaitai(path: Path) -> Samples:
    from tests.sdlog.kaitai.tfsat_log import TfsatLog

    times: list[int] = []
    imu: list[list[int]] = []
    angle: list[Any] = []
    for block in TfsatLog.from_file(str(path)).blocks:
        # Header blocks repeat the scales and hold no samples.
        if block.head.kind != TfsatLog.BlockKind.data:
            continue
        # The last block of a log may be partly filled.
        for sample in block.body.sample_slots[: block.head.sample_count]:
            times.append(block.head.time_us + sample.time_offset_us)
            imu.append(
                [
                    v
                    for imu_reading in sample.imu
                    for v in (*imu_reading.accel, imu_reading.temperature, *imu_reading.gyro)
                ]
            )
            angle.append(sample.angle)
    return Samples(np.array(times, np.int64), np.array(imu, np.int16), np.array(angle, np.uint16))
