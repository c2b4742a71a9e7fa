"""`make paper-numbers`: every number of the paper that model, design, orbit study and facility reproduce."""

from __future__ import annotations

import sys

from tests.cpp.compiling import REPOSITORY
from tests.paper_numbers.facility_rows import facility_rows
from tests.paper_numbers.maneuver_rows import SEEDS, maneuver_rows, schedule_rows
from tests.paper_numbers.orbit_rows import orbit_rows
from tests.paper_numbers.page import HEAD, section
from tests.paper_numbers.result_rows import result_rows
from tfsat_host.plan.facility import load_tower
from tfsat_host.robot import load_robot

PAGE = REPOSITORY / "docs" / "paper-numbers.md"


def page() -> str:
    """The whole page."""
    robot, cubesat, tower = load_robot(), load_robot("cubesat_3u"), load_tower()
    return "\n".join(
        [
            HEAD,
            section(
                "Maneuver design",
                "The robot's model, the optimization of its maneuver, and the particle swarm with the "
                "paper's coefficients, 48 particles and 50 "
                f"iterations, from {SEEDS} seeds.",
                maneuver_rows(robot),
            ),
            section(
                "Experiment sequence",
                "Each stroke starts when the one before has ended at 170 deg/s, rounded up to 10 ms.",
                schedule_rows(),
            ),
            section(
                "Drop tower and release",
                "COSMOTORRE, the electromagnet, its spring and two OMRON SS-5GL switches.",
                facility_rows(robot, tower),
            ),
            section(
                "Result",
                "The drop, and how well the model explained it. `tfsat-host evaluate` does the same with the "
                "uncertainty that the paper does not give.",
                result_rows(robot),
            ),
            section(
                "On orbit",
                "A 3U CubeSat whose joints move at 30 deg/s, by four-stroke loops of every ordered pair "
                "of joints.",
                orbit_rows(cubesat),
            ),
        ]
    )


def main() -> int:
    """Writes the page."""
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE.relative_to(REPOSITORY)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
