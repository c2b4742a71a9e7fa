"""Numbers that no robot has, and text that no parser survives: words, or a model that is what was written."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfsat_host.errors import TfsatError
from tfsat_host.plan.facility import default_facility_path, load_tower
from tfsat_host.robot import RobotFileError, default_robot_path, load_robot

ROBOT = default_robot_path().read_text(encoding="utf-8")
TOWER = default_facility_path().read_text(encoding="utf-8")
_WORDS = re.compile(r"[-\w.\"]+|[^\w\s]|\s+")
_MARKS = """ # = . , " ' \""" ''' \\ [ ] [[ ]] { } """
_VALUES = "0 -1 nan inf -inf 1e308 -1e308 5e-324 1e200 true 2024-01-01"
_LINES = """
[[body]]
[["body"]]
[joint.'servo']
servo.start_deg = 1
body = [
"""
_ODD = st.sampled_from(
    [
        *_MARKS.split(),
        *_VALUES.split(),
        *_LINES.splitlines(keepends=True),
        *("", " ", "\x00", "\ufeff", '"body 2"', "a." * 3000 + "b = 1\n"),
        *("1" + "0" * 400, "1" + "0" * 5000, "0x" + "f" * 9000, "[" * 2000, "{a=" * 400 + "1" + "}" * 400),
    ]
)


def write_file(folder: Path, text: str) -> Path:
    file = folder / "file.toml"
    file.write_text(text, encoding="utf-8")
    return file


@st.composite
def mangle_text(draw: st.DrawFn, text: str) -> str:
    """Draw the text with a few words replaced by odd ones or by its own, left out or doubled."""
    words = _WORDS.findall(text)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(words) - 1))
        new = draw(st.one_of(_ODD, st.sampled_from(words), st.text(max_size=3)))
        words[at : at + draw(st.integers(0, 3))] = [new]
    return "".join(words).encode("utf-8", "ignore").decode()


@settings(max_examples=100, deadline=None)
@given(mangle_text(ROBOT))
def test_mangled_robot_files_are_a_robot_or_refused_in_words(text: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        try:
            robot = load_robot(write_file(Path(folder), text))
        except RobotFileError as error:
            assert error.what.count("file.toml") == 1
            assert len(error.what) < 500
            assert error.next_step
            return
    for array in (robot.mass_kg, robot.com_m, robot.inertia_kg_m2, robot.joint_axis, robot.joint_limits_rad):
        assert np.isfinite(array).all()
    assert np.linalg.norm(robot.joint_axis, axis=1) == pytest.approx(1.0, abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(mangle_text(TOWER))
def test_mangled_facility_files_are_a_tower_or_refused_in_words(text: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        try:
            tower = load_tower(write_file(Path(folder), text))
        except TfsatError as error:
            assert type(error).__name__ == "FacilityFileError"
            assert error.what.count("file.toml") == 1
            assert len(error.what) < 500
            return
    assert tower.fall_s > 0.0


@pytest.mark.parametrize("exponent", [-290, -162, 0, 11])
def test_the_length_of_an_axis_does_not_matter(tmp_path: Path, exponent: int) -> None:
    text = ROBOT.replace("axis = [0, 1, 0]", f"axis = [-1.2e{exponent}, 0.5e{exponent}, 0]", 1)
    axis = load_robot(write_file(tmp_path, text)).joint_axis[1]
    assert axis == pytest.approx([-12 / 13, 5 / 13, 0.0], abs=1e-15)


@pytest.mark.parametrize("number", ["1e13", "-1e308", "1" + "0" * 400])
def test_numbers_that_nobody_means_are_refused(tmp_path: Path, number: str) -> None:
    for old, new in (
        ("mass_kg = 0.735", f"mass_kg = {number}"),
        ("axis = [0, 1, 0]", f"axis = [0, {number}, 0]"),
        ("max_rate_deg_s = 200.0", f"max_rate_deg_s = {number}"),
        ("xx = 1.72", f"xx = {number}"),
    ):
        with pytest.raises(RobotFileError, match=r"is beyond 1e\+12: no number here is so large"):
            load_robot(write_file(tmp_path, ROBOT.replace(old, new, 1)))


def scale_entry(text: str, entry: str, factor: float) -> str:
    """Return the text with every number of an entry, wherever it occurs, multiplied by a factor."""
    number = re.compile(r"-?\d[\d.]*")

    def times(row: re.Match[str]) -> str:
        return row[1] + number.sub(lambda match: repr(float(match[0]) * factor), row[2])

    return re.sub(rf"^({entry} = )(.*)$", times, text, flags=re.MULTILINE)


@pytest.mark.parametrize(
    ("entry", "factor", "named"),
    [
        ("inertia_g_m2", 1e-3, "radius of gyration"),
        ("inertia_g_m2", 1e3, "radius of gyration"),
        ("inertia_g_m2", 1e6, "radius of gyration"),
        ("mass_kg", 1e3, "radius of gyration"),
        ("mass_kg", 1e-3, "radius of gyration"),
        ("com_mm", 1e-3, "no center of mass is farther"),
    ],
)
@pytest.mark.parametrize("boxes", [True, False])
def test_another_unit_is_refused_with_its_cure(
    tmp_path: Path, entry: str, factor: float, named: str, boxes: bool
) -> None:
    plain = ROBOT if boxes else re.sub(r"^boxes_mm.*\n", "", ROBOT, flags=re.MULTILINE)
    load_robot(write_file(tmp_path, plain))
    with pytest.raises(RobotFileError, match=named) as refused:
        load_robot(write_file(tmp_path, scale_entry(plain, entry, factor)))
    assert "mm" in refused.value.next_step and refused.value.what.count("file.toml") == 1


def test_a_center_of_mass_about_which_its_boxes_cannot_hold_the_inertia_is_refused(tmp_path: Path) -> None:
    robot_text = ROBOT.replace("com_mm = [46.58, 50.93, 84.18]", "com_mm = [0.04658, 0.05093, 0.08418]")
    with pytest.raises(RobotFileError, match=r"body 1, com_mm: the inertia spreads the mass by .* along x"):
        load_robot(write_file(tmp_path, robot_text))


def test_robots_whose_frames_begin_at_their_centers_of_mass_are_robots(tmp_path: Path) -> None:
    plain = re.sub(r"^boxes_mm.*\n", "", ROBOT, flags=re.MULTILINE)
    assert not load_robot(write_file(tmp_path, scale_entry(plain, "com_mm", 0.0))).com_m.any()


def test_an_axis_whose_direction_is_lost_in_rounding_is_refused(tmp_path: Path) -> None:
    text = ROBOT.replace("axis = [0, 1, 0]", "axis = [5e-324, 3e-324, 0]", 1)
    with pytest.raises(RobotFileError, match=r"joint 2, axis: .* is lost in rounding") as caught:
        load_robot(write_file(tmp_path, text))
    assert "axis = [5e-324" in text.splitlines()[int(caught.value.what.split(":")[1]) - 1]


def test_a_byte_order_mark_is_no_part_of_a_file(tmp_path: Path) -> None:
    assert load_robot(write_file(tmp_path, "\ufeff" + ROBOT)).mass_kg.sum() == pytest.approx(2.847)
    assert load_tower(write_file(tmp_path, "\ufeff" + TOWER)).fall_s == 2.5
