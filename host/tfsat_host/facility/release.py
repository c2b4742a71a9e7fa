"""The release: what detaches the robot from the magnet, what pushes it off, and how far it travels.

Source: the paper, sections "Design of the release mechanism" and "Design of experiment sequence". Pure
functions of plain numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tfsat_host.units import STANDARD_GRAVITY_M_S2


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

    Raises:
        ValueError: the lever would snap back beyond its free position, PT < MD.
    """
    pre_travel_mm = switch.free_position_mm - operating_position_mm
    last_mm = pre_travel_mm - switch.movement_differential_mm
    if last_mm < 0.0:
        raise ValueError(f"a pre-travel of {pre_travel_mm:g} mm is shorter than the movement differential")
    first_mm = switch.overtravel_mm + switch.movement_differential_mm
    to_releasing = first_mm * (switch.operating_force_n + switch.releasing_force_n) / 2.0
    to_free = switch.operating_force_n * last_mm**2 / (2.0 * pre_travel_mm) if last_mm > 0.0 else 0.0
    return to_releasing + to_free


def push_off_energy_mj(switch: LeverSwitch, count: int) -> tuple[float, float]:
    """Least and greatest energy of `count` switches, mJ: a deep operating position stores more."""
    low_mm, high_mm = switch.operating_position_mm
    return count * switch_energy_mj(switch, high_mm), count * switch_energy_mj(switch, low_mm)


def release_velocity_mm_s(energy_mj: float, mass_kg: float) -> float:
    """Velocity of a robot that takes up `energy_mj` whole: v = sqrt(2 K / m), mm/s.

    Raises:
        ValueError: the mass is not above zero or the energy is negative.
    """
    if not mass_kg > 0.0 or not energy_mj >= 0.0:
        raise ValueError(f"{energy_mj:g} mJ cannot move {mass_kg:g} kg")
    return 1e3 * math.sqrt(2.0 * energy_mj * 1e-3 / mass_kg)


def residual_force_n(magnet_force_n: float, residual_magnetism: float) -> float:
    """Force of a magnet that is switched off, N; `residual_magnetism` is a fraction of its full force."""
    return magnet_force_n * residual_magnetism


def pause_s(clearance_mm: float, slowest_mm_s: float) -> float:
    """Time from release until a robot at `slowest_mm_s` has left the release mechanism by `clearance_mm`.

    Raises:
        ValueError: the velocity is not above zero: the robot would never be clear.
    """
    if not slowest_mm_s > 0.0:
        raise ValueError(f"at {slowest_mm_s:g} mm/s the robot never leaves the release mechanism")
    return clearance_mm / slowest_mm_s


def vertical_travel_mm(release_mm_s: float, duration_s: float, residual_acceleration_g: float = 0.0) -> float:
    """Way of the robot down the test space, mm: v0 t + a t^2 / 2.

    `residual_acceleration_g` is the capsule's lag behind free fall, in units of standard gravity; the
    paper neglects it.
    """
    acceleration_mm_s2 = 1e3 * STANDARD_GRAVITY_M_S2 * residual_acceleration_g
    return release_mm_s * duration_s + acceleration_mm_s2 * duration_s**2 / 2.0


def permissible_transversal_velocity_mm_s(envelope_mm: float, radius_mm: float, duration_s: float) -> float:
    """The paper's v_p = (r_f - d_m) / t, mm/s: sideways velocity that just takes the robot to the walls.

    Args:
        envelope_mm: Distance from the line of fall to the nearest wall, r_f.
        radius_mm: Greatest distance of any point of the robot from its center of mass, seen from above, d_m.
        duration_s: How long it drifts.

    Returns:
        The velocity; below zero when the robot touches the walls without any drift.

    Raises:
        ValueError: the duration is not above zero.
    """
    if not duration_s > 0.0:
        raise ValueError(f"a drift of {duration_s:g} s has no velocity")
    return (envelope_mm - radius_mm) / duration_s
