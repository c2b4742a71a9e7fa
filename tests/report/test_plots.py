"""Plots and replay show one moment and one span of time, by mouse and by keys; several drops lie over each other."""

from __future__ import annotations

import pytest

from tests.report.conftest import Opener
from tests.report.opened import Opened
from tests.report.sample_document import TIME_PLOTS, sample_document

NAMES = ("first", "second", "third")


def hover(report: Opened, plot: str, share: float) -> None:
    over = report.plot(plot).locator(".u-over")
    box = over.bounding_box()
    assert box is not None
    over.hover(position={"x": share * box["width"], "y": box["height"] / 2})


def test_the_pointer_moves_every_time_cursor_and_the_replay(report: Opened) -> None:
    at_end = report.replay_picture()
    hover(report, "rates", 0.5)
    lines, there = report.hairlines(), report.time_s
    assert len({round(lines[plot]) for plot in (*TIME_PLOTS, "timeline")}) == 1
    assert lines["rates"] > 100
    # The middle of the data, from -0.1 to 2.8 s.
    assert there == pytest.approx(1.35, abs=0.02)
    time = float(report.page.get_by_label("Time after release").input_value())
    assert time == pytest.approx(there, abs=1e-3)
    assert report.replay_picture().unlike(at_end) > 1000
    report.page.mouse.move(5, 5)
    assert report.time_s == there, "the cursor stays where the pointer left"


def test_the_legend_reads_the_line_at_the_cursor(report: Opened) -> None:
    hover(report, "joints", 0.5)
    # At 1.35 s joint 1 stands open at 59 deg.
    assert float(report.value("joints", "joint 1")) == pytest.approx(59.0, abs=3)
    report.press("Home")
    assert float(report.value("joints", "joint 1").replace("−", "-")) == pytest.approx(0.0, abs=1)


def test_spectra_share_a_cursor_of_their_own(open_document: Opener) -> None:
    report = open_document(sample_document())
    time_s = report.time_s
    assert report.hairlines()["rate_spectrum"] == 0
    hover(report, "momentum_spectrum", 0.5)
    lines = report.hairlines()
    assert lines["momentum_spectrum"] > 100
    assert lines["rate_spectrum"] == pytest.approx(lines["momentum_spectrum"], abs=1)
    report.plot("rate_spectrum").focus()
    report.press(*["ArrowRight"] * 20)
    assert report.hairlines()["momentum_spectrum"] > lines["momentum_spectrum"]
    assert report.time_s == time_s


def test_arrow_keys_move_the_cursor(report: Opened) -> None:
    # A step is 1/200 of what is shown, 2.9 s.
    step_s = 0.005 * 2.9
    report.press("Home", "ArrowRight", "ArrowRight", "ArrowRight")
    assert report.time_s == pytest.approx(-0.1 + 3 * step_s, abs=1e-3)
    report.press("ArrowLeft")
    assert report.time_s == pytest.approx(-0.1 + 2 * step_s, abs=1e-3)
    report.press("End")
    assert report.time_s == pytest.approx(2.8)
    report.press("ArrowRight")
    assert report.time_s == pytest.approx(2.8), "there is nothing after the end"


def test_keys_zoom_all_time_plots_about_the_cursor_and_back(report: Opened) -> None:
    hover(report, "rates", 0.5)
    before = {plot: report.picture(plot) for plot in (*TIME_PLOTS, "rate_spectrum")}
    cursor, time_s = report.hairlines(), report.time_s
    report.press("+", "+")
    assert all(report.picture(plot).unlike(before[plot]) > 500 for plot in TIME_PLOTS)
    assert report.picture("rate_spectrum").unlike(before["rate_spectrum"]) == 0
    assert report.hairlines() == pytest.approx(cursor, abs=1)
    report.press("ArrowRight")
    # Each + halves the span: two make steps of a quarter.
    assert report.time_s - time_s == pytest.approx(0.005 * 2.9 / 4, abs=1e-3)
    report.press("ArrowLeft", "0")
    assert all(report.picture(plot).unlike(before[plot]) == 0 for plot in TIME_PLOTS)


