"""Whether a maneuver fits the drop tower: time, reach, drift and release, each with its number and limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.dynamics.flying import arrivals_s
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.envelope import Envelope, permissible_transversal_velocities
from tfsat_host.plan.facility import (
    DropTower,
    pause_s,
    push_off_energy_mj,
    release_velocity_mm_s,
    residual_force_n,
    vertical_travel_mm,
)
from tfsat_host.robot import RobotModel
from tfsat_host.units import US_PER_S

_EXACT = 1e-9  # below what any of the numbers means: 0.7 s is not refused for its binary digits


@dataclass(frozen=True, slots=True)
class Check:
    """One comparison.

    Attributes:
        name: Stable; scripts rely on it.
        passed: Whether the maneuver may fly as far as this goes.
        value: What was found.
        limit: What it was compared with.
        at_most: Whether `limit` is the greatest permitted value; else it is the least.
        beyond: Whether the value must be beyond the limit: equal to it does not pass.
        unit: Of both.
        sentence: What it means, for a person.
    """

    name: str
    passed: bool
    value: float
    limit: float
    at_most: bool
    unit: str
    sentence: str
    beyond: bool = False

    @property
    def needed(self) -> str:
        """How the value must compare with the limit, in words."""
        if self.beyond:
            return "less than" if self.at_most else "more than"
        return "at most" if self.at_most else "at least"


def check_maneuver(
    schedule: Schedule, robot: RobotModel, tower: DropTower, envelope: Envelope
) -> tuple[Check, ...]:
    """All checks, in the order in which a drop meets them; `envelope` is that of `schedule` and `robot`."""
    slowest, fastest = release_velocities_mm_s(tower, float(robot.mass_kg.sum()))
    return (
        *_release(tower, slowest, fastest),
        _pause(schedule, tower, slowest),
        _clearance(schedule, envelope, slowest),
        _stroke_time(schedule, tower),
        _landing(schedule, robot, tower),
        *_walls(tower, envelope),
        _bottom(tower, envelope, fastest),
    )


def release_velocities_mm_s(tower: DropTower, mass_kg: float) -> tuple[float, float]:
    """Slowest and fastest release to reckon with: what the switches give this mass, and what was observed."""
    expected = [
        release_velocity_mm_s(e, mass_kg) for e in push_off_energy_mj(tower.switch, tower.switch_count)
    ]
    return min(*expected, tower.slowest_release_mm_s), max(*expected, tower.fastest_release_mm_s)


def _at_most(name: str, value: float, limit: float, unit: str, sentence: str) -> Check:
    return Check(name, value <= limit + _EXACT, value, limit, True, unit, sentence)


def _at_least(name: str, value: float, limit: float, unit: str, sentence: str) -> Check:
    return Check(name, value >= limit - _EXACT, value, limit, False, unit, sentence)


def _more_than(name: str, value: float, limit: float, unit: str, sentence: str) -> Check:
    return Check(name, value > limit + _EXACT, value, limit, False, unit, sentence, beyond=True)


def _release(tower: DropTower, slowest: float, fastest: float) -> tuple[Check, ...]:
    held = residual_force_n(tower.magnet_force_n, tower.residual_magnetism)
    low, high = tower.release_velocity_window_mm_s
    return (
        _more_than(
            "detaching-force",
            tower.spring_force_n,
            held,
            "N",
            f"The spring pushes with {tower.spring_force_n:g} N against {held:g} N of residual magnetism.",
        ),
        _at_least(
            "separation",
            tower.spring_stroke_mm,
            tower.separation_needed_mm,
            "mm",
            f"The spring separates robot and magnet by {tower.spring_stroke_mm:g} mm.",
        ),
        _at_least(
            "slowest-release",
            slowest,
            low,
            "mm/s",
            f"At {slowest:.1f} mm/s the robot is clear of the release mechanism "
            f"after {pause_s(tower.clearance_mm, slowest):.2f} s.",
        ),
        _at_most(
            "fastest-release",
            fastest,
            high,
            "mm/s",
            f"At {fastest:.1f} mm/s the robot falls {vertical_travel_mm(fastest, tower.fall_s):.0f} mm "
            "in the capsule before the landing.",
        ),
    )


def _pause(schedule: Schedule, tower: DropTower, slowest: float) -> Check:
    start_s = schedule.strokes[0].t_s
    return _at_least(
        "pause",
        start_s,
        pause_s(tower.clearance_mm, slowest),
        "s",
        f"At the first stroke, {start_s:.2f} s, even the slowest release has taken the robot "
        f"{slowest * start_s:.1f} mm away; {tower.clearance_mm:g} mm are needed.",
    )


def _clearance(schedule: Schedule, envelope: Envelope, slowest: float) -> Check:
    moving = envelope.t_s >= schedule.strokes[0].t_s - _EXACT
    gap_mm = slowest * envelope.t_s[moving] - envelope.rise_mm[moving]
    least = int(np.argmin(gap_mm))
    t_s = envelope.t_s[moving][least]
    return _at_least(
        "clearance",
        float(gap_mm[least]),
        0.0,
        "mm",
        f"The robot's highest point comes closest to where it was held {t_s:.2f} s after release: it opens "
        f"upwards by {envelope.rise_mm[moving][least]:.0f} mm while the slowest release "
        f"takes it {slowest * t_s:.0f} mm down.",
    )


def _stroke_time(schedule: Schedule, tower: DropTower) -> Check:
    moving_s = sum(abs(stroke.angle_deg) for stroke in schedule.strokes) / schedule.speed_deg_s
    planned_s, tolerance_s = tower.maneuver_time_max_s, tower.maneuver_time_tolerance_s
    return _at_most(
        "stroke-time",
        moving_s,
        planned_s + tolerance_s,
        "s",
        f"The strokes take {moving_s:.3f} s together; the fall of {tower.fall_s:g} s less a margin of "
        f"{tower.margin_s:g} s leaves {planned_s:g} s, with a tolerance of {tolerance_s:g} s.",
    )


def _landing(schedule: Schedule, robot: RobotModel, tower: DropTower) -> Check:
    end_s = max(schedule.end_us / US_PER_S, *arrivals_s(robot, schedule))
    return _at_most(
        "landing",
        end_s,
        tower.fall_s,
        "s",
        f"The last stroke ends {end_s:.2f} s after release, the fall at {tower.fall_s:g} s.",
    )


def _walls(tower: DropTower, envelope: Envelope) -> tuple[Check, ...]:
    permissible = permissible_transversal_velocities(envelope, tower.envelope_radius_mm, tower.fall_s)
    observed = tower.observed_transversal_velocity_mm_s
    return (
        _at_most(
            "envelope",
            envelope.max_radius_mm,
            tower.envelope_radius_mm,
            "mm",
            f"{envelope.max_radius_body} reaches furthest from the line of fall, "
            f"{envelope.max_radius_t_s:.2f} s after release; in its start pose the robot reaches "
            f"{envelope.folded_radius_mm:.0f} mm.",
        ),
        _at_least(
            "transversal-velocity",
            permissible.paper,
            observed,
            "mm/s",
            f"The robot may drift sideways at {permissible.paper:.1f} mm/s "
            f"({permissible.moment_by_moment:.1f} mm/s when each moment is taken by itself); "
            f"an earlier drop showed {observed:g} mm/s.",
        ),
    )


def _bottom(tower: DropTower, envelope: Envelope, fastest: float) -> Check:
    falling = envelope.t_s <= tower.fall_s + _EXACT
    travel_mm = np.array(
        [vertical_travel_mm(fastest, t, tower.residual_acceleration_g) for t in envelope.t_s[falling]]
    )
    lowest_mm = float(np.max(travel_mm + envelope.sink_mm[falling]))
    return _at_most(
        "vertical-travel",
        lowest_mm,
        tower.usable_vertical_travel_mm,
        "mm",
        f"The fastest release and {tower.residual_acceleration_g:g} g of residual acceleration take the robot's "
        f"lowest point {lowest_mm:.0f} mm down before the landing.",
    )
