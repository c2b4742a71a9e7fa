"""Pages of the guide that say something checkable."""

from __future__ import annotations

import ast
import json
import re
import warnings
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from tests.calibration.some_calibration import MEASURED, whole_calibration
from tests.docs.documents import GUIDE
from tests.evaluation.run_folder import run_folder
from tests.paths import REPOSITORY
from tests.run.bundle.commands import keep_evaluations
from tfsat_host.calibration.certificate.certificate import Landing, commands_of
from tfsat_host.calibration.sensors.gyro import by_design
from tfsat_host.calibration.sensors.joint_sensors import sensors_by_design
from tfsat_host.robot import load_robot


def _text(name: str) -> str:
    return (GUIDE / name).read_text(encoding="utf-8")


def test_the_runbook_is_a_list_to_tick() -> None:
    lines = [line for line in _text("runbook.md").splitlines() if line]
    # It has to fit one printed page, and most of its lines are to be ticked.
    assert len(lines) <= 50
    assert max(len(line) for line in lines) <= 130
    assert sum(line.startswith("- [ ] ") for line in lines) >= 0.7 * len(lines)


@pytest.mark.parametrize(
    "order",
    # The desk, the calibration, the arming, and the way back: in each the next step needs the one before.
    [
        ("status", "design --out runN/maneuver.toml", "envelope", "calibrate bias", "calibrate zero --all"),
        (
            "calibrate zero --all",
            "calibrate misalignment",
            "calibrate scale",
            "calibrate servo",
            "calibrate show",
        ),
        (
            "calibrate show",
            "upload-sequence",
            "logger-settings set --clock",
            "preflight",
            "record start",
            "arm",
        ),
        (
            "arm",
            "disarm",
            "log fetch",
            "decode",
            "evaluate",
            "report runN",
            "campaign add",
            "bundle",
            "log erase",
        ),
    ],
)
def test_the_runbook_keeps_the_order_of_the_day(order: tuple[str, ...]) -> None:
    places = [_text("runbook.md").index(f"`tfsat-host {command}") for command in order]
    assert places == sorted(places)


def test_the_runbook_makes_a_runs_folder_before_it_is_used() -> None:
    text = _text("runbook.md")
    assert 0 < text.index("`mkdir runN`") < text.index("runN/")


def test_the_runbook_copies_the_certificate_when_the_landing_is_in_it() -> None:
    """`decode` notes it in the certificate next to the recording, else in that of the desk: the next drop's."""
    text = _text("runbook.md")
    assert (
        text.index("`tfsat-host decode")
        < text.index("`cp -R calibration.toml")
        < text.index("tfsat-host eval")
    )


def _calibrate_commands(page: str) -> set[str]:
    """Return the calibrate commands of a page; `then 2 and 3` stands for the other joints."""
    matches = re.findall(r"`(tfsat-host calibrate [^`]+)`(, then 2 and 3)?", page)
    assert all(others or "--joint" not in command for command, others in matches)
    return {
        command.replace("--joint 1", f"--joint {joint}")
        for command, others in matches
        for joint in ((1, 2, 3) if others else (1,))
    }


def test_after_the_runbooks_commands_nothing_is_missing_for_a_first_drop_or_another() -> None:
    """Runbook commands leave nothing missing for a first drop or for another one.

    A landing invalidates all but scale factors, which must be measured anew before each drop.
    """
    robot = load_robot()
    # A new robot: sensors as designed, nothing measured.
    unmeasured = replace(
        whole_calibration(),
        gyros=tuple(by_design(body, imu.sensor_to_body) for body, imu in enumerate(robot.imus, 1)),
        joints=tuple(sensors_by_design(robot, joint) for joint in (1, 2, 3)),
        servo_maps=(),
    )
    landed = Landing(MEASURED + timedelta(hours=1), "recording 1a2b3c4d")
    page = _text("runbook.md")
    assert set(map(str, commands_of(unmeasured.shortcomings()))) <= _calibrate_commands(page)
    _, before_each = page.split("**Before each drop, on the desk**")
    # A later drop skips what the page marks for the first one.
    again = "\n".join(line for line in before_each.splitlines() if "first drop" not in line)
    landed_calibration = replace(whole_calibration(), landings=(landed,))
    required_commands = set(map(str, commands_of(landed_calibration.shortcomings())))
    assert len(required_commands) > 5 and required_commands <= _calibrate_commands(again)


