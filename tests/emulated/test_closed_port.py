"""A program that ends closes the sequencer's port (DTR), which ends a jog as on the real board."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.emulated.served import TIMEOUT_S, Served
from tfsat_host.devices.client import Client
from tfsat_host.devices.transport import SerialTransport
from tfsat_host.emulated.build import sequencer_hex
from tfsat_host.emulated.emulated_robot import SETTLE_US, US_PER_S, BoardIndex, EmulatedRobot, EmulationError
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.server import STEP_US, RobotServer
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import JOG_CONFIRM, JOG_IDLE_MS
from tfsat_host.protocol.messages import (
    JogReply,
    JogRequest,
    SequencerStatusReply,
    SequencerStatusRequest,
)

TO_DEG = 80.0
UNDER_WAY_DEG = 5.0
MAX_JOG_S = 20
UNDER_WAY_US = 300_000
LIMP_AFTER_US = 150_000
"""A servo goes limp 100 ms after its last pulse; the board sees its port closed within some ms."""
# The port's closing, not the missing orders, must be what ends the jog.
assert UNDER_WAY_US + LIMP_AFTER_US < 1000 * JOG_IDLE_MS, "else it would go limp for want of orders"


class SteppedPort(SerialTransport):
    """A program with the port open, in whose waiting the server's time passes."""

    def __init__(self, server: RobotServer, link: Path) -> None:
        super().__init__(str(link))
        self._server = server

    def now_s(self) -> float:
        """Virtual seconds."""
        return self._server.robot.now_us / US_PER_S

    # Time passes only here: a test steps the server by reading.
    def read(self, timeout_s: float) -> bytes:
        """Step the server once, whatever the timeout, and return the bytes received."""
        del timeout_s
        self._server.step()
        return super().read(0.0)


def angle_deg(served: Served) -> float:
    (reply,) = served.control("angles")
    return float(reply.split()[1])


def wait_until_under_way(served: Served) -> None:
    # Twenty seconds of robot time at the most.
    for _ in range(10 * MAX_JOG_S):
        if angle_deg(served) > UNDER_WAY_DEG:
            return
        served.control("wait 100ms")
    raise AssertionError("the jog moves nothing")


def jog_joint_1(client: Client) -> None:
    client.request(JogRequest(1, 0, round(100 * TO_DEG), JOG_CONFIRM), JogReply)


def test_a_jog_that_is_killed_leaves_the_joint_limp_where_it_is(served_robot: Served) -> None:
    jog = subprocess.Popen(
        [sys.executable, "-m", "tfsat_host", "jog", "--joint", "1", "--from", "0", "--to", f"{TO_DEG:g}",
         "--hold", "5", "--yes", "--port", str(served_robot.sequencer)],
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        wait_until_under_way(served_robot)
        assert served_robot.control("hold 2 3 4", "swing 1 1 1 1")[1].startswith("error"), (
            "its servo holds it"
        )
    finally:
        # SIGKILL: the program has no chance to let the joint go.
        jog.kill()
        jog.communicate(timeout=TIMEOUT_S)
    served_robot.control("wait 300ms")
    left_at_deg = angle_deg(served_robot)
    # On its way when the program died: past the start, short of the target.
    assert UNDER_WAY_DEG < left_at_deg < TO_DEG - 10.0
    served_robot.control("wait 1")
    assert angle_deg(served_robot) == pytest.approx(left_at_deg, abs=0.1)
    # A hand can swing it: the servo is limp.
    assert served_robot.control("swing 1 1 1 1") == ["ok for 1 s"]


def test_a_program_that_closes_the_port_ends_its_jog(server: RobotServer, tmp_path: Path) -> None:
    robot = server.robot
    robot.hold((2, 3, 4))
    client = Client(SteppedPort(server, tmp_path / "robot" / "sequencer"))
    jog_joint_1(client)
    # 0.3 s of motion: less than the board waits for orders.
    for _ in range(UNDER_WAY_US // STEP_US):
        server.step()
    # The servo holds the joint: a hand cannot swing it.
    with pytest.raises(EmulationError):
        robot.swing(1, 1.0, 1.0, 1)
    client.close()
    for _ in range(LIMP_AFTER_US // STEP_US):
        server.step()
    robot.swing(1, 1.0, 1.0, 1)


@pytest.mark.parametrize("image", ["native", "avr"])
def test_closing_a_port_in_this_process_ends_a_jog_and_opening_it_again_finds_the_board_safe(
    image: str,
) -> None:
    hex_path: Path | None = sequencer_hex() if image == "avr" else None
    with EmulatedRobot(hex_path=hex_path) as robot:
        robot.advance(SETTLE_US)
        robot.hold((2, 3, 4))
        client = Client(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        jog_joint_1(client)
        robot.advance(UNDER_WAY_US)
        with pytest.raises(EmulationError):
            robot.swing(1, 1.0, 1.0, 1)
        client.close()
        robot.advance(LIMP_AFTER_US)
        robot.swing(1, 1.0, 1.0, 1)
        again = Client(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        status = again.request(SequencerStatusRequest(), SequencerStatusReply)
        # The board stands by itself: the next program finds it SAFE.
        assert status.state == SequencerState.SAFE


def test_between_two_programs_the_sequencer_stays_armed(served_robot: Served, tfsat_host: RunCli) -> None:
    """Keep the sequencer armed when the arming program ends: the robot is lifted without a cable.

    Only a jog needs its program to keep running.
    """
    tfsat_host("upload-sequence", 59, 70, "--port", served_robot.sequencer)
    tfsat_host("arm", "--yes", "--port", served_robot.sequencer)
    status = tfsat_host.json("status", "--port", served_robot.sequencer)["sequencer"]
    assert status["state"] == "armed"
