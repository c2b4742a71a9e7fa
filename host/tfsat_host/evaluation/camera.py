"""Two CSV files that are read off a video: the events of the drop, and the places of the laser spots.

Events:

    event,t_s
    release,12.3833
    stroke 1,13.1000
    landing,14.8833

| column | |
|---|---|
| `event` | `release`, `stroke 1`, `stroke 2` and so on, or `landing`; each once at most, in any order, one is enough |
| `t_s` | seconds on the video's own clock, from anywhere: (frame number) / (frames per second) of the player will do |
| `std_s` | optional column or cell: standard deviation of `t_s` |

How to read them off. *release*: the first frame with a gap between magnet and robot. *stroke n*: the first frame in
which the joint has moved, by the frame before. *landing*: the first frame with the robot at the cushion. What changed
between two frames was half a frame earlier than the later of them, give or take half a frame: write that middle, and
the frame's duration / sqrt(12) as `std_s`.

The player may show slow motion: two events tell how fast its clock runs, three also whether one was misread.

Without `std_s` a video of 60 frames a second is assumed, and that a joint has turned by 1 deg before anyone sees it
(22 ms from rest at 4000 deg/s², besides the servo's own delay).

Spots on the graph paper, by a tracking program or by hand:

    t_s,spot,along_mm,up_mm
    0.1500,1,12.4,310.2
    0.1500,2,-3.1,287.9

| column | |
|---|---|
| `t_s` | seconds after the release; or instead of it: |
| `video_t_s` | seconds on the video's own clock, which the events of the same video (`video.py`) tie to the release |
| `spot` | 1 or 2: which laser, see `laser_velocity` |
| `along_mm` | horizontal place on the wall, from any zero, growing towards +y of body 2 (spot 1) or +x (spot 2) |
| `up_mm` | vertical place on the wall, from any zero, growing upwards: it falls as the robot does |
| `std_mm` | optional column or cell: standard deviation of both places; empty is 0.5 mm (paper with 1 mm squares) |

Rows may come in any order, the spots at different times. Correct for the camera's perspective before: millimetres are
those of the graph paper.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NoReturn

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray, IntArray
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.clock_fit import ClockFit
from tfsat_host.protocol.limits import MAX_STROKES

# Stricter than float(): neither nan nor inf, no underscores, no digits of other scripts.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_SHOWN = 40
"""Characters of a wrong cell that a message shows: a damaged file may hold a line of millions."""


@dataclass(frozen=True, slots=True)
class CsvForm:
    """What a file is to hold, and what it means if it does not.

    Attributes:
        path: The file.
        subject: What it is, in words.
        required: Columns that must be there; others are free.
        meaning: What is unknown without it.
        error: What is raised.
        header: The first line that it should have.
    """

    path: Path
    subject: str
    required: tuple[str, ...]
    meaning: str
    error: type[TfsatError]
    header: str

    def fail(self, what: str, next_step: str, line: int | None = None) -> NoReturn:
        """Raises `error`; `what` is led by the file, and the line if one is to blame."""
        where = f"{self.path}:{line}" if line is not None else f"{self.path}"
        raise self.error(what=f"{where}: {what}", meaning=self.meaning, next_step=next_step)


@dataclass(frozen=True, slots=True)
class CsvRow:
    """One row; cells without their surrounding blanks, missing ones empty."""

    form: CsvForm
    line: int
    cells: dict[str, str]

    def text(self, column: str) -> str:
        """Return the cell's text; empty if the file has no such column."""
        return self.cells.get(column, "")

    def number(self, column: str, *, largest: float, above: float | None = None) -> float:
        """Parse a finite number of magnitude `largest` at most, and greater than `above` if that is given."""
        cell = self.text(column)
        if not _NUMBER.fullmatch(cell):
            quoted_text = repr(cell[:_SHOWN]) if cell else "missing"
            cure = "Write a number there, with a point for the decimals, or leave out the whole row."
            self.form.fail(f"{column} is {quoted_text}.", cure, self.line)
        value = float(cell)
        if abs(value) > largest:
            self.form.fail(
                f"{column} is {value:g}, beyond {largest:g}.",
                "Correct the number or its unit, or leave out the whole row.",
                self.line,
            )
        if above is not None and not value > above:
            self.form.fail(
                f"{column} is {value:g}; it must be above {above:g}.",
                f"Correct it, or leave the column {column} out.",
                self.line,
            )
        return value


