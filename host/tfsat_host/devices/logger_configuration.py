"""The logger's settings: what the buses carry and a file holds."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.errors import UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import limits
from tfsat_host.protocol.enums import Origin
from tfsat_host.protocol.messages import LoggerSettings

GYRO_RANGES_DEG_S = (250, 500, 1000, 2000)
ACCEL_RANGES_G = (2, 4, 8, 16)
BUS_CLOCKS_KHZ = (100, 400)
DLPF_HZ = (256, 188, 98, 42, 20, 10, 5)
"""Bandwidth of the gyros by DLPF_CFG (RM-MPU-6000A rev. 4.2, p. 13)."""
_AFTER_LANDING_S = range(limits.AFTER_LANDING_MIN_S, limits.AFTER_LANDING_MAX_S + 1)
_RATES_HZ = range(limits.SAMPLE_RATE_MIN_HZ, limits.SAMPLE_RATE_MAX_HZ + 1)
_FILES_MIB = range(limits.FILE_MIN_MIB, limits.FILE_MAX_MIB + 1)
FACTORY = LoggerSettings(
    rate_hz=limits.SAMPLE_RATE_HZ,
    gyro_range_deg_s=limits.GYRO_RANGE_FACTORY_DEG_S,
    accel_range_g=limits.ACCEL_RANGE_FACTORY_G,
    dlpf_cfg=limits.DLPF_FACTORY,
    bus_khz=limits.BUS_FACTORY_KHZ,
    after_landing_s=limits.AFTER_LANDING_FACTORY_S,
    file_mib=limits.FILE_FACTORY_MIB,
)
"""What a logger that never got any uses."""


@dataclass(frozen=True, slots=True)
class StoredLoggerSettings:
    """The settings in force.

    Attributes:
        origin: Factory or uploaded.
        settings: What they say.
        rate_max_hz: What the buses carry at this clock.
    """

    origin: Origin
    settings: LoggerSettings
    rate_max_hz: int


def burst_us(bus_khz: int) -> int:
    """Duration of one 14-byte burst, rounded up."""
    return -(-limits.IMU_BURST_BITS * 1000 // bus_khz)


def rate_max_hz(bus_khz: int) -> int:
    """Compute the highest sampling rate that the buses carry, as the logger itself does (timing.h)."""
    return min(1_000_000 // _needed_us(bus_khz), limits.SAMPLE_RATE_MAX_HZ)


def file_min_mib(rate_hz: int, after_landing_s: int) -> int:
    """Compute the least file size for a drop, what follows it, and its second copy (file_budget.h)."""
    # From the release to the recording's own end, and the ring, from which a drop is written again.
    # Filled by samples or closed by the time limit, and the header now and then.
    blocks_per_s = max(-(-rate_hz // limits.SAMPLES_PER_BLOCK), 1000 // limits.PARTIAL_BLOCK_MS) + 1
    blocks = blocks_per_s * (limits.LANDING_LATEST_US // 1_000_000 + after_landing_s + 1) + limits.RING_BLOCKS
    return -(-blocks * limits.BLOCK_BYTES // (1 << 20))


def bus_arithmetic(rate_hz: int, bus_khz: int) -> str:
    """Why a rate does, or does not, fit."""
    bursts = {2: "two"}.get(limits.IMUS_PER_BUS, str(limits.IMUS_PER_BUS))
    return (
        f"{rate_hz} Hz leaves {1_000_000 // rate_hz} us; {bursts} 14-byte bursts of "
        f"{limits.IMU_BURST_BITS} bits take {limits.IMUS_PER_BUS} x {burst_us(bus_khz)} us at {bus_khz} kHz, plus "
        f"{_margin_us(bus_khz)} us kept for what else a sensor takes: {_needed_us(bus_khz)} us, "
        f"so at most {rate_max_hz(bus_khz)} Hz"
    )


def check(settings: LoggerSettings) -> None:
    """Raises UsageError for what the logger would refuse."""
    for what, value, unit, choices in (
        ("range of the gyros", settings.gyro_range_deg_s, " deg/s", GYRO_RANGES_DEG_S),
        ("range of the accelerometers", settings.accel_range_g, " g", ACCEL_RANGES_G),
        ("bus clock", settings.bus_khz, " kHz", BUS_CLOCKS_KHZ),
        ("low-pass setting", settings.dlpf_cfg, "", range(len(DLPF_HZ))),
        ("time after the landing", settings.after_landing_s, " s", _AFTER_LANDING_S),
        ("sampling rate", settings.rate_hz, " Hz", _RATES_HZ),
        ("room of a recording", settings.file_mib, " MiB", _FILES_MIB),
    ):
        if value not in choices:
            listed = f"one of {', '.join(map(str, choices))}"
            allowed = f"{choices[0]} to {choices[-1]}" if isinstance(choices, range) else listed
            raise UsageError(
                what=f"The {what} cannot be {value}{unit}: {allowed}{unit}.",
                meaning="Nothing was sent; the logger keeps its settings.",
                next_step=Advice(NextStep("logger-settings set", ("--help",))),
            )
    # A file that is full ends its recording: it must hold the longest drop with its second copy.
    least_mib = file_min_mib(settings.rate_hz, settings.after_landing_s)
    if settings.file_mib < least_mib:
        raise UsageError(
            what=f"A drop with {settings.after_landing_s} s after its landing and its second copy takes "
            f"{least_mib} MiB at {settings.rate_hz} Hz, and a recording would have {settings.file_mib} MiB.",
            meaning="It would end before it should; the logger keeps its settings.",
            next_step=f"Ask for --file-mib {least_mib} or more, or for a shorter --after-landing.",
        )
    if settings.rate_hz > rate_max_hz(settings.bus_khz):
        # A faster bus may carry the rate: offer the slowest clock that does.
        faster = [khz for khz in BUS_CLOCKS_KHZ if rate_max_hz(khz) >= settings.rate_hz]
        raise UsageError(
            what=f"{bus_arithmetic(settings.rate_hz, settings.bus_khz)}.",
            meaning="The buses cannot carry this sampling rate; the logger keeps its settings.",
            next_step=f"Ask for --rate {rate_max_hz(settings.bus_khz)}"
            + (f", or add --bus-khz {faster[0]}." if faster else "."),
        )


def _needed_us(bus_khz: int) -> int:
    return limits.IMUS_PER_BUS * burst_us(bus_khz) + _margin_us(bus_khz)


def _margin_us(bus_khz: int) -> int:
    """Compute the time reserved for a sensor that fails, or for a proof that it kept its settings."""
    return max(
        limits.SAMPLING_MARGIN_US, -(-limits.IMU_PROOF_BITS * 1000 // bus_khz) + limits.IMU_PROOF_SLACK_US
    )
