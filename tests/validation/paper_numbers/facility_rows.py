"""The numbers of the sections on the facility and the release mechanism."""

from __future__ import annotations

from tests.validation.paper_numbers.numbers import GIVEN, Row, row
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.plan.facility import (
    DropTower,
    pause_s,
    permissible_transversal_velocity_mm_s,
    push_off_energy_mj,
    release_velocity_mm_s,
    residual_force_n,
)
from tfsat_host.plan.reach_envelope import envelope_of
from tfsat_host.robot import RobotModel

PAPERS_ENVELOPE_MM = 100.0


def facility_rows(robot: RobotModel, tower: DropTower) -> list[Row]:
    """Envelope, release velocity, spring and pause."""
    # Switch energies bound the push-off velocity from below and above.
    low_mj, high_mj = push_off_energy_mj(tower.switch, tower.switch_count)
    mass_kg = float(robot.mass_kg.sum())
    envelope = envelope_of(robot, schedule_maneuver(four_stroke(59.0, 70.0)), until_s=tower.fall_s)
    radius = tower.envelope_radius_mm
    # By our envelope, not the paper's: the robot swings farther than it assumed.
    permissible_with_ours_mm_s = permissible_transversal_velocity_mm_s(
        radius, envelope.max_radius_mm, tower.fall_s
    )
    return [
        row(
            "permissible transversal velocity",
            "26",
            # Transversal velocity that keeps the robot inside the tower for the whole fall.
            permissible_transversal_velocity_mm_s(radius, PAPERS_ENVELOPE_MM, tower.fall_s),
            unit="mm/s",
        ),
        row(
            "maximum envelope of the moving robot",
            "100",
            envelope.max_radius_mm,
            unit="mm",
            details={
                "farthest corner": f"{envelope.max_radius_body} at {envelope.max_radius_t_s:.2f} s",
                "folded": f"{envelope.folded_radius_mm:.0f} mm",
                "permissible velocity with ours": f"{permissible_with_ours_mm_s:.0f} mm/s",
            },
        ),
        row(
            "least energy of both switches",
            "2.35",
            low_mj,
            unit="mJ",
        ),
        row("greatest energy of both switches", "3.12", high_mj, unit="mJ"),
        row(
            "least release velocity",
            "40.6",
            release_velocity_mm_s(low_mj, mass_kg),
            unit="mm/s",
            details={"from the rounded 2.35 mJ": f"{release_velocity_mm_s(2.35, mass_kg):.1f} mm/s"},
        ),
        row("greatest release velocity", "46.8", release_velocity_mm_s(high_mj, mass_kg), unit="mm/s"),
        row(
            "residual magnetic force",
            "10",
            residual_force_n(tower.magnet_force_n, tower.residual_magnetism),
            unit="N",
        ),
        Row(
            "detaching force of the spring",
            "11.1 N",
            f"{tower.spring_force_n:.1f}",
            GIVEN,
        ),
        row(
            "pause before the first stroke",
            "0.7",
            # The pause: clearance divided by the observed release velocity.
            pause_s(tower.clearance_mm, tower.observed_release_velocity_mm_s[0]),
            unit="s",
        ),
    ]
