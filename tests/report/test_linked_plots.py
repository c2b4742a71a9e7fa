"""Plots and replay show one moment and one span of time, by mouse and by keys."""

from __future__ import annotations

import pytest

from tests.report.conftest import OpenDocument
from tests.report.opened import Opened
from tests.report.sample_document import END_S, sample_document

TIME_PLOTS = ("euler", "rates", "joints", "momentum", "attitude_error")


@pytest.fixture
def report(open_document: OpenDocument) -> Opened:
    return open_document(sample_document())


def hover(report: Opened, plot: str, share: float) -> None:
    over = report.plot(plot).locator(".u-over")
    box = over.bounding_box()
    assert box is not None
    over.hover(position={"x": share * box["width"], "y": box["height"] / 2})


def test_the_pointer_moves_every_time_cursor_and_the_replay(report: Opened) -> None:
    at_start = report.replayed()
    hover(report, "rates", 0.5)
    lines = report.hairlines()
    assert len({round(lines[plot]) for plot in (*TIME_PLOTS, "timeline")}) == 1
    assert lines["rates"] > 100 and lines["rate_spectrum"] == 0
    assert report.time_s == pytest.approx(1.35, abs=0.02)
    assert float(report.page.get_by_label("Time after release").input_value()) == pytest.approx(
        report.time_s, abs=1e-3
    )
    assert report.replayed().unlike(at_start) > 1000


def test_the_cursor_stays_where_the_pointer_left(report: Opened) -> None:
    hover(report, "rates", 0.5)
    there = report.time_s
    report.page.mouse.move(5, 5)
    assert report.time_s == there


def test_the_legend_reads_the_line_at_the_cursor(report: Opened) -> None:
    hover(report, "joints", 0.5)
    assert float(report.value("joints", "joint 1")) == pytest.approx(59.0, abs=3)
    report.press("Home")
    assert float(report.value("joints", "joint 1").replace("−", "-")) == pytest.approx(0.0, abs=1)


def test_spectra_share_a_cursor_of_their_own(report: Opened) -> None:
    hover(report, "momentum_spectrum", 0.5)
    lines = report.hairlines()
    assert lines["momentum_spectrum"] > 100
    assert lines["rate_spectrum"] == pytest.approx(lines["momentum_spectrum"], abs=1)
    assert report.time_s == pytest.approx(END_S)


def test_arrow_keys_move_the_cursor(report: Opened) -> None:
    report.press("Home")
    report.press("ArrowRight", "ArrowRight", "ArrowRight")
    assert report.time_s == pytest.approx(-0.1 + 3 * 0.005 * 2.9, abs=1e-3)
    report.press("ArrowLeft")
    assert report.time_s == pytest.approx(-0.1 + 2 * 0.005 * 2.9, abs=1e-3)
    report.press("End")
    assert report.time_s == pytest.approx(2.8)
    report.press("ArrowRight")
    assert report.time_s == pytest.approx(2.8), "there is nothing after the end"


def test_arrow_keys_on_a_spectrum_leave_time_alone(report: Opened) -> None:
    report.plot("rate_spectrum").focus()
    report.press(*["ArrowRight"] * 20)
    assert report.hairlines()["momentum_spectrum"] > 20
    assert report.time_s == pytest.approx(END_S)


def test_keys_still_move_the_cursor_after_a_click_on_the_legend(report: Opened) -> None:
    report.plot("rates").get_by_role("button", name="ω y").click()
    report.press("Home", "ArrowRight")
    assert report.time_s == pytest.approx(-0.1 + 0.005 * 2.9, abs=1e-3)
    report.press("End")
    assert report.time_s == pytest.approx(2.8)


def test_keys_zoom_all_time_plots_about_the_cursor_and_back(report: Opened) -> None:
    hover(report, "rates", 0.5)
    before = {plot: report.picture(plot) for plot in (*TIME_PLOTS, "rate_spectrum")}
    cursor, time_s = report.hairlines(), report.time_s
    report.press("+", "+")
    assert all(report.picture(plot).unlike(before[plot]) > 500 for plot in TIME_PLOTS)
    assert report.picture("rate_spectrum").unlike(before["rate_spectrum"]) == 0
    assert report.hairlines() == pytest.approx(cursor, abs=1)
    report.press("ArrowRight")
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


def test_the_legend_switches_a_line_off_and_on(report: Opened) -> None:
    before = report.picture("rates")
    button = report.plot("rates").get_by_role("button", name="ω y")
    button.click()
    assert button.get_attribute("aria-pressed") == "false"
    assert report.picture("rates").unlike(before) > 200
    button.click()
    assert report.picture("rates").unlike(before) == 0
