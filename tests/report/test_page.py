"""The page in a browser: it opens offline without a complaint, reads well on screen and paper, and stays text."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import cycle
from typing import Any

import pytest

from tests.report.conftest import Opener
from tests.report.opened import Opened
from tests.report.sample_document import SPECTRA, TIME_PLOTS, sample_document

# 210 mm less two margins of 14 mm, at 96 px per inch.
A4_BETWEEN_MARGINS_PX = 688
# Two digits of the standard deviation; without one, four of the value; a dash without a value.
NUMBERS = [
    ((23.3149, 0.1234, "deg"), "23.31 ± 0.12 deg"),
    ((-7.1049, 2.31, "mm"), "−7.1 ± 2.3 mm"),
    ((1234.4, 67.0, "g"), "1234 ± 67 g"),
    ((12.0, 0.0996, "deg"), "12.000 ± 0.100 deg"),
    ((0.0, 0.5, "deg"), "0.00 ± 0.50 deg"),
    ((-0.0004, 0.5, "deg"), "0.00 ± 0.50 deg"),
    ((3.1e-5, 4.2e-6, "N m s"), "(3.10 ± 0.42)×10⁻⁵ N m s"),
    ((2.5349, None, "s"), "2.535 s"),
    ((0.0, None, "s"), "0 s"),
    ((6.02e23, None, ""), "6.020×10²³"),
    ((None, 0.3, "deg"), "–"),
]
# Ways out of text: attributes, elements, comments, templates, controls, names of JavaScript's own.
HOSTILE = (
    "\"><iframe src='javascript:window.injected=5'></iframe><img src=x onerror='window.injected = 4'>"
    "]]></script><svg onload='window.injected = 3'></script><script>window.injected = 2</script>"
    "<script>window.injected = 1</script>{{7*7}} ${window.injected = 6} javascript:window.injected=7"
    "line\u2028separator\u2029paragraph\x00nul\x1b[31mescape\u202eright to left\u202d"
    "lone surrogate \udc80\ud800 of a broken log<!--<script>",
    "constructor",
    "__proto__",
    "W" * 100_000,
    "",
)
COUNTS = """() => ["script", "img", "iframe", "svg", "link", "a:not([href^='#'])", "base", "object"].map(
  those => document.querySelectorAll(those).length)"""


def test_opens_with_all_its_parts(report: Opened) -> None:
    assert report.page.title() == "Drop tower robot, maneuver 59/70: drop 1"
    assert report.page.locator("h2").all_inner_texts() == [
        "✓\nGood",
        "Prediction and measurement, release to 2.50 s",
        "Strokes",
        "Key numbers",
        "Data not used, default values",
        "The drop over time",
        "Spectra",
        "Details",
    ]
    assert report.page.locator("figure.plot").count() == len(TIME_PLOTS) + len(SPECTRA) + 1
    assert report.page.locator(".table > p").count() == 3
    assert report.page.locator(".drops, .comparison").count() == 0, "one drop needs no choice"
    for plot in TIME_PLOTS + SPECTRA:
        # Blue of Okabe and Ito, which colour-blind readers can tell; the error is drawn in the text's colour.
        color = "#1c2430" if plot == "attitude_error" else "#0072b2"
        assert report.picture(plot).count(color) > 100, plot


def test_strokes_bands_and_uncertainty_are_shaded(report: Opened, open_document: Opener) -> None:
    # The same page without its shadings: the difference in pixels is theirs.
    document = sample_document()
    drop = document["drops"][0]
    drop["events"] = []
    drop["plots"][6]["band"] = None
    for series in drop["plots"][2]["series"]:
        series["std"] = series["std"] and [10.0] * len(series["values"])
    without = open_document(document)
    for plot in (name for name in TIME_PLOTS if name != "joints"):
        assert (
            report.picture(plot).count_visible_pixels() > 1.5 * without.picture(plot).count_visible_pixels()
        ), plot
    assert (
        report.picture("rate_spectrum").count_visible_pixels()
        > 1.2 * without.picture("rate_spectrum").count_visible_pixels()
    )
    for series in drop["plots"][2]["series"]:
        series["std"] = None
    none = open_document(document)
    assert (
        without.picture("joints").count_visible_pixels()
        > none.picture("joints").count_visible_pixels() + 3000
    )


def test_fits_every_screen_by_day_and_night(open_document: Opener) -> None:
    report = open_document(sample_document(), color_scheme="dark")
    assert report.picture("rates").count("#56b4e9") > 100
    for scheme in ("dark", "light"):
        report.page.emulate_media(color_scheme=scheme)
        report.page.wait_for_function(f"matchMedia('(prefers-color-scheme: {scheme})').matches")
        # Telephone, tablet, desktop: nothing may have to be scrolled sideways.
        for width in (360, 768, 1440):
            report.page.set_viewport_size({"width": width, "height": 800})
            assert report.page.evaluate("document.documentElement.scrollWidth") <= width, (scheme, width)
    assert report.picture("rates").count("#0072b2") > 100


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_prints_whole_and_light(open_document: Opener, scheme: str) -> None:
    report = open_document(sample_document(("one", "two")), color_scheme=scheme)
    before = report.picture("rates")
    # What the plots are on paper, taken while the browser prints: its last word before the page is laid out.
    report.page.evaluate(
        """() => addEventListener("beforeprint", () => queueMicrotask(() => {
             const canvas = document.querySelector('figure[data-plot="rates"] .drawing canvas');
             const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
             let blue = 0;
             for (let i = 0; i < pixels.length; i += 4)
               if (pixels[i] === 0 && pixels[i + 1] === 0x72 && pixels[i + 2] === 0xb2) blue += 1;
             window.onPaper = { blue, width: canvas.clientWidth };
           }))"""
    )
    printed = report.page.pdf(format="A4", print_background=True)
    assert printed.startswith(b"%PDF") and len(printed) > 50_000
    on_paper = report.page.evaluate("window.onPaper")
    assert on_paper["blue"] > 100
    assert on_paper["width"] <= A4_BETWEEN_MARGINS_PX
    assert report.picture("rates").unlike(before) == 0, "the screen is as it was"
    report.page.emulate_media(media="print")
    for control in (".transport", ".keys", ".drops", "footer"):
        assert report.page.locator(control).is_hidden(), control
    for selector in (".verdict", ".key-numbers", ".replay", "table.comparison"):
        assert report.page.locator(selector).is_visible(), selector


def test_numbers_are_written_to_their_uncertainty(open_document: Opener) -> None:
    document = sample_document()
    document["drops"][0]["key_numbers"] = [
        {"label": f"number {i}", "value": value, "std": std, "unit": unit, "note": ""}
        for i, ((value, std, unit), _) in enumerate(NUMBERS)
    ]
    written = open_document(document).page.locator(".key-numbers dd.figure").all_inner_texts()
    assert [text.strip() for text in written] == [expected for _, expected in NUMBERS]


def test_landmarks_names_and_focus(report: Opened) -> None:
    page = report.page
    assert [page.get_by_role(role).count() for role in ("banner", "main", "contentinfo")] == [1, 1, 1]
    # A screen reader needs a name for everything that can be reached.
    unnamed = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, [tabindex], section")].filter(element =>
             !(element.ariaLabel || element.textContent.trim() || element.labels?.length ||
               document.getElementById(element.getAttribute("aria-labelledby")))).map(element => element.outerHTML)"""
    )
    assert unnamed == []
    # Wherever another test has clicked, the next Tab leads from the first button to the second.
    page.locator("button").first.focus()
    page.keyboard.press("Tab")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"


