"""A drop tower and its release mechanism, from a facility file.

The file's format is explained by the comments of `robots/cosmotorre.toml`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from tfsat_host.errors import TfsatError
from tfsat_host.facility.release import LeverSwitch
from tfsat_host.robot import RobotFileError, default_robot_path
from tfsat_host.robot.entries import Entry
from tfsat_host.toml_reading import TomlError, read_toml
from tfsat_host.units import STANDARD_GRAVITY_M_S2

KIND = "drop tower"
_FILE_NAME = "cosmotorre.toml"
_MEANING = "Whether the maneuver fits the drop tower is unknown."


class FacilityFileError(TfsatError):
    """The facility file cannot be read or does not describe a drop tower (exit code 1)."""


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
    try:
        text, values = read_toml(file)
    except OSError as error:
        raise FacilityFileError(
            what=f"The facility file {file} cannot be read: {error.strerror}.",
            meaning=_MEANING,
            next_step="Name a facility file that exists, or name none to use COSMOTORRE.",
        ) from error
    except TomlError as error:
        raise FacilityFileError(
            what=f"{file}: {error}.",
            meaning=_MEANING,
            next_step="Correct that; robots/cosmotorre.toml shows the format.",
        ) from error
    return _tower(file, _FacilityEntry(file, text, "", 0, values))


class _FacilityEntry(Entry):
    """The entries of a facility file: read like a robot's, with an error that speaks of the facility."""

    def fail(self, key: str, problem: str, cure: str) -> NoReturn:
        try:
            super().fail(key, problem, cure)
        except RobotFileError as error:
            raise FacilityFileError(what=error.what, meaning=_MEANING, next_step=cure) from None

    def not_negative(self, key: str) -> float:
        """A number that is zero or above."""
        value = self.number(key)
        if value < 0.0:
            self.fail(key, f"{value:g} is negative", f"Give `{key}` zero or a number above it.")
        return value

    def range(self, key: str) -> tuple[float, float]:
        """Two numbers above zero, the smaller one first."""
        low, high = map(float, self.vector(key, 2))
        if not 0.0 < low <= high:
            self.fail(key, f"[{low:g}, {high:g}] is no range above zero", "Write the smaller number first.")
        return low, high


def _tower(file: Path, entry: _FacilityEntry) -> DropTower:
    entry.integer("format", (1,))
    if entry.text("kind") != KIND:
        entry.fail("kind", "is no kind of facility that is known", f'Write `kind = "{KIND}"`.')
    tower = DropTower(
        path=file,
        name=entry.text("name"),
        drop_height_m=entry.positive("drop_height_m"),
        fall_s=entry.positive("fall_s"),
        residual_acceleration_g=entry.not_negative("residual_acceleration_g"),
        payload_diameter_mm=entry.positive("payload_diameter_mm"),
        payload_height_mm=entry.positive("payload_height_mm"),
        margin_s=entry.not_negative("margin_s"),
        maneuver_time_tolerance_s=entry.not_negative("maneuver_time_tolerance_s"),
        space_diameter_mm=entry.positive("space_diameter_mm"),
        space_height_mm=entry.positive("space_height_mm"),
        envelope_radius_mm=entry.positive("envelope_radius_mm"),
        usable_vertical_travel_mm=entry.positive("usable_vertical_travel_mm"),
        release_velocity_window_mm_s=entry.range("release_velocity_window_mm_s"),
        observed_release_velocity_mm_s=entry.range("observed_release_velocity_mm_s"),
        observed_transversal_velocity_mm_s=entry.not_negative("observed_transversal_velocity_mm_s"),
        clearance_mm=entry.not_negative("clearance_mm"),
        magnet_force_n=entry.positive("magnet_force_n"),
        residual_magnetism=entry.not_negative("residual_magnetism"),
        spring_force_n=entry.positive("spring_force_n"),
        spring_stroke_mm=entry.positive("spring_stroke_mm"),
        separation_needed_mm=entry.not_negative("separation_needed_mm"),
        switch_count=entry.integer("switch_count", range(1, 9)),
        switch=_switch(entry),
    )
    _check_together(entry, tower)
    entry.done()
    return tower


def _switch(entry: _FacilityEntry) -> LeverSwitch:
    return LeverSwitch(
        operating_force_n=entry.positive("switch_operating_force_n"),
        releasing_force_n=entry.not_negative("switch_releasing_force_n"),
        overtravel_mm=entry.not_negative("switch_overtravel_mm"),
        movement_differential_mm=entry.not_negative("switch_movement_differential_mm"),
        free_position_mm=entry.positive("switch_free_position_mm"),
        operating_position_mm=entry.range("switch_operating_position_mm"),
    )


def _check_together(entry: _FacilityEntry, tower: DropTower) -> None:
    """What one number says of another."""
    longest_s = math.sqrt(2.0 * tower.drop_height_m / STANDARD_GRAVITY_M_S2)
    if tower.fall_s > longest_s:
        entry.fail(
            "fall_s",
            f"is more than {longest_s:.2f} s, which {tower.drop_height_m:g} m of free fall take",
            "Correct drop_height_m or fall_s.",
        )
    if tower.margin_s >= tower.fall_s:
        entry.fail("margin_s", f"leaves nothing of the fall of {tower.fall_s:g} s", "Give a shorter margin.")
    for key, size_mm, room_mm in (
        ("space_diameter_mm", tower.space_diameter_mm, tower.payload_diameter_mm),
        ("space_height_mm", tower.space_height_mm, tower.payload_height_mm),
    ):
        if size_mm > room_mm:
            entry.fail(
                key,
                f"is more than the {room_mm:g} mm that the inner capsule takes",
                "The test space lies inside the inner capsule.",
            )
    if 2.0 * tower.envelope_radius_mm > tower.space_diameter_mm:
        entry.fail(
            "envelope_radius_mm",
            f"is more than half of the test space of {tower.space_diameter_mm:g} mm",
            "Give the distance from the line of fall to the nearest wall or pillar.",
        )
    if tower.usable_vertical_travel_mm > tower.space_height_mm:
        entry.fail(
            "usable_vertical_travel_mm",
            f"is more than the test space's height of {tower.space_height_mm:g} mm",
            "Give the way from the release mechanism to the bottom, less the robot's height.",
        )
    switch = tower.switch
    shortest_mm = switch.free_position_mm - switch.operating_position_mm[1]
    if shortest_mm <= switch.movement_differential_mm:
        entry.fail(
            "switch_operating_position_mm",
            f"leaves a pre-travel of {shortest_mm:g} mm, not above the movement differential",
            "Check it against the switch's datasheet: FP - OP is above MD.",
        )
