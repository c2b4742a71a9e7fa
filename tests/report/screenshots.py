"""The pictures of docs/report.md: pages of emulated drops as a browser shows them.

python -m tests.report.screenshots docs/screenshots
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

from tests.evaluation.run_folder import run_folder
from tests.report.conftest import launch_chromium
from tfsat_host.cli.main import main as tfsat_host

MAX_BYTES = 250_000
_DESKTOP = {"width": 1440, "height": 900}
_PHONE = {"width": 420, "height": 900}
# Within stroke 2, from 1.05 s on: a joint is half open.
_MID_STROKE_S = "1.25"
_DROPS = (1, 2, 3)


def take(folder: Path) -> None:
    """Makes the drops, their reports and the pictures.

    Raises:
        SystemExit: a report was not made, or a picture is too large for a repository.
    """
    with tempfile.TemporaryDirectory(prefix="tfsat-screenshots-") as name, sync_playwright() as playwright:
        place = Path(name)
        single_report, several = _reports(place)
        chromium = launch_chromium(
            playwright, place, ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        )
        folder.mkdir(parents=True, exist_ok=True)
        _open_page(chromium, single_report, _DESKTOP).screenshot(path=folder / "report.png")
        _mid_stroke(_open_page(chromium, single_report, _DESKTOP)).screenshot(path=folder / "replay.png")
        _show_comparison(_open_page(chromium, several, _DESKTOP)).screenshot(path=folder / "several.png")
        _open_page(chromium, single_report, _PHONE).screenshot(path=folder / "narrow.png")
        chromium.close()
    for picture in sorted(folder.glob("*.png")):
        size = picture.stat().st_size
        sys.stdout.write(f"{picture}: {size} bytes\n")
        if size > MAX_BYTES:
            sys.exit(f"{picture} is larger than {MAX_BYTES} bytes.")


def _reports(place: Path) -> tuple[Path, Path]:
    runs = [place / f"drop {seed}" for seed in _DROPS]
    for seed, run in zip(_DROPS, runs, strict=True):
        run_folder(run, seed)
    single_report, several = place / "one.html", place / "several.html"
    for folders, page in ((runs[:1], single_report), (runs, several)):
        code = tfsat_host(["report", *map(str, folders), "--out", str(page), "--json"])
        if code != 0:
            sys.exit(f"tfsat-host report ended with {code}.")
    return single_report, several


def _open_page(chromium: Browser, page: Path, size: dict[str, int]) -> Page:
    opened = chromium.new_page(viewport=size)  # type: ignore[arg-type]
    opened.goto(page.as_uri())
    return opened


def _mid_stroke(page: Page) -> Page:
    page.get_by_label("Time after release").fill(_MID_STROKE_S)
    page.locator("#motion-head").evaluate("head => head.scrollIntoView()")
    return page


def _show_comparison(page: Page) -> Page:
    page.locator("#comparison-head").evaluate("head => head.scrollIntoView()")
    return page


if __name__ == "__main__":
    if shutil.which("chromium") is None and shutil.which("chromium-browser") is None:
        sys.exit("Chromium is missing: tools/install-toolchain.sh installs it")
    take(Path(sys.argv[1]))