def test_the_python_examples_run_one_after_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tasks = re.findall(r"```python\n(.*?)```", _text("python-api.md"), re.DOTALL)
    assert len(tasks) == 10
    keep_evaluations(monkeypatch)
    monkeypatch.chdir(tmp_path)
    run_folder(tmp_path / "run")
    run_folder(tmp_path / "run2", seed=2)
    with warnings.catch_warnings():
        # A deprecation in an example would become an error at the reader's next update.
        warnings.simplefilter("error")
        # In one namespace, as a reader pastes them one after the other.
        exec("\n".join(tasks), {})
    angle_rad, std_rad = map(float, capsys.readouterr().out.splitlines()[0].split())
    assert angle_rad == pytest.approx(0.48, abs=0.1)
    assert 0.0 < std_rad < 0.02


def test_the_notebook_runs_and_shows_the_drop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run its cells as a kernel does: what stands last in one is shown."""
    notebook = json.loads(_text("drop.ipynb"))
    keep_evaluations(monkeypatch)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    run_folder(tmp_path / "run")
    names: dict[str, Any] = {}
    shown: list[Any] = []
    for cell in (cell for cell in notebook["cells"] if cell["cell_type"] == "code"):
        *statements, last = ast.parse("".join(cell["source"])).body
        exec(compile(ast.Module(statements, []), "drop.ipynb", "exec"), names)
        assert isinstance(last, ast.Expr)
        shown.append(eval(compile(ast.Expression(last.value), "drop.ipynb", "eval"), names))
    drop, evaluation, *_, table = shown
    assert "<td>Reorientation</td>" in drop._repr_html_()
    # Of one screen, not of all that they hold.
    assert max(len(repr(thing).splitlines()) for thing in (drop, evaluation)) <= 40
    assert max(len(line) for line in repr(evaluation).splitlines()) <= 120
    assert table.shape == (8, 3)


def test_the_sketches_need_what_the_flashing_page_says() -> None:
    """Sketches need no library besides the board's core, except those that the flashing page names."""

    def find_includes(sketch: str) -> set[str]:
        sources = [
            *(REPOSITORY / "firmware" / sketch).rglob("*.[hc]*"),
            *(REPOSITORY / "firmware" / sketch).glob("*.ino"),
        ]
        text = "\n".join(path.read_text(encoding="utf-8") for path in sources)
        return set(re.findall(r"^#include <([A-Za-z/]+\.h)>", text, re.MULTILINE))

    # Headers of the compiler, which every toolchain has.
    system = {"stdint.h", "stddef.h", "string.h", "math.h", "setjmp.h"}
    assert {
        name for name in find_includes("arduino_sequencer") - system if not name.startswith(("avr/", "util/"))
    } == {"Arduino.h"}
    assert find_includes("teensy_logger") - system - {"avr/eeprom.h"} == {"Arduino.h", "SdFat.h", "Wire.h"}
    for name in ("`SdFat`", "`Wire`"):
        assert name in _text("flashing.md")


def test_porting_names_the_counts_of_the_specification() -> None:
    specification = (REPOSITORY / "protocol" / "tfsat.toml").read_text(encoding="utf-8")
    counts = [
        re.search(rf"^{name}_count = {{ value = (\d+)", specification, re.MULTILINE)
        for name in ("joint", "imu", "angle_sensor", "switch")
    ]
    assert f"| {', '.join(match[1] for match in counts if match)}: fixed" in _text("porting.md")


def test_files_that_the_guide_names_are_there() -> None:
    named = {
        path
        for page in GUIDE.glob("*.md")
        for path in re.findall(
            r"`((?:robots|firmware|tools|protocol|host|docs)/[\w/.-]+\.\w+)`",
            page.read_text(encoding="utf-8"),
        )
    }
    assert len(named) >= 6
    assert [path for path in sorted(named) if not (REPOSITORY / path).exists()] == []
