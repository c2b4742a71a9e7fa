"""Every number of the paper that model, design, orbit study and facility reproduce, by section."""

from __future__ import annotations

from tests.validation.paper_numbers.facility_rows import facility_rows
from tests.validation.paper_numbers.maneuver_rows import maneuver_rows, schedule_rows
from tests.validation.paper_numbers.numbers import Sections
from tests.validation.paper_numbers.orbit_rows import orbit_rows
from tests.validation.paper_numbers.result_rows import result_rows
from tfsat_host.plan.facility import load_tower
from tfsat_host.robot import load_robot


def compute_sections(*, quick: bool = False) -> Sections:
    """Compute the sections of the page in order; `quick` without those that take long, the design and the orbit."""
    robot, tower = load_robot(), load_tower()
    # The expensive sections take minutes: the short test leaves them out.
    dear = {} if quick else {"Maneuver design": maneuver_rows(robot)}
    cheap = {
        "Experiment sequence": schedule_rows(),
        "Drop tower and release": facility_rows(robot, tower),
        "Result": result_rows(robot),
    }
    return {**dear, **cheap, **({} if quick else {"On orbit": orbit_rows(load_robot("cubesat_3u"))})}
