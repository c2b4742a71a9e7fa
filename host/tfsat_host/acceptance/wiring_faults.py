"""What a robot may have been wired wrongly, for an acceptance that is rehearsed; and how each must be named."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import reduce

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.emulated_robot import DEFAULT_SEED, EmulatedRobot
from tfsat_host.emulated.fault_injection import CardDefect, ServoFault, WirePart
from tfsat_host.emulated.imperfections import Imperfections, draw_as_built
from tfsat_host.quantity import Column, Columns
from tfsat_host.robot import RobotModel

START_US = 6_000_000


@dataclass(frozen=True, slots=True)
class WiringFault:
    """A fault.

    Attributes:
        name: On the command line.
        finding: What the acceptance must say.
        wire: Does it to the robot.
        mounting: By IMU its turn against its place, (3, 3) rotations in body axes.
        servos: By joint what is wrong with its servo.
    """

    name: str
    finding: str
    wire: Callable[[EmulatedRobot], None] = lambda _robot: None
    mounting: Mapping[int, FloatArray] = field(default_factory=dict)
    servos: Mapping[int, ServoFault] = field(default_factory=dict)

    def mount(self, imperfections: Imperfections) -> Imperfections:
        """Return a robot's imperfections with its IMUs mounted like this."""
        mounting = imperfections.mounting.copy()
        for imu, turn in self.mounting.items():
            mounting[imu - 1] = turn @ mounting[imu - 1]
        return replace(imperfections, mounting=mounting)


def _swap(part: WirePart, first: int, second: int) -> Callable[[EmulatedRobot], None]:
    def wire(robot: EmulatedRobot) -> None:
        robot.faults.connect(part, first, second)
        robot.faults.connect(part, second, first)

    return wire


def _cut(part: WirePart, pin: int) -> Callable[[EmulatedRobot], None]:
    return lambda robot: robot.faults.connect(part, pin, None)


def _swap_buses(robot: EmulatedRobot) -> None:
    robot.faults.imu(1, "swapped", 3)
    robot.faults.imu(2, "swapped", 4)


def _cut_bus(robot: EmulatedRobot) -> None:
    robot.faults.imu(3, "dead")
    robot.faults.imu(4, "dead")


WEAK_BATTERY_OHM = 1.0
"""One servo's start is carried, two servos' are not."""
_QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])

WIRING_FAULTS = {
    fault.name: fault
    for fault in (
        WiringFault(
            "imu-3-4-swapped",
            "IMU 3 answers where IMU 4 belongs",
            lambda robot: robot.faults.imu(3, "swapped", 4),
        ),
        WiringFault("imu-buses-swapped", "exchange their buses", _swap_buses),
        WiringFault(
            "imu-2-silent",
            "IMU 2 (address 0x69, Teensy pins 18 (SDA), 19 (SCL)) does not answer",
            lambda robot: robot.faults.imu(2, "dead"),
        ),
        WiringFault(
            "imu-bus-2-cut",
            "neither IMU 3 and 4 answers: the bus at Teensy pins 17 (SDA1), 16 (SCL1)",
            _cut_bus,
        ),
        WiringFault("imu-1-turned", "IMU 1 is mounted otherwise", mounting={1: _QUARTER_TURN}),
        WiringFault("imu-4-upside-down", "IMU 4 is mounted otherwise", mounting={4: _UPSIDE_DOWN}),
        WiringFault(
            "angle-2-swapped",
            "the wires of joint 2's sensors are swapped (Teensy pins 20 and 21)",
            _swap("angle", 3, 4),
        ),
        WiringFault(
            "angle-1b-2a-swapped",
            "the wires of sensors 1b and 2a are swapped (Teensy pins 15 and 20)",
            _swap("angle", 2, 3),
        ),
        WiringFault(
            "angle-3b-cut", "angle sensor 3b (Teensy pin 23) follows no single joint", _cut("angle", 6)
        ),
        WiringFault(
            "angle-1a-turned-over",
            "angle sensor 1a (Teensy pin 14) counts the wrong way",
            lambda robot: robot.faults.connect("angle", 1, 2),
        ),
        WiringFault(
            "switches-swapped-at-sequencer",
            "switches 1 and 2 are swapped at the Micro (pins 4 and 13)",
            _swap("sequencer-switch", 1, 2),
        ),
        WiringFault(
            "switches-swapped-at-logger",
            "switches 1 and 2 are swapped at the Teensy (pins 2 and 3)",
            _swap("logger-switch", 1, 2),
        ),
        WiringFault(
            "switch-2-stuck", "switch 2 never opens", lambda robot: robot.faults.switch(2, "stuck-closed")
        ),
        WiringFault(
            "switch-1-cut", "switch 1 never closes", lambda robot: robot.faults.switch(1, "stuck-open")
        ),
        WiringFault(
            "switch-1-cut-at-logger",
            "switch 1 never closes at the Teensy: the wire to pin 2",
            _cut("logger-switch", 1),
        ),
        WiringFault(
            "switch-2-cut-at-sequencer",
            "switch 2 never closes at the Micro: the wire to pin 13",
            _cut("sequencer-switch", 2),
        ),
        WiringFault("stroke-line-cut", "Micro D12 does not reach Teensy pin 4", _cut("stroke-line", 1)),
        WiringFault(
            "servo-1-2-swapped", "the servo of joint 1 (Micro pin 9) moves joint 2", _swap("servo", 1, 2)
        ),
        WiringFault(
            "servo-3-unplugged", "the servo of joint 3 (Micro pin 11) does not move", _cut("servo", 3)
        ),
        WiringFault(
            "servo-1-reversed",
            "the servo of joint 1 (Micro pin 9) turns the wrong way",
            servos={1: "reversed"},
        ),
        WiringFault(
            "battery-weak",
            "Supply: 1 servo at once without a restart, the USB cable plugged; it restarted at 2",
            lambda robot: robot.faults.battery(WEAK_BATTERY_OHM),
        ),
        WiringFault("card-slow", "worst stall", lambda robot: robot.faults.card_stalls(700_000, 10_000_000)),
        WiringFault(
            "card-write-protected",
            "the card is write protected",
            lambda robot: robot.card_slot.spoil(CardDefect.WRITE_PROTECTED),
        ),
        WiringFault("clock-off", "Clock ratio", lambda robot: robot.faults.clock("sequencer", 2000.0)),
    )
}


@contextmanager
def emulate_faults(
    faults: Sequence[WiringFault], model: RobotModel, note: Callable[[str], None]
) -> Iterator[tuple[EmulatedRobot, Mapping[int, ServoFault]]]:
    """Yield a robot as built that is wired like this, and what is wrong with its servos once they have power.

    Raises BuildError.
    """
    imperfections = reduce(lambda before, fault: fault.mount(before), faults, draw_as_built(DEFAULT_SEED))
    with EmulatedRobot(model, imperfections=imperfections, progress=note) as robot:
        for fault in faults:
            fault.wire(robot)
        # Long enough for the logger to have looked at its card, and for IMUs that are silent to be known for it.
        robot.advance(START_US)
        yield robot, {joint: kind for fault in faults for joint, kind in fault.servos.items()}


FAULT: Columns = (Column("name", "fault"), Column("finding", "finding"))
"""Of a list of faults."""