def read_rows(form: CsvForm) -> list[CsvRow]:
    """Read all rows below the header that are not blank.

    Raises:
        TfsatError: of the form's kind; the file cannot be read, or a column is missing or duplicated.
    """
    try:
        # Spreadsheets write a byte-order mark, which would become part of the first column's name.
        with form.path.open(encoding="utf-8-sig", newline="") as file:
            return list(_rows(form, file))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text in UTF-8"
        form.fail(f"The {form.subject} cannot be read: {reason}.", "Give the path of a CSV file.")
    except csv.Error as error:
        form.fail(f"this is no CSV file: {error}.", f"Begin it with the line {form.header}")


def _rows(form: CsvForm, file: Iterable[str]) -> Iterator[CsvRow]:
    # Strict: an unclosed quote is an error, not a cell that swallows the rest of the file.
    rows = csv.reader(file, strict=True)
    names = [name.strip() for name in next(rows, [])]
    for name in form.required:
        if name not in names:
            cure = f"Begin the file with the line {form.header} and separate columns by commas."
            form.fail(f"there is no column {name}.", cure, 1)
    # Of two columns with one name the later would silently replace the other in a row's cells.
    for name in names:
        if name and names.count(name) > 1:
            cure = "Keep the one that is meant, and rename or remove the other."
            form.fail(f"the column {name[:_SHOWN]} is there {names.count(name)} times.", cure, 1)
    for row in rows:
        if any(cell.strip() for cell in row):
            # Short rows lack cells, which read as empty; cells beyond the header are dropped.
            cells = (cell.strip() for cell in row)
            yield CsvRow(form, rows.line_num, dict(zip(names, cells, strict=False)))


FRAME_STD_S = 1 / 60 / 12**0.5
"""Of what changed between two frames, 60 a second."""
STROKE_STD_S = 0.02
"""Of a stroke's first visible motion."""
_MAX_S = 1e6
_STROKE = re.compile(r"stroke ([1-9]\d?)", re.ASCII)


class VideoFileError(TfsatError):
    """The file does not give the times of events in a video (exit code 1)."""


@dataclass(frozen=True, slots=True)
class Mark:
    """An event as one clock has it.

    Attributes:
        event: `release`, `stroke 1` and so on, `landing`.
        t_s: On that clock.
        std_s: Standard deviation, above zero.
    """

    event: str
    t_s: float
    std_s: float


def read_video_marks(path: Path) -> tuple[Mark, ...]:
    """Read the events in a file, ordered by time.

    Raises:
        VideoFileError: the file cannot be read or understood; names file, line and cure.
    """
    form = CsvForm(
        path=path,
        subject="video's events",
        required=("event", "t_s"),
        meaning="The video's clock is unknown: nothing that was filmed can be compared with the log.",
        error=VideoFileError,
        header="event,t_s",
    )
    marks: dict[str, Mark] = {}
    for row in read_rows(form):
        event = _event(row)
        if event in marks:
            cure = "Keep the row that is meant."
            form.fail(f"the event {event} is there a second time.", cure, row.line)
        marks[event] = Mark(event, row.number("t_s", largest=_MAX_S), _std_s(row, event))
    if not marks:
        form.fail("there is no event.", "Add a row, such as release,12.3833", None)
    return tuple(sorted(marks.values(), key=lambda mark: mark.t_s))


def _event(row: CsvRow) -> str:
    # Ignore case and repeated blanks: the file is written by hand.
    event = " ".join(row.text("event").lower().split())
    number = _STROKE.fullmatch(event)
    is_known = event in ("release", "landing") or (number is not None and int(number[1]) <= MAX_STROKES)
    if not is_known:
        quoted_text = repr(row.text("event")[:40]) if event else "missing"
        cure = f"Write release, landing or stroke 1 to stroke {MAX_STROKES}, or leave out the row."
        row.form.fail(f"the event is {quoted_text}.", cure, row.line)
    return event


def _std_s(row: CsvRow, event: str) -> float:
    if row.text("std_s"):
        return row.number("std_s", largest=_MAX_S, above=0.0)
    return STROKE_STD_S if event.startswith("stroke") else FRAME_STD_S


# Graph paper with squares of 1 mm is read to half a square.
READING_STD_M = 0.5e-3
_MAX_TIME_S = 1e6
_MAX_MM = 1e4
_MEANING = "How fast the robot left the release mechanism cannot be told from the lasers."


