"""The file itself, before any browser: what it embeds, what it forbids, what it weighs and rounds."""

from __future__ import annotations

import base64
import hashlib
import html.parser
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.paths import REPOSITORY
from tests.report.reported_drop import evaluate_run
from tests.report.sample_document import sample_document
from tfsat_host.quantity import record
from tfsat_host.report import page, render
from tfsat_host.report.contents.chart import PLOT
from tfsat_host.report.contents.charts import charts_of
from tfsat_host.report.document_rounding import poses_to_keep, round_line
from tfsat_host.report.page import embeddable

JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


class Elements(html.parser.HTMLParser):
    """Scripts, styles and attributes of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.contents: dict[str, list[str]] = {"script": [], "style": []}
        self.attributes: list[tuple[str, str, str | None]] = []
        self._open = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag in self.contents:
            self._open = tag
            self.contents[tag].append("")

    def handle_endtag(self, tag: str) -> None:  # noqa: ARG002
        self._open = ""

    def handle_data(self, data: str) -> None:
        if self._open:
            self.contents[self._open][-1] += data


@given(JSON)
def test_embedded_json_is_the_same_and_ends_no_element(value: Any) -> None:
    text = embeddable({"value": value})
    assert json.loads(text) == {"value": value}
    # Without < and & no text can end the script element that carries it.
    assert text.isascii() and not set("<>&") & set(text)


def test_lone_surrogates_survive_into_a_file() -> None:
    document = sample_document()
    document["title"] = "broken \udc80 log"
    assert render(document).encode("utf-8")


def test_a_number_that_json_lacks_is_refused_by_the_embedding() -> None:
    with pytest.raises(ValueError, match="JSON"):
        embeddable({"value": math.nan})


def test_the_policy_names_exactly_this_script_and_style() -> None:
    elements = Elements(render(sample_document()))
    policy = next(
        value
        for tag, name, value in elements.attributes
        if (tag, name) == ("meta", "content") and "src" in str(value)
    )
    assert policy is not None and policy.startswith("default-src 'none'; ")
    [style], script = elements.contents["style"], elements.contents["script"][-1]
    for kind, text in (("script", script), ("style", style)):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{kind}-src 'sha256-{digest}'" in policy
    assert "unsafe" not in policy and "http" not in policy


def test_no_element_refers_to_anything() -> None:
    elements = Elements(render(sample_document()))
    assert not [
        each
        for each in elements.attributes
        if each[1] in ("src", "href", "srcset", "action", "data", "style")
    ]
    assert "@import" not in elements.contents["style"][0] and "url(" not in elements.contents["style"][0]


def test_every_asset_is_on_the_page() -> None:
    folder = Path(page.__file__).parent / "assets"
    carried = page.script() + page.style()
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    assert files and all(path.read_text(encoding="utf-8") in carried for path in files)


def test_libraries_are_the_ones_that_were_locked() -> None:
    folder = Path(page.__file__).parent / "vendor"
    sources = json.loads((folder / "SOURCES.json").read_text())
    lock = REPOSITORY / "tools" / "report_vendor" / "package-lock.json"
    packages = json.loads(lock.read_text())["packages"]
    assert {path.name for path in folder.iterdir()} == {"SOURCES.json", *sources}
    for name, source in sources.items():
        locked = packages[f"node_modules/{source['package']}"]
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == source["sha256"]
        assert (locked["version"], locked["integrity"]) == (source["version"], source["integrity"])
        assert source["license"] == "MIT"
    assert "resolved" not in lock.read_text(), "the lock names no host"


def test_the_scripts_set_text_as_text_only() -> None:
    for path in (Path(page.__file__).parent / "assets" / "script").iterdir():
        text = path.read_text(encoding="utf-8")
        assert not re.search(
            r"innerHTML|outerHTML|insertAdjacent|document\.write|eval\(|new Function", text
        ), path.name


def test_rounding_is_finer_than_a_plot_can_show() -> None:
    for chart in charts_of(evaluate_run()).values():
        for exact, series in zip(chart.lines, record(PLOT, chart)["series"], strict=True):
            values = np.array(series["values"], dtype=np.float64)
            finite = np.isfinite(exact.values)
            span = np.ptp(exact.values[finite]) or np.abs(exact.values[finite]).max()
            # Half of the last digit that is kept: 1e-5 of the span; of five digits on a logarithmic axis, 5e-5.
            allowed = 5.1e-5 * np.abs(exact.values) if chart.log_y else 1.0001e-5 * span
            assert np.array_equal(finite, np.isfinite(values)), chart.id
            assert np.all((np.abs(values - exact.values) <= allowed)[finite]), chart.id
    exact_values = np.linspace(-3.0, 47.0, 999)
    values, _ = round_line(exact_values, None, log=False)
    assert np.abs(values - exact_values).max() <= 1e-5 * 50.0


def test_small_uncertainties_of_large_values_keep_their_digits() -> None:
    # A band of 1e-3 on values of 1e3: rounded like the values it would vanish.
    _, std = round_line(1e3 + np.arange(240.0), np.full(240, 1.234e-3), log=False)
    assert std == pytest.approx(1.234e-3, rel=1e-2)


@pytest.mark.parametrize("rate_hz", [50, 320, 1000])
def test_the_replay_is_thinned_but_keeps_ends_and_gaps(rate_hz: int) -> None:
    # 2 s with a gap of 0.3 s, at the rates that the logger can have.
    times = np.array([i / rate_hz for i in range(2 * rate_hz) if not 0.5 < i / rate_hz < 0.8])
    kept_times = times[poses_to_keep(times)]
    # A hundred poses a second, and the last.
    assert len(kept_times) <= 201
    assert (kept_times[0], kept_times[-1]) == (times[0], times[-1])
    assert np.sort(np.diff(kept_times))[-2] <= max(1 / rate_hz, 0.01) + 2e-4, (
        "no gap but the one that was there"
    )
    assert {0.5, 0.8} <= {round(float(t), 2) for t in kept_times}


def test_numpy_numbers_are_numbers() -> None:
    document = sample_document()
    document["drops"][0]["key_numbers"][0]["value"] = np.float32(1.5)
    document["drops"][0]["window_s"] = list(np.array([0.0, 2.5]))
    assert '"value":1.5' in render(document)


def test_rendering_leaves_the_document_alone() -> None:
    document = sample_document()
    before = json.dumps(document)
    render(document)
    assert json.dumps(document) == before
