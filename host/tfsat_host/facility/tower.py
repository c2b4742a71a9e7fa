"""A drop tower and its release mechanism, from a facility file.

The file's format is explained by the comments of `robots/cosmotorre.toml`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from tfsat_host.config import ConfigKind, Table, read_config
from tfsat_host.errors import TfsatError
from tfsat_host.facility.release import LeverSwitch
from tfsat_host.robot import default_robot_path
from tfsat_host.units import STANDARD_GRAVITY_M_S2

KIND = "drop tower"
_FILE_NAME = "cosmotorre.toml"
_POSITIVE = (
    "drop_height_m fall_s payload_diameter_mm payload_height_mm space_diameter_mm space_height_mm "
    "envelope_radius_mm usable_vertical_travel_mm magnet_force_n spring_force_n spring_stroke_mm "
    "switch_operating_force_n switch_free_position_mm"
)
_NOT_NEGATIVE = (
    "residual_acceleration_g margin_s maneuver_time_tolerance_s observed_transversal_velocity_mm_s clearance_mm "
    "residual_magnetism separation_needed_mm switch_releasing_force_n switch_overtravel_mm "
    "switch_movement_differential_mm"
)
_RANGES = "release_velocity_window_mm_s observed_release_velocity_mm_s switch_operating_position_mm"


class FacilityFileError(TfsatError):
    """The facility file cannot be read or does not describe a drop tower (exit code 1)."""


_FACILITY_FILE = ConfigKind(
    name="facility file",
    error=FacilityFileError,
    meaning="Whether the maneuver fits the drop tower is unknown.",
    cure="Name a facility file that exists, or none to use COSMOTORRE; robots/cosmotorre.toml shows the format.",
)


@dataclass(frozen=True, slots=True)
class DropTower:
    """Fall, test space and release mechanism.

    Attributes:
        path: The file that it was read from.
        name: What people call it.
        drop_height_m: Height of the fall.
        fall_s: From release to landing.
        residual_acceleration_g: What remains of gravity in the capsule, units of standard gravity.
        payload_diameter_mm, payload_height_mm: What the inner capsule takes.
        margin_s: Part of the fall that is not for the strokes.
        maneuver_time_tolerance_s: By how much the strokes may exceed the rest.
        space_diameter_mm, space_height_mm: Where the robot falls.
        envelope_radius_mm: From the line of fall to the nearest wall or pillar.
        usable_vertical_travel_mm: From the release mechanism to the bottom, less the robot.
        release_velocity_window_mm_s: Least and greatest permitted, downwards.
        observed_release_velocity_mm_s: Slowest and fastest of earlier drops.
        observed_transversal_velocity_mm_s: Sideways, of an earlier drop.
        clearance_mm: Way after which the moving robot no longer touches the release mechanism.
        magnet_force_n: Of the electromagnet, switched on.
        residual_magnetism: Fraction of it that remains when it is switched off.
        spring_force_n: Detaches the robot from the magnet.
        spring_stroke_mm: By which it separates them.
        separation_needed_mm: After which the magnet no longer holds.
        switch_count: Switches that push the robot off.
        switch: One of them.
    """

    path: Path
    name: str
    drop_height_m: float
    fall_s: float
    residual_acceleration_g: float
    payload_diameter_mm: float
    payload_height_mm: float
    margin_s: float
    maneuver_time_tolerance_s: float
    space_diameter_mm: float
    space_height_mm: float
    envelope_radius_mm: float
    usable_vertical_travel_mm: float
    release_velocity_window_mm_s: tuple[float, float]
    observed_release_velocity_mm_s: tuple[float, float]
    observed_transversal_velocity_mm_s: float
    clearance_mm: float
    magnet_force_n: float
    residual_magnetism: float
    spring_force_n: float
    spring_stroke_mm: float
    separation_needed_mm: float
    switch_count: int
    switch: LeverSwitch

    @property
    def maneuver_time_max_s(self) -> float:
        """T_max: what the strokes may take together."""
        return self.fall_s - self.margin_s

    @property
    def slowest_release_mm_s(self) -> float:
        """Slowest release of earlier drops; fixes the pause."""
        return self.observed_release_velocity_mm_s[0]

    @property
    def fastest_release_mm_s(self) -> float:
        """Fastest release of earlier drops; fixes the vertical travel."""
        return self.observed_release_velocity_mm_s[1]


def default_facility_path() -> Path:
    """`cosmotorre.toml` beside the default robot."""
    return default_robot_path().with_name(_FILE_NAME)


def load_tower(path: Path | str | None = None) -> DropTower:
    """Read and check a facility file; without a path the drop tower COSMOTORRE.

    Raises:
        FacilityFileError: the file cannot be read, is not TOML or does not describe a drop tower. The
            message names file, line and entry, and how to correct it.
    """
    file = default_facility_path() if path is None else Path(path)
    top = read_config(file, _FACILITY_FILE)
    top.choice("kind", (KIND,))
    top.only(f"format kind name switch_count {_POSITIVE} {_NOT_NEGATIVE} {_RANGES}")
    figures: dict[str, Any] = {
        **{key: top.number(key, above=0) for key in _POSITIVE.split()},
        **{key: top.number(key, least=0) for key in _NOT_NEGATIVE.split()},
        **{key: _range(top, key) for key in _RANGES.split()},
    }
    switch = {field.name: figures.pop(f"switch_{field.name}") for field in fields(LeverSwitch)}
    tower = DropTower(
        path=file,
        name=top.text("name"),
        switch_count=top.integer("switch_count", 1, 8),
        switch=LeverSwitch(**switch),
        **figures,
    )
    _check_together(top, tower)
    return tower


def _range(top: Table, key: str) -> tuple[float, float]:
    """Two numbers above zero, the smaller one first."""
    low, high = top.numbers(key, 2)
    if not 0.0 < low <= high:
        top.fail(key, f"[{low:g}, {high:g}] is no range above zero", "Write the smaller number first.")
    return low, high


def _check_together(top: Table, tower: DropTower) -> None:
    """What one number says of another."""
    longest_s = math.sqrt(2.0 * tower.drop_height_m / STANDARD_GRAVITY_M_S2)
    if tower.fall_s > longest_s:
        top.fail(
            "fall_s",
            f"is more than {longest_s:.2f} s, which {tower.drop_height_m:g} m of free fall take",
            "Correct drop_height_m or fall_s.",
        )
    if tower.margin_s >= tower.fall_s:
        top.fail("margin_s", f"leaves nothing of the fall of {tower.fall_s:g} s", "Give a shorter margin.")
    for key, size_mm, room_mm in (
        ("space_diameter_mm", tower.space_diameter_mm, tower.payload_diameter_mm),
        ("space_height_mm", tower.space_height_mm, tower.payload_height_mm),
    ):
        if size_mm > room_mm:
            top.fail(
                key,
                f"is more than the {room_mm:g} mm that the inner capsule takes",
                "The test space lies inside the inner capsule.",
            )
    if 2.0 * tower.envelope_radius_mm > tower.space_diameter_mm:
        top.fail(
            "envelope_radius_mm",
            f"is more than half of the test space of {tower.space_diameter_mm:g} mm",
            "Give the distance from the line of fall to the nearest wall or pillar.",
        )
    if tower.usable_vertical_travel_mm > tower.space_height_mm:
        top.fail(
            "usable_vertical_travel_mm",
            f"is more than the test space's height of {tower.space_height_mm:g} mm",
            "Give the way from the release mechanism to the bottom, less the robot's height.",
        )
    switch = tower.switch
    shortest_mm = switch.free_position_mm - switch.operating_position_mm[1]
    if shortest_mm <= switch.movement_differential_mm:
        top.fail(
            "switch_operating_position_mm",
            f"leaves a pre-travel of {shortest_mm:g} mm, not above the movement differential",
            "Check it against the switch's datasheet: FP - OP is above MD.",
        )
