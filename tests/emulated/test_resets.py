"""Resets of the served sequencer, as `tfsat-host status` tells of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.cli.process import RunCli
from tests.emulated.served import Served
from tests.emulated.test_control import Person
from tfsat_host.devices.serial_ports import PortError
from tfsat_host.devices.transport import SerialTransport
from tfsat_host.emulated.server import RobotServer

CAUSES = {"watchdog": "watchdog", "brown-out": "brown_out", "button": "external"}
"""As a control line names them, and as the sequencer reports them."""


def arm(served: Served, tfsat_host: RunCli) -> None:
    tfsat_host("upload-sequence", 59, 70, "--port", served.sequencer)
    tfsat_host("arm", "--yes", "--port", served.sequencer)


def status(served: Served, tfsat_host: RunCli) -> dict[str, Any]:
    sequencer_status: dict[str, Any] = tfsat_host.json("status", "--port", served.sequencer)["sequencer"]
    return sequencer_status


def test_armed_with_both_switches_closed_it_is_armed_again_and_the_resets_are_counted(
    served_robot: Served, tfsat_host: RunCli
) -> None:
    arm(served_robot, tfsat_host)
    for number, (word, cause) in enumerate(CAUSES.items(), start=1):
        # Each cause once, and the counter goes up with it.
        assert served_robot.control(f"reset {word}", "wait 500ms") == ["ok", "ok"]
        sequencer_status = status(served_robot, tfsat_host)
        assert (sequencer_status["state"], sequencer_status["fault"]) == ("armed", "none")
        assert (sequencer_status["resets_while_armed"], sequencer_status["reset_cause"]) == (number, cause)
    # The drop afterwards is flown: being armed again is worth something.
    served_robot.control("drop", "wait still", "wait 500ms")
    sequencer_status = status(served_robot, tfsat_host)
    assert (sequencer_status["state"], sequencer_status["resets_while_armed"]) == ("done", len(CAUSES))


@pytest.mark.parametrize("word", list(CAUSES))
def test_armed_with_a_switch_open_it_is_in_fault_and_the_servos_hold(
    served_robot: Served, tfsat_host: RunCli, word: str
) -> None:
    arm(served_robot, tfsat_host)
    # A switch is open at the reset: the robot may have been released.
    served_robot.control("hold 2 3 4", "release 1", f"reset {word}", "wait 1")
    sequencer_status = status(served_robot, tfsat_host)
    assert (sequencer_status["state"], sequencer_status["fault"]) == ("fault", "reset_while_armed")
    assert sequencer_status["reset_cause"] == CAUSES[word]
    for joint in (1, 2, 3):
        (refused,) = served_robot.control(f"swing {joint} 10 1 1")
        # Held by its servo, in the pose of before.
        assert "Its servo holds it" in refused
    tfsat_host("disarm", "--port", served_robot.sequencer)
    assert served_robot.control("wait 300ms", "swing 1 10 1 1") == ["ok", "ok for 1 s"]


def test_a_program_that_has_the_port_open_loses_it_and_the_next_finds_it(native: Served) -> None:
    client = SerialTransport(str(native.sequencer))
    # The board's end of the link goes away, as USB does in a reset.
    assert native.control("reset button") == ["ok"]
    with pytest.raises(PortError, match="was lost"):
        client.read(1.0)
    client.close()
    SerialTransport(str(native.sequencer)).close()


def test_a_board_without_power_is_not_reset(server: RobotServer, tmp_path: Path) -> None:
    person = Person(server)
    # Without power there is nothing to reset.
    person("power sequencer off")
    assert person("reset watchdog").startswith("error The sequencer has no power")
    assert not (tmp_path / "robot" / "sequencer").is_symlink()


def test_a_board_whose_cable_is_pulled_is_reset_and_gets_no_port(server: RobotServer, tmp_path: Path) -> None:
    person = Person(server)
    person("cable sequencer pull")
    assert person("reset watchdog") == "ok"
    assert not (tmp_path / "robot" / "sequencer").is_symlink()
