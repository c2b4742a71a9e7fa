"""What stands in the report: numbers, curves and tables against the evaluation that they are of."""

from __future__ import annotations

import hashlib
import textwrap
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import numpy as np
import pytest

from tests.paths import DOCS
from tests.report.conftest import Opener
from tests.report.reported_drop import MADE, drop_of, evaluate_run, folder, numbers, plots, report_drop, table
from tfsat_host.evaluation.checks.check import Kind
from tfsat_host.evaluation.com_fit.paper_swarm import swarm_fit
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.result.model_result import significance, worth_of
from tfsat_host.quantity import plus_minus
from tfsat_host.report import render
from tfsat_host.report.contents.document_builder import document_of
from tfsat_host.robot import load_robot
from tfsat_host.sdlog.events import DropEvent
from tfsat_host.sdlog.ledger import Gap

MAX_BYTES = 1_500_000


def test_key_numbers_are_the_evaluations(drop: Any) -> None:
    evaluation, key_numbers = evaluate_run(), numbers(drop)
    turn = evaluation.reorientation
    assert key_numbers["Reorientation"]["value"] == pytest.approx(np.rad2deg(turn.angle_rad))
    assert key_numbers["Reorientation"]["std"] == pytest.approx(np.rad2deg(turn.std_rad))
    for label, sides in (("nominal", evaluation.explained.nominal), ("fitted", evaluation.explained.fitted)):
        error = key_numbers[f"Attitude error, {label} model"]
        assert error["value"] == pytest.approx(np.rad2deg(sides.error.final_norm_rad))
        assert 0.0 < error["std"] < 0.1
    # The fit has found the cause: less than a fifth of the error is left.
    assert (
        key_numbers["Attitude error, fitted model"]["value"]
        < 0.2 * key_numbers["Attitude error, nominal model"]["value"]
    )
    fit = evaluation.explained.fit
    assert key_numbers["Largest CoM correction"]["value"] == fit.values[np.abs(fit.values).argmax()]
    # The rate at which the emulated robot was released, as the paper's was.
    assert [key_numbers[f"Initial rate {axis}"]["value"] for axis in "xyz"] == pytest.approx(
        [-0.73, -0.48, -0.77], abs=0.05
    )
    assert key_numbers["Stroke 1"]["note"] == "joint 1, +59.00 deg commanded"
    assert key_numbers["Fall"]["value"] == pytest.approx(2.5, abs=0.01)
    # Percent of the samples that were expected.
    assert key_numbers["Recording"]["value"] == 100.0
    assert "Release velocity" not in key_numbers  # nobody filmed the laser spots


def test_what_a_drop_lacks_is_no_number() -> None:
    evaluation = evaluate_run()
    # No accelerometer and no landing: NaN must become "unknown", never 0.
    blind = replace(evaluation.micro_gravity, changes_g=np.full((4, 3), np.nan))
    lacking = replace(evaluation, micro_gravity=blind, instants=replace(evaluation.instants, landing=None))
    key_numbers = numbers(drop_of(lacking))
    assert key_numbers["Micro-gravity"]["value"] is None and key_numbers["Fall"]["value"] is None
    assert key_numbers["Fall"]["note"] == "no accelerometer felt a landing"


def test_strokes_are_where_they_were_flown(drop: Any) -> None:
    strokes = [event for event in drop["events"] if event["kind"] == "stroke"]
    assert [event["label"].split(",")[0] for event in strokes] == [
        "1: joint 1",
        "2: joint 2",
        "3: joint 1",
        "4: joint 2",
    ]
    assert [event["t_s"] for event in strokes] == pytest.approx([0.70, 1.05, 1.47, 1.82], abs=0.02)
    # 59 and 70 deg at up to 200 deg/s, with time to speed up and to slow down.
    assert all(0.2 < event["until_s"] - event["t_s"] < 0.5 for event in strokes)
    assert [event["t_s"] for event in drop["events"]] == sorted(event["t_s"] for event in drop["events"])


