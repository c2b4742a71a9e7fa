"""The page of a real drop in the browser: everything draws, nothing complains."""

from __future__ import annotations

import textwrap
from datetime import UTC, datetime
from pathlib import Path

from tests.report.conftest import OpenDocument
from tests.report.reported_drop import reported
from tfsat_host.report.contents.building import document_of


def test_a_real_drop_draws(open_document: OpenDocument) -> None:
    document = document_of([reported()], datetime(2026, 1, 5, tzinfo=UTC))
    opened = open_document(document)
    shown = {figure.get_attribute("data-plot") for figure in opened.page.locator("figure[data-plot]").all()}
    assert {plot["id"] for plot in document["drops"][0]["plots"]} <= shown
    text = opened.page.inner_text("body")
    assert "Reorientation" in text and document["drops"][0]["verdict"]["sentence"] in text


def test_the_documented_python_call_makes_a_page() -> None:
    text = (Path(__file__).resolve().parents[2] / "docs" / "report.md").read_text(encoding="utf-8")
    example = textwrap.dedent(text.split("made otherwise:\n", 1)[1])
    names: dict[str, object] = {"found": reported().evaluation}
    exec(example, names)
    assert str(names["page"]).startswith("<!doctype html>")
