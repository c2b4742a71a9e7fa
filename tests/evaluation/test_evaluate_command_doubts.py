"""Drops of which something is missing or wrong: what `evaluate` says, and that it never hides it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.evaluation.commanded import Said, evaluate, evaluate_to_json
from tests.evaluation.run_folder import (
    CERTIFICATE,
    DROPPED,
    change_headers,
    change_samples,
    cut,
    released_s,
    remove_blocks,
    run_folder,
    tell_time,
)
from tfsat_host.calibration.certificate.certificate import Calibration, Landing, with_landing
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.evaluation import evaluation
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.log_layout import SWITCH_OPEN_BIT
from tfsat_host.sdlog import load

HOUR = timedelta(hours=1)


def change_certificate(run: Path, change: Callable[[Calibration], Calibration]) -> None:
    file = run / CERTIFICATE
    file.write_text(format_calibration(change(read_calibration(file))), encoding="utf-8")


def silence(run: Path, body: int, from_s: float, until_s: float) -> None:
    """Silence a body's IMU between two times after the release."""
    zero_s = released_s(run)

    def change(blocks: Any, t_s: np.ndarray[Any, Any]) -> None:
        # After the release by the recording's own clock.
        silent = (t_s >= zero_s + from_s) & (t_s < zero_s + until_s)
        blocks["samples"]["flags"][silent] &= ~np.uint16(1 << (body - 1))

    change_samples(run / "SD.bin", change)


def open_before_the_release(run: Path, opened_s: Sequence[float], for_s: float) -> None:
    """Open and close both switches together at times before the release, in samples and events."""
    zero_s = released_s(run)
    edges = [(zero_s + at_s, is_open) for at in opened_s for at_s, is_open in ((-at, 1), (for_s - at, 0))]

    def change(blocks: Any, t_s: np.ndarray[Any, Any]) -> None:
        for at in opened_s:
            jolted = (t_s >= zero_s - at) & (t_s < zero_s - at + for_s)
            blocks["samples"]["flags"][jolted] |= np.uint16(0b11 << SWITCH_OPEN_BIT)
        later = np.flatnonzero((t_s[:, 0] > zero_s) & (blocks["event_count"] == 0))
        for row, (at_s, is_open) in zip(later, edges, strict=False):
            # Edges need a slot: blocks that have no event yet.
            blocks["event_count"][row] = 2
            events = blocks["events"][row]
            events["time_us"], events["code"] = round(1e6 * at_s), EventCode.SWITCH_EDGE
            events["index"], events["arg"] = (0, 1), is_open

    change_samples(run / "SD.bin", change)


def reasons(evaluation: Any) -> str:
    assert evaluation["verdict"]["level"] == "doubtful"
    return "\n".join(evaluation["verdict"]["reasons"])


def test_nothing_is_said_of_a_time_after_the_last_stroke_that_was_not_recorded(run: Path) -> None:
    cut(run, 1.06)
    reason_text = reasons(evaluate_to_json("run", expect=3))
    assert "due after the end of what can be evaluated" in reason_text
    assert "after the last stroke" not in reason_text


def test_edges_that_fit_two_releases_are_an_uncertainty_of_the_release(run: Path, good: Said) -> None:
    # Six openings of a millisecond, 4 ms apart: they fit two releases.
    open_before_the_release(run, [0.024, 0.020, 0.016, 0.012, 0.008, 0.004], 0.001)
    evaluation = evaluate_to_json("run", expect=3)
    assert "fit two releases" in reasons(evaluation)
    assert "the robot left between 24.000 ms before t = 0" in reasons(evaluation)
    assert good.json["release"]["std_s"] == 0.0
    # Uniform within 24 ms: the standard deviation is that over the root of three.
    assert evaluation["release"]["std_s"] == pytest.approx(0.024 / 3**0.5)
    fallen = re.search(r"Fall: (\S+) ± (\S+) s, release", evaluate("run").words)
    assert fallen is not None and float(fallen[2]) == pytest.approx(evaluation["release"]["std_s"], rel=0.1)
    assert float(fallen[1]) == pytest.approx(good.json["landing"]["felt"]["t_s"], abs=1e-3)