def test_bouncing_switches_are_one_event_each_and_holes_are_shown() -> None:
    evaluation = evaluate_run()
    log = evaluation.log
    # Five edges within 0.8 ms, open at the last.
    bounces = tuple(DropEvent(log.origin_us + 200 * k, "switch_edge", 0, (k + 1) % 2, 0) for k in range(5))
    others = tuple(event for event in log.events if event.name != "switch_edge")
    # 10 ms at 280 Hz: three samples.
    hole = Gap(100, 3, 0, 1, log.origin_us + 1_200_000, log.origin_us + 1_210_000)
    damaged = replace(log, events=(*bounces, *others), gaps=(hole,), samples_lost=3)
    drop = drop_of(replace(evaluation, log=damaged))
    switches = [event for event in drop["events"] if event["kind"] == "switch"]
    assert [(event["label"], event["t_s"]) for event in switches] == [("release switch 1 opened", 0.0008)]
    [gap] = [event for event in drop["events"] if event["kind"] == "gap"]
    assert (gap["t_s"], gap["until_s"], gap["label"]) == (1.2, 1.21, "3 samples lost")
    assert numbers(drop)["Recording"]["value"] < 100.0


def test_failed_checks_stand_first_with_their_cause() -> None:
    evaluation = evaluate_run()
    # A check that no drop has: nothing else can have put it there.
    bad = (
        Kind("the earth is flat", "sigma", ())
        .judge(3.0, 1.0, "It is not.")
        .caused_by("a wrong map", "Buy a globe.")
    )
    drop = drop_of(replace(evaluation, checks=(*evaluation.checks, bad)))
    first = table(drop, "Integrity checks")["rows"][0]
    assert first == [
        "the earth is flat",
        "failed",
        "3 sigma",
        "1 sigma",
        "It is not. Likely cause: a wrong map. Next step: Buy a globe.",
    ]
    reason = "the earth is flat: It is not. Likely cause: a wrong map. Next step: Buy a globe."
    assert drop["verdict"]["level"] == "doubtful" and reason in drop["verdict"]["reasons"]


def test_a_failed_check_corrects_nothing_whatever_it_protects() -> None:
    evaluation = evaluate_run()
    bad = Kind("the earth is flat", "sigma", ()).judge(3.0, 1.0, "It is not.")
    drop = drop_of(replace(evaluation, checks=(*evaluation.checks, bad)))
    caption = table(drop, "Correction of the model")["caption"]
    assert "leave the robot file unchanged" in caption and "Failed check: “the earth is flat”." in caption
    # A reader of the page has no command line that knows the recording.
    assert f"Look at the samples: tfsat-host decode {evaluation.log.path}" in drop["verdict"]["reasons"][0]


def test_passed_checks_are_folded(drop: Any) -> None:
    checks = table(drop, "Integrity checks")
    passed = [row[1] for row in checks["rows"]].count("passed")
    assert all(row[1] == "passed" for row in checks["rows"][checks["fold"]["first"] :])
    assert checks["fold"]["words"] == f"{passed} of {len(checks['rows'])} checks passed"


def test_when_nearly_everything_fails_no_single_cause_is_named() -> None:
    evaluation = evaluate_run()
    # A common cause, such as a wrong calibration, makes all checks fail: to name one sensor would mislead.
    failed = tuple(
        Kind(check.name, "sigma", ())
        .judge(3.0, 1.0, f"{check.name} is off.")
        .caused_by("a loose wire", "Solder it.")
        for check in evaluation.checks
    )
    reasons = drop_of(replace(evaluation, checks=failed))["verdict"]["reasons"]
    assert sum("checks failed, more than a single sensor causes" in reason for reason in reasons) == 1
    assert not any("a loose wire" in reason for reason in reasons)


