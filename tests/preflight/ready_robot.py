"""An emulated robot that is ready for its drop: everything is right, until a test breaks one thing."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.calibration.some_calibration import servo_map
from tfsat_host.acceptance.record import Acceptance, AcceptedBoard, StepResult, write_acceptance
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.file import format_calibration
from tfsat_host.cli.main import main
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.transport import Transport
from tfsat_host.emulated.emulated_certificate import careful_certificate
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import Imperfections, draw_as_built
from tfsat_host.errors import TfsatError
from tfsat_host.maneuver import format_maneuver, four_stroke, schedule_maneuver
from tfsat_host.preflight.preflight_check import go
from tfsat_host.robot.absent_parts import hash_wired_parts

SEED = 4
TRUTH = draw_as_built(SEED)
CERTIFICATE = "calibration-emulated.toml"
MANEUVER = four_stroke(59.0, 70.0)
WATCH_S = 2.0
"""A third of the command's own: enough for every fault here."""


@dataclass(eq=False)
class ReadyRobot:
    """A robot in its releaser, and a run's folder.

    Attributes:
        robot: Settled, the maneuver uploaded.
        folder: With maneuver and certificate.
        calibration: What the certificate says.
        set_clock: The logger's clock is set before the preflight, so many seconds off; None: it is not.
        links: What the command finds at the ends of its cables; those that are not here are the robot's.
    """

    robot: EmulatedRobot
    folder: Path
    calibration: Calibration
    capture: pytest.CaptureFixture[str]
    set_clock: float | None = 0.0
    links: dict[str, Transport | TfsatError] | None = None

    def sequencer(self) -> SequencerClient:
        return SequencerClient.connect(EmulatedTransport(self.robot, BoardIndex.SEQUENCER))

    def logger(self) -> LoggerClient:
        return LoggerClient.connect(EmulatedTransport(self.robot, BoardIndex.LOGGER))

    def certify(self, calibration: Calibration) -> None:
        """Another certificate in the run's folder."""
        self.calibration = calibration
        (self.folder / CERTIFICATE).write_text(format_calibration(calibration), encoding="utf-8")

    def accept(self, *steps: StepResult, file: str = "acceptance-emulated.json") -> None:
        """Write an acceptance of these boards, with one step that is due."""
        sequencer, logger = (AcceptedBoard.of(board.identity) for board in (self.sequencer(), self.logger()))
        done = steps or (StepResult("switches", datetime(2026, 11, 2, tzinfo=UTC), (go("fine"),)),)
        robot = hash_wired_parts(self.robot.model)
        write_acceptance(Acceptance(True, robot, ("switches",), sequencer, logger, done), self.folder / file)

    def preflight(self, *arguments: str, expect: int) -> dict[str, Any]:
        """Runs the command; what it prints as JSON."""
        self.capture.readouterr()
        code = main(["preflight", str(self.folder), "--json", *arguments])
        output = self.capture.readouterr()
        assert code == expect, output
        result: dict[str, Any] = json.loads(output.out)
        return result


def found_wrong(result: dict[str, Any]) -> set[str]:
    """Checks that found something wrong."""
    return {entry["name"] for entry in result["checks"] if entry["verdict"] == "no-go"}


def not_made(result: dict[str, Any]) -> set[str]:
    """Checks that could not be made, the optional ones aside."""
    return {
        entry["name"]
        for entry in result["checks"]
        if entry["verdict"] == "not-made" and not entry["optional"]
    }


def check(result: dict[str, Any], name: str) -> dict[str, Any]:
    return next(entry for entry in result["checks"] if entry["name"] == name)


def certificate_of(robot: EmulatedRobot, truth: Imperfections, measured_at: datetime) -> Calibration:
    """Return a complete certificate, servos included."""
    careful = careful_certificate(robot.model, truth, SEED, measured_at)
    rng = np.random.default_rng(SEED)
    return replace(careful, servo_maps=tuple(servo_map(rng, joint, measured_at) for joint in (1, 2, 3)))


@contextmanager
def ready_robot(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capture: pytest.CaptureFixture[str],
    truth: Imperfections = TRUTH,
    certified: Imperfections | None = None,
) -> Iterator[ReadyRobot]:
    """Yield a robot with these errors and a certificate of it (or of `certified`), taken an hour ago."""
    folder.mkdir(exist_ok=True)
    monkeypatch.chdir(folder.parent)
    (folder / "maneuver.toml").write_text(format_maneuver(MANEUVER), encoding="utf-8")
    monkeypatch.setattr("tfsat_host.preflight.logger_queries.WATCH_S", WATCH_S)
    with EmulatedRobot(imperfections=truth, seed=SEED) as robot:
        robot.advance(SETTLE_US)
        measured_at = (datetime.now(UTC) - timedelta(hours=1)).replace(microsecond=0)
        ready = ReadyRobot(robot, folder, certificate_of(robot, certified or truth, measured_at), capture)
        ready.certify(ready.calibration)
        ready.sequencer().upload(schedule_maneuver(MANEUVER))
        robot.advance(3_000_000)  # the logger has looked at its card

        def transports(*_: object) -> dict[str, Transport | TfsatError]:
            if ready.set_clock is not None:
                now_s = datetime.now(UTC).timestamp() + ready.set_clock
                ready.logger().set_clock(round(now_s * 1e6))
            return {board.name.lower(): EmulatedTransport(robot, board) for board in BoardIndex} | (
                ready.links or {}
            )

        monkeypatch.setattr("tfsat_host.cli.preflight_report.transports", transports)
        yield ready
