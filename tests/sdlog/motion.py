"""A log of a known motion: rest, release, a steady turn of all bodies while every joint opens to 90 deg."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.sdlog.encoder import ALL_VALID, HEADER, Recorder, event
from tests.sdlog.test_values import write
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog, load

REST_S = 3.6
FALL_S = FALL_US / 1e6
RATE_COUNTS = (1965, -1310, 3275)
"""Of every body in the fall: 30, -20, 50 deg/s, exact in counts of 65.5 LSB/(deg/s)."""
BIAS_COUNTS = (37, -52, 11)
QUARTER_TURN_COUNTS = 1024
OPENED_S = 1.0
"""Joints are open this long after the release."""


def moving_log(path: Path, *, wall_clock_us: int = 0) -> DropLog:
    """Written to `path` and loaded; samples, counts and release are exact."""
    recorder = Recorder(header=replace(HEADER, wall_clock_us=wall_clock_us))
    # Rest before the release, as a robot in the releaser has it.
    while recorder.samples * recorder.interval_us < REST_S * 1e6:
        recorder.data()
    release_us = recorder.time_us(recorder.samples)
    edges = [event(release_us, EventCode.SWITCH_EDGE, switch, 1) for switch in range(2)]
    recorder.data(flags=ALL_VALID | 0x0C00, events=edges)
    while recorder.time_us(recorder.samples) < release_us + FALL_US + 500_000:
        recorder.data(flags=ALL_VALID | 0x0C00)
    recorder.close()
    log = load(write(path, recorder.image()))
    fallen = log.t_us >= release_us
    imu = np.zeros_like(log.imu_counts)
    imu[:, :, 4:7] = BIAS_COUNTS
    # The bias stays in the fall: it is the sensor's own.
    imu[fallen, :, 4:7] += np.array(RATE_COUNTS, np.int16)
    opened = np.clip((log.t_us - release_us) / (OPENED_S * 1e6), 0, 1)
    turned = np.round(opened * QUARTER_TURN_COUNTS)
    sensors = load_robot().angle_sensors
    # Both sensors of a joint turn, each in its own direction.
    angles = np.stack([(2048 + sensor.direction * turned) % 4096 for sensor in sensors], axis=1)
    return replace(log, imu_counts=imu, angle_counts=angles.astype(np.uint16))