def test_a_correction_within_its_uncertainty_is_not_called_for() -> None:
    evaluation = evaluate_run()
    assert worth_of(evaluation) == "to be made" and significance(evaluation) > 3.0
    explained = evaluation.explained
    # Values of 2 % of their standard deviations.
    fit = replace(explained.fit, values=0.02 * explained.fit.std)
    right = replace(evaluation, explained=replace(explained, fit=fit, nominal=explained.fitted))
    assert worth_of(right) == "not called for"
    drop = drop_of(right)
    assert "Correction: none needed" in table(drop, "Correction of the model")["caption"]
    assert "no correction is called for" in numbers(drop)["Largest CoM correction"]["note"]


def test_standing_joints_have_a_row_each(drop: Any) -> None:
    rows = table(drop, "Joints between their strokes")["rows"]
    assert [row[0] for row in rows] == [f"joint {rest.joint}" for rest in evaluate_run().standing]
    assert {row[-1] for row in rows} <= {"steady", "crept", "moved"}


def test_correction_says_what_the_data_cannot_tell(drop: Any) -> None:
    correction, fit = table(drop, "Correction of the model"), evaluate_run().explained.fit
    assert [row[0] for row in correction["rows"]] == list(fit.offsets.names)
    assert correction["rows"][5][0] == "body 2 CoM z"
    assert correction["rows"][5][2] == _as_on_the_page(fit.values[5], fit.std[5])
    assert all(sentence in correction["caption"] for sentence in evaluate_run().identifiability.sentences())


def _as_on_the_page(value: float, std: float) -> str:
    return plus_minus(value, std, sign=True).replace("-", "−")


def test_swarm_of_the_paper_stands_beside_the_correction_if_it_was_asked_for(drop: Any) -> None:
    evaluation = evaluate_run()
    swarm = swarm_fit(evaluation.explained.fit, evaluation.explained.driven.flown, seeds=(1, 2))
    beside = table(drop_of(replace(evaluation, swarm=swarm)), "Correction of the model")
    assert len(beside["columns"]) == len(table(drop, "Correction of the model")["columns"]) + 1
    assert [row[-1] for row in beside["rows"]] == [
        _as_on_the_page(value, spread) for value, spread in zip(swarm.values, swarm.spread, strict=True)
    ] + ["–"] * (len(evaluation.explained.fit.offsets) - len(swarm.values))


def test_offset_at_its_bound_is_named() -> None:
    evaluation = evaluate_run()
    # The fifth offset: three of body 1, then x and y of body 2.
    fit = replace(evaluation.explained.fit, at_bound=np.arange(len(evaluation.explained.fit.values)) == 4)
    stuck = drop_of(replace(evaluation, explained=replace(evaluation.explained, fit=fit)))
    assert "Stopped at its bound: body 2 CoM y." in table(stuck, "Correction of the model")["caption"]


def test_provenance_names_the_very_bytes(drop: Any) -> None:
    rows = dict(table(drop, "Provenance")["rows"])
    recording = folder() / "SD.bin"
    assert rows["recording"] == str(recording)
    # Years later only this tells which recording a printed page is of.
    assert rows["SHA-256 of the recording"] == hashlib.sha256(recording.read_bytes()).hexdigest()
    assert rows["session"] == f"{evaluate_run().log.session:08x}"
    assert rows["released"].startswith("2026-01-05 09:00")
    assert "(emulated)" in rows["logger"] and rows["maneuver"].startswith("joint 1 +59 deg at 0.7 s")


def test_calibration_older_than_a_landing_is_marked() -> None:
    from tfsat_host.calibration.certificate.certificate import Landing, with_landing

    evaluation = evaluate_run()
    # Half an hour after the calibration, half an hour before the drop: biases may have jumped.
    landed = with_landing(
        evaluation.calibration, Landing(datetime(2026, 1, 5, 8, 30, tzinfo=UTC), "a witness")
    )
    rows = {
        row[0]: row[3]
        for row in table(drop_of(replace(evaluation, calibration=landed)), "Calibration")["rows"]
    }
    assert rows["bias of body 1"] == "2026-01-05 08:00 UTC, before a landing"
    assert rows["scale factors of body 1"] == "2026-01-05 08:00 UTC"  # survives any landing


