"""The CSV file of a measured joint history: what is read, and what is said when it is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tfsat_host.dynamics.motion_files import HistoryFileError, read_history


def test_columns_may_stand_in_any_order_beside_others(tmp_path: Path) -> None:
    file = tmp_path / "h.csv"
    file.write_bytes(
        b"\xef\xbb\xbftheta2_deg, t_s ,comment,theta1_deg\r\n0,0.5,begin,10\r\n\r\n-30,1,,20\r\n"
    )
    history = read_history(file, 2, between="linear")
    assert history.breaks_s.tolist() == [0.5, 1.0]
    assert np.degrees(history.angles_rad(np.array([0.75]))) == pytest.approx(np.array([[15.0, -15.0]]))


def test_between_samples_a_spline_unless_lines_are_wanted(tmp_path: Path) -> None:
    file = tmp_path / "h.csv"
    file.write_text("t_s,theta1_deg\n0,0\n1,1\n2,8\n3,27\n4,64\n")
    at = np.array([2.5])
    # t³ at 2.5 is 15.6; a straight line would give 17.5.
    assert np.degrees(read_history(file, 1).angles_rad(at))[0, 0] == pytest.approx(2.5**3)
    assert np.degrees(read_history(file, 1, between="linear").angles_rad(at))[0, 0] == pytest.approx(17.5)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", ":1: there is no column t_s"),
        ("t_s;theta1_deg;theta2_deg;theta3_deg\n", ":1: there is no column t_s"),
        ("t_s,theta1_deg,theta2_deg\n0,0,0\n", ":1: there is no column theta3_deg"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg,theta4_deg\n", ":1: the column theta4_deg is one too many"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n0,0,0,0\n", "there are 1"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n0,0,0,0\n1,0,x,0\n", ":3: theta2_deg is 'x'"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n0,0,0,0\n1,0,0\n", ":3: theta3_deg is missing"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n0,0,0,nan\n", ":2: theta3_deg is 'nan'"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n1,0,0,0\n\n1,0,0,0\n", ":4: t_s is 1 after 1"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n-2,0,0,0\n-1,0,0,0\n", "after the release"),
        ("t_s,theta1_deg,joint_1_deg,theta2_deg,theta3_deg\n", ":1: the column theta1_deg is there 2 times"),
        ('t_s,theta1_deg,theta2_deg,theta3_deg\n"0,0,0,0\n', "no CSV file"),
        ("t_s,theta1_deg,theta1_deg,theta2_deg,theta3_deg\n", ":1: the column theta1_deg is there 2 times"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n0,1_0,0,0\n", ":2: theta1_deg is '1_0'"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n0,\u0661\u0660,0,0\n", ":2: theta1_deg is '\u0661\u0660'"),
        (
            't_s,note,theta1_deg,theta2_deg,theta3_deg\n0,"a\nb",0,0,0\n1,x,abc,0,0\n',
            ":4: theta1_deg is 'abc'",
        ),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n0,1e300,0,0\n", ":2: theta1_deg is 1e+300, beyond 100000"),
        ("t_s,theta1_deg,theta2_deg,theta3_deg\n0,0,0,0\n1e-320,0,0,0\n", ":3: t_s is 1e-320 s after"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "h.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(HistoryFileError) as caught:
        read_history(file, 3)
    assert caught.value.what.startswith(str(file)) and says in caught.value.what
    assert caught.value.next_step


@pytest.mark.parametrize("name", ["missing.csv", ".", "SD.bin"])
def test_a_file_that_cannot_be_read(tmp_path: Path, name: str) -> None:
    (tmp_path / "SD.bin").write_bytes(bytes(range(256)))
    with pytest.raises(HistoryFileError, match="cannot be read"):
        read_history(tmp_path / name, 3)


def test_rows_before_the_release_say_where_the_joints_are_then(tmp_path: Path) -> None:
    file = tmp_path / "truth.csv"
    file.write_text("t_s,joint_1_deg,joint_2_deg,joint_3_deg\n-3,9,9,9\n-1,0,8,0\n1,10,8,4\n2,20,8,4\n")
    history = read_history(file, 3, between="linear")
    assert history.breaks_s.tolist() == [0.0, 1.0, 2.0]
    # Halfway between the two rows: the joints are there at the release.
    assert np.degrees(history.angles_rad(np.array([0.0, 0.5]))) == pytest.approx(
        np.array([[5, 8, 2], [7.5, 8, 3]])
    )
