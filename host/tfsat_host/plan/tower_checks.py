"""Whether a maneuver fits the drop tower: time, reach, drift and release, each with its number and limit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tfsat_host.dynamics.simulation import arrivals_s
from tfsat_host.maneuver import Schedule
from tfsat_host.maneuver.schedule import STROKES as SCHEDULED
from tfsat_host.plan.facility import (
    DropTower,
    pause_s,
    push_off_energy_mj,
    release_velocity_mm_s,
    residual_force_n,
    vertical_travel_mm,
)
from tfsat_host.plan.reach_envelope import (
    Envelope,
    TransversalVelocities,
    permissible_transversal_velocities,
)
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.robot import RobotModel
from tfsat_host.units import s_from_us

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
    """Run all checks of a maneuver, in the order in which a drop meets them.

    `envelope` is that of `schedule` and `robot`.
    """
    slowest, fastest = release_velocities_mm_s(tower, float(robot.mass_kg.sum()))
    return (
        *_release(tower, slowest, fastest),
        *_strokes(schedule, robot, tower, envelope, slowest),
        *_space(tower, envelope, fastest),
    )


def release_velocities_mm_s(tower: DropTower, mass_kg: float) -> tuple[float, float]:
    """Slowest and fastest release to reckon with: what the switches give this mass, and what was observed."""
    expected = [
        release_velocity_mm_s(e, mass_kg) for e in push_off_energy_mj(tower.switch, tower.switch_count)
    ]
    # Trust neither datasheet nor earlier drops alone: the wider range of both.
    velocities = (*expected, *tower.observed_release_velocity_mm_s)
    return min(velocities), max(velocities)


def _check(name: str, value: float, needed: str, limit: float, unit: str, sentence: str) -> Check:
    """`needed` is how the value must compare: at most, at least, more than."""
    at_most, beyond = needed == "at most", needed == "more than"
    # What is left to the limit; equality passes unless the value must be beyond it.
    room = limit - value if at_most else value - limit
    passed = room > _EXACT if beyond else room >= -_EXACT
    return Check(name, passed, value, limit, at_most, unit, sentence, beyond)


def _release(tower: DropTower, slowest: float, fastest: float) -> Iterator[Check]:
    residual_n = residual_force_n(tower.magnet_force_n, tower.residual_magnetism)
    low, high = tower.release_velocity_window_mm_s
    spring = (
        f"The spring pushes with {tower.spring_force_n:g} N against {residual_n:g} N of residual magnetism."
    )
    yield _check("detaching-force", tower.spring_force_n, "more than", residual_n, "N", spring)
    apart = f"The spring separates robot and magnet by {tower.spring_stroke_mm:g} mm."
    yield _check("separation", tower.spring_stroke_mm, "at least", tower.separation_needed_mm, "mm", apart)
    clear = (
        f"At {slowest:.1f} mm/s the robot is clear of the release mechanism "
        f"after {pause_s(tower.clearance_mm, slowest):.2f} s."
    )
    yield _check("slowest-release", slowest, "at least", low, "mm/s", clear)
    falls = (
        f"At {fastest:.1f} mm/s the robot falls {vertical_travel_mm(fastest, tower.fall_s):.0f} mm "
        "in the capsule before the landing."
    )
    yield _check("fastest-release", fastest, "at most", high, "mm/s", falls)


def _strokes(
    schedule: Schedule, robot: RobotModel, tower: DropTower, envelope: Envelope, slowest: float
) -> Iterator[Check]:
    start_s = schedule.strokes[0].t_s
    away = (
        f"At the first stroke, {start_s:.2f} s, even the slowest release has taken the robot "
        f"{slowest * start_s:.1f} mm away; {tower.clearance_mm:g} mm are needed."
    )
    yield _check("pause", start_s, "at least", pause_s(tower.clearance_mm, slowest), "s", away)
    # Before the first stroke the robot keeps its shape, and only falls away.
    moving = envelope.t_s >= start_s - _EXACT
    t_s, rise_mm = envelope.t_s[moving], envelope.rise_mm[moving]
    # The worst moment of the slowest release against the robot's own opening upwards.
    least = int(np.argmin(slowest * t_s - rise_mm))
    gap = (
        f"The robot's highest point comes closest to where it was held {t_s[least]:.2f} s after release: it opens "
        f"upwards by {rise_mm[least]:.0f} mm while the slowest release takes it {slowest * t_s[least]:.0f} mm down."
    )
    yield _check("clearance", float(slowest * t_s[least] - rise_mm[least]), "at least", 0.0, "mm", gap)
    moving_s = schedule.moving_s
    planned_s, tolerance_s = tower.maneuver_time_max_s, tower.maneuver_time_tolerance_s
    together = (
        f"Joints move for {moving_s:.3f} s; the fall of {tower.fall_s:g} s less a margin of "
        f"{tower.margin_s:g} s leaves {planned_s:g} s, with a tolerance of {tolerance_s:g} s."
    )
    yield _check("stroke-time", moving_s, "at most", planned_s + tolerance_s, "s", together)
    # Servos that need longer than scheduled count, too.
    end_s = max(s_from_us(schedule.end_us), *arrivals_s(robot, schedule))
    landing = f"The last stroke ends {end_s:.2f} s after release, the fall at {tower.fall_s:g} s."
    yield _check("landing", end_s, "at most", tower.fall_s, "s", landing)


def _space(tower: DropTower, envelope: Envelope, fastest: float) -> Iterator[Check]:
    permissible = permissible_transversal_velocities(envelope, tower.envelope_radius_mm, tower.fall_s)
    reach = (
        f"{envelope.max_radius_body} reaches furthest from the line of fall, {envelope.max_radius_t_s:.2f} s after "
        f"release; in its start pose the robot reaches {envelope.folded_radius_mm:.0f} mm."
    )
    yield _check("envelope", envelope.max_radius_mm, "at most", tower.envelope_radius_mm, "mm", reach)
    observed = tower.observed_transversal_velocity_mm_s
    drift = (
        f"The robot may drift sideways at {permissible.paper:.1f} mm/s ({permissible.moment_by_moment:.1f} mm/s when "
        f"each moment is taken on its own); an earlier drop showed {observed:g} mm/s."
    )
    yield _check("transversal-velocity", permissible.paper, "at least", observed, "mm/s", drift)
    falling = envelope.t_s <= tower.fall_s + _EXACT
    g = tower.residual_acceleration_g
    # The worst case downwards: fastest release, residual acceleration, and the robot's own reach below.
    travel_mm = vertical_travel_mm(fastest, envelope.t_s[falling], g)
    lowest_mm = float(np.max(travel_mm + envelope.sink_mm[falling]))
    bottom = (
        f"The fastest release and {g:g} g of residual acceleration take the robot's "
        f"lowest point {lowest_mm:.0f} mm down before the landing."
    )
    yield _check("vertical-travel", lowest_mm, "at most", tower.usable_vertical_travel_mm, "mm", bottom)


def _format_value(value: float, unit: str) -> str:
    """Times to a millisecond, all else to a tenth."""
    return f"{value:.3f} {unit}" if unit == "s" else f"{value:.1f} {unit}"


CHECK: Columns = (
    Column("name", "check"),
    Column("passed", "result", words=lambda check: "ok" if check.passed else "FAILED"),
    Column("value", "value", words=lambda check: _format_value(check.value, check.unit)),
    Column("limit", "limit", words=lambda check: f"{check.needed} {_format_value(check.limit, check.unit)}"),
    *fields("at_most unit sentence beyond"),
)


@dataclass(frozen=True, eq=False)
class TowerReport:
    """A maneuver against a drop tower.

    Attributes:
        schedule: The maneuver.
        robot: Who flies it.
        tower: Where.
        envelope: How far the robot reaches.
        checks: All of them, in the order in which a drop meets them.
        initial_rate_deg_s: Of the base at the release, as typed; None: no angular momentum.
    """

    schedule: Schedule
    robot: RobotModel
    tower: DropTower
    envelope: Envelope
    checks: tuple[Check, ...]
    initial_rate_deg_s: Sequence[float] | None = None

    @property
    def failed(self) -> list[Check]:
        """The checks that did not pass."""
        return [check for check in self.checks if not check.passed]

    @property
    def permissible(self) -> TransversalVelocities:
        """Sideways velocities that just take the robot to the walls by the landing."""
        return permissible_transversal_velocities(
            self.envelope, self.tower.envelope_radius_mm, self.tower.fall_s
        )

    @property
    def verdict(self) -> str:
        """Whether the maneuver fits, in a line."""
        if self.failed:
            names = ", ".join(check.name for check in self.failed)
            return f"DOES NOT FIT {self.tower.name}: {len(self.failed)} of {len(self.checks)} checks failed ({names})"
        return f"FITS {self.tower.name}: {len(self.checks)} of {len(self.checks)} checks passed"


def _format_reach(report: TowerReport) -> str:
    envelope = report.envelope
    return (
        f"{envelope.max_radius_mm:.0f} mm from the line of fall ({envelope.max_radius_body}, "
        f"{envelope.max_radius_t_s:.2f} s after release; by the boxes of the robot file)"
    )


REPORT: Columns = (
    Column("fits", of=lambda report: not report.failed),
    Column("checks", columns=CHECK),
    Column("max_radius_mm", "Reach", of="envelope.max_radius_mm", words=_format_reach),
    Column("max_radius_t_s", of="envelope.max_radius_t_s"),
    Column("max_radius_body", of="envelope.max_radius_body"),
    Column("folded_radius_mm", "Reach in the start pose", of="envelope.folded_radius_mm", form=".0f"),
    Column("height_mm", "Height", of="envelope.height_mm", form=".0f"),
    Column(
        "permissible_transversal_velocity_mm_s",
        "Max. sideways velocity",
        of="permissible.paper",
        words=lambda report: (
            f"{report.permissible.paper:.1f} mm/s ({report.permissible.moment_by_moment:.1f} mm/s moment by moment)"
        ),
    ),
    Column("permissible_transversal_velocity_moment_by_moment_mm_s", of="permissible.moment_by_moment"),
    Column("facility", of="tower.name"),
    Column("schedule", of="schedule.strokes", columns=SCHEDULED),
    *fields("end_s=schedule.end_s robot=robot.name initial_rate_deg_s notices=schedule.notices"),
)
"""A report as `tfsat-host envelope` shows it: all of it in `--json`, what has a label as facts for people."""