def test_without_a_calibration(run: Path, good: Said) -> None:
    (run / CERTIFICATE).unlink()
    evaluation = evaluate_to_json("run", expect=3)
    assert evaluation["calibration"] is None
    assert "There is no calibration" in reasons(evaluation)
    assert any("tfsat-host calibrate" in note for note in evaluation["notes"])
    # Without calibration the reorientation is more uncertain, but not wrong.
    assert evaluation["reorientation_deg_std"] > 1.5 * good.json["reorientation_deg_std"]


def test_a_calibration_that_a_landing_has_ended(run: Path) -> None:
    change_certificate(
        # A landing half an hour before this drop: everything measured before it is over.
        run,
        lambda calibration: with_landing(calibration, Landing(DROPPED - HOUR / 2, "a test")),
    )
    result = evaluate("run")
    assert result.code == 3
    assert result.words.startswith("DOUBTFUL: the calibration is not valid for this drop")
    assert "Measured before the last landing" in result.words
    assert "To measure: tfsat-host calibrate bias" in result.words
    assert "The bias of body 1, 2, 3, 4 is that of the" in result.words
    assert "(not valid for this drop)" in result.words


def test_its_own_landing_is_no_objection_to_a_calibration(run: Path) -> None:
    assert evaluate("run").code == 0
    (landing,) = read_calibration(run / CERTIFICATE).landings
    # The evaluation noted this drop's own landing: it is later than the drop.
    assert landing.at > DROPPED
    assert evaluate("run").code == 0


@pytest.mark.parametrize("told", [None, datetime(1970, 1, 1, 0, 5, tzinfo=UTC)], ids=["none", "1970"])
def test_without_a_time_of_day_nobody_knows_which_was_first(run: Path, told: datetime | None) -> None:
    """Doubt a recording without a time of day; 1970 is what a computer without a clock told the logger."""
    tell_time(run / "SD.bin", told)
    evaluation = evaluate_to_json("run", expect=3)
    assert "The recording has no time of day" in reasons(evaluation)
    assert "Measured before the last landing" not in reasons(evaluation)
    assert evaluation["recording"]["released"] is None


def test_a_calibration_of_another_robot_is_not_used(run: Path) -> None:
    change_certificate(
        run,
        lambda calibration: replace(
            calibration, subject=replace(calibration.subject, logger_serial="00c0ffee")
        ),
    )
    evaluation = evaluate_to_json("run", expect=3)
    assert "None of its numbers hold" in reasons(evaluation)
    assert "There is no calibration" in reasons(evaluation), "it was evaluated without"


def test_the_numbers_of_an_imu_that_was_exchanged_are_not_used(run: Path) -> None:
    change_certificate(
        run,
        # Another WHO_AM_I in body 3's place: another part, with another bias.
        lambda calibration: replace(calibration, subject=replace(calibration.subject, who_am_i="68687068")),
    )
    evaluation = evaluate_to_json("run", expect=3)
    assert "The IMU of body 3 is another than the one that was calibrated" in reasons(evaluation)
    assert "The bias of body 3 is that of the" in reasons(evaluation)


def test_a_calibration_that_cannot_be_read_is_refused(run: Path) -> None:
    (run / CERTIFICATE).write_text("nonsense")
    result = evaluate("run")
    assert result.code == 1 and result.out == ""
    assert f"{Path('run') / CERTIFICATE}: is not valid TOML" in result.err


def test_a_gyro_that_dies_in_the_fall_is_bridged(run: Path, good: Said) -> None:
    # From half a second after the release to the end.
    silence(run, 1, 0.5, 9.0)
    evaluation = evaluate_to_json("run", expect=3)
    assert "The gyro of body 1 lacks" in reasons(evaluation)
    assert "bridged from its neighbours" in reasons(evaluation)
    assert [body["bridged"] for body in evaluation["bodies"]] == [True, False, False, False]
    assert evaluation["reorientation_deg_std"] > good.json["reorientation_deg_std"]
    off = evaluation["reorientation_deg"] - good.json["reorientation_deg"]
    assert abs(off) < 4 * evaluation["reorientation_deg_std"]