def test_keys_inside_a_control_are_its_own(report: Opened) -> None:
    button = report.plot("rates").get_by_role("button", name="ω y")
    button.focus()
    # Space presses the button; elsewhere it would start the replay.
    report.press(" ")
    assert button.get_attribute("aria-pressed") == "false"
    assert report.page.get_by_role("button", name="Play").is_visible()
    report.press(" ")
    assert button.get_attribute("aria-pressed") == "true"


def test_libraries_come_with_their_licences(report: Opened) -> None:
    report.page.locator(".licences summary").click()
    texts = report.page.locator(".licences pre").all_inner_texts()
    assert len(texts) == 2 and all("Permission is hereby granted" in text for text in texts)


def test_a_wide_table_scrolls_by_itself_with_the_arrow_keys(open_document: Opener) -> None:
    document = sample_document()
    table = document["drops"][0]["tables"][0]
    table["columns"] = [f"column {i}" for i in range(40)]
    table["rows"] = [["12.5"] * 40]
    report = open_document(document)
    region = report.page.locator(".table .scrolling").first
    region.focus()
    time_s = report.time_s
    report.press("ArrowRight")
    report.page.wait_for_function("() => document.activeElement.scrollLeft > 0")
    assert report.time_s == time_s


def poison_strings(part: Any, text: str) -> Any:
    """Replace every string of the document by `text`, except the keys, which make it a document."""
    if isinstance(part, dict):
        return {key: poison_strings(value, text) for key, value in part.items()}
    if isinstance(part, list):
        return [poison_strings(item, text) for item in part]
    return text if isinstance(part, str) else part


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_injects_nothing(open_document: Opener, text: str) -> None:
    report = open_document(poison_strings(sample_document(("a", "b")), text))
    assert report.page.evaluate(COUNTS) == [3, 0, 0, 0, 0, 0, 0, 0], "the page's own three scripts"
    assert report.page.evaluate("() => window.injected ?? null") is None
    assert report.page.evaluate("() => Object.prototype.injected ?? null") is None
    assert report.page.evaluate("document.documentElement.scrollWidth") <= 1280
    report.press("ArrowRight", "+", "0", " ", " ")