def test_shift_and_arrows_pan(report: Opened) -> None:
    hover(report, "rates", 0.5)
    report.press("+")
    before = report.hairlines()["rates"]
    width = report.plot("rates").locator(".u-over").evaluate("over => over.clientWidth")
    report.press("Shift+ArrowRight")
    assert before - report.hairlines()["rates"] == pytest.approx(0.1 * width, abs=2)


def test_dragging_zooms_in_and_a_double_click_shows_everything(report: Opened) -> None:
    before = report.picture("euler")
    over = report.plot("rates").locator(".u-over")
    hover(report, "rates", 0.4)
    report.page.mouse.down()
    hover(report, "rates", 0.6)
    assert report.plot("rates").locator(".selection").is_visible()
    report.page.mouse.up()
    assert report.picture("euler").unlike(before) > 500
    hover(report, "rates", 1.0 - 1e-3)
    assert report.time_s == pytest.approx(-0.1 + 0.6 * 2.9, abs=0.02)
    over.dblclick()
    hover(report, "rates", 1.0 - 1e-3)
    assert report.time_s == pytest.approx(2.8, abs=0.02)


def test_the_legend_switches_a_line_off_and_on_and_leaves_the_keys(report: Opened) -> None:
    before = report.picture("rates")
    button = report.plot("rates").get_by_role("button", name="ω y")
    button.click()
    assert button.get_attribute("aria-pressed") == "false"
    assert report.picture("rates").unlike(before) > 200
    report.press("Home", "ArrowRight")
    assert report.time_s == pytest.approx(-0.1 + 0.005 * 2.9, abs=1e-3)
    button.click()
    assert report.picture("rates").unlike(before) == 0


def test_several_drops_stand_side_by_side_and_behind_each_other(open_document: Opener) -> None:
    report = open_document(sample_document(NAMES))
    table = report.page.locator("table.comparison")
    assert table.locator("thead th").all_inner_texts() == ["Key number", "A first", "B second", "C third"]
    rows = [row.locator("th, td").all_inner_texts() for row in table.locator("tbody tr").all()]
    assert [text.replace("\n", " ") for text in rows[0]] == ["Verdict", "✓ Good", "! Doubtful", "✕ Failed"]
    assert rows[1][0] == "Reorientation"
    assert len(set(rows[1][1:])) == 3 and all("± 0.083 deg" in cell for cell in rows[1][1:])
    all_three, others = report.picture("rates"), report.page.get_by_label("in the plots")
    others.nth(1).uncheck()
    two = report.picture("rates")
    others.nth(2).uncheck()
    assert two.unlike(all_three) > 300 and report.picture("rates").unlike(two) > 300
    others.nth(1).check()
    others.nth(2).check()
    assert report.picture("rates").unlike(all_three) == 0


def test_choosing_another_drop_shows_all_of_it(open_document: Opener) -> None:
    report = open_document(sample_document(NAMES))
    report.page.get_by_label("Time after release").fill("1.4")
    before, drops = report.replay_picture(), report.page.locator("input[name=drop]")
    drops.nth(1).check()
    assert report.page.locator(".verdict .level").inner_text() == "!\nDoubtful"
    assert report.time_s == pytest.approx(1.4), "the moment stays"
    assert report.replay_picture().unlike(before) > 300
    moved = report.replay_picture()
    report.plot("rates").focus()
    report.press("Home")
    assert report.replay_picture().unlike(moved) > 1000
    drops.nth(2).check()
    assert report.page.locator(".verdict .level").inner_text() == "✕\nFailed"


def test_drops_that_lack_something_or_are_longer_overlay(open_document: Opener) -> None:
    document = sample_document(NAMES[:2])
    document["drops"][1] = sample_document(NAMES[:2], samples=97)["drops"][1]
    document["drops"][1]["key_numbers"].pop(0)
    document["drops"][1]["plots"].pop(0)
    report = open_document(document)
    table = report.page.locator("table.comparison")
    assert table.locator("tr", has_text="Reorientation").locator("td").last.inner_text() == "–"
    with_both = report.picture("joints")
    report.page.get_by_label("in the plots").nth(1).uncheck()
    assert report.picture("joints").unlike(with_both) > 300
    assert report.plot("euler").count() == 1
    report.page.locator("input[name=drop]").nth(1).check()
    assert report.plot("euler").count() == 0
