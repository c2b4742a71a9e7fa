"""One file for each way a maneuver can be wrong; its name is the defect's."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tfsat_host.maneuver import Defect, ManeuverError, parse_maneuver, read_maneuver, schedule_maneuver

FILES = sorted((Path(__file__).parent / "defects").glob("*.toml"))


def test_every_defect_has_its_file() -> None:
    # An unreadable file cannot be kept in the repository.
    assert {file.stem for file in FILES} == {defect.value for defect in Defect} - {Defect.FILE_UNREADABLE}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_defect_is_refused_by_name_and_says_the_cure(tfsat_host: RunCli, file: Path) -> None:
    error = tfsat_host.json("upload-sequence", "--file", file, "--dry-run", expect=1)["error"]
    assert error["code"] == file.stem and error["what"].count(str(file)) == 1
    assert error["meaning"] and error["next_step"]


@pytest.mark.parametrize("name", ["missing.toml", "."])
def test_a_file_that_cannot_be_read(tfsat_host: RunCli, name: str) -> None:
    error = tfsat_host.json("upload-sequence", "--file", name, "--dry-run", expect=1)["error"]
    assert error["code"] == Defect.FILE_UNREADABLE
    assert name in error["what"]


# A recording given by mistake, and a file above 1 MB.
@pytest.mark.parametrize(
    "contents", [bytes(range(256)), b"schema = 1\n" + b"#" * 1_000_000], ids=["no text", "too large"]
)
def test_what_cannot_be_a_maneuver(tmp_path: Path, contents: bytes) -> None:
    file = tmp_path / "SD.bin"
    file.write_bytes(contents)
    with pytest.raises(ManeuverError) as caught:
        read_maneuver(file)
    assert caught.value.code == Defect.FILE_SYNTAX


@pytest.mark.parametrize(
    ("line", "code"),
    [
        # Equal to 1 in Python; a flag is a number there; 400 digits are beyond any float.
        ("schema = 1.0", Defect.FILE_SCHEMA),
        ("schema = 1\nname = 3", Defect.FILE_WRONG_TYPE),
        ("schema = 1\nspeed_deg_s = true", Defect.FILE_WRONG_TYPE),
        ("schema = 1\nspeed_deg_s = 1" + "0" * 400, Defect.FILE_WRONG_TYPE),
        ("schema = 1\npause = 0.7", Defect.FILE_UNKNOWN_KEY),
        ("", Defect.FILE_MISSING_KEY),
    ],
)
def test_entries_above_the_strokes(line: str, code: Defect) -> None:
    with pytest.raises(ManeuverError) as caught:
        parse_maneuver(f"{line}\n[[strokes]]\njoint = 1\nangle_deg = 10\n")
    assert caught.value.code == code


def test_a_pause_beside_explicit_times_is_refused_because_it_would_do_nothing() -> None:
    with pytest.raises(ManeuverError, match=":2: pause_s: has no effect"):
        parse_maneuver("schema = 1\npause_s = 0.8\n[[strokes]]\njoint = 1\nangle_deg = 10\nt_s = 0.7\n")


# As an integer it can be printed, as a float it can be held: only its size is wrong.
HUGE = "1" + "0" * 300
STROKE = "schema = 1\n[[strokes]]\njoint = 1\nangle_deg = 10\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (STROKE + 't_s = "0.7"', "maneuver:5: strokes 1, t_s: '0.7' is not a number"),
        (STROKE + "t_s = 1e300", "t_s: 1e+300 is beyond 1e+12"),
        (STROKE + f"t_s = {HUGE}", "… is beyond 1e+12"),
        (STROKE.replace("10", "1e300"), "angle_deg: 1e+300 is beyond 1e+12"),
        (STROKE.replace("joint = 1", f"joint = {HUGE}"), "moves joint 1000"),
        (f"schema = {HUGE}\n", "maneuver:1: schema: 1000"),
    ],
)
def test_odd_values_are_shown_as_written_and_short(text: str, words: str) -> None:
    with pytest.raises(ManeuverError) as caught:
        schedule_maneuver(parse_maneuver(text))
    assert words in caught.value.what
    # The value is cut: 300 digits would push the advice off the screen.
    assert len(caught.value.what) < 200


@pytest.mark.parametrize("command", ["upload-sequence", "rehearse"])
# argparse takes `-inf` and `-1e3` for options: the command must not.
@pytest.mark.parametrize(
    ("a_deg", "code"), [("-inf", "angle-not-finite"), ("-1e3", "joint-range"), ("-.5", "joint-range")]
)
def test_a_negative_angle_is_no_option(tfsat_host: RunCli, command: str, a_deg: str, code: str) -> None:
    assert tfsat_host.json(command, a_deg, "70", expect=1)["error"]["code"] == code


def test_a_negative_speed_is_no_option(tfsat_host: RunCli) -> None:
    arguments = ("upload-sequence", "59", "70", "--speed", "-1e3", "--dry-run")
    assert tfsat_host.json(*arguments, expect=1)["error"]["code"] == Defect.SPEED_RANGE


@pytest.mark.parametrize(
    ("command", "not_done"),
    [
        ("upload-sequence", "Nothing was sent to the robot."),
        ("rehearse", "Nothing was flown."),
        ("simulate", "Nothing was simulated."),
        ("envelope", "Nothing was computed."),
        ("sensitivity", "Nothing was computed."),
    ],
)
def test_a_refusal_speaks_of_the_command_that_was_typed(
    tfsat_host: RunCli, command: str, not_done: str
) -> None:
    # 95 deg: beyond the joints' 90.
    (tfsat_host.folder / "far.toml").write_text("schema = 1\n[[strokes]]\njoint = 1\nangle_deg = 95\n")
    for file in ("missing.toml", "far.toml"):
        error = tfsat_host.json(command, "--file", file, expect=1)["error"]
        assert error["meaning"].endswith(not_done)
        assert error["meaning"].count("Nothing was") == 1
    error = tfsat_host.json(command, "--file", "missing.toml", expect=1)["error"]
    assert f"tfsat-host {command} --file" in error["next_step"]
    assert f"tfsat-host {command} 59 70" in error["next_step"]


@pytest.mark.parametrize("command", ["upload-sequence", "rehearse", "envelope", "sensitivity"])
def test_without_strokes_there_is_no_maneuver(tfsat_host: RunCli, command: str) -> None:
    (tfsat_host.folder / "still.toml").write_text("schema = 1\nstrokes = []\n")
    error = tfsat_host.json(command, "--file", "still.toml", expect=1)["error"]
    assert error["code"] == Defect.NO_STROKES
    assert "still.toml" in error["what"]
