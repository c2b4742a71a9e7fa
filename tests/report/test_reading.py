"""What a reader is told: the verdict in a word, numbers with their uncertainty, tables with captions."""

from __future__ import annotations

import pytest

from tests.report.conftest import OpenDocument
from tests.report.sample_document import sample_document

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


def test_numbers_are_written_to_their_uncertainty(open_document: OpenDocument) -> None:
    document = sample_document()
    document["drops"][0]["key_numbers"] = [
        {"label": f"number {i}", "value": value, "std": std, "unit": unit, "note": ""}
        for i, ((value, std, unit), _) in enumerate(NUMBERS)
    ]
    written = open_document(document).page.locator(".key-numbers dd.figure").all_inner_texts()
    assert [text.strip() for text in written] == [expected for _, expected in NUMBERS]


@pytest.mark.parametrize(
    ("level", "words"), [("good", "✓\nGood"), ("doubtful", "!\nDoubtful"), ("failed", "✕\nFailed")]
)
def test_the_verdict_is_a_symbol_and_a_word(open_document: OpenDocument, level: str, words: str) -> None:
    document = sample_document()
    document["drops"][0]["verdict"]["level"] = level
    assert open_document(document).page.locator(".verdict .level").inner_text() == words


def test_landmarks_names_and_focus(open_document: OpenDocument) -> None:
    page = open_document(sample_document()).page
    assert [page.get_by_role(role).count() for role in ("banner", "main", "contentinfo")] == [1, 1, 1]
    unnamed = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, [tabindex], section")].filter(element =>
             !(element.ariaLabel || element.textContent.trim() || element.labels?.length ||
               document.getElementById(element.getAttribute("aria-labelledby")))).map(element => element.outerHTML)"""
    )
    assert unnamed == []
    page.keyboard.press("Tab")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"


def test_keys_inside_a_control_are_its_own(open_document: OpenDocument) -> None:
    report = open_document(sample_document())
    button = report.plot("rates").get_by_role("button", name="ω y")
    button.focus()
    report.press(" ")
    assert button.get_attribute("aria-pressed") == "false"
    assert report.page.get_by_role("button", name="Play").is_visible()


def test_libraries_come_with_their_licences(open_document: OpenDocument) -> None:
    page = open_document(sample_document()).page
    page.locator(".licences summary").click()
    texts = page.locator(".licences pre").all_inner_texts()
    assert len(texts) == 2 and all("Permission is hereby granted" in text for text in texts)


def test_a_wide_table_scrolls_by_itself_with_the_arrow_keys(open_document: OpenDocument) -> None:
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
