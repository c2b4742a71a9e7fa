"""On paper: dark screens print light, plots fit the page, and nothing stands there that needs a screen."""

from __future__ import annotations

import pytest

from tests.report.conftest import OpenDocument
from tests.report.sample_document import sample_document

A4_BETWEEN_MARGINS_PX = 688


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_prints_whole_and_light(open_document: OpenDocument, scheme: str) -> None:
    report = open_document(sample_document(), color_scheme=scheme)
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


def test_paper_has_no_controls(open_document: OpenDocument) -> None:
    report = open_document(sample_document(("one", "two")))
    report.page.emulate_media(media="print")
    for control in (".transport", ".keys", ".drops", "footer"):
        assert report.page.locator(control).is_hidden(), control
    for kept in (".verdict", ".key-numbers", ".replay", "table.comparison"):
        assert report.page.locator(kept).is_visible(), kept
