"""`tfsat-host design --grid`: the distribution as a table, a CSV and a picture."""

from __future__ import annotations

import csv

import pytest

from tests.cli.process import RunCli

GRID = ("design", "--robot", "cubesat_3u", "--grid")


def test_the_paper_s_figures(tfsat_host: RunCli) -> None:
    found = tfsat_host.json(*GRID, "5")
    assert found["maneuvers"] == 1944
    assert sorted(found["farthest"]["joints"]) == [2, 3]
    assert found["farthest"]["reorientation_deg"] == pytest.approx(39.31, abs=0.15)
    assert found["most_efficient"]["efficiency"] == pytest.approx(0.1092, abs=0.001)
    assert found["average_rate_deg_s"] == pytest.approx(3.28, abs=0.02)
    assert found["slew_time_s"] == pytest.approx(27.4, abs=0.15)
    assert found["expected_error_deg"] == pytest.approx(1.21, abs=0.005)
    assert len(found["pairs"]) == 6 and found["files"] == []


def test_text_shows_every_pair(tfsat_host: RunCli) -> None:
    shown = tfsat_host(*GRID, "15").stdout
    for pair in ("1 2", "2 1", "1 3", "3 1", "2 3", "3 2"):
        assert f"\n {pair} " in shown
    assert "deg/s" in shown


def test_every_loop_is_in_the_csv(tfsat_host: RunCli) -> None:
    found = tfsat_host.json(*GRID, "15", "--out", "loops.csv")
    with (tfsat_host.folder / "loops.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == found["maneuvers"] == 6 * 6**2
    best = max(rows, key=lambda row: float(row["efficiency"]))
    assert float(best["efficiency"]) == pytest.approx(found["most_efficient"]["efficiency"], abs=1e-8)
    for row in rows:
        travel = 2.0 * (float(row["alpha_deg"]) + float(row["beta_deg"]))
        assert float(row["efficiency"]) == pytest.approx(float(row["reorientation_deg"]) / travel, abs=1e-7)
    assert found["most_efficient"]["euler_zyx_deg"] == pytest.approx(
        [float(best[f"euler_{axis}_deg"]) for axis in "zyx"], abs=1e-7
    )


@pytest.mark.parametrize(("name", "starts"), [("d.png", b"\x89PNG"), ("d.pdf", b"%PDF"), ("d.svg", b"<?xml")])
def test_a_picture(tfsat_host: RunCli, name: str, starts: bytes) -> None:
    for _ in range(2):  # the second time over its own
        tfsat_host(*GRID, "15", "--figure", name)
    assert (tfsat_host.folder / name).read_bytes().startswith(starts)


def test_files_of_others_and_strange_pictures_are_refused(tfsat_host: RunCli) -> None:
    (tfsat_host.folder / "notes.csv").write_text("mine\n")
    tfsat_host(*GRID, "15", "--out", "notes.csv", expect=1)
    assert (tfsat_host.folder / "notes.csv").read_text() == "mine\n"
    assert ".png" in tfsat_host(*GRID, "15", "--figure", "picture.doc", expect=1).stderr
    tfsat_host(*GRID, "0", expect=1)
