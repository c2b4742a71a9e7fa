"""Where an entry of a TOML file stands: the parser does not say, and a person needs to know."""

from __future__ import annotations

import re

# Not a row of numbers in an array that goes over several lines.
_HEADER = re.compile(r"\s*\[{1,2}\s*([^\[\],]+?)\s*\]{1,2}\s*(?:#|$)")


def line_of(text: str, table: str, index: int, key: str) -> int | None:
    """Line (from 1) of `key` in the `index`-th `[[table]]`, of its header if the key is not there.

    `table` is empty for the entries above all tables. A sub-table `[joint.servo]` belongs to the
    `[[joint]]` before it. A `key` that is a table itself stands at its header. None if there is no such table.
    """
    owner = table.partition(".")[0]
    below = f"{table}.{key}" if table else key
    seen, inside, header = -1, table == "", None if table else 1
    for number, line in enumerate(text.splitlines(), start=1):
        if match := _HEADER.match(line):
            name = match[1]
            seen += name == owner
            if name == below and (seen == index or not table):
                return number
            inside = seen == index and name == table
            if seen == index and name in (owner, table):
                header = number
        elif inside and re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*=", line):
            return number
    return header
