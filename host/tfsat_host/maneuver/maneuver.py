"""A maneuver: strokes in order, with the speed and the pause that fix their times; and its file.

The file is TOML that people write, checked key by key:

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

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from tfsat_host.config import ConfigKind, Fault, Table, format_config, parse_config, read_config
from tfsat_host.config.places import line_of
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.units import cdeg_from_deg
from tfsat_host.whole_file import write_whole

NO_MANEUVER = "There is no maneuver that could be flown."


class Defect(StrEnum):
    """Stable names of the defects; tests, scripts and the documentation rely on them."""

    ANGLE_NOT_FINITE = "angle-not-finite"
    ZERO_STROKE = "zero-stroke"
    UNKNOWN_JOINT = "unknown-joint"
    JOINT_RANGE = "joint-range"
    NO_STROKES = "no-strokes"
    TOO_MANY_STROKES = "too-many-strokes"
    SPEED_RANGE = "speed-range"
    TIME_NOT_FINITE = "time-not-finite"
    TIMES_INCOMPLETE = "times-incomplete"
    BEFORE_PAUSE = "before-pause"
    STARTS_TOO_CLOSE = "starts-too-close"
    OVERLAP = "overlap"
    OUTLASTS_FALL = "outlasts-fall"
    FILE_UNREADABLE = "file-unreadable"
    FILE_SYNTAX = "file-syntax"
    FILE_SCHEMA = "file-schema"
    FILE_UNKNOWN_KEY = "file-unknown-key"
    FILE_MISSING_KEY = "file-missing-key"
    FILE_WRONG_TYPE = "file-wrong-type"


class ManeuverError(TfsatError):
    """The maneuver cannot be flown, or its file cannot be understood.

    What a command left undone because of it, the command adds to `meaning`.

    Attributes:
        code: Which defect; stable.
        stroke: Number of the stroke at fault, counted from 1, or None when it is the whole maneuver.
    """

    def __init__(
        self,
        code: StrEnum,
        *,
        what: str,
        next_step: str,
        meaning: str = NO_MANEUVER,
        stroke: int | None = None,
    ) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.code = Defect(code)
        self.stroke = stroke

    def in_file(self, file: Path) -> ManeuverError:
        """Return the same error with the maneuver's file added, and the line of the stroke at fault."""
        where = str(file) if self.stroke is None else place_of_stroke(file, self.stroke)
        return ManeuverError(
            self.code,
            what=f"{where}: {self.what}",
            meaning=self.meaning,
            next_step=self.next_step,
            stroke=self.stroke,
        )


def place_of_stroke(file: Path, number: int) -> str:
    """Return `FILE:LINE` of a stroke, counted from 1, in a maneuver file that could be read."""
    return f"{file}:{line_of(file.read_text(encoding='utf-8'), ('strokes', number - 1))}"


@dataclass(frozen=True, slots=True)
class Stroke:
    """One joint moves once, by a relative angle.

    Attributes:
        joint: 1 to 3; joint i joins body i and body i+1.
        angle_deg: Change of the joint angle; positive opens the joint.
        t_s: Start after release, if it is fixed; None leaves it to the schedule rule.
    """

    joint: int
    angle_deg: float
    t_s: float | None = None

    @property
    def angle_cdeg(self) -> int:
        """Hundredths of a degree, as the board gets it; half to even.

        Raises:
            ValueError: the angle is infinite or not a number.
        """
        return cdeg_from_deg(self.angle_deg)


DEFAULT_SPEED_DEG_S = 170.0  # average joint speed of the drop experiment (paper, maneuver design)
DEFAULT_PAUSE_S = 0.70  # keeps the robot off the release mechanism even at the slowest release, 30 mm/s


@dataclass(frozen=True, slots=True)
class Maneuver:
    """Strokes in the order they begin, from the folded pose (every joint at 0 deg).

    Strokes with times of their own may begin together, or while other joints are under way.

    Attributes:
        strokes: What moves, in order.
        speed_deg_s: Average speed of a joint during a stroke.
        pause_s: From release to the first stroke.
        name: For people; not sent to the robot.
    """

    strokes: tuple[Stroke, ...]
    speed_deg_s: float = DEFAULT_SPEED_DEG_S
    pause_s: float = DEFAULT_PAUSE_S
    name: str = ""


def four_stroke(a_deg: float, b_deg: float, *, speed_deg_s: float = DEFAULT_SPEED_DEG_S) -> Maneuver:
    """Build the closed loop +A joint 1, +B joint 2, -A joint 1, -B joint 2 (paper, maneuver design)."""
    strokes = (Stroke(1, a_deg), Stroke(2, b_deg), Stroke(1, -a_deg), Stroke(2, -b_deg))
    return Maneuver(strokes, speed_deg_s=speed_deg_s, name=f"{a_deg:g}/{b_deg:g}")


SCHEMA = 1
_KIND = ConfigKind(
    name="maneuver file",
    error=ManeuverError,
    meaning=NO_MANEUVER,
    cure=Advice(
        "For a file to start from, without any board: ",
        NextStep("upload-sequence", ("59", "70", "--dry-run", "--out", "maneuver.toml")),
    ),
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
    """Parse a maneuver from the text of a file; `source` is the file's name in errors.

    Raises:
        ManeuverError: syntax, schema, unknown or missing keys, wrong types.
    """
    return _maneuver(parse_config(text, source, _KIND))


def _maneuver(top: Table) -> Maneuver:
    top.only("schema name speed_deg_s pause_s strokes")
    rows = top.tables("strokes", "joint angle_deg t_s", needed=True)
    strokes = tuple(_stroke(row) for row in rows)
    # Where strokes have times a pause means nothing: refuse it rather than ignore it.
    if top.has("pause_s") and any(stroke.t_s is not None for stroke in strokes):
        top.fail(
            "pause_s",
            "has no effect when the strokes have times of their own",
            "Remove pause_s, or t_s from every stroke.",
            Fault.UNKNOWN_KEY,
        )
    # Infinite numbers pass here: `schedule_maneuver` has errors of its own for them.
    return Maneuver(
        strokes,
        speed_deg_s=top.number("speed_deg_s", DEFAULT_SPEED_DEG_S, finite=False),
        pause_s=top.number("pause_s", DEFAULT_PAUSE_S, finite=False),
        name=top.text("name", "", empty=True),
    )


def _stroke(row: Table) -> Stroke:
    return Stroke(
        row.integer("joint", requirement="a joint's number: 1, 2 or 3"),
        row.number(
            "angle_deg", finite=False, requirement="a number, the change of the joint angle in degrees"
        ),
        row.number("t_s", finite=False) if row.has("t_s") else None,
    )


def format_maneuver(maneuver: Maneuver) -> str:
    """Format a maneuver as the text of a maneuver file; `parse_maneuver` restores the same maneuver."""
    # A pause beside fixed times would be refused when the file is read.
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
    write_whole(path, format_maneuver(maneuver).encode())
