"""What the page shows: the parts of a document, as in its JSON.

Times are seconds after release, ascending. Wherever a number may be missing it is None; the page leaves a gap
there. Strings may come from a hostile log: the page shows them as text, whatever they hold.
"""

from __future__ import annotations

from typing import Literal, NotRequired, TypedDict

FORMAT = 2
"""Version of this layout; the page says so when it gets another one."""


class PageVerdict(TypedDict):
    """The one sentence that a reader takes home, and why."""

    level: Literal["good", "doubtful", "failed"]
    sentence: str
    reasons: list[str]


class KeyNumber(TypedDict):
    """A result and its standard deviation, both in `unit`. Those of one `row` stand side by side under its name."""

    label: str
    value: float | None
    std: float | None
    unit: str
    note: str
    row: NotRequired[str]


class Event(TypedDict):
    """A moment, or with `until_s` a span, of the drop."""

    t_s: float
    kind: Literal["release", "stroke", "landing", "switch", "gap", "other"]
    label: str
    until_s: float | None


class PlotSeries(TypedDict):
    """One line of a plot: n values over the plot's x.

    `component` is 0 to 2 for x, y, z (or joints 1 to 3) and 3 for a norm: it chooses the color. `kind` chooses
    the style of the line: measured solid, model before and after correction dashed, commanded dotted.
    """

    label: str
    values: list[float | None]
    std: list[float | None] | None
    component: int
    kind: Literal["measured", "before", "after", "commanded"]


class Plot(TypedDict):
    """Some lines over one x. Plots of the same `id` are laid over each other when there are several drops.

    `x` None stands for the drop's `t_s`; such plots share cursor and zoom. `band` is a range of x to shade.
    `withheld` says which lines are not drawn because a check failed; empty: none.
    """

    id: str
    title: str
    x_label: str
    y_label: str
    x: list[float] | None
    log_x: bool
    log_y: bool
    band: list[float] | None
    caption: str
    withheld: str
    series: list[PlotSeries]


class ReplayBody(TypedDict):
    """A body's shape: boxes, low and high corner in m, in the body's own frame."""

    name: str
    boxes_m: list[list[list[float]]]


class Replay(TypedDict):
    """Poses over m times: `[m][bodies][7]`, the body frame's origin in m, then its quaternion x, y, z, w.

    Inertial frame. `model` is what the model predicted, or None. A pose with a None in it is not drawn.
    """

    bodies: list[ReplayBody]
    t_s: list[float]
    measured: list[list[list[float | None]]]
    model: list[list[list[float | None]]] | None


class Fold(TypedDict):
    """Rows of a table from `first` on are folded away under these words."""

    first: int
    words: str


class PageTable(TypedDict):
    """Rows of text under column heads."""

    title: str
    columns: list[str]
    rows: list[list[str]]
    caption: str
    fold: NotRequired[Fold]


class Drop(TypedDict):
    """All of one drop. `t_s` belongs to the plots without x, `window_s` is what was evaluated.

    `prediction`, `change` and `strokes` stand on the first screen; `no_replay` says why `replay` is None.
    """

    name: str
    verdict: PageVerdict
    prediction: PageTable
    change: str
    strokes: PageTable
    key_numbers: list[KeyNumber]
    notes: list[str]
    t_s: list[float]
    window_s: list[float]
    events: list[Event]
    plots: list[Plot]
    replay: Replay | None
    no_replay: str
    tables: list[PageTable]


class Document(TypedDict):
    """One page. `lacking` says which drops should be here and are not; `tables` are of all drops together."""

    format: int
    title: str
    made_by: str
    made_at: str
    lacking: list[str]
    tables: list[PageTable]
    drops: list[Drop]
