"""The maneuver file: TOML that people write, checked key by key before anything else sees it.

    schema = 1
    name = "drop tower 59/70"
    speed_deg_s = 170.0        # optional
    pause_s = 0.70             # optional; with t_s in the strokes it has no place

    [[strokes]]
    joint = 1
    angle_deg = 59.0
    t_s = 0.70                 # optional; in every stroke or in none

A key that is not known is an error: a misspelt `angel_deg` must not fly as something else.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tfsat_host.maneuver.errors import Defect, ManeuverError, shortened
from tfsat_host.maneuver.maneuver import DEFAULT_PAUSE_S, DEFAULT_SPEED_DEG_S, Maneuver
from tfsat_host.maneuver.stroke import Stroke

SCHEMA = 1
_MANEUVER_KEYS = ("schema", "name", "speed_deg_s", "pause_s", "strokes")
_STROKE_KEYS = ("joint", "angle_deg", "t_s")
_FILE_BYTES_MAX = 1_000_000
_START_FROM = (
    "For a file to start from, without any board: "
    "tfsat-host upload-sequence 59 70 --dry-run --out maneuver.toml"
)


def read_maneuver(path: Path) -> Maneuver:
    """Reads a maneuver file; its strokes are checked by `schedule_maneuver`.

    Raises:
        ManeuverError: the file cannot be read or understood; names file, entry and cure.
    """
    try:
        if path.stat().st_size > _FILE_BYTES_MAX:
            raise _error(path.name, Defect.FILE_SYNTAX, "this is no maneuver file: it is too large.")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ManeuverError(
            Defect.FILE_UNREADABLE,
            what=f"The maneuver file {path} cannot be read: {error.strerror or error}.",
            next_step="Give the path of a maneuver file.",
        ) from error
    except UnicodeDecodeError as error:
        raise _error(str(path), Defect.FILE_SYNTAX, "this is no text in UTF-8.") from error
    return parse_maneuver(text, source=str(path))


def parse_maneuver(text: str, *, source: str = "maneuver") -> Maneuver:
    """The maneuver in the text of a file; `source` is the name that errors give it.

    Raises:
        ManeuverError: syntax, schema, unknown or missing keys, wrong types.
    """
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also numbers and nesting beyond Python's own limits
        raise _error(source, Defect.FILE_SYNTAX, f"this is no TOML: {error}.") from error
    entries = _Entries(source, "", table)
    entries.require("schema")
    if type(table["schema"]) is not int or table["schema"] != SCHEMA:
        raise _error(
            source,
            Defect.FILE_SCHEMA,
            f"schema is {shortened(repr(table['schema']))}; this version of tfsat-host reads schema {SCHEMA}.",
            f"Write schema = {SCHEMA}, or use the tfsat-host that made the file.",
        )
    entries.allow(_MANEUVER_KEYS)
    entries.require("strokes")
    rows = table["strokes"]
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise _error(
            source,
            Defect.FILE_WRONG_TYPE,
            "strokes is no list of tables.",
            "Begin each stroke with [[strokes]].",
        )
    strokes = tuple(_stroke(source, number, row) for number, row in enumerate(rows, 1))
    if "pause_s" in table and any(stroke.t_s is not None for stroke in strokes):
        raise _error(
            source,
            Defect.FILE_UNKNOWN_KEY,
            "pause_s has no effect when the strokes have times of their own.",
            "Remove pause_s, or t_s from every stroke.",
        )
    return Maneuver(
        strokes,
        speed_deg_s=entries.number("speed_deg_s", DEFAULT_SPEED_DEG_S),
        pause_s=entries.number("pause_s", DEFAULT_PAUSE_S),
        name=entries.text("name", ""),
    )


def format_maneuver(maneuver: Maneuver) -> str:
    """The text of a maneuver file; `parse_maneuver` gives the same maneuver back."""
    timed = any(stroke.t_s is not None for stroke in maneuver.strokes)
    lines = [f"schema = {SCHEMA}"]
    if maneuver.name:
        lines.append(f"name = {_toml_string(maneuver.name)}")
    lines.append(f"speed_deg_s = {float(maneuver.speed_deg_s)!r}")
    if not timed:
        lines.append(f"pause_s = {float(maneuver.pause_s)!r}")
    if not maneuver.strokes:
        lines.append("strokes = []")
    for stroke in maneuver.strokes:
        lines += ["", "[[strokes]]", f"joint = {stroke.joint}", f"angle_deg = {float(stroke.angle_deg)!r}"]
        if stroke.t_s is not None:
            lines.append(f"t_s = {float(stroke.t_s)!r}")
    return "\n".join(lines) + "\n"


def write_maneuver(maneuver: Maneuver, path: Path) -> None:
    """Writes a maneuver file.

    Raises:
        OSError: the file cannot be written.
    """
    path.write_text(format_maneuver(maneuver), encoding="utf-8")


def _stroke(source: str, number: int, row: Mapping[str, Any]) -> Stroke:
    entries = _Entries(source, f"stroke {number}: ", row, number)
    entries.allow(_STROKE_KEYS)
    entries.require("joint")
    entries.require("angle_deg")
    joint = row["joint"]
    if not isinstance(joint, int) or isinstance(joint, bool):
        raise entries.wrong_type("joint", "a whole number such as 1")
    t_s = entries.number("t_s", 0.0) if "t_s" in row else None
    return Stroke(joint, entries.number("angle_deg", 0.0), t_s)


class _Entries:
    """One table of the file, with the words to say where an entry stands."""

    def __init__(self, source: str, place: str, table: Mapping[str, Any], stroke: int | None = None) -> None:
        self._source = source
        self._place = place
        self._table = table
        self._stroke = stroke

    def allow(self, keys: tuple[str, ...]) -> None:
        for key in self._table:
            if key not in keys:
                raise self._fail(
                    Defect.FILE_UNKNOWN_KEY,
                    f"the key {key!r} is not known.",
                    f"Known keys: {', '.join(keys)}.",
                )

    def require(self, key: str) -> None:
        if key not in self._table:
            raise self._fail(Defect.FILE_MISSING_KEY, f"the key {key!r} is missing.", f"Add {_EXAMPLES[key]}")

    def number(self, key: str, default: float) -> float:
        value = self._table.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.wrong_type(key, "a number")
        try:
            return float(value)
        except OverflowError as error:
            raise self.wrong_type(key, "a number of usual size") from error

    def text(self, key: str, default: str) -> str:
        value = self._table.get(key, default)
        if not isinstance(value, str):
            raise self.wrong_type(key, "text in quotes")
        return value

    def wrong_type(self, key: str, wanted: str) -> ManeuverError:
        value = self._table[key]
        shown = _toml_string(value) if isinstance(value, str) else str(value)
        return self._fail(Defect.FILE_WRONG_TYPE, f"{key} is {shortened(shown)}.", f"Give {wanted}.")

    def _fail(self, code: Defect, what: str, next_step: str) -> ManeuverError:
        return _error(self._source, code, self._place + what, next_step, self._stroke)


_EXAMPLES = {
    "schema": f"the line schema = {SCHEMA} at the top of the file.",
    "strokes": "at least one [[strokes]] with joint and angle_deg.",
    "joint": "joint = 1, 2 or 3.",
    "angle_deg": "angle_deg, the change of the joint angle in degrees.",
}


def _error(
    source: str,
    code: Defect,
    what: str,
    next_step: str = _START_FROM,
    stroke: int | None = None,
) -> ManeuverError:
    return ManeuverError(code, what=f"{source}: {what}", next_step=next_step, stroke=stroke)


def _toml_string(text: str) -> str:
    """A TOML basic string: JSON's escapes are a subset of TOML's, but DEL must be escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
