"""Verdicts and key numbers as plain HTML, for readers whose browser runs no script."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

from tfsat_host.quantity import number, plus_minus


def without_script(document: Mapping[str, Any]) -> str:
    """Of all drops; every string of the document is escaped.

    Args:
        document: As it is embedded, see `shortening.shortened`.
    """
    lacking = [f"<p>{_text(one)}</p>" for one in document.get("lacking", ())]
    return "\n".join([f"<h1>{_text(document['title'])}</h1>", *lacking, *map(_drop, document["drops"])])


def _drop(drop: Mapping[str, Any]) -> str:
    verdict = drop["verdict"]
    reasons = "".join(f"<li>{_text(reason)}</li>" for reason in verdict["reasons"])
    numbers = "".join(
        f"<tr><th>{_text(one['label'])}</th><td>{_figure(one)}</td><td>{_text(one['note'])}</td></tr>"
        for one in drop["key_numbers"]
    )
    return (
        f"<h2>{_text(drop['name'])}: {_text(verdict['level'])}</h2>\n<p>{_text(verdict['sentence'])}</p>\n"
        f"<ul>{reasons}</ul>\n<table>{numbers}</table>"
    )


def _figure(one: Mapping[str, Any]) -> str:
    value, std = one["value"], one["std"]
    if value is None:
        return "–"
    unit = _text(one["unit"])
    shown = number(value, ".4g") if std is None or std <= 0.0 else plus_minus(value, std)
    return f"{shown} {unit}"


def _text(text: object) -> str:
    """Without what no UTF-8 file can hold: lone surrogates of an undecodable log."""
    printable = str(text).encode("utf-8", "replace").decode("utf-8").replace("\x00", "")
    return html.escape(printable)
