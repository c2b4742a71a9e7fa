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

from pathlib import Path

from tfsat_host.config import ConfigKind, Fault, Table, format_config, parse_config, read_config
from tfsat_host.maneuver.maneuver import (
    DEFAULT_PAUSE_S,
    DEFAULT_SPEED_DEG_S,
    NO_MANEUVER,
    Defect,
    Maneuver,
    ManeuverError,
    Stroke,
)

SCHEMA = 1
_KIND = ConfigKind(
    name="maneuver file",
    error=ManeuverError,
    meaning=NO_MANEUVER,
    cure="For a file to start from, without any board: "
    "tfsat-host upload-sequence 59 70 --dry-run --out maneuver.toml",
    format=("schema", SCHEMA),
    codes={Fault.NOT_TEXT: Defect.FILE_SYNTAX, Fault.FORMAT: Defect.FILE_SCHEMA},
    bytes_max=1_000_000,
)


def read_maneuver(path: Path) -> Maneuver:
    """Reads a maneuver file; its strokes are checked by `schedule_maneuver`.

    Raises:
        ManeuverError: the file cannot be read or understood; names file, line, entry and cure.
    """
    return _maneuver(read_config(path, _KIND))


def parse_maneuver(text: str, *, source: str = "maneuver") -> Maneuver:
    """The maneuver in the text of a file; `source` is the name that errors give it.

    Raises:
        ManeuverError: syntax, schema, unknown or missing keys, wrong types.
    """
    return _maneuver(parse_config(text, source, _KIND))


def _maneuver(top: Table) -> Maneuver:
    top.only("schema name speed_deg_s pause_s strokes")
    rows = top.tables("strokes", "joint angle_deg t_s", needed=True)
    strokes = tuple(_stroke(row) for row in rows)
    if top.has("pause_s") and any(stroke.t_s is not None for stroke in strokes):
        top.fail(
            "pause_s",
            "has no effect when the strokes have times of their own",
            "Remove pause_s, or t_s from every stroke.",
            Fault.UNKNOWN_KEY,
        )
    return Maneuver(
        strokes,
        speed_deg_s=top.number("speed_deg_s", DEFAULT_SPEED_DEG_S, finite=False),
        pause_s=top.number("pause_s", DEFAULT_PAUSE_S, finite=False),
        name=top.text("name", "", empty=True),
    )


def _stroke(row: Table) -> Stroke:
    return Stroke(
        row.integer("joint", wanted="a joint's number: 1, 2 or 3"),
        row.number("angle_deg", finite=False, wanted="a number, the change of the joint angle in degrees"),
        row.number("t_s", finite=False) if row.has("t_s") else None,
    )


def format_maneuver(maneuver: Maneuver) -> str:
    """The text of a maneuver file; `parse_maneuver` gives the same maneuver back."""
    timed = any(stroke.t_s is not None for stroke in maneuver.strokes)
    return format_config(
        {
            "schema": SCHEMA,
            "name": maneuver.name or None,
            "speed_deg_s": float(maneuver.speed_deg_s),
            "pause_s": None if timed else float(maneuver.pause_s),
            "strokes": [
                {"joint": stroke.joint, "angle_deg": float(stroke.angle_deg), "t_s": stroke.t_s}
                for stroke in maneuver.strokes
            ],
        }
    )


def write_maneuver(maneuver: Maneuver, path: Path) -> None:
    """Writes a maneuver file.

    Raises:
        OSError: the file cannot be written.
    """
    path.write_text(format_maneuver(maneuver), encoding="utf-8")
