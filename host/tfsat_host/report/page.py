"""The report page: one HTML file that needs nothing but itself.

The file holds no address and asks for nothing: its policy lets run exactly the one script and apply exactly the
one style sheet whose hashes it names, and forbids every request. The document lies in it as JSON and is shown as
text only; the browser is told to refuse any other way (trusted types).
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from typing import Any

from tfsat_host.report import assets
from tfsat_host.report.embedding import embeddable
from tfsat_host.report.results import without_script
from tfsat_host.report.shortening import shortened

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
<p>Plots and replay draw themselves with JavaScript, which is switched off here. All results as text:
tfsat-host evaluate.</p>
</noscript>
<script type="application/json" id="document">{document}</script>
<script type="application/json" id="licences">{licences}</script>
<script>{script}</script>
</body>
</html>
"""


def render(document: Mapping[str, Any]) -> str:
    """The page of a document (`tfsat_host.report.document.Document`), to be written as UTF-8.

    Numbers are rounded to what a plot can show; NaN and infinity become gaps; strings beyond 2000 characters are
    cut, and say so.

    Raises:
        KeyError: A part of the document is missing.
        TypeError: The document holds something that JSON cannot.
    """
    script, style = assets.script(), assets.style()
    cut = shortened(document)
    return _PAGE.format(
        policy=_policy(script, style),
        style=style,
        results=without_script(cut),
        document=embeddable(cut),
        licences=embeddable(dict(assets.licences())),
        script=script,
    )


def _policy(script: str, style: str) -> str:
    """Content Security Policy: this script, this style, nothing from anywhere."""
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {_hash_source(script)}",
            f"style-src {_hash_source(style)}",
            "base-uri 'none'",
            "form-action 'none'",
            "require-trusted-types-for 'script'",
            "trusted-types 'none'",
        )
    )


def _hash_source(text: str) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"
