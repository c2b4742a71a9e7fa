"""What is recommended can be typed as it stands; verdicts have colours on a terminal only."""

from __future__ import annotations

import argparse
import io
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest

from tests.preflight.ready_robot import CERTIFICATE, ReadyRobot, check
from tfsat_host.calibration.certificate.certificate import Landing
from tfsat_host.cli.main import main
from tfsat_host.cli.preflight_report import complete_steps, transports
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.preflight_check import no_go
from tfsat_host.present.output import Output
from tfsat_host.robot import default_robot_path


def arguments(**options: object) -> argparse.Namespace:
    return argparse.Namespace(
        **{"command": "preflight", "port": None, "logger_port": None, "emulated": False, **options}
    )


@pytest.mark.parametrize(
    ("step", "expected_step"),
    [
        (NextStep("disarm"), "tfsat-host disarm --port /dev/s"),
        (
            NextStep("logger-settings set", ("--clock",)),
            "tfsat-host logger-settings set --clock --port /dev/l",
        ),
        (NextStep("log fetch", ("ram",)), "tfsat-host log fetch ram --port /dev/l"),
        (
            NextStep("upload-sequence", ("--file", "maneuver.toml")),
            "tfsat-host upload-sequence --file 'a run/maneuver.toml' --port /dev/s",
        ),
        (
            NextStep("calibrate scale", ("--turn", "z", "360")),
            "tfsat-host calibrate scale --turn z 360 --out 'a run/calibration.toml' --port /dev/l",
        ),
        (NextStep("calibrate show"), "tfsat-host calibrate show --out 'a run/calibration.toml'"),
    ],
)
def test_commands_name_this_runs_files_and_devices(step: NextStep, expected_step: str) -> None:
    run = Path("a run")
    (preflight_check,) = complete_steps(
        [no_go("Wrong.", Advice("First ", step, ", then again."))],
        arguments(port="/dev/s", logger_port="/dev/l"),
        run / "maneuver.toml",
        default_robot_path(),
        str(run / "calibration.toml"),
        emulated=False,
    )
    assert preflight_check.next_step == f"First {expected_step}, then again."


def test_commands_name_another_robot_than_the_shipped_one(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("another", encoding="utf-8")
    steps = [NextStep("calibrate show"), NextStep("acceptance"), NextStep("disarm")]
    (preflight_check,) = complete_steps(
        [no_go("Wrong.", Advice(*(part for step in steps for part in (step, " "))))],
        arguments(),
        Path("maneuver.toml"),
        robot,
        "",
        emulated=False,
    )
    assert preflight_check.next_step.split("tfsat-host ")[1:] == [
        f"calibrate show --robot {robot} ",
        f"acceptance --robot {robot} ",
        "disarm ",
    ]


def test_an_explicit_port_scans_no_others(monkeypatch: pytest.MonkeyPatch) -> None:
    requests = []

    def no_port(board: str, explicit: str | None, _out: Output) -> object:
        requests.append((board, explicit))
        raise PortError(PortProblem.MISSING, what="Not there.", next_step="Plug it in.")

    from contextlib import ExitStack

    monkeypatch.setattr("tfsat_host.cli.preflight_report.open_port", no_port)
    for options, expected in (
        ({}, [("sequencer", None), ("logger", None)]),
        ({"port": "/dev/s"}, [("sequencer", "/dev/s")]),
        ({"port": "/dev/s", "logger_port": "/dev/l"}, [("sequencer", "/dev/s"), ("logger", "/dev/l")]),
    ):
        requests.clear()
        with ExitStack() as stack:
            transport_by_board = transports(arguments(**options), None, stack, Output(stderr=io.StringIO()))  # type: ignore[arg-type]
        assert requests == expected
        assert all(isinstance(transport, PortError) for transport in transport_by_board.values())


def test_of_many_commands_that_are_wanted_the_one_is_named_that_lists_them(ready: ReadyRobot) -> None:
    """Name the command that lists all wanted commands, if there are too many to show."""
    landed = Landing(ready.calibration.written + timedelta(minutes=30), "recording 1a2b3c4d")
    ready.certify(replace(ready.calibration, landings=(landed,)))
    commands = {gap.command for gap in ready.calibration.shortcomings()}
    step = check(ready.preflight(expect=4), "calibration")["next_step"]
    assert len(commands) > 3 and " more" not in step
    command = f"tfsat-host calibrate show --out {ready.folder / CERTIFICATE}"
    assert step.startswith(f"{command} names all {len(commands)} commands")


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_verdicts_are_green_and_red_on_a_terminal(ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setenv("TERM", "xterm")
    terminal = Terminal()
    monkeypatch.setattr("sys.stdout", terminal)
    ready.robot.set_switch(1, False)
    assert main(["preflight", str(ready.folder), "--full"]) == 4
    text = terminal.getvalue()
    assert "\x1b[32mGO" in text and "\x1b[1;31mNO-GO" in text


def test_the_emulated_robot_of_the_command_is_asked_with_its_own_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nobody could have set it, and calibration has not been made: those, and no others."""
    import json

    monkeypatch.chdir(tmp_path)
    assert main(["preflight", "--emulated", "--json"]) == 4
    result = json.loads(capsys.readouterr().out)
    assert check(result, "clock")["verdict"] == "go"
    assert {"calibration", "maneuver", "card"} & {
        entry["name"] for entry in result["checks"] if entry["verdict"] != "go"
    } == {"calibration", "maneuver"}
    assert "--emulated" in check(result, "calibration")["next_step"]
