"""docs/simulate.md: its commands run, and its tables name what there is."""

from __future__ import annotations

import re
import shlex

import numpy as np

from tests.cli.process import RunCli
from tests.cli.test_documentation import shell_examples
from tests.paths import DOCS

PAGE = DOCS / "simulate.md"
TEXT = PAGE.read_text(encoding="utf-8")


def first_cells(heading: str, column: int = 1) -> list[str]:
    """Return the names in backquotes in a column of the table below a heading."""
    section = TEXT.partition(f"## {heading}")[2].partition("\n## ")[0]
    rows = [line.split("|") for line in section.splitlines() if line.startswith("|")]
    return [name for row in rows[1:] for name in re.findall(r"`([^`]+)`", row[column])]


def test_the_commands_run_in_order_and_the_tables_are_complete(tfsat_host: RunCli) -> None:
    for example in shell_examples(PAGE):
        # Every example of the page is typed as it stands.
        program, *arguments = shlex.split(example)
        assert program == "tfsat-host"
        tfsat_host(*arguments)
    assert set(tfsat_host.json("simulate", 59, 70)) == set(first_cells("Conventions"))
    with np.load(tfsat_host.folder / "motion.npz") as archive:
        assert set(archive) == set(first_cells("The columns of `--out`", 2))
    header = (tfsat_host.folder / "motion.csv").read_text(encoding="ascii").splitlines()[0].split(",")
    stems = {re.sub(r"_[xyzw](?=_|$)", "", re.sub(r"\d", "", name)) for name in header}
    named = {name for name in first_cells("The columns of `--out`") if not name.startswith("_")}
    # Axes and numbers are left out: the page names one of each kind.
    assert stems == {re.sub(r"_[xyzw](?=_|$)", "", re.sub(r"\d", "", name)) for name in named}