def test_lost_samples(run: Path) -> None:
    zero_s = released_s(run)
    # 60 ms of samples are gone, in the middle of a stroke.
    remove_blocks(run / "SD.bin", zero_s + 1.20, zero_s + 1.26)
    evaluation = evaluate_to_json("run", expect=3)
    assert "samples are lost" in reasons(evaluation)
    assert evaluation["recording"]["samples_lost"] > 5
    assert "the recording is incomplete" in evaluation["verdict"]["sentence"].lower()


def test_a_hole_that_nothing_can_be_carried_over(run: Path) -> None:
    zero_s = released_s(run)
    # Half a second: too long for any interpolation.
    remove_blocks(run / "SD.bin", zero_s + 1.0, zero_s + 1.5)
    result = evaluate("run")
    assert result.code == 1 and result.out == ""
    assert result.err.count("Error: ") == 1


def test_a_log_that_ends_after_the_landing(run: Path) -> None:
    cut(run, 2.8)
    evaluation = evaluate_to_json("run", expect=3)
    assert "The recording has no end" in reasons(evaluation)
    assert evaluation["recording"]["verdict"] == "truncated"


def test_a_log_that_ends_in_the_fall_says_so(run: Path) -> None:
    cut(run, 1.6)
    evaluation = evaluate_to_json("run", expect=3)
    assert "The recording ends 1.60 s after the release, in the fall" in reasons(evaluation)
    # The last 50 ms before the end of the recording are left out.
    assert evaluation["until_s"] == pytest.approx(1.55, abs=0.02)
    assert [stroke["moved"] for stroke in evaluation["strokes"]] == [True, True, True, False]
    assert "Stroke 4 (joint 2): " in reasons(evaluation)


def test_a_log_without_a_release_is_refused(run: Path) -> None:
    cut(run, -0.5)
    result = evaluate("run")
    assert result.code == 1 and result.out == ""
    assert "has no release" in result.err
    assert f"Events of the recording: tfsat-host decode {Path('run/SD.bin')}" in result.err


@pytest.mark.parametrize(
    ("make", "args", "code", "words"),
    [
        (lambda _: None, ("nowhere",), 1, "There is no file or folder nowhere."),
        (lambda here: (here / "empty").mkdir(), ("empty",), 1, "empty holds no recording"),
        (lambda here: (here / "none.bin").write_text("no log"), ("none.bin",), 1, "none.bin"),
        (lambda _: None, ("run", "--maneuver", "none.toml"), 1, "The maneuver file none.toml cannot be read"),
        (lambda _: None, ("run", "--calibration", "none.toml"), 1, "none.toml"),
        (lambda _: None, ("run", "--robot", "cubesat_3u"), 1, "does not fit the boards"),
        (lambda _: None, ("run", "--session", "xyz"), 2, "'xyz' is no recording's id"),
        (lambda _: None, ("run", "--session", "0"), 2, "00000000"),
        (lambda _: None, ("run", "--facility", "cosmotorre.toml"), 2, "--facility"),
        (lambda _: None, ("run", "--laser", "none.csv"), 1, "none.csv"),
        (lambda _: None, (), 2, "RUN"),
    ],
)
def test_what_cannot_be_understood(
    run: Path, make: Callable[[Path], Any], args: tuple[str, ...], code: int, words: str
) -> None:
    make(run.parent)
    result = evaluate(*args)
    assert result.code == code and result.out == ""
    assert words in result.err


def test_several_recordings_in_a_folder_are_named(run: Path) -> None:
    (run / "SD.bin").rename(run / "DROP0001.BIN")
    (run / "DROP0002.BIN").write_bytes((run / "DROP0001.BIN").read_bytes())
    result = evaluate("run")
    assert result.code == 1
    assert "run holds several recordings: DROP0001.BIN, DROP0002.BIN." in result.err
    assert f"tfsat-host evaluate {Path('run/DROP0001.BIN')}" in result.err


