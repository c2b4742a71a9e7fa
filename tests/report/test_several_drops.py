"""Several drops: one in front, the others behind it by letter, and their numbers side by side."""

from __future__ import annotations

import pytest

from tests.report.conftest import OpenDocument
from tests.report.opened import Opened
from tests.report.sample_document import sample_document

NAMES = ("first", "second", "third")


@pytest.fixture
def report(open_document: OpenDocument) -> Opened:
    return open_document(sample_document(NAMES))


def test_their_key_numbers_stand_side_by_side(report: Opened) -> None:
    table = report.page.locator("table.comparison")
    assert table.locator("thead th").all_inner_texts() == ["Key number", "A first", "B second", "C third"]
    rows = [row.locator("th, td").all_inner_texts() for row in table.locator("tbody tr").all()]
    assert [text.replace("\n", " ") for text in rows[0]] == ["Verdict", "✓ Good", "! Doubtful", "✕ Failed"]
    assert rows[1][0] == "Reorientation"
    assert len(set(rows[1][1:])) == 3 and all("± 0.083 deg" in cell for cell in rows[1][1:])


def test_a_number_that_one_drop_lacks_is_a_dash(open_document: OpenDocument) -> None:
    document = sample_document(NAMES[:2])
    document["drops"][1]["key_numbers"].pop(0)
    table = open_document(document).page.locator("table.comparison")
    assert table.locator("tr", has_text="Reorientation").locator("td").last.inner_text() == "–"


def test_the_others_lie_behind_and_can_be_taken_away(report: Opened) -> None:
    both = report.picture("rates")
    report.page.get_by_label("in the plots").nth(1).uncheck()
    one = report.picture("rates")
    assert one.unlike(both) > 300
    report.page.get_by_label("in the plots").nth(2).uncheck()
    none = report.picture("rates")
    assert none.unlike(one) > 300
    report.page.get_by_label("in the plots").nth(1).check()
    report.page.get_by_label("in the plots").nth(2).check()
    assert report.picture("rates").unlike(both) == 0


def test_choosing_another_drop_shows_all_of_it(report: Opened) -> None:
    report.page.get_by_label("Time after release").fill("1.4")
    before = report.replayed()
    report.page.locator("input[name=drop]").nth(1).check()
    assert report.page.locator(".verdict .level").inner_text() == "!\nDoubtful"
    assert report.time_s == pytest.approx(1.4), "the moment stays"
    assert report.replayed().unlike(before) > 300
    moved = report.replayed()
    report.plot("rates").focus()
    report.press("Home")
    assert report.replayed().unlike(moved) > 1000


def test_a_plot_that_only_one_drop_has_is_shown_there(open_document: OpenDocument) -> None:
    document = sample_document(NAMES[:2])
    document["drops"][1]["plots"].pop(0)
    report = open_document(document)
    assert report.plot("euler").count() == 1
    report.page.locator("input[name=drop]").nth(1).check()
    assert report.plot("euler").count() == 0


def test_drops_of_different_lengths_and_rates_overlay(open_document: OpenDocument) -> None:
    document = sample_document(NAMES[:2])
    document["drops"][1] = sample_document(NAMES[:2], samples=97)["drops"][1]
    report = open_document(document)
    with_both = report.picture("joints")
    report.page.get_by_label("in the plots").nth(1).uncheck()
    assert report.picture("joints").unlike(with_both) > 300


def test_one_drop_needs_no_choice(open_document: OpenDocument) -> None:
    report = open_document(sample_document())
    assert report.page.locator(".drops, .comparison").count() == 0
