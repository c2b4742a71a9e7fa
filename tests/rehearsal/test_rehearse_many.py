"""Many rehearsals: their distribution, and that neither workers nor company change a drop."""

from __future__ import annotations

import csv

import pytest

from tests.cli.process import RunCli
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.many import Series, distributions, fly_many
from tfsat_host.robot import load_robot


def test_the_same_drops_whatever_the_number_of_workers() -> None:
    series = Series(schedule_maneuver(four_stroke(59.0, 70.0)), load_robot(), seed=5)
    alone, together = fly_many(series, 2, workers=1), fly_many(series, 2, workers=2)
    assert [one.compared for one in alone] == [one.compared for one in together]
    assert [one.strokes_off_us for one in alone] == [one.strokes_off_us for one in together]
    first, second = alone
    assert first.compared != second.compared
    assert (first.verdict, first.samples_lost, first.refused) == ("good", 0, "")
    (reorientation, *_) = distributions(alone)
    assert (reorientation.name, reorientation.count) == ("reorientation", 2)
    assert reorientation.rms_error < 0.05


def test_the_command(tfsat_host: RunCli) -> None:
    told = tfsat_host.json("rehearse", "59", "70", "--runs", "2", "--seed", "5", "--out", "many")
    assert (told["runs"], told["good"], told["samples_lost"]) == (2, 2, 0)
    assert told["stroke_timing_us"]["largest"] < 500
    with (tfsat_host.folder / "many" / "runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["number"] for row in rows] == ["1", "2"]
    again = tfsat_host.json("rehearse", "59", "70", "--seed", rows[1]["seed"], "--out", "again")
    found = {one["name"]: one["found"] for one in again["compared"]}
    assert float(rows[1]["reorientation found"]) == pytest.approx(found["reorientation"], abs=1e-6)
    assert "95 % hold" in tfsat_host("rehearse", "59", "70", "--runs", "2", "--out", "many").stdout


def test_its_folder(tfsat_host: RunCli) -> None:
    """Somebody's files stay, and of an earlier rehearsal nothing is left beside."""
    precious = tfsat_host.folder / "precious"
    precious.mkdir()
    (precious / "runs.csv").write_text("mine")
    refused = tfsat_host("rehearse", "59", "70", "--runs", "2", "--out", "precious", expect=2)
    assert "holds files that no rehearsal made" in refused.stderr
    assert (precious / "runs.csv").read_text() == "mine"
    tfsat_host("rehearse", "59", "70", "--out", "run")
    tfsat_host("rehearse", "59", "70", "--runs", "2", "--out", "run")
    left = {path.name for path in (tfsat_host.folder / "run").iterdir() if path.is_file()}
    assert left == {".tfsat-rehearsal", "maneuver.toml", "runs.csv", "runs.json"}


def test_a_series_with_a_preflight_that_says_no(tfsat_host: RunCli) -> None:
    told = tfsat_host.json("rehearse", "59", "70", "--runs", "2", "--fault", "card-full", expect=4)
    assert (told["dropped"], told["none"]) == (0, 2)
    assert told["no_go"] == {"card-room": 2, "card-writing": 2}


def test_runs_that_are_none(tfsat_host: RunCli) -> None:
    assert "is no number of runs" in tfsat_host("rehearse", "59", "70", "--runs", "0", expect=2).stderr
