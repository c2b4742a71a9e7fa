"""`tfsat-host sensitivity` as a user has it."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tfsat_host.robot import default_robot_path
from tfsat_host.robot.model import UNCERTAIN

_EXACT = tuple(word for key in UNCERTAIN for word in ("--sigma", f"{key}=0"))


@pytest.fixture(autouse=True)
def _small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reduce the chunk size: a chunk is flown whole, however few samples a study has."""
    monkeypatch.setattr("tfsat_host.plan.study.CHUNK", 20)
    monkeypatch.setattr("tfsat_host.plan.study._WORTH_A_PROCESS", 1000)


def test_json_has_derivatives_sources_and_samples(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("sensitivity", 58.75, 70.29, "--samples", 500)
    assert result["reorientation_deg"] == pytest.approx(26.1124, abs=1e-4)
    contributions = [row["contribution_deg"] for row in result["parameters"]]
    assert contributions == sorted(contributions, reverse=True)
    assert contributions[0] > 0.5
    for row in result["parameters"]:
        assert row["contribution_deg"] == pytest.approx(abs(row["reorientation_deg_per_unit"]) * row["std"])
    assert sum(row["linear_share"] for row in result["sources"]) == pytest.approx(1.0)
    turned = result["monte_carlo"]["outputs"]["reorientation_deg"]
    assert turned["std"]["value"] == pytest.approx(result["linear"]["reorientation_std_deg"], rel=0.15)
    assert sum(result["monte_carlo"]["histogram"]["samples"]) == result["monte_carlo"]["samples"] == 500
    assert [row["limit_s"] for row in result["monte_carlo"]["exceeded"]] == [1.5, 1.55, 2.5]
    assert result["uncertainty"]["com_mm"] == 3.0


def test_people_read_what_to_measure_first(tfsat_host: RunCli) -> None:
    screen = tfsat_host("sensitivity", 59, 70, "--samples", 200).stdout
    assert len(screen.splitlines()) <= 40
    assert screen.startswith("Expected rotation:  2") and " ± 2." in screen.splitlines()[0]
    text = " ".join(screen.split())
    for words in (
        "Nominal rotation: 26.106 deg",
        "Measure first: joint 2 servo scale ± 7 %",
        "stroke 2 end (joint 2)",
    ):
        assert words in text
    assert "fall 2.5" in text and "█" not in text
    full = tfsat_host("sensitivity", 59, 70, "--samples", 200, "--full").stdout
    for words in ("scales of servos", "97.5 %", "█"):
        assert words in full


@pytest.mark.parametrize(
    "release",
    [
        "59 70",
        "59 70 --initial-rate 1 -2 3",
        "20 90 --speed 400 --initial-rate 1 -2 3",
        "90 90 --robot cubesat_3u",
        *(
            pytest.param(slow, marks=pytest.mark.prove)
            for slow in (
                "59 70 --speed 5 --initial-rate 0.5 -1 2",
                "59 70 --speed 20 --initial-rate 40 20 -30",
                "90 90 --robot cubesat_3u --speed 1 --initial-rate 3 -3 3",
            )
        ),
    ],
)
def test_it_agrees_with_simulate_to_the_figures_printed(tfsat_host: RunCli, release: str) -> None:
    simulated = tfsat_host.json("simulate", *release.split())
    sensitivity = tfsat_host.json("sensitivity", *release.split(), "--samples", 2, *_EXACT)
    turned = sensitivity["monte_carlo"]["outputs"]["reorientation_deg"]["mean"]["value"]
    for key in ("reorientation_deg", "rotation_vector_deg", "quaternion_xyzw"):
        assert sensitivity[key] == pytest.approx(simulated[key], abs=2e-4)
    assert turned == pytest.approx(simulated["reorientation_deg"], abs=2e-4)


def test_it_warns_where_the_integration_is_not_good_enough(
    tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = tfsat_host.json("sensitivity", 59, 70, "--samples", 2)
    assert 0.0 < good["integration_error_deg"] < 1e-4 and good["notices"] == []
    monkeypatch.setattr(
        "tfsat_host.dynamics.simulation_result.ERROR_DEG", 0.5 * good["integration_error_deg"]
    )
    (notice,) = tfsat_host.json("sensitivity", 59, 70, "--samples", 2)["notices"]
    assert "by the error of the integration" in notice


def test_errors_too_large_for_first_order_are_a_notice(tfsat_host: RunCli) -> None:
    large = ("--samples", 200, *_EXACT, "--sigma", "joint_axis_deg=40")
    (notice,) = tfsat_host.json("sensitivity", 59, 70, *large)["notices"]
    assert "too large for first order" in notice


def test_sigma_overrides_what_the_file_states(tfsat_host: RunCli) -> None:
    result = tfsat_host.json(
        "sensitivity", 59, 70, "--samples", 100, *_EXACT, "--sigma", "stroke_relative=0.01"
    )
    assert {row["kind"] for row in result["sources"] if row["linear_deg"]} == {"servo_scale"}
    assert result["uncertainty"]["stroke_relative"] == 0.01


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--sigma", "com=2"), "joint_point_mm"),
        (("--sigma", "com_mm=-1"), "no standard deviation"),
        (("--sigma", "com_mm=nan"), "no standard deviation"),
        (("--sigma", "mass_relative=0.5"), "up to 0.2"),
        (("--sigma", "com_mm"), "KEY=VALUE"),
        (("--samples", "1"), "from 2 to"),
        (("--workers", "0"), "from 1"),
        (("--workers", "1", "--dask", "tcp://127.0.0.1:1"), "not allowed"),
        (("--initial-rate", "0", "0", "nan"), "is no rate"),
        (("--dask", "nonsense"), "missing port"),
    ],
)
def test_what_makes_no_sense_is_refused_with_a_cure(
    tfsat_host: RunCli, arguments: tuple[str, ...], words: str
) -> None:
    assert words in tfsat_host("sensitivity", 59, 70, *arguments, expect=2).stderr