class LaserFileError(TfsatError):
    """The file does not give the tracks of the laser spots (exit code 1)."""


@dataclass(frozen=True, eq=False)
class LaserTracks:
    """n places of a laser spot, by time.

    Attributes:
        path: The file.
        t_s: (n,) after the release; on the video's clock if `on_video_clock`.
        spot: (n,) 1 or 2.
        along_m: (n,) horizontally, see the module's table.
        up_m: (n,) upwards.
        std_m: (n,) standard deviation of a place, each coordinate.
        on_video_clock: What `t_s` counts.
        rate_std: Relative standard deviation of how fast that clock runs; 0 where `t_s` counts from the release.
    """

    path: Path
    t_s: FloatArray
    spot: IntArray
    along_m: FloatArray
    up_m: FloatArray
    std_m: FloatArray
    on_video_clock: bool
    rate_std: float = 0.0

    def between(self, from_s: float, until_s: float) -> LaserTracks:
        """Return the tracks between two times, both included."""
        return self.only((self.t_s >= from_s) & (self.t_s <= until_s))

    def only(self, rows: BoolArray) -> LaserTracks:
        """Return the tracks in the selected rows (n,)."""
        columns = ("t_s", "spot", "along_m", "up_m", "std_m")
        return replace(self, **{name: getattr(self, name)[rows] for name in columns})

    def after_release(self, video: ClockFit | None) -> LaserTracks:
        """Return the same tracks on the logger's clock, whose zero is the release.

        Raises:
            LaserFileError: the tracks are on the video's clock, and that clock is unknown.
        """
        if not self.on_video_clock:
            return self
        if video is None:
            raise LaserFileError(
                what=f"{self.path}: video_t_s counts on the video's clock, which nothing ties to the release.",
                meaning=_MEANING,
                next_step="Give the video's events too, or write seconds after the release into a column t_s.",
            )
        # Relative error of the clock's slope: every velocity by this clock is off by it.
        rate_std = 1e-6 * video.rate_ppm_std * video.slope
        return replace(self, t_s=video.to_logger_s(self.t_s), on_video_clock=False, rate_std=rate_std)


def read_tracks(path: Path) -> LaserTracks:
    """Read the laser tracks in a file, ordered by time.

    Raises:
        LaserFileError: the file cannot be read or understood; names file, line and cure.
    """
    required = ("spot", "along_mm", "up_mm")
    form = CsvForm(
        path, "tracks of the laser spots", required, _MEANING, LaserFileError, "t_s,spot,along_mm,up_mm"
    )
    rows = read_rows(form)
    if not rows:
        form.fail("there is no place of a spot.", "Add rows, such as 0.15,1,12.4,310.2")
    clock = _clock(form, rows[0])
    table = np.array([_place(row, clock) for row in rows])
    table = table[np.argsort(table[:, 0], kind="stable")]
    t_s, spot, along_mm, up_mm, std_m = table.T
    return LaserTracks(
        path, t_s, spot.astype(np.int64), 1e-3 * along_mm, 1e-3 * up_mm, std_m, clock == "video_t_s"
    )


def _clock(form: CsvForm, row: CsvRow) -> str:
    """Find the file's one column of times; refuse both or neither."""
    there = [name for name in ("t_s", "video_t_s") if name in row.cells]
    if len(there) != 1:
        subject = "both t_s and video_t_s are" if there else "neither t_s nor video_t_s is"
        cure = "Keep one: t_s counts from the release, video_t_s on the video's own clock."
        form.fail(f"{subject} a column of this file.", cure, 1)
    return there[0]


def _place(row: CsvRow, clock: str) -> tuple[float, ...]:
    if row.text("spot") not in ("1", "2"):
        quoted_text = repr(row.text("spot")[:40]) if row.text("spot") else "missing"
        row.form.fail(f"the spot is {quoted_text}.", "Write 1 or 2, or leave out the row.", row.line)
    std_m = READING_STD_M
    if row.text("std_mm"):
        std_m = 1e-3 * row.number("std_mm", largest=_MAX_MM, above=0.0)
    return (
        row.number(clock, largest=_MAX_TIME_S),
        float(row.text("spot")),
        row.number("along_mm", largest=_MAX_MM),
        row.number("up_mm", largest=_MAX_MM),
        std_m,
    )
