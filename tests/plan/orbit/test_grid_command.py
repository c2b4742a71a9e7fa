"""`tfsat-host design --grid`: the distribution as a table, a CSV and a picture."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from tests.cli.process import RunCli

GRID = ("design", "--robot", "cubesat_3u", "--grid")


def test_the_paper_s_figures(tfsat_host: RunCli) -> None:
    summary = tfsat_host.json(*GRID, "5")
    assert summary["maneuvers"] == 1944
    assert sorted(summary["farthest"]["joints"]) == [2, 3]
    assert summary["farthest"]["reorientation_deg"] == pytest.approx(39.31, abs=0.15)
    assert summary["most_efficient"]["efficiency"] == pytest.approx(0.1092, abs=0.001)
    assert summary["average_rate_deg_s"] == pytest.approx(3.28, abs=0.02)
    assert summary["slew_time_s"] == pytest.approx(27.4, abs=0.15)
    assert summary["expected_error_deg"] == pytest.approx(1.21, abs=0.005)
    assert len(summary["pairs"]) == 6 and summary["files"] == []


def test_text_shows_every_pair(tfsat_host: RunCli) -> None:
    text = tfsat_host(*GRID, "15").stdout
    for pair in ("1 2", "2 1", "1 3", "3 1", "2 3", "3 2"):
        assert f"\n {pair} " in text
    assert "deg/s" in text


def test_every_loop_is_in_the_csv(tfsat_host: RunCli) -> None:
    summary = tfsat_host.json(*GRID, "15", "--out", "loops.csv")
    with (tfsat_host.folder / "loops.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == summary["maneuvers"] == 6 * 6**2
    best = max(rows, key=lambda row: float(row["efficiency"]))
    assert float(best["efficiency"]) == pytest.approx(summary["most_efficient"]["efficiency"], abs=1e-8)
    for row in rows:
        travel = 2.0 * (float(row["alpha_deg"]) + float(row["beta_deg"]))
        # Twice both displacements is what the joints travel.
        assert float(row["efficiency"]) == pytest.approx(float(row["reorientation_deg"]) / travel, abs=1e-7)
    assert summary["most_efficient"]["euler_zyx_deg"] == pytest.approx(
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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("15", "--figure", "picture.jpg"), ".png"),
        (("15", "--out", "maneuver.toml"), "loops.csv"),
        (("0",), "above zero"),
        (("-5",), "above zero"),
        (("15", "--speed", "0"), "--speed 30"),
        (("15", "--limit", "30,30"), "--limit 30,30,30"),
        (("15", "--joints", "1,4"), "joints 1 to 3"),
        (("15", "--joints", "1,1"), "different"),
        (("15", "--time-limit", "2"), "--time-limit"),
        (("15", "--seed", "2"), "--seed"),
        (("15", "--particles", "9"), "--particles"),
        (("15", "--iterations", "9"), "--iterations"),
        (("15", "--penalty", "1e9"), "--penalty"),
        (("15", "--inertia", "1,1"), "--inertia"),
        (("15", "--own-best", "1,1"), "--own-best"),
        (("15", "--best-of-all", "1,1"), "--best-of-all"),
        (("15", "--alternating", "--swarm"), "--alternating, --swarm"),
    ],
)
def test_what_does_not_fit_a_grid_is_refused_by_name(
    tfsat_host: RunCli, arguments: tuple[str, ...], message: str
) -> None:
    assert message in tfsat_host(*GRID, *arguments, expect=2).stderr
    assert not list(tfsat_host.folder.glob("*.*"))


def test_speed_limits_and_joints_are_kept_to(tfsat_host: RunCli) -> None:
    summary = tfsat_host.json(*GRID, "5", "--speed", "60", "--limit", "30,20", "--joints", "2,3")
    assert summary["maneuvers"] == 2 * 6 * 4
    assert [sorted(pair["joints"]) for pair in summary["pairs"]] == [[2, 3], [2, 3]]
    for pair in (*summary["pairs"], summary["farthest"]):
        by_joint = dict(zip(pair["joints"], (pair["alpha_deg"], pair["beta_deg"]), strict=True))
        assert by_joint[2] <= 30.0 + 1e-9 and by_joint[3] <= 20.0 + 1e-9
    assert summary["average_rate_deg_s"] == pytest.approx(60.0 * summary["most_efficient"]["efficiency"])
    assert "joints at 60 deg/s" in " ".join(tfsat_host(*GRID, "15", "--speed", "60").stdout.split())


def test_long_work_is_announced(tfsat_host: RunCli) -> None:
    stderr = tfsat_host(*GRID, "0.9", "--joints", "1,2", "--out", "loops.csv", "--figure", "d.png").stderr
    assert [line.rstrip(" …") for line in stderr.splitlines()] == [
        "Computing the loops",
        "Writing loops.csv",
        "Writing d.png",
    ]


@pytest.mark.parametrize("robot", ["cubesat_3u", "drop_tower"])
def test_both_of_the_most_efficient_are_stars_before_all_points(tfsat_host: RunCli, robot: str) -> None:
    from matplotlib.colors import to_rgb
    from matplotlib.image import imread

    tfsat_host("design", "--robot", robot, "--grid", "3", "--figure", "d.png")
    picture = np.asarray(imread(tfsat_host.folder / "d.png"))[:, :, :3]
    gold = np.isclose(picture, to_rgb("gold"), atol=0.01).all(axis=2)
    # One star is in the legend, at the upper left; the plot has two whole ones.
    legend = gold[: len(gold) // 7].sum()
    # The legend has one star, the plot two.
    assert legend > 100
    assert gold[len(gold) // 7 :].sum() > 1.5 * legend
