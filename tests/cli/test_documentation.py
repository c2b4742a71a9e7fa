"""What the README tells people to type does what it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.paths import REPOSITORY

DOCUMENTS = sorted(
    [*REPOSITORY.glob("*.md"), *REPOSITORY.glob("docs/**/*.md"), *REPOSITORY.glob("protocol/*.md")]
)


def shell_examples(document: Path) -> list[str]:
    """Return the lines of the document's `sh` blocks."""
    blocks = re.findall(r"```sh\n(.*?)```", document.read_text(encoding="utf-8"), flags=re.DOTALL)
    return [line for block in blocks for line in block.splitlines() if line.strip()]


def test_examples_of_the_readme_run_in_order(tfsat_host: RunCli) -> None:
    """Run the README's examples in order: a rehearsal leaves the files that the quick start names."""
    examples = shell_examples(REPOSITORY / "README.md")
    assert len(examples) >= 5
    for example in examples:
        program, *arguments = shlex.split(example)
        assert program == "tfsat-host"
        tfsat_host(*arguments)
    run = tfsat_host.folder / "run"
    names = (path.name + "/" * path.is_dir() for path in run.iterdir() if not path.name.startswith("."))
    # The session differs from run to run.
    file_names = {re.sub(r"-[0-9a-f]{8}\.", "-SESSION.", name) for name in names}
    rows = re.findall(
        r"^\| (`.*?) \|", (REPOSITORY / "docs/guide/quick-start.md").read_text("utf-8"), re.MULTILINE
    )
    assert {name for row in rows for name in re.findall(r"`([^`]+)`", row)} == file_names


def anchors(document: Path) -> set[str]:
    """Return the anchors of the document's headings, as GitHub and Sphinx make them."""
    headings = re.findall(r"^#+ (.*)$", document.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(REPOSITORY).as_posix())
def test_links_lead_somewhere(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    for path, anchor in re.findall(r"\]\(([^)#]*)(?:#([^)]*))?\)", text):
        if not path.startswith(("http:", "https:", "mailto:")):
            target = document.parent / path if path else document
            assert target.exists(), path
            # The anchor must be a heading of the page that it leads to.
            assert not anchor or target.suffix != ".md" or anchor in anchors(target), f"{path}#{anchor}"


def test_commands_named_in_the_readme_exist(tfsat_host: RunCli) -> None:
    overview = tfsat_host("--help").stdout
    for command in set(
        re.findall(r"`tfsat-host ([a-z-]+)", (REPOSITORY / "README.md").read_text(encoding="utf-8"))
    ):
        assert f"    {command}" in overview, command
