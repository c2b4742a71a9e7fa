"""A maneuver in which all three joints move at once: uploaded, flown by the firmware, recorded and evaluated."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.process import RunCli

# Late enough for a robot that opens three joints at once to be clear of the releaser.
TOGETHER = """schema = 1
[[strokes]]
joint = 1
angle_deg = 60
t_s = 1.00
[[strokes]]
joint = 2
angle_deg = 50
t_s = 1.00
[[strokes]]
joint = 3
angle_deg = 40
t_s = 1.10
[[strokes]]
joint = 1
angle_deg = -60
t_s = 1.61
[[strokes]]
joint = 2
angle_deg = -50
t_s = 1.70
[[strokes]]
joint = 3
angle_deg = -40
t_s = 1.70
"""


@pytest.fixture
def maneuver(tmp_path: Path) -> Path:
    file = tmp_path / "together.toml"
    file.write_text(TOGETHER)
    return file


def test_a_drop_with_joints_that_move_together_is_good(tfsat_host: RunCli, maneuver: Path) -> None:
    summary = tfsat_host.json("rehearse", "--file", maneuver)
    assert summary["warnings"] == [] and len(summary["strokes_s"]) == 4, "two pairs begin together"
    evaluation = tfsat_host.json("evaluate", "run")
    assert evaluation["verdict"]["level"] == "good", evaluation["verdict"]
    for stroke, (joint, deg, t_s) in zip(
        evaluation["strokes"],
        [(1, 60, 1.0), (2, 50, 1.0), (3, 40, 1.1), (1, -60, 1.61), (2, -50, 1.7), (3, -40, 1.7)],
        strict=True,
    ):
        assert stroke["joint"] == joint
        # The line rises with the pulse; the servo's own delay and gain are its affair.
        assert stroke["logged_s"] == pytest.approx(t_s, abs=3e-4)
        assert stroke["size_deg"] == pytest.approx(deg, abs=1.5)


def test_a_board_that_moves_one_joint_at_a_time_refuses_it(tfsat_host: RunCli, maneuver: Path) -> None:
    error = tfsat_host.json("upload-sequence", "--file", maneuver, "--emulated", "--yes", expect=4)["error"]
    assert error["code"] == "too_many_moving"
    assert "moving_at_once = 1" in error["what"] and "Nothing was sent" in error["meaning"]
