"""Many rehearsals: their distribution, and that neither workers nor company change a drop."""

from __future__ import annotations

import csv

import pytest

from tests.cli.process import RunCli
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.many import Campaign, distributions, fly_many
from tfsat_host.robot import load_robot


def test_the_same_drops_whatever_the_number_of_workers() -> None:
    campaign = Campaign(schedule_maneuver(four_stroke(59.0, 70.0)), load_robot(), seed=5)
    alone, together = fly_many(campaign, 2, workers=1), fly_many(campaign, 2, workers=2)
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


def test_runs_that_are_none(tfsat_host: RunCli) -> None:
    assert "is no number of runs" in tfsat_host("rehearse", "59", "70", "--runs", "0", expect=2).stderr