def test_notes_do_not_repeat_the_verdict() -> None:
    drop = drop_of(replace(evaluate_run(), notes=("The gyro of body 4 was silent.",)))
    assert "The gyro of body 4 was silent." in drop["verdict"]["reasons"]
    assert "The gyro of body 4 was silent." not in drop["notes"]


def test_without_a_schedule_strokes_are_those_of_the_line() -> None:
    drop = drop_of(replace(evaluate_run(), schedule=None, strokes=(), clocks=None))
    assert [event["label"] for event in drop["events"] if event["kind"] == "stroke"] == [
        "stroke 1",
        "stroke 2",
        "stroke 3",
        "stroke 4",
    ]
    assert not [entry for entry in drop["tables"] if entry["title"] in ("Strokes", "Clocks")]
    assert {line["kind"] for line in plots(drop)["joints"]["series"]} == {"measured"}


def test_several_drops_are_one_document_with_the_same_plots() -> None:
    drops = [report_drop(name="morning"), report_drop(name="evening")]
    document = document_of(drops, MADE)
    assert [drop["name"] for drop in document["drops"]] == ["morning", "evening"]
    assert document["title"] == "EMULATED drop tower robot: morning, evening"
    first, second = ([plot["id"] for plot in drop["plots"]] for drop in document["drops"])
    assert first == second


def test_the_page_is_small_and_has_verdict_and_numbers_without_a_script() -> None:
    document = document_of([report_drop(name="<b>drop</b>")], MADE)
    # The name is markup: as text it must stay text, without any script.
    page = render(document)
    assert len(page.encode()) < MAX_BYTES
    text = page.split("<noscript>")[1].split("</noscript>")[0]
    assert "<h2>&lt;b&gt;drop&lt;/b&gt;: good</h2>" in text and "<th>Reorientation</th>" in text
    drop = document["drops"][0]
    for words in (drop["verdict"]["sentence"], drop["change"], drop["prediction"]["title"]):
        assert words in text


@pytest.mark.parametrize("silent", ["the gyro of body 4, and all for 50 ms", "the angle sensors of joint 3"])
def test_whatever_is_missing_the_page_is_made(silent: str) -> None:
    """And the maneuver is unknown."""
    log, gyro = evaluate_run().log, "gyro" in silent
    imu, angles = log.imu_valid.copy(), log.angle_valid.copy()
    if gyro:
        # One gyro never; all of them once, in the middle of a stroke.
        imu[:, 3] = False
        imu[(log.t_s > 1.2) & (log.t_s < 1.25)] = False
    else:
        # Both sensors of joint 3.
        angles[:, 4:] = False
    damaged = replace(log, imu_valid=imu, angle_valid=angles)
    evaluation = evaluate(damaged, load_robot(), evaluate_run().calibration, None)
    document = document_of([report_drop(evaluation)], MADE)
    drop = document["drops"][0]
    assert len(render(document).encode()) < MAX_BYTES
    assert drop["verdict"]["level"] == "doubtful"
    assert numbers(drop)["Reorientation"]["std"] > 0.0
    assert ("never answered" in table(drop, "Joints")["rows"][2][3]) is not gyro
    assert any("gyro of body 4" in reason for reason in drop["verdict"]["reasons"]) is gyro


def test_a_real_drop_draws(open_document: Opener) -> None:
    document = document_of([report_drop()], MADE)
    opened = open_document(document)
    plot_ids = {
        figure.get_attribute("data-plot") for figure in opened.page.locator("figure[data-plot]").all()
    }
    assert {plot["id"] for plot in document["drops"][0]["plots"]} <= plot_ids
    text = opened.page.inner_text("body")
    assert "Reorientation" in text and document["drops"][0]["verdict"]["sentence"] in text


def test_the_documented_python_call_makes_a_page() -> None:
    text = (DOCS / "report.md").read_text(encoding="utf-8")
    example = textwrap.dedent(text.split("made otherwise:\n", 1)[1])
    names: dict[str, object] = {"evaluation": report_drop().evaluation}
    exec(example, names)
    assert str(names["page"]).startswith("<!doctype html>")
