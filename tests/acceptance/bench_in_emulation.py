"""The bench of an acceptance with an emulated robot: its steps, one after the other, in this process."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext

from tfsat_host.acceptance.bench import Bench
from tfsat_host.acceptance.emulated_hands import EmulatedHands
from tfsat_host.acceptance.record import Acceptance, AcceptedBoard
from tfsat_host.acceptance.steps import STEPS, make_step
from tfsat_host.acceptance.wiring_faults import WIRING_FAULTS, emulate_faults
from tfsat_host.devices.jogging import JogClient
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.robot import RobotModel, load_robot

NAMES = tuple(step.name for step in STEPS)


@contextmanager
def emulated_bench(
    faults: Sequence[str] = (), robot: RobotModel | None = None
) -> Iterator[tuple[Bench, EmulatedRobot]]:
    model = robot or load_robot()
    with emulate_faults([WIRING_FAULTS[name] for name in faults], model, print) as (emulated, servos):
        sequencer = JogClient.connect(EmulatedTransport(emulated, BoardIndex.SEQUENCER))
        logger = LoggerClient.connect(EmulatedTransport(emulated, BoardIndex.LOGGER))
        hands = EmulatedHands(emulated, servos)
        silent = nullcontext(lambda _seconds: None)
        yield (
            Bench(
                emulated.model,
                sequencer,
                logger,
                hands,
                lambda: sequencer,
                print,
                lambda _what, _total: silent,
            ),
            emulated,
        )


def accept(bench: Bench, steps: Sequence[str] = NAMES) -> Acceptance:
    boards = AcceptedBoard.of(bench.sequencer.identity), AcceptedBoard.of(bench.logger.identity)
    acceptance = Acceptance(True, "", NAMES, *boards)
    for step in STEPS:
        if step.name in steps:
            acceptance = acceptance.with_step(make_step(step, bench, acceptance))
    return acceptance