def test_a_robot_file_that_states_nothing_needs_sigma(tfsat_host: RunCli) -> None:
    text = default_robot_path().read_text(encoding="utf-8")
    file = tfsat_host.folder / "certain.toml"
    file.write_text(text[: text.index("[uncertainty]")], encoding="utf-8")
    refused = tfsat_host("sensitivity", 59, 70, "--robot", file, expect=2).stderr
    assert "states no uncertainty" in refused and "--sigma" in refused
    result = tfsat_host.json("sensitivity", 59, 70, "--robot", file, "--samples", 50, "--sigma", "com_mm=1")
    assert {row["kind"] for row in result["sources"] if row["linear_deg"]} == {"com"}


def test_a_robot_without_boards_has_no_tower_to_keep_to(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("sensitivity", 90, 90, "--robot", "cubesat_3u", "--samples", 100)
    assert result["speed_deg_s"] == pytest.approx(30.0)
    assert result["monte_carlo"]["exceeded"] == []
    assert result["monte_carlo"]["outputs"]["end_s"]["mean"]["value"] > 12.0


def test_every_sample_goes_to_a_file_and_nobody_s_file_is_overwritten(
    tfsat_host: RunCli, tmp_path: Path
) -> None:
    file = tmp_path / "samples.csv"
    command = ("sensitivity", 59, 70, "--samples", 60, "--out", file)
    result = tfsat_host.json(*command)
    assert result["files"] == {"csv": str(file)}
    rows = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
    turned = [float(row["reorientation_deg"]) for row in rows]
    assert len(rows) == 60
    assert sum(turned) / 60 == pytest.approx(
        result["monte_carlo"]["outputs"]["reorientation_deg"]["mean"]["value"]
    )
    assert {"body_1_mass_kg", "body_2_com_x_mm", "stroke_1_end_joint_1_deg", "joint_2_speed_deg_s"} <= rows[
        0
    ].keys()
    tfsat_host(*command)
    file.write_text("mine\n", encoding="utf-8")
    assert "--force" in tfsat_host(*command, expect=1).stderr
    assert file.read_text(encoding="utf-8") == "mine\n"
    tfsat_host(*command, "--force")


def test_a_maneuver_from_a_file(tfsat_host: RunCli) -> None:
    tfsat_host("upload-sequence", 59, 70, "--dry-run", "--out", "m.toml")
    by_file = tfsat_host.json("sensitivity", "--file", "m.toml", "--samples", 20)
    by_angles = tfsat_host.json("sensitivity", 59, 70, "--samples", 20)
    assert by_file["monte_carlo"] == by_angles["monte_carlo"]


def test_a_speed_beyond_the_servos_is_said(tfsat_host: RunCli) -> None:
    command = ("sensitivity", 59, 70, "--samples", 2)
    fast = tfsat_host(*command, "--speed", 400)
    assert "above the greatest rate of the servos, 200 deg/s" in fast.stderr
    assert "greatest rate" in tfsat_host.json(*command, "--speed", 400)["notices"][-1]
    assert tfsat_host.json(*command)["notices"] == []


def test_a_place_that_takes_no_file_is_named_before_anything_is_computed(tfsat_host: RunCli) -> None:
    name = "x" * 246 + ".csv"  # leaves no room for what stands next to it until it is whole
    refused = tfsat_host("sensitivity", 59, 70, "--samples", 5000, "--out", name, expect=1).stderr
    assert f"Error: {name} cannot be written: " in refused
    assert "Flying" not in refused
