"""The report page: one HTML file that needs nothing but itself.

The file holds no address and asks for nothing: its policy lets run exactly the one script and apply exactly the
one style sheet whose hashes it names, and forbids every request. The document lies in it as JSON and is shown as
text only; the browser is to refuse any other way (trusted types).
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from tfsat_host.next_step import NextStep
from tfsat_host.quantity import number, plus_minus
from tfsat_host.report.document_rounding import clean

_LIBRARIES = ("uplot.min.js", "twgl.min.js")
_LICENCES = ("uplot.LICENSE", "twgl.LICENSE")

_STYLES = ("base", "header", "verdict", "motion", "plots", "replay", "tables", "print")

# The scripts share one scope: a file uses names of the files above it. No bundler, no build step.
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
_HARMLESS = {ord(character): f"\\u{ord(character):04x}" for character in "<>&"}
"""Inside JSON these occur in strings only, where an escape means the same. Without `<` no tag and no comment
begins; everything beyond ASCII (U+2028, lone surrogates from an undecodable log) is escaped by json itself."""
_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>tfsat report</title>
<style>{style}</style>
</head>
<body>
<noscript>
{results}
<p>Plots and replay need JavaScript, which is off. All results as text: {as_text}</p>
</noscript>
<script type="application/json" id="document">{document}</script>
<script type="application/json" id="licences">{licences}</script>
<script>{script}</script>
</body>
</html>
"""


def render(document: Mapping[str, Any]) -> str:
    """Render the page of a document, to be written as UTF-8.

    NaN and infinity become gaps; strings beyond 2000 characters are cut, and say so.

    Raises:
        KeyError: A part of the document is missing.
        TypeError: The document holds something that JSON cannot.
    """
    js, css = script(), style()
    cut = clean(document)
    return _PAGE.format(
        policy=_policy(js, css),
        style=css,
        results=without_script(cut),
        as_text=NextStep("evaluate"),
        document=embeddable(cut),
        licences=embeddable(dict(licences())),
        script=js,
    )


def _policy(js: str, css: str) -> str:
    """Content Security Policy: this script, this style, nothing from anywhere."""
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {_hash_source(js)}",
            f"style-src {_hash_source(css)}",
            "base-uri 'none'",
            "form-action 'none'",
            "require-trusted-types-for 'script'",
            "trusted-types 'none'",
        )
    )


def _hash_source(text: str) -> str:
    # A hash source of the policy: base64 of the SHA-256 of exactly what stands between the tags.
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


@cache
def script() -> str:
    """Return all JavaScript: the libraries, then our own as one strict function."""
    # The libraries define globals; our own code sees them from inside one function and leaves none.
    libraries = "\n".join(_read("vendor", name) for name in _LIBRARIES)
    own = "\n".join(_read("assets", "script", f"{name}.js") for name in _SCRIPTS)
    return f'{libraries}\n(() => {{\n"use strict";\n{own}\n}})();\n'


@cache
def style() -> str:
    """Return all CSS: the library's, then our own."""
    own = [_read("assets", "style", f"{name}.css") for name in _STYLES]
    return "\n".join([_read("vendor", "uplot.min.css"), *own])


@cache
def licences() -> tuple[tuple[str, str], ...]:
    """Name and licence text of each library that the page carries."""
    return tuple((name.removesuffix(".LICENSE"), _read("vendor", name)) for name in _LICENCES)


def _read(*path: str) -> str:
    return files("tfsat_host.report").joinpath(*path).read_text(encoding="utf-8")


def embeddable(document: Mapping[str, Any]) -> str:
    """Encode the document as ASCII for a `<script type="application/json">` element.

    Raises:
        ValueError: A number is not finite.
        TypeError: Something that JSON cannot hold.
    """
    # NaN would be no JSON: a browser refuses the whole document for one.
    text = json.dumps(document, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.translate(_HARMLESS)


def without_script(document: Mapping[str, Any]) -> str:
    """Render all drops for browsers without JavaScript; every string of the document is escaped."""
    lacking = [f"<p>{_text(sentence)}</p>" for sentence in document.get("lacking", ())]
    return "\n".join([f"<h1>{_text(document['title'])}</h1>", *lacking, *map(_drop, document["drops"])])


def _drop(drop: Mapping[str, Any]) -> str:
    verdict = drop["verdict"]
    reasons = "".join(f"<li>{_text(reason)}</li>" for reason in verdict["reasons"])
    numbers = "".join(
        f"<tr><th>{_text(key_number['label'])}</th><td>{_figure(key_number)}</td><td>{_text(key_number['note'])}</td></tr>"
        for key_number in drop["key_numbers"]
    )
    return (
        f"<h2>{_text(drop['name'])}: {_text(verdict['level'])}</h2>\n<p>{_text(verdict['sentence'])}</p>\n"
        f"<ul>{reasons}</ul>\n{_table(drop['prediction'])}\n<p>{_text(drop['change'])}</p>\n"
        f"{_table(drop['strokes'])}\n<table>{numbers}</table>"
    )


def _table(table: Mapping[str, Any]) -> str:
    rows = [table["columns"], *table["rows"]]
    cells = ("".join(f"<td>{_text(cell)}</td>" for cell in row) for row in rows)
    body = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<table><caption>{_text(table['title'])}</caption>{body}</table>"


def _figure(key_number: Mapping[str, Any]) -> str:
    value, std = key_number["value"], key_number["std"]
    if value is None:
        return "–"
    unit = _text(key_number["unit"])
    # Without a standard deviation no decimals are known to mean anything: four digits.
    number_text = number(value, ".4g") if std is None or std <= 0.0 else plus_minus(value, std)
    return f"{number_text} {unit}"


def _text(text: object) -> str:
    """Without what no UTF-8 file can hold: lone surrogates of an undecodable log."""
    printable = str(text).encode("utf-8", "replace").decode("utf-8").replace("\x00", "")
    return html.escape(printable)
