"""What a tired team reads first, on a desk and on a telephone: all of it in sight, nothing wrapped or overlaid."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import pytest
from playwright.sync_api import Locator

from tests.report.conftest import Opener
from tests.report.opened import Opened
from tests.report.sample_document import sample_document

# A small laptop and a telephone held upright.
SIZES = [(1280, 800), (420, 900)]
PARTS = (".verdict", ".prediction table", ".change", "canvas.bodies", ".transport", ".strokes table")
# Contrast of WCAG 2: relative luminances, at least 4.5 to 1 for text (level AA).
CONTRAST = """() => {
  const channels = text => (text.match(/[\\d.]+/g) ?? []).map(Number);
  const context = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
  const backgroundOf = element => {
    const layers = [];
    for (let each = element; each; each = each.parentElement) layers.unshift(getComputedStyle(each).backgroundColor);
    context.clearRect(0, 0, 1, 1);
    for (const layer of layers) { context.fillStyle = layer; context.fillRect(0, 0, 1, 1); }
    return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);
  };
  const luminance = rgb => rgb.map(part => part / 255)
    .map(part => part <= 0.03928 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4)
    .reduce((sum, part, i) => sum + part * [0.2126, 0.7152, 0.0722][i], 0);
  const poor = [];
  for (const element of document.querySelectorAll("body *")) {
    const isText = [...element.childNodes].some(node => node.nodeType === 3 && node.textContent.trim());
    if (!isText || !element.checkVisibility({ visibilityProperty: true })) continue;
    const style = getComputedStyle(element);
    const [a, b] = [channels(style.color), backgroundOf(element)].map(rgb => luminance(rgb.slice(0, 3)));
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) * Number(style.opacity);
    if (ratio < 4.5) poor.push(`${element.className} ${element.textContent.slice(0, 20)}: ${ratio.toFixed(2)}`);
  }
  return poor;
}"""


def box(locator: Locator) -> dict[str, float]:
    bounds = locator.bounding_box()
    assert bounds is not None
    left, top, width, height = (bounds[key] for key in ("x", "y", "width", "height"))
    return {"x": left, "y": top, "height": height, "right": left + width, "bottom": top + height}


def open_at(open_document: Opener, width: int, height: int, document: Any = None) -> Opened:
    return open_document(document or sample_document(), viewport={"width": width, "height": height})


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_verdict_prediction_change_replay_and_strokes_are_in_sight(
    open_document: Opener, width: int, height: int
) -> None:
    report = open_at(open_document, width, height)
    for part in PARTS:
        bounds = box(report.page.locator(part))
        assert bounds["x"] >= 0.0 and bounds["right"] <= width, part
        assert bounds["y"] >= 0.0 and bounds["bottom"] <= height, part
        assert bounds["height"] > 20.0, part
    # No table of the first screen has to be scrolled sideways.
    for table in (".prediction .scrolling", ".strokes .scrolling"):
        assert report.page.locator(table).evaluate("region => region.scrollWidth <= region.clientWidth"), (
            table
        )


def test_the_replay_stands_at_the_left_and_stays_beside_the_plots(open_document: Opener) -> None:
    report = open_at(open_document, 1280, 800)
    assert box(report.page.locator(".watch"))["right"] < box(report.page.locator(".prediction"))["x"]
    report.plot("rates").scroll_into_view_if_needed()
    replay = box(report.page.locator("canvas.bodies"))
    assert replay["y"] >= 0.0 and replay["bottom"] <= 800


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_numbers_and_their_units_stay_on_one_line(open_document: Opener, width: int, height: int) -> None:
    report = open_at(open_document, width, height)
    cells = report.page.locator(".strokes td, .prediction td, .key-numbers .figure, .strokes tbody th")
    lines = cells.evaluate_all(
        """cells => cells.filter(cell => cell.textContent.trim() && cell.checkVisibility()).map(cell => {
             const range = document.createRange();
             range.selectNodeContents(cell);
             const tops = [...range.getClientRects()].map(rect => (rect.top + rect.bottom) / 2);
             return [cell.textContent, Math.max(...tops) - Math.min(...tops)];
           })"""
    )
    assert len(lines) > 20 and all(height_px < 6.0 for _, height_px in lines), lines


@pytest.mark.parametrize("width", [1280, 420, 360])
def test_names_of_events_do_not_lie_over_each_other(open_document: Opener, width: int) -> None:
    document = sample_document()
    document["drops"][0]["events"] += [
        {"t_s": t, "kind": "switch", "label": f"release switch {i} opened", "until_s": None}
        # Three switches within 3 ms: their names would lie over each other.
        for i, t in enumerate((0.001, 0.002, 0.003), 1)
    ]
    report = open_at(open_document, width, 900, document)
    names = [box(name) for name in report.page.locator(".names > *").all()]
    assert len(names) >= 5
    place = box(report.page.locator(".timeline .u-over"))
    for name in names:
        assert name["x"] >= place["x"] and name["right"] <= place["right"] + 1.0
    for first, second in combinations(names, 2):
        apart = (
            first["right"] <= second["x"]
            or second["right"] <= first["x"]
            or first["bottom"] <= second["y"]
            or second["bottom"] <= first["y"]
        )
        assert apart, (first, second)


@pytest.mark.parametrize(("width", "form"), [(1280, "1: joint 1, +59 deg"), (250, "1")])
def test_the_names_of_all_strokes_have_the_same_form(open_document: Opener, width: int, form: str) -> None:
    names = open_at(open_document, width, 900).page.locator(".stroke-name").all_inner_texts()
    assert names[0] == form and len(names) == 4
    assert len({name.count(",") for name in names}) == 1


def test_many_reasons_leave_the_numbers_in_sight(open_document: Opener) -> None:
    document = sample_document()
    # More than fit: the numbers must stay in sight.
    document["drops"][0]["verdict"]["reasons"] = [f"Reason {i}: the sensors disagree." for i in range(14)]
    report = open_at(open_document, 1280, 800, document)
    assert box(report.page.locator(".prediction table"))["bottom"] < 800
    report.page.get_by_text("All 14 reasons").click()
    assert report.page.get_by_text("Reason 13: the sensors disagree.").is_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_stands_out_from_its_background(open_document: Opener, scheme: str) -> None:
    document = sample_document(("one", "two", "three"))
    document["drops"][0]["plots"][0]["withheld"] = (
        "fitted model withheld: momentum throughout the fall (check failed)"
    )
    report = open_document(document, color_scheme=scheme)
    # A line that is switched off is shown paler: it must stay readable.
    report.plot("rates").get_by_role("button", name="ω y").click()
    assert report.page.evaluate(CONTRAST) == []


def test_every_drawing_has_a_text_in_its_place(report: Opened) -> None:
    unnamed = report.page.evaluate(
        """() => [...document.querySelectorAll("canvas")].filter(canvas =>
             canvas.ariaHidden !== "true" && !(["img", "application"].includes(canvas.role) && canvas.ariaLabel))
             .map(canvas => canvas.parentElement.className)"""
    )
    assert unnamed == []
    label = report.plot("rates").get_by_role("img").get_attribute("aria-label")
    assert label == "The rates: deg. Lines: ω x, ω y, ω z."


def test_withheld_lines_are_named_in_their_place(open_document: Opener) -> None:
    document = sample_document()
    rates = document["drops"][0]["plots"][1]
    rates.update(series=[], withheld="withheld: gyros of bodies 3 and 4 (check failed)", caption="")
    report = open_document(document)
    assert report.plot("rates").locator(".withheld").inner_text() == rates["withheld"]
    assert report.plot("rates").locator("canvas").count() == 0
    report.press("ArrowRight", "+", "0")
