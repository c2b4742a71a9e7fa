"""`make paper-numbers`: every number of the paper that model, design, orbit study and facility reproduce."""

from __future__ import annotations

import sys

from tests.paths import REPOSITORY
from tests.validation.paper_numbers.facility_rows import facility_rows
from tests.validation.paper_numbers.maneuver_rows import SEEDS, maneuver_rows, schedule_rows
from tests.validation.paper_numbers.orbit_rows import orbit_rows
from tests.validation.paper_numbers.page import HEAD, section
from tests.validation.paper_numbers.result_rows import result_rows
from tests.validation.provenance import seal
from tfsat_host.plan.facility import load_tower
from tfsat_host.robot import load_robot

PAGE = REPOSITORY / "docs" / "paper-numbers.md"


def sections(*, quick: bool = False) -> list[str]:
    """The page's sections in order; `quick` without those that take long, the design and the orbit."""
    robot, tower = load_robot(), load_tower()
    swarms = (
        f"The optimum, and {SEEDS} seeds of the particle swarm with the paper's coefficients, 48 particles and 50 "
        "iterations."
    )
    rule = "Each stroke starts when the one before has ended at 170 deg/s, rounded up to 10 ms."
    orbit = (
        "A 3U CubeSat whose joints move at 30 deg/s, by four-stroke loops of every ordered pair of joints."
    )
    return [
        *([] if quick else [section("Maneuver design", swarms, maneuver_rows(robot))]),
        section("Experiment sequence", rule, schedule_rows()),
        section("Drop tower and release", "", facility_rows(robot, tower)),
        section("Result", "", result_rows(robot)),
        *([] if quick else [section("On orbit", orbit, orbit_rows(load_robot("cubesat_3u")))]),
    ]


def main() -> int:
    """Writes the page."""
    PAGE.write_text(HEAD + "\n".join([seal("paper-numbers"), *sections()]), encoding="utf-8")
    print(f"wrote {PAGE.relative_to(REPOSITORY)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
