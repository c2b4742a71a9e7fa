"""What can be told of a picture without looking: its colors, and whether another one shows the same.

Pixels stay in the browser, which counts them; only the counts travel.
"""

from __future__ import annotations

from typing import cast

from playwright.sync_api import JSHandle, Locator

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

    def drawn(self) -> int:
        """How many pixels are not quite transparent."""
        return self._count("pixels => pixels.filter(pixel => pixel >>> 24).length")

    def colors(self) -> int:
        """How many colors there are."""
        return self._count("pixels => new Set(pixels).size")

    def count(self, hex_color: str) -> int:
        """How many pixels have exactly this color, "#rrggbb" (canvas pixels read as alpha, blue, green, red)."""
        red, green, blue = (int(hex_color[i : i + 2], 16) for i in (1, 3, 5))
        wanted = 0xFF000000 | blue << 16 | green << 8 | red
        return cast(
            int, self._pixels.evaluate("(pixels, wanted) => pixels.filter(p => p === wanted).length", wanted)
        )

    def unlike(self, other: Picture) -> int:
        """How many pixels differ from the other picture's; both of one page and of one size."""
        different = "(a, b) => a.length === b.length ? a.filter((pixel, i) => pixel !== b[i]).length : -1"
        count = cast(int, self._pixels.evaluate(different, other._pixels))
        assert count >= 0, "pictures of different sizes"
        return count

    def _count(self, script: str) -> int:
        return cast(int, self._pixels.evaluate(script))