def test_several_recordings_in_a_file_are_told_apart(run: Path) -> None:
    run_folder(run.parent / "second", seed=2)
    both = (run / "SD.bin").read_bytes() + (run.parent / "second" / "SD.bin").read_bytes()
    sessions = [load(folder / "SD.bin").session for folder in (run, run.parent / "second")]
    (run / "SD.bin").write_bytes(both)
    for session in sessions:
        result = evaluate("run", "--session", f"{session:08x}", "--json")
        assert f'"session": "{session:08x}"' in result.out
        assert "holds 2 recordings" in result.err and "tfsat-host evaluate" in result.err


def damage_badly(run: Path) -> None:
    """Lose 30 ms of each 100 ms, bend every sensor in the fall, and end the calibration before the drop."""
    zero_s = released_s(run)
    for from_s in np.arange(-8.0, 2.4, 0.1):
        remove_blocks(run / "SD.bin", zero_s + from_s, zero_s + from_s + 0.03)

    def bend(blocks: Any, t_s: np.ndarray[Any, Any]) -> None:
        late, imu, angle = t_s > zero_s + 0.9, blocks["samples"]["imu"], blocks["samples"]["angle"]
        # Another step for each body, so that no single sensor can be the cause.
        for body in range(4):
            imu["gyro"][:, :, body][late] += np.int16(200 * (body + 1))
            imu["accel"][:, :, body][late] += np.int16(2000 * (body + 1))
        # One of the two angle sensors of joints 1 and 2.
        angle[:, :, 0][late] += 200
        angle[:, :, 3][late] += 300

    change_samples(run / "SD.bin", bend)
    change_certificate(
        run, lambda calibration: with_landing(calibration, Landing(DROPPED - HOUR / 2, "a test"))
    )


def test_a_badly_damaged_drop_has_its_gravest_reasons_on_one_screen(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    damage_badly(run)
    all_reasons = evaluate_to_json("run", expect=3)["verdict"]["reasons"]
    assert len(all_reasons) > 20
    screen, full = evaluate("run", full=False), evaluate("run")
    lines = screen.out.splitlines()
    assert len(lines) <= 40 and lines[-1].startswith("DOUBTFUL: ")
    shown, full_shown = (
        # The reasons stand above the first empty line.
        [line for line in said.out.partition("\n\n")[0].splitlines() if line.startswith("  - ")]
        for said in (screen, full)
    )
    assert 1 < len(shown) <= 5 and len(full_shown) == len(all_reasons)
    assert shown == full_shown[: len(shown)], "the gravest first"
    more = f"  {len(all_reasons) - len(shown)} more reasons: tfsat-host evaluate run --full"
    assert lines.index(more) < lines.index("")


def test_reasons_that_fit_a_screen_are_all_there_in_full(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    cut(run, 2.8)
    screen = evaluate("run", full=False)
    (reason,) = evaluate_to_json("run", expect=3)["verdict"]["reasons"]
    assert reason in screen.words and "more reason" not in screen.out
    assert len(screen.out.splitlines()) <= 40


@pytest.mark.parametrize("header", [{"dlpf_cfg": 0}, {"rate_hz": 10, "angle_offset_us": [65535] * 6}])
def test_a_header_of_other_settings_is_doubtful(run: Path, header: dict[str, Any]) -> None:
    """It was a run with 42 Hz and 280 samples a second."""
    # A header with other settings than those that the samples show.
    change_headers(run / "SD.bin", **header)
    result = evaluate("run")
    assert result.code == 3 and result.out.startswith("DOUBTFUL:")


def test_readings_that_no_motion_explains_end_in_words(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def singular(*_: object) -> None:
        raise np.linalg.LinAlgError("Singular matrix")

    # As if the equations had no solution: an evaluation must end in words, not in a traceback.
    monkeypatch.setattr(evaluation, "motion_of", singular)
    result = evaluate("run")
    assert (
        result.code == 1
        and "no motion explains the readings" in result.err
        and f"tfsat-host decode {Path('run/SD.bin')}" in result.err
    )
