"""What the output pins did: pulses, gaps, strokes. Time is in cycles of the CPU's clock, 1/16 us."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from tests.validation.campaign import Broken
from tests.validation.tables import cell
from tfsat_host.protocol.limits import JOINT_COUNT, SERVO_PULSE_MAX_US, SERVO_PULSE_MIN_US

CYCLES_PER_US = 16
CYCLES_PER_MS = 1000 * CYCLES_PER_US
CYCLES_PER_TICK = 8
STROKE_LINE = 3


class PinEdge(NamedTuple):
    """A change of an output pin: 0 to 2 are the servos, 3 is the stroke line."""

    cycle: int
    pin: int
    high: bool


class Pulse(NamedTuple):
    """One servo pulse."""

    rise: int
    width: int


class Onset(NamedTuple):
    """The rise of the first pulse of a new width."""

    cycle: int
    joint: int
    width: int


class Extremes(NamedTuple):
    """The least and the greatest of some numbers."""

    least: float
    greatest: float

    def __str__(self) -> str:
        return f"{cell(self.least)} to {cell(self.greatest)}"

    @classmethod
    def of(cls, values: Iterable[float], unit: float = 1) -> Extremes:
        """Return the extremes of `values`, in multiples of `unit`."""
        numbers = list(values)
        return cls(min(numbers) / unit, max(numbers) / unit)


@dataclass(frozen=True, slots=True)
class Signal:
    """The three servo signals from one edge list."""

    trains: tuple[tuple[Pulse, ...], ...]

    @property
    def onsets(self) -> list[Onset]:
        """In order of time."""
        onsets = [
            Onset(after.rise, joint, after.width)
            for joint, train in enumerate(self.trains, start=1)
            for before, after in pairwise(train)
            if after.width != before.width
        ]
        return sorted(onsets)

    @property
    def widths(self) -> Extremes:
        return Extremes.of(pulse.width for train in self.trains for pulse in train)

    @property
    def gaps(self) -> Extremes:
        """From rise to rise of the same servo."""
        return Extremes.of(
            after.rise - before.rise for train in self.trains for before, after in pairwise(train)
        )

    def check_widths(self) -> None:
        """Raises Broken where a pulse leaves what a servo can take."""
        widths = self.widths
        if widths.least < SERVO_PULSE_MIN_US * CYCLES_PER_US:
            raise Broken(f"a pulse of {widths.least / CYCLES_PER_US} us")
        if widths.greatest > SERVO_PULSE_MAX_US * CYCLES_PER_US:
            raise Broken(f"a pulse of {widths.greatest / CYCLES_PER_US} us")


def whole_pulses(edges: Iterable[PinEdge], pin: int) -> list[Pulse]:
    """Return the ended pulses of one pin, from its first rise on."""
    pulses: list[Pulse] = []
    rise: int | None = None
    for edge in edges:
        if edge.pin != pin:
            continue
        if rise is not None and not edge.high:
            pulses.append(Pulse(rise, edge.cycle - rise))
        rise = edge.cycle if edge.high else None
    return pulses


def read_signal(edges: Iterable[PinEdge]) -> Signal:
    """Read the complete pulses of all servos.

    Raises Broken where a pin's edges do not alternate, or a servo has no pulse.
    """
    trains: list[list[Pulse]] = [[] for _ in range(JOINT_COUNT)]
    rises: list[int | None] = [None] * JOINT_COUNT
    for cycle, pin, high in edges:
        if pin >= JOINT_COUNT:
            continue
        rise = rises[pin]
        if high != (rise is None):
            raise Broken(f"two edges of the same kind on servo {pin + 1} at cycle {cycle}")
        if rise is not None:
            trains[pin].append(Pulse(rise, cycle - rise))
        rises[pin] = cycle if high else None
    if not all(trains):
        raise Broken(f"no pulses on servo {trains.index([]) + 1}")
    return Signal(tuple(map(tuple, trains)))
