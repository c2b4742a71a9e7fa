"""Many rehearsals: their distribution, and that neither workers nor company change a drop."""

from __future__ import annotations

import csv
import io
import json
import signal
from collections.abc import Callable
from typing import Any

import pytest

from tests.cli.process import RunCli
from tfsat_host.cli.main import main
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
    shown = tfsat_host("rehearse", "59", "70", "--runs", "2", "--out", "many").stdout
    assert "95 % hold" in shown and "2 of 2" in shown and "100 %" not in shown


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
    assert left == {".tfsat-rehearsal", "maneuver.toml", "robot.toml", "runs.csv", "runs.json"}


def test_a_series_with_a_preflight_that_says_no(tfsat_host: RunCli) -> None:
    told = tfsat_host.json("rehearse", "59", "70", "--runs", "2", "--fault", "card-full", expect=4)
    assert (told["dropped"], told["none"]) == (0, 2)
    assert told["no_go"] == {"card-room": 2, "card-writing": 2}
    (noticed,) = told["faults_noticed"]
    assert noticed == {"name": "card-full", "struck": 2, "noticed": 2, "noticed_by": {"preflight": 2}}


def test_who_noticed_is_counted_over_the_drops(tfsat_host: RunCli) -> None:
    typed = ("rehearse", "59", "70", "--runs", "2", "--fault", "servo-dead", "--fault", "crane-jolt")
    shown = tfsat_host(*typed, expect=3).stdout
    assert "servo-dead. It struck in 2 and was noticed in 2 of them (the evaluation: 2)." in shown
    assert "crane-jolt. It struck in 2 and was noticed in 2 of them" in shown


def test_a_folder_that_cannot_be_written_is_refused_before_the_first_drop(
    tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tfsat_host.folder / "file").write_text("mine")
    monkeypatch.chdir(tfsat_host.folder)
    monkeypatch.setattr("tfsat_host.rehearsal.many.fly_many", None)  # nobody may fly
    err = io.StringIO()
    monkeypatch.setattr("sys.stderr", err)
    assert main(["rehearse", "59", "70", "--runs", "2", "--out", "file/many"]) == 1
    assert "is a file, not a folder" in err.getvalue()


def test_what_was_flown_when_it_was_stopped_is_kept() -> None:
    """The wish comes after the first drop: what flies then is flown to its end, and nothing more begins."""
    series = Series(schedule_maneuver(four_stroke(59.0, 70.0)), load_robot(), seed=5)
    landed: list[int] = []
    flown = fly_many(series, 50, workers=1, progress=lambda: landed.append(1), stop=lambda: bool(landed))
    assert [one.number for one in flown] == [1]
    assert fly_many(series, 2, workers=1, stop=lambda: True) == ()


def test_ctrl_c_keeps_the_table(tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C reaches the whole terminal, and the drops that fly are told all the same."""
    monkeypatch.chdir(tfsat_host.folder)
    stopped: list[int] = []

    def stop_once() -> None:
        if not stopped:
            stopped.append(1)
            signal.raise_signal(signal.SIGINT)

    def interrupted(
        series: Series, runs: int, *, progress: Callable[[], None], stop: Callable[[], bool]
    ) -> Any:
        def one_more() -> None:
            progress()
            stop_once()

        return fly_many(series, runs, workers=1, progress=one_more, stop=stop)

    monkeypatch.setattr("tfsat_host.rehearsal.many.fly_many", interrupted)
    out, err = io.StringIO(), io.StringIO()
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr("sys.stderr", err)
    assert main(["rehearse", "59", "70", "--runs", "50", "--out", "many"]) == 130
    assert "Interrupted after 1 of 50 drops." in err.getvalue()
    assert "Dropped 1 of 1: 1 good" in out.getvalue()
    assert "--file many/maneuver.toml --robot many/robot.toml --seed SEED" in out.getvalue()
    with (tfsat_host.folder / "many" / "runs.csv").open() as file:
        assert [row["number"] for row in csv.DictReader(file)] == ["1"]
    told = json.loads((tfsat_host.folder / "many" / "runs.json").read_text())
    assert (told["runs"], told["asked"], told["imu"]) == (1, 50, "InvenSense MPU-6050")


def test_runs_that_are_none(tfsat_host: RunCli) -> None:
    assert "is no number of runs" in tfsat_host("rehearse", "59", "70", "--runs", "0", expect=2).stderr
