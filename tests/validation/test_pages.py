"""Pages show their campaigns' tables; each says what it was run with; a target is met or named as missed."""

from __future__ import annotations

import datetime
import re
from pathlib import Path

import pytest

from tests.paths import DOCS
from tests.validation.pages import fill_tables, find_missed, list_missed
from tests.validation.provenance import PROOFS, SHA256_ROW, Proof, read_provenance
from tests.validation.targets import Target, read_targets, targets_csv

PAGES = [page for page in sorted(DOCS.glob("*.md")) if "<!-- table: " in page.read_text(encoding="utf-8")]
TARGETS = sorted(DOCS.glob("*/targets.csv"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_shows_its_tables(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert fill_tables(text) == text, "Run: make pages"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_names_each_target_that_is_missed_and_no_other(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert list_missed(text) == find_missed(text)


@pytest.mark.parametrize("proof", PROOFS, ids=lambda proof: proof.name)
def test_a_page_shows_or_links_every_table_of_its_campaign(proof: Proof) -> None:
    pages = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for table in proof.folder.glob("*.csv"):
        assert f"{proof.name}/{table.name}" in pages, table.name


@pytest.mark.parametrize("proof", PROOFS, ids=lambda proof: proof.name)
def test_a_campaign_says_what_it_was_run_with(proof: Proof) -> None:
    provenance = read_provenance(proof.folder)
    assert re.fullmatch(r"\d+\.\d+\.\d+", provenance["version of tfsat"])
    datetime.date.fromisoformat(provenance["date of the last commit"][:10])
    assert re.fullmatch(r"[\d.]+ min|not recorded", provenance["duration"])
    assert re.fullmatch(r"[0-9a-f]{64}", provenance[SHA256_ROW])


@pytest.mark.parametrize("table", TARGETS, ids=lambda table: table.parent.name)
def test_a_target_is_called_met_where_it_is(table: Path) -> None:
    for target, met in read_targets(table):
        assert target.is_met == met, target.quantity


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "proof").mkdir()
    targets = [Target("error", 0.25, high=0.3, unit="deg"), Target("95 % hold", 99.5, 90.0, 99.0, "%")]
    (tmp_path / "proof" / "targets.csv").write_text(targets_csv(targets))
    (tmp_path / "proof" / "figures.csv").write_text(
        "of,what,value\nlink,runs,7\ncard,cuts,9\nlink,noise,none\n"
    )
    return tmp_path


def test_a_table_is_filled_in_whole_or_in_part(folder: Path) -> None:
    marks = ("figures.csv link -->\n", "targets.csv -->\nformer\n")
    page = "and\n".join(f"<!-- table: proof/{mark}<!-- end -->\n" for mark in marks)
    filled = fill_tables(page, folder)
    assert "| what | value |\n| --- | --- |\n| runs | 7 |\n| noise | none |\n" in filled
    assert (
        "| quantity | value | at least | at most | unit | met |\n| --- | --: | --: | --: | --- | --- |\n"
        in filled
    )
    assert (
        "| 95 % hold | 99.5 | 90 | 99 | % | **no** |" in filled
        and "cuts" not in filled
        and "former" not in filled
    )
    assert fill_tables(filled, folder) == filled


def test_rows_that_are_not_there_are_named(folder: Path) -> None:
    with pytest.raises(ValueError, match=r"figures\.csv has no row of 'cable'"):
        fill_tables("<!-- table: proof/figures.csv cable -->\n<!-- end -->", folder)


def test_a_missed_target_is_looked_for_in_its_section(folder: Path) -> None:
    table = "<!-- table: proof/targets.csv -->\n<!-- end -->\n\n"
    assert find_missed(table, folder) == {"95 % hold"}
    assert list_missed(
        table + "## Missed targets\n\n- **95 %\n  hold** by chance.\n\n## Next\n\n- **no**\n"
    ) == {"95 % hold"}
    assert list_missed("- **95 % hold**") == set()
