"""An emulated robot on the bench with both boards at hand, and servos of known errors."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np
import pytest

from tfsat_host.calibration.solution import Solution, solve
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import Step, servo, zero
from tfsat_host.cli.calibrate.bench import Bench, EmulatedPerson, origin_of
from tfsat_host.cli.calibrate.jogged_joint import measure_servo
from tfsat_host.devices.jogging import JogClient
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot, EmulationError
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import Imperfections, ideal
from tfsat_host.emulated.manual_motion import Operator
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.robot import load_robot

MODEL = load_robot()
LIMP_AFTER_US = 120_000
GAINS, OFFSETS_DEG, BACKLASHES_DEG = (0.95, 1.02, 0.93), (1.5, -1.0, 0.5), (0.8, 0.2, 1.1)


def wrong(repeat_deg: float = 0.0) -> Imperfections:
    """Servos of the errors above; sensors with noise only."""
    return replace(
        ideal(),
        angle_noise_rad=np.deg2rad(0.05),
        servo_gain=np.array(GAINS),
        servo_offset_rad=np.deg2rad(OFFSETS_DEG),
        servo_backlash_rad=np.deg2rad(BACKLASHES_DEG),
        servo_repeat_rad=np.deg2rad(np.full(3, repeat_deg)),
    )


@dataclass
class Rig:
    """An emulated robot on the bench, and its zero points."""

    robot: EmulatedRobot
    bench: Bench
    out: Output
    zeros: Evidence

    def measure_joint(self, joint: int) -> Evidence:
        settings = self.bench.jog.settings().settings
        sensors = self.solution().joints[joint - 1]
        return measure_servo(joint, settings, sensors, self.bench, MODEL, self.out)

    def read(self, step: Step, duration_s: float) -> Evidence:
        return read(self.bench.logger, EmulatedOperator(self.robot), step, duration_s)

    def solution(self) -> Solution:
        return solve([self.zeros], MODEL)

    def is_let_go(self, joint: int) -> bool:
        self.robot.advance(LIMP_AFTER_US)
        # A limp servo lets the joint be swung by hand; a driven one would resist.
        try:
            self.robot.hold(servo(joint).held)
            self.robot.swing(joint, 1.0, 0.1, 1)
        except EmulationError:
            return False
        return self.bench.jog.status().state == SequencerState.SAFE


@contextmanager
def rig(imperfections: Imperfections, hands: Operator | None = None, seed: int = 1) -> Iterator[Rig]:
    with EmulatedRobot(MODEL, imperfections=imperfections, seed=seed) as robot:
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        sequencer = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        operator = EmulatedOperator(robot, hands)
        # Zero points first: a servo is measured by the angle sensors.
        zeros = read(logger, operator, zero(None), operator.duration_s(zero(None)))
        out = Output(yes=True, stdout=io.StringIO(), stderr=io.StringIO())
        bench = Bench(logger, EmulatedPerson(operator, out, jogging=True), zeros.origin, sequencer)
        yield Rig(robot, bench, out, zeros)


def read(logger: LoggerClient, operator: EmulatedOperator, step: Step, duration_s: float) -> Evidence:
    operator.begin(step)
    with logger.live() as scales:
        samples = logger.samples_of(duration_s)
    return Evidence(step, Counts.from_live(samples, scales), datetime.now(UTC), origin_of(logger))


def befall(here: Rig, monkeypatch: pytest.MonkeyPatch, after: int, what: Callable[[], None]) -> None:
    """Something happens in the tour, at the pause of that number."""
    samples_of = here.bench.logger.samples_of
    pauses = 0

    def count_pause(duration_s: float) -> list[LiveSample]:
        nonlocal pauses
        pauses += 1
        # The pauses of a tour are numbered: something happens in the middle of it.
        if pauses == after:
            what()
        return samples_of(duration_s)

    monkeypatch.setattr(here.bench.logger, "samples_of", count_pause)
