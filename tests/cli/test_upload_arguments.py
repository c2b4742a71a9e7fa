"""`upload-sequence` up to the port: the schedule it shows, the files it writes, what it refuses."""

from __future__ import annotations

import pytest

from tests.cli.process import RunCli
from tfsat_host.maneuver import four_stroke, read_maneuver

SCHEDULE = [
    {"t_s": 0.7, "joint": 1, "angle_deg": 59.0},
    {"t_s": 1.05, "joint": 2, "angle_deg": 70.0},
    {"t_s": 1.47, "joint": 1, "angle_deg": -59.0},
    {"t_s": 1.82, "joint": 2, "angle_deg": -70.0},
]


def test_dry_run_in_json(tfsat_host: RunCli) -> None:
    assert tfsat_host.json("upload-sequence", 59, 70, "--dry-run") == {
        "schedule": SCHEDULE,
        "end_s": 2.23,
        "verified": False,
        "device": None,
        "dry_run": True,
        "notices": [],
    }


def test_dry_run_for_people(tfsat_host: RunCli) -> None:
    process = tfsat_host("upload-sequence", 59, 70, "--dry-run")
    for text in ("0.70", "1.05", "1.47", "1.82", "+59.00", "-70.00", "Ends 2.23 s", "nothing was sent"):
        assert text in process.stdout
    assert process.stderr == ""


def test_a_rounded_angle_is_said_on_stderr_and_in_json(tfsat_host: RunCli) -> None:
    process = tfsat_host("upload-sequence", "58.755", 70, "--dry-run")
    assert "Warning: The angle of stroke 1 was rounded from 58.755 to 58.76 deg" in process.stderr
    notices = tfsat_host.json("upload-sequence", "58.755", 70, "--dry-run")["notices"]
    assert len(notices) == 2


def test_what_does_not_fit_the_drop_tower_is_said(tfsat_host: RunCli) -> None:
    process = tfsat_host("upload-sequence", 59, 90, "--dry-run", expect=3)
    assert "The check stroke-time failed: Joints move for 1.753 s" in process.stderr
    assert "DOES NOT FIT COSMOTORRE" in process.stdout and "but see the warning" in process.stdout
    assert (
        "FITS COSMOTORRE: 11 of 11 checks passed."
        in tfsat_host("upload-sequence", 59, 70, "--dry-run").stdout
    )


ROW = "[[strokes]]\njoint = {}\nangle_deg = {}\nt_s = {}\n"


@pytest.mark.parametrize("command", ["upload-sequence", "rehearse", "envelope"])
@pytest.mark.parametrize(
    ("strokes", "code", "line", "words"),
    [
        (
            [(1, 60, 0.7), (2, 50, 0.8), (1, -60, 0.9)],
            "overlap",
            10,
            "A joint cannot do two strokes at once.",
        ),
        ([(1, 60, 0.7), (2, 50, 0.703)], "starts-too-close", 6, "at the same time or 10 ms apart."),
        ([(1, 60, 0.7), (2, 50, 0.7), (2, -50, 2.3)], "outlasts-fall", 10, "land while it still moves."),
    ],
    ids=["one joint twice", "3 ms apart", "after the fall"],
)
def test_overlapping_strokes_that_cannot_be_flown_are_refused_with_their_line(
    tfsat_host: RunCli, command: str, strokes: list[tuple[float, ...]], code: str, line: int, words: str
) -> None:
    file = tfsat_host.folder / "m.toml"
    file.write_text("schema = 1\n" + "".join(ROW.format(*stroke) for stroke in strokes))
    error = tfsat_host.json(command, "--file", file, expect=1)["error"]
    assert error["code"] == code and error["what"].startswith(f"{file}:{line}: Stroke {len(strokes)} ")
    assert words in error["meaning"]


def test_a_dry_run_says_how_many_joints_the_settings_must_allow(tfsat_host: RunCli) -> None:
    file = tfsat_host.folder / "m.toml"
    file.write_text("schema = 1\n" + ROW.format(1, 60, 0.7) + ROW.format(3, 50, 0.7))
    process = tfsat_host("upload-sequence", "--file", file, "--dry-run")
    assert "up to 2 joints at once (servo settings: moving_at_once)." in " ".join(process.stdout.split())


@pytest.mark.parametrize(
    ("a", "b", "code"),
    [
        ("90.01", "70", "joint-range"),
        ("-59", "70", "joint-range"),
        ("nan", "70", "angle-not-finite"),
        ("59", "inf", "angle-not-finite"),
        ("59", "1e999", "angle-not-finite"),
        ("0", "70", "zero-stroke"),
        ("90", "90", "outlasts-fall"),
    ],
)
def test_angles_that_cannot_be_flown(tfsat_host: RunCli, a: str, b: str, code: str) -> None:
    plain = tfsat_host("upload-sequence", a, b, "--port", "/nonexistent", expect=1)
    assert plain.stdout == ""
    error = tfsat_host.json("upload-sequence", a, b, "--port", "/nonexistent", expect=1)["error"]
    assert error["code"] == code
    assert error["what"] in plain.stderr


def test_the_maneuver_is_written_and_flown_from_the_file(tfsat_host: RunCli) -> None:
    tfsat_host("upload-sequence", 59, 70, "--dry-run", "--out", "m.toml")
    assert read_maneuver(tfsat_host.folder / "m.toml") == four_stroke(59, 70)
    assert tfsat_host.json("upload-sequence", "--file", "m.toml", "--dry-run")["schedule"] == SCHEDULE


def test_nothing_is_overwritten_without_force(tfsat_host: RunCli) -> None:
    file = tfsat_host.folder / "m.toml"
    file.write_text("mine")
    tfsat_host("upload-sequence", 59, 70, "--dry-run", "--out", file, expect=2)
    assert file.read_text() == "mine"
    tfsat_host("upload-sequence", 59, 70, "--dry-run", "--out", file, "--force")
    assert read_maneuver(file) == four_stroke(59, 70)


def test_with_no_board_the_error_says_what_to_do(tfsat_host: RunCli) -> None:
    plain = tfsat_host("upload-sequence", 59, 70, expect=1, without_ports=True)
    for words in ("No sequencer found", "Plug in the Arduino Micro", "--port", "--emulated"):
        assert words in plain.stderr
    error = tfsat_host.json("upload-sequence", 59, 70, expect=1, without_ports=True)["error"]
    assert error["code"] == "none-found"


def test_a_port_that_is_missing_or_none(tfsat_host: RunCli) -> None:
    assert (
        tfsat_host.json("upload-sequence", 59, 70, "--port", "nowhere", expect=1)["error"]["code"]
        == "missing"
    )
    named = {"TFSAT_SEQUENCER_PORT": str(tfsat_host.folder)}
    error = tfsat_host.json("upload-sequence", 59, 70, expect=1, environ=named)["error"]
    assert error["code"] == "no-serial-port"
