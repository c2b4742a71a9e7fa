"""One report in the browser: what a reader sees and does, and what the page says and asks for behind it.

Pixels stay in the browser, which counts them; only the counts travel.
"""

from __future__ import annotations

from pathlib import Path
from typing import cast

from playwright.sync_api import Dialog, JSHandle, Locator, Page

_TAKE = """
canvas => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const ctx = copy.getContext("2d");
  ctx.drawImage(canvas, 0, 0);
  return new Uint32Array(ctx.getImageData(0, 0, copy.width, copy.height).data.buffer);
}
"""


class Picture:
    """A canvas as it was when this was made."""

    def __init__(self, canvas: Locator) -> None:
        self._pixels: JSHandle = canvas.evaluate_handle(_TAKE)

    def count_visible_pixels(self) -> int:
        """Count the pixels that are not fully transparent."""
        return self._count("pixels => pixels.filter(pixel => pixel >>> 24).length")

    def colors(self) -> int:
        """Count the distinct colors."""
        return self._count("pixels => new Set(pixels).size")

    def count(self, hex_color: str) -> int:
        """Count the pixels of exactly this color, "#rrggbb" (canvas pixels read as alpha, blue, green, red)."""
        red, green, blue = (int(hex_color[i : i + 2], 16) for i in (1, 3, 5))
        pixel = 0xFF000000 | blue << 16 | green << 8 | red
        return cast(
            int, self._pixels.evaluate("(pixels, wanted) => pixels.filter(p => p === wanted).length", pixel)
        )

    def unlike(self, other: Picture) -> int:
        """Count the pixels that differ from another picture of the same page and size."""
        different = "(a, b) => a.length === b.length ? a.filter((pixel, i) => pixel !== b[i]).length : -1"
        count = cast(int, self._pixels.evaluate(different, other._pixels))
        assert count >= 0, "pictures of different sizes"
        return count

    def _count(self, script: str) -> int:
        return cast(int, self._pixels.evaluate(script))


class Opened:
    """A page that was loaded from a file.

    Attributes:
        complaints: Console messages, errors that nobody caught, dialogs.
        requests: Every address that was asked for; the file itself is the first.
    """

    def __init__(self, page: Page, path: Path) -> None:
        self.page = page
        self.address = path.as_uri()
        self.complaints: list[str] = []
        self.requests: list[str] = []
        page.on("console", lambda message: self._note_complaint(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: self.complaints.append(f"error: {error}"))
        page.on("dialog", self._dismiss_dialog)
        page.on("request", lambda request: self.requests.append(request.url))
        page.goto(self.address)

    def _note_complaint(self, text: str) -> None:
        # That WebGL had to wait is the tests' own doing: they read pixels.
        if "GPU stall due to ReadPixels" not in text:
            self.complaints.append(text)

    def _dismiss_dialog(self, dialog: Dialog) -> None:
        self.complaints.append(f"dialog: {dialog.message}")
        dialog.dismiss()

    @property
    def time_s(self) -> float:
        """The replay's time, as it stands above the bodies."""
        return float(self.page.locator(".when").inner_text().removesuffix(" s").replace("−", "-"))

    def plot(self, name: str) -> Locator:
        """Find the figure of the plot with this id."""
        return self.page.locator(f'figure[data-plot="{name}"]')

    def picture(self, name: str) -> Picture:
        """Return the drawing of the plot with this id once pending drawing is done."""
        # Drawing is put off to the next frame: wait for it.
        self.page.evaluate("() => new Promise(requestAnimationFrame)")
        return Picture(self.plot(name).locator(".drawing canvas"))

    def replay_picture(self) -> Picture:
        """Return the picture of the replay."""
        return Picture(self.page.locator("canvas.bodies"))

    def value(self, name: str, label: str) -> str:
        """Read the legend value of the line with this label, at the cursor."""
        row = self.plot(name).locator("li", has=self.page.get_by_text(label, exact=True))
        return row.locator(".value").inner_text()

    def hairlines(self) -> dict[str, float]:
        """Return the horizontal position of each plot's cursor, in px."""
        return {
            str(figure.get_attribute("data-plot") or "timeline"): figure.locator(".hairline").evaluate(
                "line => new DOMMatrix(getComputedStyle(line).transform).e"
            )
            for figure in self.page.locator("figure.plot").all()
        }

    def press(self, *keys: str) -> None:
        """Types keys wherever the focus is."""
        for key in keys:
            self.page.keyboard.press(key)

    def rest(self) -> None:
        """Puts plots, cursor and focus back to where they were after loading, but for the time."""
        # To a corner: over a plot the pointer would move the cursor.
        self.page.mouse.move(5, 5)
        self.page.evaluate("() => document.activeElement.blur()")
        self.press("0", "End")
