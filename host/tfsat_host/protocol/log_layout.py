"""The log's blocks as numpy dtype descriptors (numpy itself is not imported here).

Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
"""

from __future__ import annotations

from typing import Any

HEADER_BYTES = 32
SAMPLE_BYTES = 74
EVENT_BYTES = 16
EVENTS_OFFSET = 476
CRC_OFFSET = 508

IMU_READING_DTYPE: list[tuple[Any, ...]] = [
    ("accel", "<i2", (3,)),
    ("temperature", "<i2"),
    ("gyro", "<i2", (3,)),
]

SAMPLE_DTYPE: list[tuple[Any, ...]] = [
    ("time_offset_us", "<u4"),
    ("flags", "<u2"),
    ("imu", IMU_READING_DTYPE, (4,)),
    ("angle", "<u2", (6,)),
]

EVENT_DTYPE: list[tuple[Any, ...]] = [
    ("time_us", "<u8"),
    ("code", "u1"),
    ("index", "u1"),
    ("arg", "<u2"),
    ("value", "<i4"),
]

SERVO_SETTING_DTYPE: list[tuple[Any, ...]] = [
    ("zero_us", "<u2"),
    ("ns_per_deg", "<u2"),
    ("reversed", "u1"),
    ("min_cdeg", "<i2"),
    ("max_cdeg", "<i2"),
]

BLOCK_HEADER_DTYPE: list[tuple[Any, ...]] = [
    ("magic", "<u4"),
    ("version", "u1"),
    ("kind", "u1"),
    ("sample_count", "u1"),
    ("event_count", "u1"),
    ("session", "<u4"),
    ("block_number", "<u4"),
    ("first_sample", "<u4"),
    ("samples_dropped", "<u4"),
    ("time_us", "<u8"),
]

LOG_HEADER_DTYPE: list[tuple[Any, ...]] = [
    ("protocol_hash", "u1", (8,)),
    ("firmware_version", "u1", (3,)),
    ("imu_present", "u1"),
    ("board_serial", "u1", (8,)),
    ("image_crc", "<u4"),
    ("rate_hz", "<f4"),
    ("gyro_lsb_per_deg_s", "<f4"),
    ("accel_lsb_per_g", "<f4"),
    ("temperature_lsb_per_c", "<f4"),
    ("temperature_offset_c", "<f4"),
    ("angle_counts_per_turn", "<u4"),
    ("gyro_range_deg_s", "<u2"),
    ("accel_range_g", "u1"),
    ("dlpf_cfg", "u1"),
    ("who_am_i", "u1", (4,)),
    ("bus_khz", "<u2"),
    ("after_landing_s", "<u2"),
    ("schema", "u1", (384,)),
    ("wall_clock_us", "<u8"),
    ("imu_offset_us", "<u2", (4,)),
    ("angle_offset_us", "<u2", (6,)),
]

LOG_FOOTER_DTYPE: list[tuple[Any, ...]] = [
    ("samples", "<u4"),
    ("samples_dropped", "<u4"),
    ("blocks", "<u4"),
    ("ring_peak_blocks", "<u4"),
    ("interval_min_us", "<u4"),
    ("interval_max_us", "<u4"),
    ("jitter_rms_us", "<f4"),
    ("late_ticks", "<u4"),
    ("ring_blocks", "<u4"),
    ("card_stall_max_ms", "<u4"),
    ("blocks_rewritten", "<u4"),
    ("stop_reason", "u1"),
]

LOGGER_SETTINGS_DTYPE: list[tuple[Any, ...]] = [
    ("rate_hz", "<u2"),
    ("gyro_range_deg_s", "<u2"),
    ("accel_range_g", "u1"),
    ("dlpf_cfg", "u1"),
    ("bus_khz", "<u2"),
    ("after_landing_s", "<u2"),
    ("file_mib", "<u2"),
]

LOG_ENTRY_DTYPE: list[tuple[Any, ...]] = [
    ("number", "<u2"),
    ("session", "<u4"),
    ("blocks", "<u4"),
    ("wall_clock_us", "<u8"),
    ("closed", "u1"),
]

DATA_BLOCK_DTYPE: list[tuple[Any, ...]] = [
    *BLOCK_HEADER_DTYPE,
    ("samples", SAMPLE_DTYPE, (6,)),
    ("events", EVENT_DTYPE, (2,)),
    ("crc", "<u4"),
]
