"""The guide as a site: it builds without a warning, no link in it is dead, and the runbook prints on one page."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from tests.paths import REPOSITORY


class _Page(HTMLParser):
    """Ids and links of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if value is not None and name in ("id", "name"):
                self.ids.add(value)
            elif value is not None and name in ("href", "src") and tag != "link":
                self.links.append(value)


@cache
def _page(path: Path) -> _Page:
    return _Page(path)


def dead_links(site: Path) -> list[str]:
    """Links of a site to files or anchors that it has not."""
    dead = []
    for path in sorted(site.rglob("*.html")):
        for link in _page(path).links:
            parts = urlsplit(link)
            # Other sites are not looked up: a test must not need the network.
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            if not target.is_file() or (
                anchor and target.suffix == ".html" and anchor not in _page(target).ids
            ):
                dead.append(f"{path.relative_to(site)}: {link}")
    return dead


def _pages_printed(page: Path, folder: Path) -> int:
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.fail("Chromium is missing: tools/install-toolchain.sh installs it", pytrace=False)
    pdf = folder / "printed.pdf"
    # --no-sandbox: in a container Chromium's own sandbox does not start.
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer"]
    options += [f"--user-data-dir={folder / 'chromium'}", f"--print-to-pdf={pdf}", page.as_uri()]
    subprocess.run([chromium, *options], capture_output=True, timeout=100, check=True)
    return len(re.findall(rb"/Type ?/Page\b", pdf.read_bytes()))


# One test, for the site takes seconds to build; `make test` looks at links and anchors in the Markdown.
@pytest.mark.prove
def test_the_site_has_no_warning_and_no_dead_link(tmp_path: Path) -> None:
    site = tmp_path / "site"
    # -W turns each warning into an error; --keep-going shows all of them at once.
    options = ["-W", "--keep-going", "-q", "-c", "docs", "-d", str(tmp_path / "trees")]
    command = [sys.executable, "-m", "sphinx", *options, ".", str(site)]
    process = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    hint = "\nA new page needs its row in docs/index.md." if "toctree" in process.stderr else ""
    assert (process.returncode, process.stderr + hint) == (0, "")
    assert len(list(site.rglob("*.html"))) > 30
    assert dead_links(site) == []
    assert _page(site / "docs" / "guide" / "runbook.html").ids
    assert _pages_printed(site / "docs" / "guide" / "runbook.html", tmp_path) == 1


@pytest.mark.parametrize("link", ["none.html", "other.html#none", "#none"])
def test_a_dead_link_would_be_found(tmp_path: Path, link: str) -> None:
    (tmp_path / "other.html").write_text('<p id="here"><a href="page.html#there">')
    (tmp_path / "page.html").write_text(f'<p id="there"><a href="other.html#here"><a href="{link}">')
    assert dead_links(tmp_path) == [f"page.html: {link}"]
