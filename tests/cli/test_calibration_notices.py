"""What `decode` and `arm` say of a calibration: whose it is, how old, and what it lacks."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.calibration.quiet_drop import quiet_drop
from tests.calibration.some_calibration import SUBJECT
from tests.cli.certified import (
    DROPPED,
    HOUR,
    MEASURED,
    certificate,
    join_sentences,
    whole_calibration,
    write_drop,
)
from tests.cli.process import RunCli
from tests.emulated.served import Served
from tfsat_host.calibration.certificate.certificate import Landing, with_landing
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.sensors.gyro import by_design


def test_without_a_certificate_decode_is_silent(tfsat_host: RunCli) -> None:
    process = tfsat_host("decode", write_drop(tfsat_host.folder), "--json")
    assert json.loads(process.stdout)["calibration"] is None
    assert "alibration" not in process.stderr


def test_a_calibration_that_holds_and_then_learns_of_the_landing(tfsat_host: RunCli) -> None:
    file = certificate(tfsat_host.folder, whole_calibration())
    process = tfsat_host("decode", write_drop(tfsat_host.folder))
    assert "calibration.toml (valid for this recording)" in process.stderr
    landing = "2024-07-01 10:30:02 UTC"
    assert f"calibration.toml knows of the landing at {landing} now" in process.stderr
    (known_landing,) = read_calibration(file).landings
    assert known_landing.told_by == "recording 1234abcd"
    assert (known_landing.at - DROPPED).total_seconds() == pytest.approx(2.5, abs=0.1)
    again = tfsat_host("decode", write_drop(tfsat_host.folder), "--json")
    assert json.loads(again.stdout)["calibration"] == {
        "file": str(file),
        "usable": True,
        "shortcomings": [],
        "sentences": [],
    }
    assert "knows of the landing" not in again.stderr
    # Decoded twice, it landed once.
    assert len(read_calibration(file).landings) == 1
    report = tfsat_host.json("calibrate", "show")
    assert report["ready"] is False
    assert {row["state"] for row in report["quantities"]} == {"stale", "valid"}


def test_landings_before_the_recording_count(tfsat_host: RunCli) -> None:
    early = with_landing(whole_calibration(), Landing(MEASURED + HOUR / 2, "a test"))
    certificate(tfsat_host.folder, early)
    result = tfsat_host.json("decode", write_drop(tfsat_host.folder))
    assert result["warnings"] == []
    assert result["calibration"]["usable"] is False
    # Everything that a landing may change: biases, misalignments and zero points.
    assert len(result["calibration"]["shortcomings"]) == 18
    assert result["calibration"]["shortcomings"][0] == {
        "quantity": "bias of body 1",
        "reason": "stale",
        "taken": MEASURED.isoformat(),
        "command": "tfsat-host calibrate bias",
    }
    assert join_sentences(result).startswith(
        "Measured before the last landing, which may have changed it: bias of body 1, "
    )
    assert "tfsat-host calibrate bias" in join_sentences(result)


def test_what_was_measured_after_the_drop_is_named(tfsat_host: RunCli) -> None:
    certificate(tfsat_host.folder, whole_calibration(measured_at=DROPPED + HOUR))
    result = tfsat_host.json("decode", write_drop(tfsat_host.folder))
    assert join_sentences(result).startswith("Measured only after the landing that followed")
    assert "bias of body 1, bias of body 2, bias of body 3 and 15 more" in join_sentences(result)


def test_what_it_lacks_is_named(tfsat_host: RunCli) -> None:
    calibration = whole_calibration()
    bare = replace(calibration, gyros=(by_design(1, np.eye(3)), *calibration.gyros[1:]))
    certificate(tfsat_host.folder, bare)
    result = tfsat_host.json("decode", write_drop(tfsat_host.folder))
    assert join_sentences(result).startswith(
        "The calibration lacks bias of body 1, misalignment of body 1 about x, "
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            {"logger_serial": "00c0ffee"},
            "it was taken on logger 00c0ffee; these hang on logger 3132333435363738",
        ),
        ({"emulated": True}, "The calibration is of an emulated robot; these sensors are a real one's"),
    ],
)
def test_of_other_sensors(tfsat_host: RunCli, change: dict[str, Any], words: str) -> None:
    other = whole_calibration(subject=replace(SUBJECT, **change))
    file = certificate(tfsat_host.folder, other, "other.toml")
    result = tfsat_host.json("decode", write_drop(tfsat_host.folder), "--calibration", file)
    assert words in join_sentences(result)
    assert result["calibration"]["usable"] is False
    # Its landing is not noted in the certificate of another robot.
    assert read_calibration(file).landings == (), "another robot did not land"


def test_an_imu_that_was_exchanged_is_named_and_the_robot_landed_all_the_same(tfsat_host: RunCli) -> None:
    other = whole_calibration(subject=replace(SUBJECT, who_am_i="68686968"))
    file = certificate(tfsat_host.folder, other)
    result = tfsat_host.json("decode", write_drop(tfsat_host.folder))
    assert join_sentences(result).startswith("The IMU of body 3 is another than the one that was calibrated")
    assert result["calibration"]["usable"] is False
    # The robot landed, whichever IMU it has.
    assert len(read_calibration(file).landings) == 1


def test_an_emulated_recording_looks_for_an_emulated_certificate(tfsat_host: RunCli) -> None:
    certificate(tfsat_host.folder, whole_calibration())
    emulated = whole_calibration(subject=replace(SUBJECT, emulated=True))
    log = write_drop(tfsat_host.folder, image_crc=0)
    assert tfsat_host.json("decode", log)["calibration"] is None
    certificate(tfsat_host.folder, emulated, "calibration-emulated.toml")
    result = tfsat_host.json("decode", log)
    assert result["calibration"]["file"].endswith("calibration-emulated.toml")
    assert result["calibration"]["usable"] is True


def test_the_certificate_beside_the_log_comes_first(tfsat_host: RunCli) -> None:
    beside = tfsat_host.folder / "drop"
    beside.mkdir()
    certificate(tfsat_host.folder, whole_calibration())
    log = write_drop(beside)
    assert tfsat_host.json("decode", log)["calibration"]["file"] == "calibration.toml"
    certificate(beside, whole_calibration())
    assert tfsat_host.json("decode", log)["calibration"]["file"] == str(beside / "calibration.toml")


@pytest.mark.parametrize("text", ["format = 2\n", "nonsense", None])
def test_a_certificate_that_cannot_be_read_is_a_warning(tfsat_host: RunCli, text: str | None) -> None:
    file = tfsat_host.folder / "mine.toml"
    if text is not None:
        file.write_text(text)
    process = tfsat_host("decode", write_drop(tfsat_host.folder), "--calibration", file, "--json")
    result = json.loads(process.stdout)
    assert result["verdict"] == "complete"
    assert result["calibration"]["usable"] is False
    assert str(file) in join_sentences(result)
    assert f"Warning: {result['calibration']['sentences'][0]}" in process.stderr


def test_a_certificate_that_cannot_be_written_is_a_warning(tfsat_host: RunCli) -> None:
    """Warn of a certificate that cannot be written.

    Its name is so long that no new file next to it can be named after it.
    """
    # 245 characters: the name is allowed, a temporary file's is not.
    file = certificate(tfsat_host.folder, whole_calibration()).rename(tfsat_host.folder / f"{'c' * 245}.toml")
    process = tfsat_host("decode", write_drop(tfsat_host.folder), "--calibration", file)
    assert "could not be written into" in process.stderr
    assert read_calibration(file).landings == ()


def test_the_quiet_before_a_release(tfsat_host: RunCli) -> None:
    assert tfsat_host.json("decode", write_drop(tfsat_host.folder))["quiet_s"] is None
    data, bias_rad_s = quiet_drop(4, unix_us=round(DROPPED.timestamp() * 1e6))
    log = tfsat_host.folder / "QUIET.BIN"
    log.write_bytes(data)
    process = tfsat_host("decode", log, "--json")
    # 14 s of quiet, less the time of the release itself.
    assert 12.0 < json.loads(process.stdout)["quiet_s"] < 13.5
    (line,) = (line for line in process.stderr.splitlines() if "rested" in line)
    assert re.search(r"The gyros rested for 1[23] s before the release: bias body 1 [+-]", line)
    assert line.endswith(f"tfsat-host calibrate bias --log {log}")
    biases_deg_s = [float(word) for word in re.findall(r"[+-]\d+\.\d{3}", line)]
    # Four bodies and three axes, as the truth has them.
    assert biases_deg_s == pytest.approx(np.degrees(bias_rad_s).ravel().tolist(), abs=0.02)
    certificate(tfsat_host.folder, whole_calibration(), "my own.toml")
    process = tfsat_host("decode", log, "--calibration", "my own.toml")
    assert f"calibrate bias --log {log} --out 'my own.toml' --emulated" in process.stderr
    log.write_bytes(quiet_drop(4)[0])
    assert "Without a time of day no calibration takes it." in tfsat_host("decode", log).stderr


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    monkeypatch.chdir(tmp_path)
    with Served() as process:
        yield process


def test_arming_says_what_stands_against_the_calibration(robot: Served, tfsat_host: RunCli) -> None:
    ports = {
        "TFSAT_SEQUENCER_PORT": robot.announced["sequencer"],
        "TFSAT_LOGGER_PORT": robot.announced["logger"],
    }
    tfsat_host("upload-sequence", 59, 70, environ=ports)
    silent = tfsat_host("arm", "--yes", "--json", environ=ports)
    assert json.loads(silent.stdout)["calibration"] is None
    assert "alibration" not in silent.stderr
    tfsat_host("disarm", environ=ports)
    serial = tfsat_host.json("status", environ=ports)["logger"]["device"]["serial"]
    mine = replace(SUBJECT, logger_serial=serial, emulated=True)
    file = certificate(tfsat_host.folder, whole_calibration(subject=mine), "calibration-emulated.toml")
    # Emulated, and of this very logger.
    armed = tfsat_host("arm", "--yes", "--json", environ=ports)
    assert "calibration-emulated.toml (valid for this drop)" in armed.stderr
    assert json.loads(armed.stdout)["calibration"]["usable"] is True
    tfsat_host("disarm", environ=ports)
    certificate(
        tfsat_host.folder,
        with_landing(whole_calibration(subject=mine), Landing(datetime.now(UTC), "a test")),
        file.name,
    )
    armed = tfsat_host("arm", "--yes", "--json", environ=ports)
    assert json.loads(armed.stdout)["state"] == "armed"
    assert f"Calibration {file.name}: Measured before the last landing" in armed.stderr
    # The same 18 as after any landing.
    assert len(json.loads(armed.stdout)["calibration"]["shortcomings"]) == 18
    tfsat_host("disarm", environ=ports)
    real = certificate(tfsat_host.folder, whole_calibration(), "real.toml")
    armed = tfsat_host("arm", "--yes", "--json", "--calibration", real, environ=ports)
    assert "The calibration is of a real robot" in armed.stderr
    tfsat_host("disarm", environ=ports)
    alone = tfsat_host("arm", "--yes", "--json", "--calibration", real, "--port", robot.sequencer)
    assert "the logger was not asked whether it is of this" in alone.stderr
    tfsat_host("disarm", environ=ports)
    real.write_text("nonsense")
    armed = tfsat_host("arm", "--yes", "--json", "--calibration", real, environ=ports)
    assert json.loads(armed.stdout)["state"] == "armed"
    assert f"Warning: {real}: is not valid TOML" in armed.stderr
