"""Strings from a damaged or forged log stay strings; numbers that are none become gaps."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from tests.report.conftest import OpenDocument
from tests.report.sample_document import sample_document

HOSTILE = (
    "<script>window.injected = 1</script>",
    "</script><script>window.injected = 2</script>",
    "<!--<script>",
    "]]></script><svg onload='window.injected = 3'>",
    "<img src=x onerror='window.injected = 4'>",
    "\"><iframe src='javascript:window.injected=5'></iframe>",
    "{{7*7}} ${window.injected = 6} javascript:window.injected=7",
    "line\u2028separator\u2029paragraph\x00nul\x1b[31mescape",
    "\u202eright to left\u202d",
    "lone surrogate \udc80\ud800 of a broken log",
    "constructor",
    "__proto__",
    "W" * 100_000,
    "",
)

COUNTS = """() => ["script", "img", "iframe", "svg", "link", "a:not([href^='#'])", "base", "object"].map(
  those => document.querySelectorAll(those).length)"""


def poisoned(part: Any, text: str) -> Any:
    """The document with every string replaced; keys stay, or it would be no document."""
    if isinstance(part, dict):
        return {key: poisoned(value, text) for key, value in part.items()}
    if isinstance(part, list):
        return [poisoned(item, text) for item in part]
    return text if isinstance(part, str) else part


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_injects_nothing(open_document: OpenDocument, text: str) -> None:
    report = open_document(poisoned(sample_document(("a", "b")), text))
    assert report.page.evaluate(COUNTS) == [3, 0, 0, 0, 0, 0, 0, 0], "the page's own three scripts"
    assert report.page.evaluate("() => window.injected ?? null") is None
    assert report.page.evaluate("() => Object.prototype.injected ?? null") is None
    assert report.page.evaluate("document.documentElement.scrollWidth") <= 1280
    report.press("ArrowRight", "+", "0", " ", " ")


def test_shows_hostile_text_as_it_is(open_document: OpenDocument) -> None:
    text = "<b>not bold</b> &amp; <script>alert(1)</script>"
    report = open_document(poisoned(sample_document(), text))
    assert report.page.locator("h1").inner_text() == text
    assert report.page.title() == text
    assert report.page.locator(".verdict > p").inner_text() == text


def test_even_injected_markup_could_not_run(open_document: OpenDocument) -> None:
    report = open_document(sample_document())
    refused = report.page.evaluate(
        """() => {
          try { document.body.innerHTML = "<img src=x onerror='window.injected = 1'>"; return false; }
          catch { return true; }
        }"""
    )
    assert refused
    assert any("TrustedHTML" in complaint for complaint in report.complaints)
    report.complaints.clear()


def test_the_page_may_not_ask_for_anything(open_document: OpenDocument) -> None:
    report = open_document(sample_document())
    refused = report.page.evaluate("() => fetch('data:text/plain,hello').then(() => false, () => true)")
    assert refused
    assert any("Content Security Policy" in complaint for complaint in report.complaints)
    report.complaints.clear()


def without_numbers(part: Any, number: float) -> Any:
    if isinstance(part, dict):
        return {
            key: value if key == "format" else without_numbers(value, number) for key, value in part.items()
        }
    if isinstance(part, list):
        return [without_numbers(item, number) for item in part]
    return number if isinstance(part, float) else part


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf], ids=str)
def test_numbers_that_are_none_become_gaps(open_document: OpenDocument, number: float) -> None:
    document = sample_document()
    drop = document["drops"][0]
    for part in ("key_numbers", "replay"):
        kept = drop[part].get("t_s") if part == "replay" else None
        drop[part] = without_numbers(drop[part], number)
        if kept is not None:
            drop[part]["t_s"] = kept
    for plot in drop["plots"]:
        plot["series"] = without_numbers(plot["series"], number)
    report = open_document(document)
    assert set(report.page.locator(".key-numbers .value").all_inner_texts()) == {"–"}
    assert report.value("euler", "roll measured") == "–"
    report.press("ArrowRight", "+")


def nothing_but_text(document: dict[str, Any]) -> None:
    document["drops"][0].update(events=[], plots=[], replay=None, tables=[], notes=[], key_numbers=[])


def no_times(document: dict[str, Any]) -> None:
    document["drops"][0].update(t_s=[], plots=[], replay=None)


def a_single_sample(document: dict[str, Any]) -> None:
    drop = document["drops"][0]
    drop["t_s"] = drop["t_s"][:1]
    for plot in drop["plots"]:
        plot["x"] = None if plot["x"] is None else plot["x"][:1]
        for series in plot["series"]:
            series["values"] = series["values"][:1]
            series["std"] = None if series["std"] is None else series["std"][:1]


def zero_frequency(document: dict[str, Any]) -> None:
    for plot in document["drops"][0]["plots"]:
        if plot["x"] is not None:
            plot["x"][0] = 0.0
            plot["series"][0]["values"][3] = 0.0


def a_constant_line(document: dict[str, Any]) -> None:
    for plot in document["drops"][0]["plots"]:
        for series in plot["series"]:
            series["values"] = [1.0] * len(series["values"])


def events_beyond_the_data(document: dict[str, Any]) -> None:
    events = document["drops"][0]["events"]
    events += [{"t_s": t, "kind": "stroke", "label": "late", "until_s": t + 1} for t in (-50.0, 50.0)]


@pytest.mark.parametrize(
    "damage",
    [nothing_but_text, no_times, a_single_sample, zero_frequency, a_constant_line, events_beyond_the_data],
)
def test_meagre_documents_still_show_what_they_have(
    open_document: OpenDocument, damage: Callable[[dict[str, Any]], None]
) -> None:
    document = sample_document()
    damage(document)
    report = open_document(document)
    assert report.page.locator(".verdict .level").inner_text() == "✓\nGood"
    report.press("ArrowRight", "+", "0", "End", " ")


def test_another_format_is_refused_in_words(open_document: OpenDocument) -> None:
    report = open_document({**sample_document(), "format": 2})
    assert "has format 2, this page shows format 1" in report.page.locator("body").inner_text()
    report = open_document({**sample_document(), "drops": []})
    assert "holds no drop" in report.page.locator("body").inner_text()
