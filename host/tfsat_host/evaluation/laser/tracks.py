"""Where the two laser spots were on the graph paper, over time: a CSV file from a tracking program or by hand.

    t_s,spot,along_mm,up_mm
    0.1500,1,12.4,310.2
    0.1500,2,-3.1,287.9

| column | |
|---|---|
| `t_s` | seconds after the release; or instead of it: |
| `video_t_s` | seconds on the video's own clock, which the events of the same video (`video.py`) tie to the release |
| `spot` | 1 or 2: which laser, as `laser.LaserGeometry` has them |
| `along_mm` | horizontal place on the wall, from any zero, growing towards +y of body 2 (spot 1) or +x (spot 2) |
| `up_mm` | vertical place on the wall, from any zero, growing upwards: it falls as the robot does |
| `std_mm` | optional column or cell: standard deviation of both places; empty is 0.5 mm (paper with 1 mm squares) |

Rows may come in any order, the spots at different times. Correct for the camera's perspective before: millimetres are
those of the graph paper.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.clocks.clock_fit import ClockFit
from tfsat_host.evaluation.csv_columns import CsvForm, CsvRow, read_rows

FloatArray = NDArray[np.float64]

READING_STD_M = 0.5e-3
_LARGEST_S = 1e6
_LARGEST_MM = 1e4
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
    """

    path: Path
    t_s: FloatArray
    spot: NDArray[np.int64]
    along_m: FloatArray
    up_m: FloatArray
    std_m: FloatArray
    on_video_clock: bool

    def after_release(self, video: ClockFit | None) -> LaserTracks:
        """The same tracks by the logger's clock, whose zero is the release.

        Raises:
            LaserFileError: they are on the video's clock, and that is unknown.
        """
        if not self.on_video_clock:
            return self
        if video is None:
            raise LaserFileError(
                what=f"{self.path}: video_t_s counts on the video's clock, which nothing ties to the release.",
                meaning=_MEANING,
                next_step="Give the video's events too, or write seconds after the release into a column t_s.",
            )
        return replace(self, t_s=video.to_logger_s(self.t_s), on_video_clock=False)


def read_tracks(path: Path) -> LaserTracks:
    """The tracks in a file, by time.

    Raises:
        LaserFileError: the file cannot be read or understood; names file, line and cure.
    """
    required = ("spot", "along_mm", "up_mm")
    form = CsvForm(path, "tracks of the laser spots", required, _MEANING, LaserFileError)
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
    """The one column of times."""
    there = [name for name in ("t_s", "video_t_s") if name in row.cells]
    if len(there) != 1:
        found = "both t_s and video_t_s are" if there else "neither t_s nor video_t_s is"
        cure = "Keep one: t_s counts from the release, video_t_s on the video's own clock."
        form.fail(f"{found} a column of this file.", cure, 1)
    return there[0]


def _place(row: CsvRow, clock: str) -> tuple[float, ...]:
    if row.text("spot") not in ("1", "2"):
        shown = repr(row.text("spot")[:40]) if row.text("spot") else "missing"
        row.form.fail(f"the spot is {shown}.", "Write 1 or 2, or leave out the row.", row.line)
    std_m = READING_STD_M
    if row.text("std_mm"):
        std_m = 1e-3 * row.number("std_mm", largest=_LARGEST_MM, above=0.0)
    return (
        row.number(clock, largest=_LARGEST_S),
        float(row.text("spot")),
        row.number("along_mm", largest=_LARGEST_MM),
        row.number("up_mm", largest=_LARGEST_MM),
        std_m,
    )
