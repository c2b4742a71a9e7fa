"""`calibrate show` as a user has it: every quantity, what to type for what is missing, and the papers."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.calibration.some_calibration import MEASURED, whole_calibration
from tests.cli.process import RunCli
from tfsat_host.calibration.certificate.certificate import Calibration, Landing, Recording, with_landing
from tfsat_host.calibration.certificate.file import format_calibration
from tfsat_host.calibration.review import age_words
from tfsat_host.calibration.sensors.gyro import by_design
from tfsat_host.calibration.steps.evidence import sha256

HOUR = timedelta(hours=1)


def certificate(folder: Path, calibration: Calibration, name: str = "calibration.toml") -> Path:
    file = folder / name
    file.write_text(format_calibration(calibration), encoding="utf-8")
    return file


def test_show_without_a_certificate_says_how_to_begin(tfsat_host: RunCli) -> None:
    error = tfsat_host.json("calibrate", "show", expect=1)["error"]
    assert error["what"] == "No calibration: file calibration.toml does not exist."
    assert error["next_step"] == "Begin with: tfsat-host calibrate bias"
    error = tfsat_host.json("calibrate", "show", "--emulated", expect=1)["error"]
    assert "calibration-emulated.toml" in error["what"]
    assert error["next_step"].endswith("calibrate bias --emulated")


@pytest.mark.parametrize(("requested_suffix", "there"), [("", "-emulated"), ("-emulated", "")])
def test_show_names_the_certificate_of_the_other_robot(
    tfsat_host: RunCli, requested_suffix: str, there: str
) -> None:
    """Next to it: a rehearsal leaves an emulated robot's where its person then looks for it."""
    # The other robot's certificate, so that its name can be told.
    certificate(tfsat_host.folder, whole_calibration(), f"calibration{there}.toml")
    option, other = ((f"--{name[1:]}",) if name else () for name in (requested_suffix, there))
    error = tfsat_host.json("calibrate", "show", *option, expect=1)["error"]
    assert error["what"] == f"No calibration: file calibration{requested_suffix}.toml does not exist."
    assert f"calibration{there}.toml" in error["meaning"]
    assert " ".join(["tfsat-host calibrate show", *other]) in error["next_step"]
    assert "tfsat-host calibrate bias" in error["next_step"]


def test_show_tells_every_quantity_in_peoples_units(tfsat_host: RunCli) -> None:
    # Half an hour more than three hours: "3 h ago" whenever the test runs.
    calibration = whole_calibration(measured_at=datetime.now(UTC) - 3 * HOUR - HOUR / 2)
    certificate(tfsat_host.folder, calibration)
    report = tfsat_host.json("calibrate", "show")
    assert report["ready"] is True
    assert report["commands"] == []
    rows = {row["quantity"]: row for row in report["quantities"]}
    # Three biases, misalignments and scale factors a gyro, and the joints' own.
    assert len(rows) == 30
    bias = rows["bias of body 2"]
    assert bias["value"] == pytest.approx(np.degrees(calibration.gyros[1].bias_rad_s))
    assert (bias["std"], bias["unit"]) == (pytest.approx([0.005] * 3), "deg/s")
    assert bias["age_s"] == pytest.approx(12600, abs=300)
    turned = rows["misalignment of body 4 about y"]
    assert (turned["value"], turned["std"]) == (pytest.approx(1.5), pytest.approx(0.02))
    assert turned["axis_sensor"] == pytest.approx(calibration.gyros[3].rotation.T @ [0.0, 1.0, 0.0])
    scale = rows["scale factor z of body 3"]
    assert scale["value"] == pytest.approx(calibration.gyros[2].scale[2])
    assert (scale["std"], scale["frame"]) == (pytest.approx(np.radians(0.05)), "body")
    assert rows["zero point of joint 1"]["value"] == pytest.approx(np.degrees(calibration.joints[0].zero_rad))
    servo = calibration.servo_maps[2]
    assert rows["servo of joint 3"]["value"] == pytest.approx(np.degrees(servo.backlash_rad))
    text = tfsat_host("calibrate", "show", "--full", environ={"COLUMNS": "150"}).stdout
    for words in ("3 h ago", "± 0.0050 deg/s", "1.500 ± 0.020 deg", "scale factors of the gyros, body axes"):
        assert words in text
    assert "stale" not in text


def test_the_first_screen_is_the_verdict_what_it_rests_on_and_what_to_type(tfsat_host: RunCli) -> None:
    calibration = whole_calibration(measured_at=datetime.now(UTC) - 3 * HOUR)
    # Body 1 as designed: its six quantities are missing.
    bare = replace(calibration, gyros=(by_design(1, np.eye(3)), *calibration.gyros[1:]))
    certificate(tfsat_host.folder, with_landing(bare, Landing(datetime.now(UTC) - HOUR, "a test")))
    lines = tfsat_host("calibrate", "show", environ={"COLUMNS": "80"}).stdout.splitlines()
    verdict = "NOT READY: 6 calibrations missing, 15 calibrations older than the last landing"
    assert (lines[0], lines[-1]) == (verdict, verdict)
    # One screen of 80 columns.
    assert len(lines) <= 40 and max(map(len, lines)) <= 80
    text = "\n".join(lines)
    for words in ("3 of 4", "1 missing, 3 stale", "tfsat-host calibrate bias\n", "show --full"):
        assert words in text
    certificate(tfsat_host.folder, calibration)
    ready = tfsat_host("calibrate", "show").stdout
    assert ready.startswith("READY: 30 of 30 calibrations valid until the next landing\n")
    assert "To measure" not in ready


