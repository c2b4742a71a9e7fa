"""`upload-sequence` with a calibration: how far each stroke will miss, by the settings that are on the board."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.calibration.simulated_servo import SimulatedServo
from tests.calibration.some_calibration import MEASURED
from tests.cli.process import RunCli
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.servos.fit import fit_servo_map
from tfsat_host.calibration.servos.servo_map import ServoMap, settings_from_map
from tfsat_host.cli import stroke_errors
from tfsat_host.cli.main import main
from tfsat_host.servo_settings import FACTORY, format_settings

SERVO = SimulatedServo(gain=0.95, offset_deg=1.0, backlash_deg=1.0, repeatability_deg=0.3, noise_deg=0.05)
MAPS = tuple(
    fit_servo_map(replace(SERVO, seed=joint).visit_plan(), joint, FACTORY.of(joint), MEASURED)
    for joint in (1, 2)
)
Calibrated = Callable[..., Path]


@pytest.fixture
def calibration_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Calibrated:
    """Puts a calibration with these servo maps into the current folder."""
    monkeypatch.chdir(tmp_path)

    def place_calibration(name: str, maps: Sequence[ServoMap] = MAPS) -> Path:
        (tmp_path / name).touch()

        def read(path: Path) -> tuple[ServoMap, ...]:
            assert path.name == name
            return tuple(maps)

        monkeypatch.setattr(stroke_errors, "read_servo_maps", read)
        return Path(name)

    return place_calibration


def _upload(capsys: pytest.CaptureFixture[str], *options: str, expect: int = 0) -> Any:
    assert main(["upload-sequence", "59", "70", "--json", *options]) == expect
    return json.loads(capsys.readouterr().out)


def test_each_stroke_with_what_it_will_miss_by(
    calibration_file: Calibrated, capsys: pytest.CaptureFixture[str]
) -> None:
    calibration_file("calibration-emulated.toml")
    result = _upload(capsys, "--emulated")
    assert [(row["stroke"], row["joint"], row["commanded_deg"]) for row in result["expected"]] == [
        (1, 1, 59.0),
        (2, 2, 70.0),
        (3, 1, -59.0),
        (4, 2, -70.0),
    ]
    # 5 % of the stroke; half the play from wherever the joint hung, then all of it.
    expected_deg = [-2.95 - 0.5, -3.5 - 0.5, 2.95 + 1.0, 3.5 + 1.0]
    assert [row["error_deg"] for row in result["expected"]] == pytest.approx(expected_deg, abs=0.4)
    first, second, third, fourth = (row["std_deg"] for row in result["expected"])
    assert 0.3 < third < first < 1.0
    assert 0.3 < fourth < second < 1.0
    assert result["verified"] is True


def test_for_people(calibration_file: Calibrated, capsys: pytest.CaptureFixture[str]) -> None:
    calibration_file("calibration-emulated.toml", MAPS[:1])
    assert main(["upload-sequence", "59", "70", "--emulated"]) == 0
    output = capsys.readouterr()
    assert "misses by / deg" in output.out
    (first,) = [line for line in output.out.splitlines() if line.lstrip().startswith("0.70")]
    assert float(first.split()[3]) == pytest.approx(-3.45, abs=0.4)
    (second,) = [line for line in output.out.splitlines() if line.lstrip().startswith("1.05")]
    assert second.split()[-2:] == ["–", "–"]
    assert "Warning: calibration-emulated.toml has no servo map of joint 2" in output.err
    assert "tfsat-host calibrate servo --joint 2" in output.err


def test_settings_that_are_not_the_maps_are_said_and_computed_with(
    calibration_file: Calibrated, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    calibration_file("calibration-emulated.toml")
    before = _upload(capsys, "--emulated")
    assert len(before["notices"]) == 2
    assert before["notices"][0].startswith("The servo settings on the board are not those of")
    assert "for joint 1: they are up to 3." in before["notices"][0]
    assert "tfsat-host upload-servos" in before["notices"][0]
    assert "for joint 2" in before["notices"][1]

    settings = settings_from_map(MAPS[1], settings_from_map(MAPS[0], FACTORY))
    (tmp_path / "servos.toml").write_text(format_settings(settings))
    assert main(["upload-servos", "servos.toml", "--emulated", "--yes"]) == 0
    capsys.readouterr()
    after = _upload(capsys, "--emulated")
    assert after["notices"] == []
    # The gain is made up for; the play is not.
    assert [row["error_deg"] for row in after["expected"]] == pytest.approx([-0.5, -0.5, 1.0, 1.0], abs=0.3)


def test_without_a_map_nothing_is_expected(
    calibration_file: Calibrated, capsys: pytest.CaptureFixture[str]
) -> None:
    calibration_file("calibration.toml")  # of the real robot, which is not asked
    result = _upload(capsys, "--emulated")
    assert (result["expected"], result["notices"]) == (None, [])
    calibration_file("calibration-emulated.toml", ())
    result = _upload(capsys, "--emulated")
    assert result["expected"] is None
    assert [notice.split(":")[0].split()[-2:] for notice in result["notices"]] == [
        ["joint", "1"],
        ["joint", "2"],
    ]


def test_a_file_of_another_name(calibration_file: Calibrated, capsys: pytest.CaptureFixture[str]) -> None:
    path = calibration_file("yesterday.toml")
    assert _upload(capsys, "--emulated")["expected"] is None
    assert len(_upload(capsys, "--emulated", "--calibration", str(path))["expected"]) == 4


def test_a_file_that_cannot_be_read(
    calibration_file: Calibrated, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = calibration_file("calibration-emulated.toml")

    def fail(path: Path) -> tuple[ServoMap, ...]:
        raise CalibrationError(what=f"{path} is damaged.", meaning="It says nothing.", next_step="Measure.")

    monkeypatch.setattr(stroke_errors, "read_servo_maps", fail)
    result = _upload(capsys, "--emulated")
    assert (result["verified"], result["expected"]) == (True, None)
    assert result["notices"] == [
        "How far the strokes will miss is not known. calibration-emulated.toml is damaged. Measure."
    ]
    refused = _upload(capsys, "--emulated", "--calibration", str(path), expect=1)
    assert refused["error"]["what"] == "calibration-emulated.toml is damaged."


def test_usage(tfsat_host: RunCli) -> None:
    upload = ("upload-sequence", 59, 70, "--calibration", "none.toml")
    missing = tfsat_host(*upload, "--port", "/nonexistent", expect=2)
    assert "There is no calibration none.toml." in missing.stderr
    dry = tfsat_host(*upload, "--dry-run", expect=2)
    assert "Leave out --dry-run or --calibration." in dry.stderr
    assert dry.stdout == ""
