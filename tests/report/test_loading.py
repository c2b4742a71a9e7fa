"""The page opens offline, without a complaint, and has drawn everything by then."""

from __future__ import annotations

import sys

import pytest

from tests.report.conftest import OpenDocument
from tests.report.sample_document import sample_document
from tfsat_host.report import render

TIME_PLOTS = ("euler", "rates", "joints", "momentum", "attitude_error")
SPECTRA = ("momentum_spectrum", "rate_spectrum", "error_spectrum")


def test_opens_with_all_its_parts(open_document: OpenDocument) -> None:
    report = open_document(sample_document())
    assert report.page.title() == "Drop tower robot, maneuver 59/70: drop 1"
    assert report.page.locator("h2").all_inner_texts() == [
        "✓\nGood",
        "Key numbers",
        "What could not be used",
        "The drop over time",
        "Spectra",
        "Details",
    ]
    assert report.page.locator("figure.plot").count() == len(TIME_PLOTS) + len(SPECTRA) + 1
    assert report.page.locator(".table > p").count() == 3
    took_ms = report.page.evaluate("performance.getEntriesByType('navigation')[0].loadEventEnd")
    sys.stdout.write(f"report of one drop opened in {took_ms:.0f} ms\n")


def test_plots_draw_their_lines(open_document: OpenDocument) -> None:
    report = open_document(sample_document())
    for plot in TIME_PLOTS + SPECTRA:
        color = "#1c2430" if plot == "attitude_error" else "#0072b2"
        assert report.picture(plot).count(color) > 100, plot


def test_strokes_are_shaded_in_every_time_plot(open_document: OpenDocument) -> None:
    document = sample_document()
    with_events = open_document(document)
    shaded = {plot: with_events.picture(plot).drawn() for plot in TIME_PLOTS}
    document["drops"][0]["events"] = []
    without = open_document(document)
    for plot, count in shaded.items():
        assert count > 1.5 * without.picture(plot).drawn(), plot


def test_the_band_below_the_cutoff_is_shaded(open_document: OpenDocument) -> None:
    document = sample_document()
    with_band = open_document(document)
    shaded = with_band.picture("rate_spectrum").drawn()
    document["drops"][0]["plots"][6]["band"] = None
    without = open_document(document)
    assert shaded > 1.2 * without.picture("rate_spectrum").drawn()


def test_uncertainty_is_a_band(open_document: OpenDocument) -> None:
    document = sample_document()
    joints = document["drops"][0]["plots"][2]
    for series in joints["series"]:
        series["std"] = None if series["std"] is None else [10.0] * len(series["values"])
    wide = open_document(document)
    for series in joints["series"]:
        series["std"] = None
    none = open_document(document)
    assert wide.picture("joints").drawn() > none.picture("joints").drawn() + 3000


@pytest.mark.parametrize("width", [360, 768, 1440])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_fits_every_screen(open_document: OpenDocument, width: int, scheme: str) -> None:
    report = open_document(sample_document(), viewport={"width": width, "height": 800}, color_scheme=scheme)
    assert report.page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_dark_screen_gets_dark_plots(open_document: OpenDocument) -> None:
    report = open_document(sample_document(), color_scheme="dark")
    assert report.picture("rates").count("#56b4e9") > 100
    report.page.emulate_media(color_scheme="light")
    report.page.wait_for_function("matchMedia('(prefers-color-scheme: light)').matches")
    assert report.picture("rates").count("#0072b2") > 100


def test_one_drop_of_800_samples_stays_small() -> None:
    assert len(render(sample_document(samples=800)).encode()) <= 1.5e6
