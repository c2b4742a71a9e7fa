"""A maneuver in which all three joints move at once: uploaded, flown by the firmware, recorded and evaluated."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

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
    check_gain_over_59_70(tfsat_host, evaluation["reorientation_deg"])


def check_gain_over_59_70(tfsat_host: RunCli, reorientation_deg: float) -> None:
    """Check that screen and page compare the last run with the same simulated 59/70."""
    screen = " ".join(tfsat_host("evaluate", "run", "--full").stdout.split())
    words = re.search(r"Gain over 59/70: (\S+) ± \S+ deg, 59/70, one joint at a time: (\S+) deg", screen)
    assert words
    gain_deg, alone_deg = map(float, words.groups())
    assert gain_deg == pytest.approx(reorientation_deg - alone_deg, abs=2e-3)
    # Without angular momentum it turns 26.106 deg; the release turns the robot by some more or less.
    assert alone_deg == pytest.approx(26.1, abs=2.0) and alone_deg != pytest.approx(26.106, abs=0.01)
    page = (tfsat_host.folder / "run" / "report.html").read_text()
    document = json.loads(page.partition('id="document">')[2].partition("</script>")[0])
    poses = np.array(document["drops"][0]["replay"]["reference"])[:, 0, 3:]
    turn = Rotation.from_quat(poses[0]).inv() * Rotation.from_quat(poses[-1])
    assert np.rad2deg(turn.magnitude()) == pytest.approx(alone_deg, abs=0.01)


# As `design --together` has it: when the third joint starts, two are under way, and strokes follow before it ends.
DESIGNED = [(1, 90, 0.7), (3, 90, 0.7), (2, 90, 1.05), (1, -90, 1.33), (3, -90, 1.48), (2, -90, 1.67)]


def test_a_supply_that_dips_under_three_servos_is_named_and_the_recording_kept(
    tfsat_host: RunCli, tmp_path: Path
) -> None:
    file = tmp_path / "designed.toml"
    rows = [f"[[strokes]]\njoint = {joint}\nangle_deg = {deg}\nt_s = {t_s}\n" for joint, deg, t_s in DESIGNED]
    file.write_text("schema = 1\n" + "".join(rows))
    process = tfsat_host("rehearse", "--file", file, "--fault", "weak-battery", expect=None)
    assert "fault: reset while running (last start: brown out)" in " ".join(process.stdout.split())
    summary = json.loads((tfsat_host.folder / "run" / "summary.json").read_text())
    (fault,) = summary["faults"]
    assert fault["outcome"] == "stops at once and stays where it is" and fault["came_of_it"]
    assert any(found["by_name"] for found in fault["noticed_by"])
    evaluation = tfsat_host.json("evaluate", "run", expect=3)
    reasons = " ".join(evaluation["verdict"]["reasons"])
    assert evaluation["verdict"]["level"] == "doubtful"
    assert "The sequencer stopped after 3 joints had moved at once: its supply may have dipped." in reasons
    # It was the file's maneuver, as far as it went.
    assert "Another maneuver" not in reasons
    # Nothing was gained over 59/70 by a loop that stayed open.
    assert "Gain over" not in (tfsat_host.folder / "run" / "report.html").read_text()
    assert tfsat_host.json("decode", "run/SD.bin", "--out", "decoded")["verdict"] == "complete"


def test_a_board_that_moves_one_joint_at_a_time_refuses_it(tfsat_host: RunCli, maneuver: Path) -> None:
    error = tfsat_host.json("upload-sequence", "--file", maneuver, "--emulated", "--yes", expect=4)["error"]
    assert error["code"] == "too_many_moving"
    # Line 6 is the second stroke's.
    assert error["what"].startswith(f"{maneuver}:6: Stroke 2 makes 2 joints move at once")
    assert "moving_at_once = 1" in error["what"] and "Nothing was sent" in error["meaning"]
