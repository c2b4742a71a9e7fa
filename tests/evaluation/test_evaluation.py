"""`evaluate` as a call: what one missing record does to the others, and recordings that end about the release."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.evaluation.drops import DROPPED, certificate, fly_drop
from tests.fixtures.emulated_drop import Drop
from tfsat_host.calibration.apply import CalibratedSamples, apply_calibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.evaluation.camera import LaserTracks
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import ExternalObservations, evaluate
from tfsat_host.evaluation.laser_velocity import windows_of
from tfsat_host.evaluation.motion.samples import EvaluationError
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.plan.facility import load_tower
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.rehearsal.rehearsed_drop import rehearse
from tfsat_host.rehearsal.truth import truth_as_filed
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog, load
from tfsat_host.sdlog.droplog import _BY_SAMPLE


def evaluate_drop(drop: Drop, log: DropLog, witnesses: ExternalObservations | None = None) -> Evaluation:
    return evaluate(
        log, drop.model, certificate(drop, 1), drop.schedule, recorded=DROPPED, witnesses=witnesses
    )


@cache
def whole_evaluation() -> Evaluation:
    return evaluate_drop(fly_drop(1), fly_drop(1).log)


def test_minutes_on_the_hook_cost_no_memory_and_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot hung for ten minutes: what it felt longer than 31 s before the release is not looked at."""
    drop, seen = fly_drop(1), []

    def watch(counts: Counts, *rest: Any) -> CalibratedSamples:
        seen.append(len(counts.t_us))
        return apply_calibration(counts, *rest)

    monkeypatch.setattr("tfsat_host.evaluation.evaluation.apply_calibration", watch)
    log, earlier_us = drop.log, 600_000_000
    rows = np.arange(0, len(log), 3)
    columns: dict[str, Any] = {name: getattr(log, name) for name in _BY_SAMPLE}
    before = {name: column[rows] for name, column in columns.items()}
    before["t_us"] = before["t_us"] - earlier_us
    joined: dict[str, Any] = {
        name: np.concatenate([before[name], column]) for name, column in columns.items()
    }
    long_log = replace(log, **joined)
    evaluation = evaluate_drop(drop, long_log)
    assert seen == [len(log)]
    assert len(evaluation.log) == len(log) + len(rows)
    assert evaluation.turns[0].angle_rad == whole_evaluation().turns[0].angle_rad


def test_a_stroke_that_the_logger_did_not_see_is_no_part_of_the_quiet_time() -> None:
    drop = fly_drop(1)
    first = next(event for event in drop.log.events if event.name == "stroke")
    evaluation = evaluate_drop(
        # The first stroke's edge is missing: the schedule still tells when it was due.
        drop,
        replace(drop.log, events=tuple(e for e in drop.log.events if e is not first)),
    )
    rate, expected = evaluation.initial_rates[0].rate_rad_s, whole_evaluation().initial_rates[0].rate_rad_s
    assert np.rad2deg(rate) == pytest.approx(np.rad2deg(expected), abs=0.01)


def test_an_edge_that_is_no_stroke_does_not_end_the_quiet_time() -> None:
    drop = fly_drop(1)
    first = next(event for event in drop.log.events if event.name == "stroke")
    # An edge 0.65 s before the first stroke, where nothing was commanded.
    early = replace(first, t_us=first.t_us - 650_000)
    evaluation = evaluate_drop(drop, replace(drop.log, events=(early, *drop.log.events)))
    assert evaluation.initial_rates[0].std_rad_s == pytest.approx(
        whole_evaluation().initial_rates[0].std_rad_s, rel=0.05
    )


def test_spots_that_tell_nothing_take_nothing_from_the_rest() -> None:
    drop = fly_drop(1)
    # Three places only, all of them late in the fall.
    places = np.array([2.0, 2.1, 2.2])
    late = LaserTracks(
        Path("tracks.csv"),
        places,
        np.array([1, 1, 2]),
        0.0 * places,
        0.0 * places,
        1e-3 + 0.0 * places,
        False,
    )
    evaluation = evaluate_drop(
        drop, drop.log, ExternalObservations(laser=late, windows=windows_of(load_tower()))
    )
    assert evaluation.release_velocity is None
    assert any(note.startswith("No release velocity.") for note in evaluation.notes)
    assert evaluation.reorientation.angle_rad > 0.3


def test_a_header_that_names_another_low_pass_is_found_out() -> None:
    drop = fly_drop(1)
    # 5 Hz in the header, 42 Hz in the data.
    other = replace(drop.log, header=replace(drop.log.header, dlpf_cfg=6))
    evaluation = evaluate_drop(drop, other)
    (check,) = (check for check in evaluation.checks if check.name == "lag of the gyros")
    assert check.verdict == "failed"
    assert any("which no chip has" in note for note in evaluation.notes)


def test_a_joint_that_moves_where_nothing_commands_it_is_in_the_verdict() -> None:
    """Report a joint that moves without a command in the verdict.

    The last stroke of the schedule is left out, so that it was flown without a command.
    """
    drop = fly_drop(1)
    assert all(standing.remark == "" for standing in whole_evaluation().standing)
    shorter = replace(drop.schedule, strokes=drop.schedule.strokes[:3])
    evaluation = evaluate(drop.log, drop.model, certificate(drop, 1), shorter, recorded=DROPPED)
    assert any("where nothing commanded it" in reason for reason in verdict_of(evaluation).reasons)


STEP = 4
AROUND_S = (-0.3, 0.5)


def test_every_end_around_the_release(tmp_path: Path) -> None:
    schedule, robot = schedule_maneuver(four_stroke(59.0, 70.0)), load_robot()
    drop = rehearse(schedule, robot, truth_as_filed(robot, 1))
    file = tmp_path / "SD.bin"
    outcomes = []
    for blocks in range(STEP, len(drop.card) // BLOCK_BYTES, STEP):
        file.write_bytes(drop.card[: blocks * BLOCK_BYTES])
        log = load(file)
        # Only ends around the release: everything else is another test's.
        if log.release_us is None or not AROUND_S[0] < log.t_s[-1] < AROUND_S[1]:
            continue
        try:
            evaluate(log, robot, drop.calibration, schedule)
            outcomes.append("evaluated")
        except EvaluationError as refused:
            outcomes.append(refused.meaning)
    assert "Nothing of the fall is recorded: nothing to evaluate." in outcomes
    assert outcomes[-1] == "evaluated"