def test_the_commands_after_an_emulated_certificate_are_for_the_emulated_robot(tfsat_host: RunCli) -> None:
    whole = whole_calibration(measured_at=datetime.now(UTC) - 3 * HOUR)
    emulated = replace(whole, subject=replace(whole.subject, emulated=True))
    file = certificate(tfsat_host.folder, with_landing(emulated, Landing(datetime.now(UTC) - HOUR, "a test")))
    # Named by --out: nothing that was typed says that it is of an emulated robot.
    text = tfsat_host("calibrate", "show", "--out", str(file)).stdout
    commands = [line.strip() for line in text.splitlines() if "tfsat-host calibrate" in line]
    assert len(commands) > 2 and all(command.endswith(" --emulated") for command in commands)


def test_scale_factors_are_shown_about_the_bodies_axes(tfsat_host: RunCli) -> None:
    calibration = whole_calibration()
    gyro = calibration.gyros[0]
    turned = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # x of the body is z of the sensor
    doubtful = gyro.covariance.copy()
    # The z axis of the sensor that the body's z lies along was never measured well.
    doubtful[7, 7] = 0.017**2
    scale_times = {axis: gyro.scaled[axis] for axis in "xy"}
    mounted = replace(gyro, rotation=turned, covariance=doubtful, scaled=scale_times)
    certificate(tfsat_host.folder, replace(calibration, gyros=(mounted, *calibration.gyros[1:])))
    report = tfsat_host.json("calibrate", "show")
    rows = {row["quantity"]: row for row in report["quantities"]}
    for axis, sensor in (("x", 2), ("y", 0)):
        # By the body's axes, not the sensor's.
        row = rows[f"scale factor {axis} of body 1"]
        assert (row["value"], row["std"]) == pytest.approx((gyro.scale[sensor], np.radians(0.05)))
    assert rows["scale factor z of body 1"]["state"] == "missing"
    assert report["commands"] == ["tfsat-host calibrate scale --turn z 360"]


def test_show_says_what_to_type_and_which_papers_are_there(tfsat_host: RunCli) -> None:
    calibration = whole_calibration()
    folder = tfsat_host.folder / "mine-recordings"
    folder.mkdir()
    (folder / "rest-1.npz").write_bytes(b"as it was")
    # A recording that was changed, and one that is gone.
    (folder / "zero-1.npz").write_bytes(b"changed")
    recordings = tuple(
        Recording(step, MEASURED, f"{step}-1.npz", sha256(b"as it was"))
        for step in ("rest", "zero", "turn-z")
    )
    bare = replace(
        calibration, gyros=(by_design(1, np.eye(3)), *calibration.gyros[1:]), recordings=recordings
    )
    file = certificate(
        tfsat_host.folder, with_landing(bare, Landing(MEASURED + HOUR, "recording 1a2b3c4d")), "mine.toml"
    )
    report = tfsat_host.json("calibrate", "show", "--out", file.name)
    # As it was, changed, and not there.
    assert [recording["state"] for recording in report["recordings"]] == ["matches", "changed", "gone"]
    assert report["landings"] == [{"at": "2026-07-01T10:30:00+00:00", "told_by": "recording 1a2b3c4d"}]
    missing = [row for row in report["quantities"] if row["state"] == "missing"]
    assert [row["value"] for row in missing] == [None] * 6
    assert report["commands"][0] == "tfsat-host calibrate bias --out mine.toml"
    text = tfsat_host("calibrate", "show", "--full", "--out", file.name, environ={"COLUMNS": "150"}).stdout
    for words in (
        "missing",
        "stale",
        "\n  tfsat-host calibrate scale --turn z 360 --out mine.toml\n",
        "unmodified",
        "CHANGED",
        "NOT THERE",
        "2 recordings altered or missing",
        "1 of 3 unmodified (SHA-256)",
        "2026-07-01 10:30:00 UTC",
        "(recording 1a2b3c4d)",
    ):
        assert words in text


@pytest.mark.parametrize(
    ("age", "words"),
    [
        (timedelta(seconds=90), "just now"),
        (timedelta(minutes=119), "119 min ago"),
        (timedelta(hours=47), "47 h ago"),
        (timedelta(days=2), "2 days ago"),
        (timedelta(minutes=-5), "in the future"),
    ],
)
def test_ages(age: timedelta, words: str) -> None:
    assert age_words(age) == words


def test_show_is_not_ready_while_a_recording_or_the_clock_is_doubtful(tfsat_host: RunCli) -> None:
    # A hash that no file can have.
    recording = Recording("rest", MEASURED, "rest.npz", "00" * 32)
    now = datetime.now(UTC)
    certificate(
        tfsat_host.folder, replace(whole_calibration(measured_at=now - HOUR), recordings=(recording,))
    )
    assert tfsat_host.json("calibrate", "show")["ready"] is False
    assert "NOT READY: 1 recording altered or missing" in tfsat_host("calibrate", "show").stdout
    # Dated in the future: the clock was wrong then or is now.
    certificate(tfsat_host.folder, replace(whole_calibration(measured_at=now + HOUR), recordings=()))
    assert tfsat_host.json("calibrate", "show")["ready"] is False
    assert "30 calibrations dated in the future" in tfsat_host("calibrate", "show").stdout
