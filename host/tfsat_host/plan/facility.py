"""A drop tower and its release mechanism: its file, what pushes the robot off, and how far it travels.

The file's format is explained by the comments of `robots/cosmotorre.toml`. Source of the release: the paper, sections
"Design of the release mechanism" and "Design of experiment sequence".
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from tfsat_host.config import ConfigKind, Table, read_config
from tfsat_host.errors import TfsatError
from tfsat_host.robot import default_robot_path
from tfsat_host.units import STANDARD_GRAVITY_M_S2

if TYPE_CHECKING:
    from tfsat_host.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class LeverSwitch:
    """A snap-action switch with a lever, in the words of its datasheet.

    The lever is free at FP, snaps at OP while it is pressed, snaps back at RP = OP + MD while it
    returns, and can be pressed by OT beyond OP to TTP. Positions are heights above the mounting holes.

    Attributes:
        operating_force_n: OF, at the lever's operating position.
        releasing_force_n: RF, at its releasing position.
        overtravel_mm: OT, from OP to TTP.
        movement_differential_mm: MD, from OP to RP.
        free_position_mm: FP.
        operating_position_mm: Least and greatest OP.
    """

    operating_force_n: float
    releasing_force_n: float
    overtravel_mm: float
    movement_differential_mm: float
    free_position_mm: float
    operating_position_mm: tuple[float, float]


def switch_energy_mj(switch: LeverSwitch, operating_position_mm: float) -> float:
    """Energy that one switch gives to what pressed it, as its lever returns from TTP to FP; mJ (N mm).

    The paper names the area "enclosed by the thick lines" of a figure that its text does not describe. This
    is the reading of it that gives the paper's numbers to every printed digit:

    * from TTP to RP, over OT + MD, the force falls evenly from OF to RF;
    * from RP to FP the lever follows the pressing line, which rises evenly from 0 at FP to OF at OP:
      over PT - MD, from OF (PT - MD) / PT to 0, with the pre-travel PT = FP - OP.
    """
    # PT, then the lever's ways from RP to FP and from TTP to RP.
    pre_travel_mm = switch.free_position_mm - operating_position_mm
    last_mm = pre_travel_mm - switch.movement_differential_mm
    first_mm = switch.overtravel_mm + switch.movement_differential_mm
    # Areas below the force: a trapezoid from OF to RF, then a triangle of the pressing line.
    to_releasing = first_mm * (switch.operating_force_n + switch.releasing_force_n) / 2.0
    to_free = switch.operating_force_n * last_mm**2 / (2.0 * pre_travel_mm)
    return to_releasing + to_free


def push_off_energy_mj(switch: LeverSwitch, count: int) -> tuple[float, float]:
    """Compute the least and greatest push-off energy of `count` switches, mJ.

    A deep operating position stores more.
    """
    low_mm, high_mm = switch.operating_position_mm
    return count * switch_energy_mj(switch, high_mm), count * switch_energy_mj(switch, low_mm)


def release_velocity_mm_s(energy_mj: float, mass_kg: float) -> float:
    """Velocity of a robot that takes up `energy_mj` whole: v = sqrt(2 K / m), mm/s."""
    return 1e3 * math.sqrt(2.0 * energy_mj * 1e-3 / mass_kg)


def residual_force_n(magnet_force_n: float, residual_magnetism: float) -> float:
    """Force of a magnet that is switched off, N; `residual_magnetism` is a fraction of its full force."""
    return magnet_force_n * residual_magnetism


def pause_s(clearance_mm: float, slowest_mm_s: float) -> float:
    """Time from release until a robot at `slowest_mm_s` has left the release mechanism by `clearance_mm`."""
    return clearance_mm / slowest_mm_s


_Duration = TypeVar("_Duration", float, "FloatArray")


def vertical_travel_mm(
    release_mm_s: float, duration_s: _Duration, residual_acceleration_g: float = 0.0
) -> _Duration:
    """Way of the robot down the test space in times of any shape, mm: v0 t + a t^2 / 2.

    `residual_acceleration_g` is the capsule's lag behind free fall, in units of standard gravity; the
    paper neglects it.
    """
    acceleration_mm_s2 = 1e3 * STANDARD_GRAVITY_M_S2 * residual_acceleration_g
    return release_mm_s * duration_s + acceleration_mm_s2 * duration_s**2 / 2.0


def permissible_transversal_velocity_mm_s(envelope_mm: float, radius_mm: float, duration_s: float) -> float:
    """Compute the permissible transversal velocity v_p = (r_f - d_m) / t of the paper, mm/s.

    Args:
        envelope_mm: Distance from the line of fall to the nearest wall, r_f.
        radius_mm: Greatest distance of any point of the robot from its center of mass, seen from above, d_m.
        duration_s: Duration of the drift.

    Returns:
        The sideways velocity that just takes the robot to the walls; negative if it touches them without drift.
    """
    return (envelope_mm - radius_mm) / duration_s


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


def default_facility_path() -> Path:
    """`cosmotorre.toml` in the folder of the default robot."""
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
    # The file gives the switch's figures with a prefix: they become a record of their own.
    switch = {field.name: figures.pop(f"switch_{field.name}") for field in fields(LeverSwitch)}
    tower = DropTower(
        path=file,
        name=top.text("name"),
        switch_count=top.integer("switch_count", 1, 8),
        switch=LeverSwitch(**switch),
        **figures,
    )
    # Single figures are in range by now; these may contradict one another.
    _check_together(top, tower)
    return tower


def _range(top: Table, key: str) -> tuple[float, float]:
    """Read a range of two positive numbers, the smaller one first."""
    low, high = top.numbers(key, 2)
    if not 0.0 < low <= high:
        top.fail(key, f"[{low:g}, {high:g}] is no range above zero", "Write the smaller number first.")
    return low, high


def _check_together(top: Table, tower: DropTower) -> None:
    """Numbers that contradict one another."""
    # Free fall from rest over the drop height, h = g t^2 / 2.
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
    # The highest operating position leaves the shortest pre-travel; RP must lie below FP.
    shortest_mm = switch.free_position_mm - switch.operating_position_mm[1]
    if shortest_mm <= switch.movement_differential_mm:
        top.fail(
            "switch_operating_position_mm",
            f"leaves a pre-travel of {shortest_mm:g} mm, not above the movement differential",
            "Check it against the switch's datasheet: FP - OP is above MD.",
        )
