"""`calibrate` as a user has it: what each command measures, writes and refuses to overwrite."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from tests.calibration.quiet_drop import quiet_drop
from tests.cli.process import RunCli
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.emulated.emulated_robot import DEFAULT_SEED
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.robot import load_robot

TRUTH = draw_as_built(DEFAULT_SEED)
FILE = "calibration-emulated.toml"


@pytest.mark.usefixtures("few_looks")
def test_one_certificate_takes_the_steps_of_all_commands(tfsat_host: RunCli) -> None:
    def calibrate(*args: object) -> dict[str, object]:
        result = tfsat_host.json("calibrate", *args, "--emulated")
        assert (result["file"], result["emulated"]) == (FILE, True)
        for step in result["steps"]:
            recording = tfsat_host.folder / "calibration-emulated-recordings" / step["file"]
            # The recording's own hash is the one of the certificate.
            assert hashlib.sha256(recording.read_bytes()).hexdigest() == step["sha256"]
        missing.append(len(result["missing"]))
        return dict(result)

    missing: list[int] = []
    check_bias(calibrate("bias"))
    check_zero(calibrate("zero", "--all"))
    check_misalignment(calibrate("misalignment", "--joint", 3))
    check_scale(calibrate("scale", "--joint", 3), np.array([3]), 0)
    check_scale(calibrate("scale", "--turn", "z", "-360"), np.arange(4), 2)
    assert missing == sorted(set(missing), reverse=True), "each command leaves less to do"
    recordings = [recording.step for recording in read_calibration(tfsat_host.folder / FILE).recordings]
    # Steps stand in the order in which they were recorded.
    assert recordings == ["rest", "zero", "swing-joint-3-body-4", "sweep-joint-3-body-4", "turn-z"]


def check_bias(result: dict[str, object]) -> None:
    bodies = result["bodies"]
    assert isinstance(bodies, list)
    biases_deg_s = np.array([body["bias_deg_s"] for body in bodies])
    std = np.array([body["std_deg_s"] for body in bodies])
    assert (np.abs(biases_deg_s - np.rad2deg(TRUTH.gyro_bias_rad_s)) < 5.0 * std).all()
    assert std.max() < 0.01


def check_zero(result: dict[str, object]) -> None:
    joints = result["joints"]
    assert isinstance(joints, list)
    zeros = np.array([joint["zero_deg"] for joint in joints]).ravel()
    design = np.array([sensor.zero_offset_rad for sensor in load_robot().angle_sensors])
    bent = np.abs(TRUTH.angle_nonlinearity_rad).sum(axis=1)
    # Angles on the circle: a difference of nearly 360 deg is a small one.
    off = np.exp(1j * np.deg2rad(zeros)) / np.exp(1j * (design + TRUTH.angle_zero_rad))
    # A sensor that bends at zero looks like a shifted zero: allowed as far as it bends.
    assert (np.abs(np.angle(off)) < bent + np.deg2rad(0.05)).all(), "its bend at zero is a part of a zero"
    assert {joint["disagreement_deg"] for joint in joints} == {None}


def check_misalignment(result: dict[str, object]) -> None:
    axes = result["axes"]
    assert isinstance(axes, list)
    (axis,) = axes
    assert (result["joint"], axis["body"]) == (3, 4)
    model = load_robot()
    # The joint's axis in sensor axes, by the truth.
    true = (TRUTH.mounting[3] @ model.imus[3].sensor_to_body).T @ model.joint_axis[2]
    assert np.rad2deg(np.linalg.norm(np.cross(axis["axis_sensor"], true))) < 4.0 * axis["std_deg"]
    assert axis["angle_deg"] == pytest.approx(np.rad2deg(np.arccos(true @ axis["nominal_sensor"])), abs=0.5)
    assert axis["rms_rate_deg_s"] > 20.0 and len(axis["cross_axis"]) == 2
    assert axis["bias_deg_s"] == pytest.approx(np.rad2deg(TRUTH.gyro_bias_rad_s[3]), abs=0.02)


def check_scale(
    result: dict[str, object], bodies: np.ndarray[tuple[int], np.dtype[np.int_]], axis: int
) -> None:
    scales = result["scales"]
    assert isinstance(scales, list)
    assert [row["body"] for row in scales] == list(bodies + 1)
    assert {(row["axis"], row["frame"]) for row in scales} == {("xyz"[axis], "body")}
    # What a gyro shows along the direction that the body's axis has for it.
    along = [(TRUTH.mounting[body] @ load_robot().imus[body].sensor_to_body)[axis] for body in bodies]
    true = [axis @ TRUTH.gyro_response[body] @ axis for body, axis in zip(bodies, along, strict=True)]
    off = np.array([row["scale"] for row in scales]) - true
    assert (np.abs(off) < 4.0 * np.array([row["std"] for row in scales])).all()
    assert np.abs(off).max() < 0.003


@pytest.mark.usefixtures("short_steps")
def test_what_a_person_is_told_where_there_is_no_terminal(tfsat_host: RunCli) -> None:
    process = tfsat_host("calibrate", "scale", "--joint", 3, "--emulated")
    for words in (
        "Lay the robot on the bench",  # no bias was taken within the last quarter of an hour
        "Accepted: biases of bodies 1, 2, 3 and 4",
        "Hold bodies 1, 2 and 3 on the bench.",
        "joint 3 at +",
        "all 13 rests are there",
        "Accepted: body 4: scale factor x ",
    ):
        assert words in process.stderr
    for words in (
        "Scale factors",
        "calibrations missing",
        f"Certificate: {FILE}",
        "of no use for a real one",
    ):
        assert words in process.stdout
    assert "Reading" not in process.stdout
    again = tfsat_host("calibrate", "scale", "--joint", 3, "--emulated", "--resume")
    assert "kept from" in again.stderr and "Sweep of body 4 about joint 3: kept" in again.stderr
    assert "reading over truth" in again.stdout, "what is kept is the result"


@pytest.mark.usefixtures("short_steps")
def test_other_files_are_not_overwritten(tfsat_host: RunCli) -> None:
    notes = tfsat_host.folder / "notes.toml"
    notes.write_text("mine = true\n")
    refused = tfsat_host("calibrate", "bias", "--emulated", "--out", notes, expect=1)
    assert "notes.toml" in refused.stderr
    # A file without the marker of tfsat is somebody's own.
    assert [path.name for path in tfsat_host.folder.iterdir()] == ["notes.toml"]
    assert notes.read_text() == "mine = true\n"
    # With --force the user has said so.
    tfsat_host("calibrate", "bias", "--emulated", "--out", notes, "--force")
    assert read_calibration(notes).subject.emulated


@pytest.mark.usefixtures("short_steps")
def test_the_certificate_of_another_robot_is_refused(tfsat_host: RunCli) -> None:
    tfsat_host("calibrate", "bias", "--emulated")
    certificate = tfsat_host.folder / FILE
    own = read_calibration(certificate)
    serial = own.subject.logger_serial
    # Another logger's certificate: mixing two robots would pass unnoticed.
    others = replace(own, subject=replace(own.subject, logger_serial="00c0ffee00c0ffee"))
    certificate.write_text(format_calibration(others))
    before = certificate.read_bytes()
    refused = tfsat_host("calibrate", "zero", "--all", "--emulated", expect=1)
    assert "holds another calibration" in refused.stderr and "00c0ffee" in refused.stderr
    assert "--force" in refused.stderr
    assert certificate.read_bytes() == before
    tfsat_host("calibrate", "zero", "--all", "--emulated", "--force")
    begun = read_calibration(certificate)
    # Begun anew: nothing of the other logger's certificate is kept.
    assert begun.subject.logger_serial == serial and [recording.step for recording in begun.recordings] == [
        "zero"
    ]


def test_a_bias_out_of_a_recording(tfsat_host: RunCli) -> None:
    recording = tfsat_host.folder / "DROP0001.BIN"
    began = datetime(2026, 5, 4, 10, tzinfo=UTC)
    recording.write_bytes(quiet_drop(4, unix_us=round(began.timestamp() * 1e6), as_built=True)[0])
    result = tfsat_host.json("calibrate", "bias", "--log", recording)
    check_bias(result)
    (step,) = result["steps"]
    assert abs((datetime.fromisoformat(step["taken"]) - began).total_seconds()) < 5.0
    assert result["file"] == FILE, "the log says that it is an emulated robot's"
    # A logger that was not told the time of day: no bias could be dated.
    recording.write_bytes(quiet_drop(4, as_built=True)[0])
    refused = tfsat_host("calibrate", "bias", "--log", recording, "--out", "new.toml", expect=1)
    assert "at what time of day" in refused.stderr and not Path(tfsat_host.folder / "new.toml").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("misalignment",), "--joint"),
        (("misalignment", "--joint", "4"), "4"),
        (("zero",), "--joint --all"),
        (("zero", "--joint", "1", "--all"), "not allowed with"),
        (("scale", "--turn", "z", "36"), "90 to 720 deg"),
        (("scale", "--turn", "w", "360"), "no axis of a body"),
        (("scale", "--turn", "z", "once"), "not a number"),
        (("scale", "--turn", "z", "360", "--jog"), "a turn is done by hand"),
        ((), "needs a quantity"),
    ],
)
def test_arguments_that_mean_nothing(tfsat_host: RunCli, arguments: tuple[str, ...], words: str) -> None:
    options = ("--emulated",) if arguments else ()
    assert words in tfsat_host("calibrate", *arguments, *options, expect=2).stderr


def test_without_a_logger(tfsat_host: RunCli) -> None:
    result = tfsat_host("calibrate", "misalignment", "--joint", "1", expect=1, without_ports=True)
    assert "Plug in the Teensy 4.1" in result.stderr
    assert "--emulated" in result.stderr
