"""A page in headless Chromium, and everything that it said or asked for."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Playwright, sync_playwright

from tests.report.opened import Opened
from tests.report.reported_drop import drop_of
from tests.report.sample_document import sample_document
from tfsat_host.report import render

# No request of the browser's own (updates, variations), and WebGL without a graphics card.
_QUIET = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
]
_WITH_WEBGL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
_WITHOUT_WEBGL = ["--disable-3d-apis"]


@pytest.fixture(scope="session")
def _playwright() -> Iterator[Playwright]:
    with sync_playwright() as playwright:
        yield playwright


def launch_chromium(playwright: Playwright, home: Path, options: list[str]) -> Browser:
    """Chromium with these options besides those that keep it quiet."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.fail("Chromium is missing: tools/install-toolchain.sh installs it", pytrace=False)
    environment: dict[str, str | float | bool] = {**os.environ, "HOME": str(home)}
    return playwright.chromium.launch(executable_path=chromium, args=_QUIET + options, env=environment)


@pytest.fixture(scope="session")
def browser(_playwright: Playwright, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    chromium = launch_chromium(_playwright, tmp_path_factory.mktemp("chromium"), _WITH_WEBGL)
    yield chromium
    chromium.close()


@pytest.fixture
def browser_without_webgl(_playwright: Playwright, tmp_path: Path) -> Iterator[Browser]:
    chromium = launch_chromium(_playwright, tmp_path, _WITHOUT_WEBGL)
    yield chromium
    chromium.close()


class Opener:
    """Renders documents and opens them; at the end demands that no page ever complained or asked for anything."""

    def __init__(self, browser: Browser, folder: Path) -> None:
        self._browser, self._folder = browser, folder
        self._opened: list[Opened] = []

    def __call__(self, document: Any, *, into: Browser | None = None, **context: Any) -> Opened:
        path = self._folder / f"report{len(self._opened)}.html"
        path.write_text(render(document), encoding="utf-8")
        size = {"viewport": {"width": 1280, "height": 900}}
        page: Page = (into or self._browser).new_page(**{**size, **context})
        self._opened.append(Opened(page, path))
        return self._opened[-1]

    def close(self) -> None:
        for each in self._opened:
            each.page.close()
            # The page must work offline, and say nothing in a console that no team reads.
            assert each.complaints == []
            assert each.requests == [each.address]


@pytest.fixture
def open_document(browser: Browser, tmp_path: Path) -> Iterator[Opener]:
    opener = Opener(browser, tmp_path)
    yield opener
    opener.close()


@pytest.fixture(scope="session")
def _sample(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    opener = Opener(browser, tmp_path_factory.mktemp("sample"))
    yield opener(sample_document())
    opener.close()


@pytest.fixture
def report(_sample: Opened) -> Opened:
    """Return the page of the one-drop sample, loaded once and reset: plots whole, the cursor at the end.

    Tests must leave its documents as they are.
    """
    _sample.rest()
    return _sample


@pytest.fixture(scope="session")
def drop() -> Any:
    """Return the document's part of a real drop."""
    return drop_of()
