"""A page in headless Chromium, and everything that it said or asked for."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Playwright, sync_playwright

from tests.report.opened import Opened
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

OpenDocument = Callable[..., Opened]


@pytest.fixture(scope="session")
def _playwright() -> Iterator[Playwright]:
    with sync_playwright() as playwright:
        yield playwright


def launched(playwright: Playwright, home: Path, options: list[str]) -> Browser:
    """Chromium with these options besides those that keep it quiet."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.fail("Chromium is missing: tools/install-toolchain.sh installs it", pytrace=False)
    environment: dict[str, str | float | bool] = {**os.environ, "HOME": str(home)}
    return playwright.chromium.launch(executable_path=chromium, args=_QUIET + options, env=environment)


@pytest.fixture(scope="session")
def browser(_playwright: Playwright, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    chromium = launched(_playwright, tmp_path_factory.mktemp("chromium"), _WITH_WEBGL)
    yield chromium
    chromium.close()


@pytest.fixture
def browser_without_webgl(_playwright: Playwright, tmp_path: Path) -> Iterator[Browser]:
    chromium = launched(_playwright, tmp_path, _WITHOUT_WEBGL)
    yield chromium
    chromium.close()


@pytest.fixture
def open_document(browser: Browser, tmp_path: Path) -> Iterator[OpenDocument]:
    """Renders a document, opens it, and at the end demands that the page never complained or asked for anything."""
    opened: list[Opened] = []

    def open_it(document: Mapping[str, Any], *, into: Browser = browser, **context: Any) -> Opened:
        path = tmp_path / f"report{len(opened)}.html"
        path.write_text(render(document), encoding="utf-8")
        page: Page = into.new_page(**{"viewport": {"width": 1280, "height": 900}, **context})
        opened.append(Opened(page, path))
        return opened[-1]

    yield open_it
    for each in opened:
        each.page.close()
        assert each.complaints == []
        assert each.requests == [each.address]
