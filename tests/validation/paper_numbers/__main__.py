"""`make paper-numbers`: computes the tables of docs/paper-numbers.md."""

from __future__ import annotations

from tests.validation.paper_numbers.maneuver_rows import SEEDS
from tests.validation.paper_numbers.numbers import make_tables
from tests.validation.paper_numbers.sections import compute_sections
from tests.validation.provenance import CampaignRun


def main() -> None:
    """Write the tables."""
    run = CampaignRun("paper-numbers")
    # Seeds of the swarm are part of what the tables rest on.
    run.write(make_tables(compute_sections()), {"seeds of the particle swarm": SEEDS})
    print("Written: docs/paper-numbers")


if __name__ == "__main__":
    main()
