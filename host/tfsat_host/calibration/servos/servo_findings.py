"""What the measurement of a servo has found, with its columns for JSON and for people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees

import numpy as np

from tfsat_host.calibration.servos.servo_map import ServoMap, ServoPoint, board_pulse_us, servo_plan
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.quantity import Column, Columns, Quantity, fields
from tfsat_host.servo_settings import NS_PER_US
from tfsat_host.units import CDEG_PER_DEG


@dataclass(frozen=True, slots=True)
class ServoVisit:
    """A visit, with the angle that its pulse was commanded for, and whether it may have ended at a stop.

    The map leaves out those at a stop.
    """

    point: ServoPoint
    commanded_deg: float
    at_stop: bool


@dataclass(frozen=True, slots=True)
class ServoPlace:
    """All visits to one pulse.

    Attributes:
        pulse_us: As commanded.
        commanded_deg: By the board's setting.
        opening_deg, closing_deg: Mean angle at rest after arriving from either side; None: never from there.
    """

    pulse_us: float
    commanded_deg: float
    opening_deg: float | None
    closing_deg: float | None


@dataclass(frozen=True, slots=True)
class ServoResiduals:
    """A joint's deviations from commanded angles with a setting, over its limits.

    Attributes:
        mean_deg: The largest, on average of both directions: the effect of rounding and old settings.
        side_deg: Half the backlash, by which it stops short from either side.
        scatter_deg: Standard deviation of one arrival, including the nonlinearity of the servo.
    """

    mean_deg: float
    side_deg: float
    scatter_deg: float


VISITS: Columns = (
    Column("commanded_deg", of=lambda visit: round(visit.commanded_deg, 3)),
    Column("pulse_us", of="point.pulse_us"),
    Column("direction", of=lambda visit: "opening" if visit.point.direction > 0 else "closing"),
    *fields("reached_deg=point.reached_rad std_deg=point.std_rad at_stop"),
)
PLACES: Columns = (
    Column("commanded_deg", "commanded", form=".1f"),
    Column("pulse_us", "pulse", form="g"),
    Column("opening_deg", "reached opening", form=".2f"),
    Column("closing_deg", "reached closing", form=".2f"),
)
RESIDUALS: Columns = (
    Column("mean_deg", "Max. error, average of both directions", form=".2f"),
    Column("side_deg", "Error by backlash, either direction", form=".2f"),
    Column("scatter_deg", "Scatter (std of an arrival)", form=".2f"),
)


def compute_gain(servo_map: ServoMap) -> Quantity:
    """Compute the reached per commanded change, by the setting that was in force; 1 is exact."""
    setting = servo_map.setting
    # Signed by the setting: a servo that does as told has gain +1, reversed or not.
    us_per_deg = setting.ns_per_deg / NS_PER_US * (-1.0 if setting.reversed else 1.0)
    std = float(np.sqrt(servo_map.covariance[1, 1])) * abs(us_per_deg)
    return Quantity(degrees(servo_map.slope_rad_per_us * us_per_deg), degrees(std))


def compute_offset(servo_map: ServoMap) -> Quantity:
    """Compute the joint angle at rest when 0 deg is commanded, deg, on average of both directions.

    It is by the setting that was in force.
    """
    zero_us = float(servo_map.setting.zero_us)
    reached_rad, std_rad = servo_map.reached_rad(zero_us, 0), servo_map.std_rad(zero_us)
    return Quantity(degrees(reached_rad), degrees(std_rad), form="+.3f")


MAP: Columns = (
    *fields("backlash_deg backlash_std_deg repeatability_deg nonlinearity_deg places"),
    Column("gain", of=lambda servo_map: compute_gain(servo_map).value),
    Column("gain_std", of=lambda servo_map: compute_gain(servo_map).std),
    Column("offset_deg", of=lambda servo_map: compute_offset(servo_map).value),
    Column("offset_std_deg", of=lambda servo_map: compute_offset(servo_map).std),
)
MAP_FACTS: Columns = (
    Column("", "Gain", words=lambda servo_map: compute_gain(servo_map).text()),
    Column("", "Offset", words=lambda servo_map: f"{compute_offset(servo_map).text()} deg at 0 deg"),
    Column("backlash_deg", "Backlash", std="backlash_std_rad"),
    Column("repeatability_deg", "Repeatability (std of an arrival)", form=".2f"),
    Column("nonlinearity_deg", "Nonlinearity (std of the places)", form=".2f"),
)
"""Of a servo map, in figures that people compare."""

DYNAMICS: Columns = (
    Column("joint", "joint"),
    Column("direction", "direction", of=lambda fit: "opening" if fit.direction > 0 else "closing"),
    Column("speed_deg_s", "speed", of="max_rate_rad_s", std=lambda fit: degrees(fit.std[0])),
    Column(
        "acceleration_deg_s2", "acceleration", of="acceleration_rad_s2", std=lambda fit: degrees(fit.std[1])
    ),
    Column("delay_ms", "delay", of="delay_s", std=lambda fit: 1e3 * fit.std[2]),
    Column("strokes", "strokes"),
    Column("residual_deg", "residual rms", form=".2f"),
    *fields("recorded_at"),
)
"""Of the measured dynamics of a servo in one direction."""


def commanded_deg(pulse_us: float, setting: ServoSetting) -> float:
    """Invert the board's line to get the angle that a pulse was commanded for."""
    change_us = (pulse_us - setting.zero_us) * (-1.0 if setting.reversed else 1.0)
    return change_us * NS_PER_US / setting.ns_per_deg


def average_places(points: Sequence[ServoPoint], setting: ServoSetting) -> list[ServoPlace]:
    """Average the visits to each pulse, either side apart; in order of the commanded angle."""

    def mean_deg(pulse_us: float, direction: int) -> float | None:
        # Means of either side apart: their difference at one pulse is the backlash there.
        side = [p.reached_rad for p in points if (p.pulse_us, p.direction) == (pulse_us, direction)]
        return degrees(np.mean(side)) if side else None

    places = [
        ServoPlace(pulse_us, commanded_deg(pulse_us, setting), mean_deg(pulse_us, 1), mean_deg(pulse_us, -1))
        for pulse_us in {point.pulse_us for point in points}
    ]
    return sorted(places, key=lambda place: place.commanded_deg)


def predict_residuals(servo_map: ServoMap, setting: ServoSetting) -> ServoResiduals:
    """Predict the joint's deviations from commanded angles with a setting."""
    # Through the board's own rounding, at the places where the servo is measured.
    off_deg = [
        degrees(servo_map.reached_rad(board_pulse_us(setting, angle_cdeg), 0)) - angle_cdeg / CDEG_PER_DEG
        for angle_cdeg in servo_plan(setting)
    ]
    return ServoResiduals(
        max(map(abs, off_deg)),
        degrees(abs(servo_map.backlash_rad)) / 2,
        degrees(np.hypot(servo_map.repeatability_rad, servo_map.nonlinearity_rad)),
    )
