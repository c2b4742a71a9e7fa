"""Input that parses and means nothing: answered at once, by name, with what to type."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.evaluation.run_folder import change_headers, run_folder
from tests.paths import REPOSITORY

ROBOT = (REPOSITORY / "robots" / "drop_tower.toml").read_text(encoding="utf-8")
CONTROLS = ("\x1b[2J", "\a", "\u202e", "\u2066")


@pytest.mark.parametrize("key", ["name", "source"])
@pytest.mark.parametrize("control", CONTROLS)
def test_a_robot_file_with_control_characters_is_refused(tfsat_host: RunCli, key: str, control: str) -> None:
    # TOML escapes: the file's text itself holds no control character.
    escaped = "".join(f"\\u{ord(sign):04x}" for sign in control)
    text = re.sub(rf'^{key} = "', lambda match: match[0] + escaped, ROBOT, count=1, flags=re.MULTILINE)
    (tfsat_host.folder / "robot.toml").write_text(text, encoding="utf-8")
    process = tfsat_host("robot", "robot.toml", expect=1)
    assert f"{key}: holds U+{ord(control[0]):04X}, a character that cannot be seen" in process.stderr
    # Not one control character reaches the terminal.
    assert not any(sign in process.stdout + process.stderr for sign in control if not sign.isprintable())


@pytest.mark.parametrize("control", CONTROLS)
def test_a_typed_path_with_control_characters_is_shown_as_an_escape(tfsat_host: RunCli, control: str) -> None:
    for command in (["robot"], ["evaluate"], ["decode"], ["simulate", "--file"]):
        process = tfsat_host(*command, f"x{control}.toml", expect=None)
        assert control[0] not in process.stdout + process.stderr


@pytest.mark.parametrize(
    ("command_line", "words"),
    [
        ("design --grid 0.01", "Give a step of at least"),
        ("plan --target z:20 --model-error 1e9", "'1e9' is too large: write a number from 0 to 5"),
        ("simulate --file many.toml", "has 10000 strokes; at most 100 are possible here"),
        ("sensitivity --file many.toml", "has 10000 strokes; at most 100 are possible here"),
        ("simulate --file dots.toml", "is nested too deeply: a key has more than 20 dots"),
        ("simulate --file fifo", "'fifo' is a device, pipe or socket, not a file"),
        ("simulate --history fifo", "'fifo' is a device, pipe or socket, not a file"),
        ("evaluate run --calibration fifo", "'fifo' is a device, pipe or socket, not a file"),
        ("evaluate run --video fifo", "'fifo' is a device, pipe or socket, not a file"),
        ("decode fifo", "'fifo' is a device, pipe or socket, not a file"),
        ("calibrate show --out fifo", "'fifo' is a device, pipe or socket, not a file"),
        ("simulate --file /dev/zero", "'/dev/zero' is a device, pipe or socket, not a file"),
        ("evaluate run", "low-pass setting 77 (possible: 0, 1, 2, 3, 4, 5, 6)"),
    ],
)
def test_it_is_refused_by_name(tfsat_host: RunCli, command_line: str, words: str) -> None:
    folder = tfsat_host.folder
    os.mkfifo(folder / "fifo")
    strokes = "".join(
        f"[[strokes]]\njoint = 1\nangle_deg = {10 * (-1) ** number}\n" for number in range(10_000)
    )
    (folder / "many.toml").write_text(f"schema = 1\n{strokes}")
    (folder / "dots.toml").write_text(f"schema = 1\n{'.'.join(['a'] * 20_000)} = 1\n")
    run_folder(folder / "run")
    change_headers(folder / "run" / "SD.bin", dlpf_cfg=77)
    process = tfsat_host(*command_line.split(), expect=None)
    # Refused as a usage error or as a failure, never as a bug.
    assert process.returncode in (1, 2)
    assert words in process.stderr


INERTIA = re.compile(r"(?<=[xyz] = )-?[\d.]+")


def _scale_lines(pattern: re.Pattern[str], factor: float, line_start: str) -> str:
    """Return the robot's file with the numbers of some lines in another unit."""
    return "\n".join(
        pattern.sub(lambda match: repr(float(match[0]) * factor), line)
        if line.startswith(line_start)
        else line
        for line in ROBOT.splitlines()
    )


_NUMBER = re.compile(r"(?<![\w_])-?\d+(\.\d+)?")
LENGTHS = ("origin_mm", "com_mm", "boxes_mm", "point_mm", "joint_point_mm", "position_mm")


def _in_meters() -> str:
    return "\n".join(
        key + "=" + _NUMBER.sub(lambda match: repr(float(match[0]) * 1e-3), values)
        if (key := line.partition("=")[0]).strip() in LENGTHS and (values := line.partition("=")[2])
        else line
        for line in ROBOT.splitlines()
    )


SLIPS = {
    "inertia in g mm2 times 1000": _scale_lines(INERTIA, 1e3, "inertia_g_m2"),
    "inertia in kg m2": _scale_lines(INERTIA, 1e-3, "inertia_g_m2"),
    "one inertia in kg m2": INERTIA.sub(lambda match: repr(float(match[0]) * 1e-3), ROBOT, count=6),
    "lengths in m": _in_meters(),
    "masses in g": _scale_lines(_NUMBER, 1e3, "mass_kg"),
    "a hinge 5 m away": ROBOT.replace("point_mm = [0.0, 10.0, 236.0]", "point_mm = [5000.0, 10.0, 236.0]"),
    "an IMU 5 m away": ROBOT.replace(
        "position_mm = [50.0, 50.0, 50.0]", "position_mm = [5000.0, 50.0, 50.0]", 1
    ),
    "a mass without end": re.sub(r"mass_kg = [\d.]+", "mass_kg = 1e308", ROBOT, count=1),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_units_that_slipped_are_refused(tfsat_host: RunCli, slip: str) -> None:
    # The slip is in the text: a replacement that found nothing would prove nothing.
    assert SLIPS[slip] != ROBOT
    (tfsat_host.folder / "slip.toml").write_text(SLIPS[slip], encoding="utf-8")
    for command in (["robot"], ["simulate", "59", "70", "--robot"]):
        process = tfsat_host(*command, "slip.toml", expect=1)
        # File and line stand at the head of the message.
        assert re.search(r"slip\.toml:\d+: ", process.stderr)
        assert re.search(r"Check the units|in mm|above 0", process.stderr)


INTERRUPTED = """
import os, signal, sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == module:
            os.kill(os.getpid(), signal.SIGINT)

module = sys.argv.pop(1)
sys.meta_path.insert(0, Interrupt())
from tfsat_host.cli.start import start
sys.exit(start())
"""


@pytest.mark.parametrize(
    "module",
    ["tfsat_host.cli.main", "tfsat_host.errors", "tfsat_host.present.output", "tfsat_host.cli.robot"],
)
def test_ctrl_c_ends_it_without_a_traceback_at_any_time(module: str, tmp_path: Path) -> None:
    process = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, module, "robot"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        # A shell may have ignored SIGINT for its children: the default handler is set again.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert "Traceback" not in process.stderr
    assert process.returncode in (-signal.SIGINT, 130)
