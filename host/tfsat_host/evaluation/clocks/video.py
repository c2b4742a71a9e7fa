"""Events of the drop as a camera saw them, read off the frames of its video: a CSV file.

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

Without `std_s` a video of 60 frames a second is assumed, and that a joint has turned by 1 deg before anyone sees it
(22 ms from rest at 4000 deg/s², besides the servo's own delay).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.csv_columns import CsvForm, CsvRow, read_rows
from tfsat_host.protocol.limits import MAX_STROKES

FRAME_STD_S = 1 / 60 / 12**0.5
"""Of what changed between two frames, 60 a second."""
STROKE_STD_S = 0.02
"""Of a stroke's first visible motion."""
_LARGEST_S = 1e6
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
    """The events in a file, by time.

    Raises:
        VideoFileError: the file cannot be read or understood; names file, line and cure.
    """
    form = CsvForm(
        path=path,
        subject="video's events",
        required=("event", "t_s"),
        meaning="The video's clock is unknown: nothing that was filmed can be set beside the log.",
        error=VideoFileError,
    )
    found: dict[str, Mark] = {}
    for row in read_rows(form):
        event = _event(row)
        if event in found:
            cure = "Keep the row that is meant."
            form.fail(f"the event {event} is there a second time.", cure, row.line)
        found[event] = Mark(event, row.number("t_s", largest=_LARGEST_S), _std_s(row, event))
    if not found:
        form.fail("there is no event.", "Add a row, such as release,12.3833", None)
    return tuple(sorted(found.values(), key=lambda mark: mark.t_s))


def _event(row: CsvRow) -> str:
    event = " ".join(row.text("event").lower().split())
    number = _STROKE.fullmatch(event)
    known = event in ("release", "landing") or (number is not None and int(number[1]) <= MAX_STROKES)
    if not known:
        shown = repr(row.text("event")[:40]) if event else "missing"
        cure = f"Write release, landing or stroke 1 to stroke {MAX_STROKES}, or leave out the row."
        row.form.fail(f"the event is {shown}.", cure, row.line)
    return event


def _std_s(row: CsvRow, event: str) -> float:
    if row.text("std_s"):
        return row.number("std_s", largest=_LARGEST_S, above=0.0)
    return STROKE_STD_S if event.startswith("stroke") else FRAME_STD_S