def test_shows_hostile_text_as_it_is_and_lets_no_markup_run(open_document: Opener) -> None:
    text = "<b>not bold</b> &amp; <script>alert(1)</script>"
    report = open_document(poison_strings(sample_document(), text))
    assert report.page.locator("h1").inner_text() == text
    assert report.page.title() == text
    assert report.page.locator(".verdict > p").inner_text() == text
    # The policy forbids what the page itself never does: to parse markup, and to ask for anything.
    refused = report.page.evaluate(
        """() => {
          try { document.body.innerHTML = "<img src=x onerror='window.injected = 1'>"; return false; }
          catch { return true; }
        }"""
    )
    assert refused and any("TrustedHTML" in complaint for complaint in report.complaints)
    refused = report.page.evaluate("() => fetch('data:text/plain,hello').then(() => false, () => true)")
    assert refused and any("Content Security Policy" in complaint for complaint in report.complaints)
    report.complaints.clear()


def without_numbers(part: Any, wrong: Callable[[], float]) -> Any:
    if isinstance(part, dict):
        return {key: value if key == "t_s" else without_numbers(value, wrong) for key, value in part.items()}
    if isinstance(part, list):
        return [without_numbers(item, wrong) for item in part]
    return wrong() if isinstance(part, float) else part


def test_numbers_that_are_none_become_gaps(open_document: Opener) -> None:
    document, numbers = sample_document(), cycle([math.nan, math.inf, -math.inf])
    drop = document["drops"][0]
    for part in ("key_numbers", "replay"):
        drop[part] = without_numbers(drop[part], lambda: next(numbers))
    for plot in drop["plots"]:
        plot["series"] = without_numbers(plot["series"], lambda: next(numbers))
    report = open_document(document)
    assert set(report.page.locator(".key-numbers .value").all_inner_texts()) == {"–"}
    assert report.value("euler", "roll measured") == "–"
    report.press("ArrowRight", "+")


def nothing_but_text(drop: dict[str, Any]) -> None:
    drop.update(events=[], plots=[], replay=None, tables=[], notes=[], key_numbers=[])


def no_times(drop: dict[str, Any]) -> None:
    drop.update(t_s=[], plots=[], replay=None)


def a_single_sample(drop: dict[str, Any]) -> None:
    drop["t_s"] = drop["t_s"][:1]
    for plot in drop["plots"]:
        plot["x"] = plot["x"] and plot["x"][:1]
        for series in plot["series"]:
            series.update(values=series["values"][:1], std=series["std"] and series["std"][:1])


def odd_values(drop: dict[str, Any]) -> None:
    """Set odd values in the drop: a frequency of zero, constant lines, events beyond the data."""
    for plot in drop["plots"]:
        for series in plot["series"]:
            series["values"] = [1.0] * len(series["values"])
        if plot["x"] is not None:
            plot["x"][0] = plot["series"][0]["values"][3] = 0.0
    drop["events"] += [{"t_s": t, "kind": "stroke", "label": "late", "until_s": t + 1} for t in (-50.0, 50.0)]


@pytest.mark.parametrize("damage", [nothing_but_text, no_times, a_single_sample, odd_values])
def test_meagre_documents_still_show_what_they_have(
    open_document: Opener, damage: Callable[[dict[str, Any]], None]
) -> None:
    document = sample_document()
    damage(document["drops"][0])
    report = open_document(document)
    assert report.page.locator(".verdict .level").inner_text() == "✓\nGood"
    report.press("ArrowRight", "+", "0", "End", " ")


def test_another_format_is_refused_in_words(open_document: Opener) -> None:
    # A page of a later program shows nothing half-understood.
    report = open_document({**sample_document(), "format": 3})
    assert "has format 3, this page shows format 2" in report.page.locator("body").inner_text()
    report = open_document({**sample_document(), "drops": []})
    assert "holds no drop" in report.page.locator("body").inner_text()
