"""JSON that may stand inside an HTML page: nothing in it can end its element or start another one."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

_HARMLESS = {ord(character): f"\\u{ord(character):04x}" for character in "<>&"}
"""Inside JSON these occur in strings only, where an escape means the same. Without `<` no tag and no comment
begins; everything beyond ASCII (U+2028, lone surrogates from an undecodable log) is escaped by json itself."""


def embeddable(document: Mapping[str, Any]) -> str:
    """The document as ASCII for a `<script type="application/json">` element.

    Raises:
        ValueError: A number is not finite.
        TypeError: Something that JSON cannot hold.
    """
    text = json.dumps(document, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.translate(_HARMLESS)
