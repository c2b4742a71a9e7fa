"""Figures as files: the same bytes for the same drop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.report.contents.charts.of_drop import charts_of
from tfsat_host.report.contents.events import events_of
from tfsat_host.report.figures import style
from tfsat_host.report.figures.arrangements import FIGURES, Drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODULE = "matplotlib"
FORMATS = ("pdf", "png")
MARKER = b"made by tfsat-host report"
"""Stands in every file: how the command knows its own."""
_SHOWN_FROM_S = 0.0


class MissingMatplotlibError(TfsatError):
    """Figures were asked for and matplotlib is not installed (exit code 1)."""


def check_matplotlib() -> None:
    """Does nothing if figures can be drawn.

    Raises:
        MissingMatplotlibError: they cannot.
    """
    from importlib.util import find_spec

    if find_spec(MODULE) is None:
        raise MissingMatplotlibError(
            what="--figures needs matplotlib, which is not installed.",
            meaning="Nothing was drawn or written.",
            next_step="In tfsat's folder: python -m pip install '.[figures]'; or leave --figures out.",
        )


def drawn_of(found: Evaluation) -> Drawn:
    """What the figures of a drop are made of."""
    return Drawn(
        charts_of(found), events_of(found), found.motion.t_s, (_SHOWN_FROM_S, found.motion.samples.until_s)
    )


def write_figure(name: str, drawn: Drawn, file_format: str, path: Path) -> None:
    """One of `FIGURES` in one of `FORMATS`."""
    import matplotlib as mpl

    # Whatever matplotlibrc a computer has: the figures look the same.
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(style.RC)
        figure = FIGURES[name](drawn)
        _save(figure, file_format, path)


def _save(figure: Figure, file_format: str, path: Path) -> None:
    text = MARKER.decode()
    # Without dates, and without the library's version, which changes nothing that one sees.
    metadata = (
        {"Creator": text, "Producer": None, "CreationDate": None}
        if file_format == "pdf"
        else {"Software": text}
    )
    figure.savefig(path, format=file_format, dpi=style.PNG_DPI, metadata=metadata)
