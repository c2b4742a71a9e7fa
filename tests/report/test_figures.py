"""The figures as files: sizes, fonts, the same bytes every time."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.patches import Rectangle

from tests.report.reported_drop import evaluate_run
from tfsat_host.report.figures import FIGURES, FORMATS, MARKER, FigureData, drawn_of, write_figure

# One and two columns of a journal.
WIDTHS_MM = {"motion": 183.0, "momentum": 183.0, "rate-error": 89.0, "attitude-error": 89.0}


@pytest.fixture(scope="module")
def figure_data() -> FigureData:
    return drawn_of(evaluate_run())


def render_figure(name: str, figure_data: FigureData, file_format: str, folder: Path) -> bytes:
    path = folder / f"{name}.{file_format}"
    write_figure(name, figure_data, file_format, path)
    return path.read_bytes()


@pytest.mark.parametrize("name", WIDTHS_MM)
def test_each_figure_is_the_same_bytes_of_its_width_with_its_fonts(
    name: str, figure_data: FigureData, tmp_path: Path
) -> None:
    files = {file_format: render_figure(name, figure_data, file_format, tmp_path) for file_format in FORMATS}
    again = (
        FORMATS if name == "attitude-error" else ()
    )  # one figure stands for all: the style is theirs together
    # A user's own matplotlibrc must not reach the files.
    with mpl.rc_context({"font.size": 23.0, "lines.linewidth": 9.0, "savefig.dpi": 50}):
        assert all(
            render_figure(name, figure_data, file_format, tmp_path) == files[file_format]
            for file_format in again
        )
    for data in files.values():
        assert MARKER in data[:4096] + data[-4096:]
        # A date in a file would change its bytes from day to day.
        assert b"CreationDate" not in data and b"20260" not in data[-2048:]
    # IHDR of the PNG: width and height, big-endian, at byte 16; 300 dots per inch.
    width, height = struct.unpack(">II", files["png"][16:24])
    assert width == pytest.approx(WIDTHS_MM[name] / 25.4 * 300.0, abs=1.0)
    assert height < width
    pdf = files["pdf"]
    # TrueType: many journals refuse fonts of type 3.
    assert b"/FontFile2" in pdf and b"/Type3" not in pdf
    [box] = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", pdf)
    # PDF counts 72 points per inch.
    assert float(box[0]) == pytest.approx(WIDTHS_MM[name] / 25.4 * 72.0, abs=0.1)


def test_every_figure_is_the_papers() -> None:
    assert list(FIGURES) == list(WIDTHS_MM)


def test_strokes_are_shaded_behind_the_measured_angles(figure_data: FigureData) -> None:
    figure = FIGURES["motion"](figure_data)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["(a)", "(b)", "(c)", "(d)"]
    joints = figure.axes[2]
    spans = [(patch.get_x(), patch.get_width()) for patch in joints.patches if isinstance(patch, Rectangle)]
    assert [start for start, _ in spans] == pytest.approx([0.70, 1.05, 1.47, 1.82], abs=0.02)
    first = joints.lines[0]
    moving = np.abs(np.diff(first.get_ydata())) > 0.3
    times = np.asarray(first.get_xdata())[1:][moving]
    inside = [any(start <= t <= start + width for start, width in spans) for t in times]
    assert moving.any() and np.mean(inside) > 0.98


def test_before_and_after_share_their_scale(figure_data: FigureData) -> None:
    before, after, *spectra = FIGURES["momentum"](figure_data).axes
    assert before.get_ylim() == after.get_ylim()
    assert spectra[0].get_ylim() == spectra[1].get_ylim()
    assert all(axes.get_xscale() == "log" for axes in spectra)
    # What the correction is for: the averages of the corrected model are the flatter ones.
    flat = [np.nanstd(np.asarray(axes.lines[-1].get_ydata(), dtype=np.float64)) for axes in (before, after)]
    assert flat[1] < 0.3 * flat[0]


def test_figures_name_the_check_instead_of_withheld_curves(tmp_path: Path) -> None:
    withheld = dict.fromkeys(("rates", "attitudes", "strokes", "offsets"), "gyro bias at rest")
    data = drawn_of(evaluate_run().with_withheld(withheld))
    for name, draw in FIGURES.items():
        for axes in draw(data).axes:
            texts = [text.get_text() for text in axes.texts]
            assert [text for text in texts if "withheld: “gyro bias at rest” (check failed)" in text], name
        assert render_figure(name, data, "png", tmp_path)
