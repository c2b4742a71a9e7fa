"""How numbers and sentences of an evaluation are written on a terminal."""

from __future__ import annotations

import math
import shutil
import textwrap
from collections.abc import Iterable

from tfsat_host.cli.output import Output

WIDEST = 80
_LABEL = 12
_LEAST = 24
_MOST_DECIMALS = 6


def plus_minus(value: float, std: float, *, sign: bool = False) -> str:
    """`27.978 ± 0.014`: as many decimals as the standard deviation has a meaning with, two digits of it."""
    if not math.isfinite(value):
        return "unknown"
    if not math.isfinite(std):
        return f"{number(value, 2, sign=sign)} ± unknown"
    decimals = 2 if std <= 0.0 else min(max(1 - math.floor(math.log10(std)), 0), _MOST_DECIMALS)
    return f"{number(value, decimals, sign=sign)} ± {std:.{decimals}f}"


def number(value: float, decimals: int, *, sign: bool = False) -> str:
    """A number with so many decimals and no minus before a zero; `unknown` if it is none."""
    if not math.isfinite(value):
        return "unknown"
    rounded = round(float(value), decimals) + 0.0
    return f"{rounded:+.{decimals}f}" if sign else f"{rounded:.{decimals}f}"


def printable(text: object) -> str:
    """A name as it can be shown: what would move the cursor or colour the screen is written as an escape."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text))


def labelled(label: str, text: str, out: Output) -> None:
    """A line that begins with a label; it goes on below its text, and where that leaves no room, below the label."""
    width = _width()
    indent = _LABEL if width >= _LEAST + _LABEL else 2
    first = label.ljust(_LABEL) if indent == _LABEL else f"{label}  ".lstrip() or "  "
    for line in _wrapped(text, width, first, " " * indent):
        out.line(line)


def bullets(texts: Iterable[str], out: Output) -> None:
    """One sentence or more each."""
    for text in texts:
        for line in _wrapped(text, _width(), "  - ", "    "):
            out.line(line)


def sentences(texts: Iterable[str], out: Output) -> None:
    """As they are, one below the other."""
    for text in texts:
        for line in _wrapped(text, _width(), "", "  "):
            out.line(line)


def _wrapped(text: str, width: int, first: str, others: str) -> list[str]:
    return textwrap.wrap(
        printable(text),
        width,
        initial_indent=first,
        subsequent_indent=others,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _width() -> int:
    return min(shutil.get_terminal_size((WIDEST, 24)).columns, WIDEST)
