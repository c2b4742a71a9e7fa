"""Many rehearsals: their distribution, and that neither workers nor company change a drop."""

from __future__ import annotations

import csv
import json
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.rehearsal.days import SCHEDULE
from tests.run.bundle.commands import command, result
from tfsat_host.rehearsal import series
from tfsat_host.rehearsal.series import Series, fly_many
from tfsat_host.rehearsal.series_result import distributions
from tfsat_host.robot import load_robot
from tfsat_host.worker_processes import SerialExecutor

# Drops of one series differ by their own seeds, each derived from this one.
FIVE = Series(SCHEDULE, load_robot(), seed=5)


@pytest.fixture
def in_this_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to `tmp_path` and fly drops in this process, which has everything imported."""

    @contextmanager
    def pool(*_: Any, **__: Any) -> Iterator[SerialExecutor]:
        yield SerialExecutor()

    monkeypatch.setattr(series, "worker_pool", pool)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_same_drops_whatever_the_number_of_workers() -> None:
    alone, together = fly_many(FIVE, 2, workers=1), fly_many(FIVE, 2, workers=2)
    assert [drop.compared for drop in alone] == [drop.compared for drop in together]
    assert [drop.strokes_off_us for drop in alone] == [drop.strokes_off_us for drop in together]
    first, second = alone
    # Equal drops would agree for any number of workers.
    assert first.compared != second.compared
    assert (first.verdict, first.samples_lost, first.refused) == ("good", 0, "")
    (reorientation, *_) = distributions(alone)
    assert (reorientation.name, reorientation.count) == ("reorientation", 2)
    assert reorientation.rms_error < 0.05


def test_the_command_counts_the_drops_and_writes_their_table(in_this_process: Path) -> None:
    text = command("rehearse", "59", "70", "--runs", "2", "--seed", "5", "--out", "many").out
    assert "in 95 %" in text and " 2/2" in text and "100 %" not in text
    summary = json.loads((in_this_process / "many" / "runs.json").read_text())
    assert (summary["runs"], summary["good"], summary["samples_lost"]) == (2, 2, 0)
    assert summary["stroke_timing_us"]["largest"] < 500
    with (in_this_process / "many" / "runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["number"] for row in rows] == ["1", "2"]
    # Any drop of the series can be flown alone by its seed.
    again = result("rehearse", "59", "70", "--seed", rows[1]["seed"], "--out", "again")
    estimates = {estimate["name"]: estimate["found"] for estimate in again["compared"]}
    assert float(rows[1]["reorientation found"]) == pytest.approx(estimates["reorientation"], abs=1e-6)


@pytest.mark.usefixtures("in_this_process")
def test_a_series_with_a_preflight_that_gives_no_go() -> None:
    summary = result("rehearse", "59", "70", "--runs", "2", "--fault", "card-full", expect=4)
    assert (summary["dropped"], summary["none"]) == (0, 2)
    assert summary["no_go"] == {"card-room": 2, "card-writing": 2}
    (noticed,) = summary["faults_noticed"]
    assert noticed == {"name": "card-full", "struck": 2, "noticed": 2, "noticed_by": {"preflight": 2}}


@pytest.mark.usefixtures("in_this_process")
def test_who_detected_faults_is_counted_over_the_drops() -> None:
    arguments = ("rehearse", "59", "70", "--runs", "2", "--fault", "servo-dead", "--fault", "crane-jolt")
    text = command(*arguments, expect=3).out
    words = " ".join(text.split())
    assert "servo-dead: injected in 2, detected in 2 (evaluation 2)" in words
    assert "crane-jolt: injected in 2, detected in 2" in words


@pytest.mark.usefixtures("in_this_process")
def test_what_was_flown_when_it_was_stopped_is_kept() -> None:
    """Keep the drops flown when the series is stopped.

    The stop is requested after the first drop: drops in flight are finished, and no more begin.
    """
    landed: list[int] = []
    drops = fly_many(FIVE, 50, workers=1, progress=lambda: landed.append(1), stop=lambda: bool(landed))
    assert [drop.number for drop in drops] == [1]
    assert fly_many(FIVE, 2, workers=1, stop=lambda: True) == ()


def test_ctrl_c_keeps_the_table(in_this_process: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C reaches the whole terminal, and the drops that fly are finished all the same."""
    stopped: list[int] = []

    def interrupt_series(
        many: Series, runs: int, *, progress: Callable[[], None], stop: Callable[[], bool]
    ) -> Any:
        def one_more() -> None:
            progress()
            if not stopped:
                stopped.append(1)
                # After the first drop: what is flown by then must be in the table.
                signal.raise_signal(signal.SIGINT)

        return fly_many(many, runs, workers=1, progress=one_more, stop=stop)

    monkeypatch.setattr(series, "fly_many", interrupt_series)
    output = command("rehearse", "59", "70", "--runs", "50", "--out", "many", expect=130)
    assert "Interrupted after 1 of 50 drops." in output.err
    assert output.out.startswith("Drops: 1 of 1 dropped, 1 good")
    assert output.out.splitlines()[-1].startswith("Drops: 1 of 1 dropped, 1 good")
    assert "--file many/maneuver.toml --robot many/robot.toml --seed SEED" in output.out
    with (in_this_process / "many" / "runs.csv").open() as file:
        assert [row["number"] for row in csv.DictReader(file)] == ["1"]
    summary = json.loads((in_this_process / "many" / "runs.json").read_text())
    assert (summary["runs"], summary["asked"], summary["imu"]) == (1, 50, "InvenSense MPU-6050")
