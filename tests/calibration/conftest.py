"""Benches that several files of tests share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.calibration.scripted_person import Doing, Run, Scripted, Terminal
from tfsat_host.calibration.steps.step import DURATION_S, Step, StepKind
from tfsat_host.cli.calibrate.bench import Bench, origin_of
from tfsat_host.cli.main import main
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport


@pytest.fixture
def few_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Check a step's progress four times less often while it is recorded."""
    monkeypatch.setattr("tfsat_host.calibration.progress.LOOK_S", 2.0)


@pytest.fixture
def short_steps(few_looks: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rests and swings last a quarter to a half: where their numbers are not what is proved."""
    for kind, duration_s in ((StepKind.REST, 5.0), (StepKind.ZERO, 2.0), (StepKind.SWING, 6.0)):
        monkeypatch.setitem(DURATION_S, kind, duration_s)


@pytest.fixture
def calibrate(short_steps: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Run]:
    """Runs a command with a scripted person; gives its exit code and the steps that were asked for."""
    monkeypatch.chdir(tmp_path)
    with EmulatedRobot(seed=5) as robot:
        robot.advance(SETTLE_US)

        def run(*arguments: str, stdin_text: str = "", **doing: Doing) -> tuple[int, list[Step]]:
            # Attempts are counted from 1; a keyword `_2` says what is done at the second one.
            person = Scripted(robot, {int(name[1:]): what for name, what in doing.items()})

            @contextmanager
            def open_bench(*_: object, jog: bool = False) -> Iterator[Bench]:
                logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
                yield Bench(logger, person, origin_of(logger))

            monkeypatch.setattr("tfsat_host.cli.calibrate.flow.open_bench", open_bench)
            monkeypatch.setattr("sys.stdin", Terminal(stdin_text))
            return main(arguments), person.requested_steps

        yield run
