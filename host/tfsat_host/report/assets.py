"""The page's own scripts and styles, in the order in which the page holds them, and what it is drawn with.

The scripts share one scope: a file uses names of the files above it. No bundler, no build step.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files

_LIBRARIES = ("uplot.min.js", "twgl.min.js")
_LICENCES = ("uplot.LICENSE", "twgl.LICENSE")

_STYLES = ("base", "header", "verdict", "motion", "plots", "replay", "tables", "print")

_SCRIPTS = (
    "elements",  # the page's parts, text as text
    "numbers",  # numbers as people read them
    "palette",  # colors, dashes and symbols
    "drops",  # which drop is looked at, which lie behind it
    "clock",  # the moment that plots and replay show
    "view",  # the span of time that the plots show
    "events",  # strokes and moments, on plots and in words
    "lines",  # a plot's lines, of one drop or several
    "marks",  # symbols and letters on lines
    "legend",  # names, values, switches of a plot's lines
    "axes",  # scales and ticks
    "pointer",  # the mouse over a chart
    "chart",  # a uPlot in a group of linked ones
    "plot",  # one plot
    "timeline",  # strokes and events by name
    "poses",  # where the bodies are at a time
    "boxes",  # boxes as triangles and edges
    "camera",  # how the replay is looked at
    "scene",  # bodies by WebGL
    "still",  # bodies without WebGL
    "triad",  # the inertial axes in the replay's corner
    "replay",  # the replay and what stands under it
    "transport",  # play, speed, scrub
    "keyboard",  # the keys
    "verdict",  # verdict, key numbers, what could not be used
    "comparison",  # several drops: which one, and their numbers side by side
    "tables",  # tables, licences
    "contents",  # the sections by name, drops that are missing
    "page",  # all of it
)


@cache
def script() -> str:
    """All JavaScript: the libraries, then our own as one strict function."""
    libraries = "\n".join(_read("vendor", name) for name in _LIBRARIES)
    own = "\n".join(_read("assets", "script", f"{name}.js") for name in _SCRIPTS)
    return f'{libraries}\n(() => {{\n"use strict";\n{own}\n}})();\n'


@cache
def style() -> str:
    """All CSS."""
    own = [_read("assets", "style", f"{name}.css") for name in _STYLES]
    return "\n".join([_read("vendor", "uplot.min.css"), *own])


@cache
def licences() -> tuple[tuple[str, str], ...]:
    """Name and licence text of each library that the page carries."""
    return tuple((name.removesuffix(".LICENSE"), _read("vendor", name)) for name in _LICENCES)


def _read(*path: str) -> str:
    return files("tfsat_host.report").joinpath(*path).read_text(encoding="utf-8")
