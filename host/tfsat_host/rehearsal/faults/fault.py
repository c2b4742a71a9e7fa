"""One fault of a rehearsed day: when it is injected, what it does, and what the robot must then do."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from zlib import crc32

import numpy as np

from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.quantity import Columns, fields
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.truth import Truth

AT = "@"
"""Between a fault's name and another moment than its own, as in gyro-dead@powered."""
OF = "="
"""Between a fault's name and another size than its own, as in wrong-masses=1.5."""
GUARD_US = 100_000
"""Before and after the landing."""


class Moment(Enum):
    """The moments of the day, in their order, each named after what has just been done or is just about to be."""

    POWERED = "boards have started"
    UPLOADED = "maneuver uploaded and read back"
    CHECKED = "preflight made"
    RECORDING = "recording, hanging in the releaser"
    ARMED = "armed"
    LIFTED = "cables pulled, on the crane's hook"
    RELEASE = "about to be let go"
    FALLING = "halfway through the fall"
    BEFORE_LANDING = "100 ms before the landing"
    LANDING = "landing"
    LANDED = "100 ms after the landing"

    @property
    def typed(self) -> str:
        """As people type it."""
        return self.name.lower().replace("_", "-")


BEFORE_PREFLIGHT = (Moment.POWERED, Moment.UPLOADED)
"""What is injected then is there when the preflight looks."""


def between(first: Moment, last: Moment) -> tuple[Moment, ...]:
    """Return all moments from `first` to `last`, both included."""
    moments = tuple(Moment)
    return moments[moments.index(first) : moments.index(last) + 1]


def words_of(moments: Collection[Moment]) -> str:
    """Format moments as people type them: `any moment`, `powered to armed`, or each by its name."""
    chosen = tuple(moment for moment in Moment if moment in moments)
    if chosen == tuple(Moment):
        return "any moment"
    if len(chosen) > 2 and chosen == between(chosen[0], chosen[-1]):
        return f"{chosen[0].typed} to {chosen[-1].typed}"
    return ", ".join(moment.typed for moment in chosen)


class Outcome(Enum):
    """What the robot must do in spite of a fault, or because of it."""

    FLIES = "flies the maneuver"
    STANDS_STILL = "moves no joint"
    STOPS = "stops at once and stays where it is"
    NOT_DROPPED = "is not dropped"


Outcomes = Mapping[Moment, Outcome]
"""What the robot must do, by the moment of the injection; at a moment that is missing the fault cannot be."""


def outcomes_between(first: Moment, last: Moment, outcome: Outcome) -> dict[Moment, Outcome]:
    """Map all moments from `first` to `last` to the same outcome."""
    return dict.fromkeys(between(first, last), outcome)


def at_any_moment(outcome: Outcome) -> dict[Moment, Outcome]:
    """Map every moment to the same outcome."""
    return dict.fromkeys(Moment, outcome)


def break_part(part: str, *how: object) -> Callable[[Day], object]:
    """Build an injection that calls a method of the emulated robot's `Faults` with these arguments."""
    return lambda day: getattr(day.robot.faults, part)(*how)


def _do_nothing(*_: object) -> None:
    """Inject nothing: the robot is so from the day's beginning."""


@dataclass(frozen=True, slots=True)
class Size:
    """How large a fault is; where several numbers go wrong, one standard deviation of each.

    Attributes:
        value: By default; 0: as if it were not there.
        unit: Of it.
        most: That makes sense.
    """

    value: float
    unit: str
    most: float

    def __str__(self) -> str:
        return f"{self.value:g} {self.unit}".rstrip()


@dataclass(frozen=True, eq=False)
class Fault:
    """See the module.

    Attributes:
        name: To type.
        what: What happens, a sentence that is true at every moment in `outcomes`.
        moment: When.
        outcomes: What the robot must then do, if a preflight does not keep it from being dropped.
        action: Injects it; with a size, given that and a generator of the day's seed, too.
        complete: The recording holds the whole drop; else it holds all that had reached the card.
        noticed: Words by which a refusal, the log or the report names it; empty: nothing is to be noticed.
        preflight: Checks of the preflight that find it if it is there before the preflight; empty: none can;
            None: it cannot be there then.
        part: What it is a fault of, which can have one at a time; empty: of nothing that another fault is of, too.
        size: How large it is; None: it just is.
        three_moving: What the robot must do, and the words that name it, where the maneuver moves three joints at once;
            None: the same as with any other.
        hidden: Makes the robot that flies, of another size than 0, with the same generator; None: it is as drawn.
    """

    name: str
    what: str
    moment: Moment
    outcomes: Outcomes
    action: Callable[..., object] = _do_nothing
    complete: bool = True
    noticed: str = ""
    preflight: tuple[str, ...] | None = None
    part: str = ""
    size: Size | None = None
    three_moving: tuple[Outcome, str] | None = None
    hidden: Callable[[Truth, float, np.random.Generator], Truth] | None = None

    @property
    def kind(self) -> str:
        """Its name without size and moment."""
        return self.name.partition(AT)[0].partition(OF)[0]

    @property
    def is_zero(self) -> bool:
        """Whether its size is 0: it changes nothing."""
        return self.size is not None and not self.size.value

    def with_moving(self, moving_at_once: int) -> Fault:
        """Return the fault in a maneuver that moves so many joints at once."""
        if self.three_moving is None or moving_at_once < JOINT_COUNT:
            return self
        outcome, noticed = self.three_moving
        return replace(self, outcomes=dict.fromkeys(self.outcomes, outcome), noticed=noticed)

    def inject(self, day: Day) -> None:
        """Inject the fault now."""
        if self.size is None:
            self.action(day)
        elif not self.is_zero:
            self.action(day, self.size.value, self._random(day.seed))

    def apply(self, truth: Truth) -> Truth:
        """Return the robot that flies instead of `truth` because of this fault."""
        if self.hidden is None or self.size is None or self.is_zero:
            return truth
        return self.hidden(truth, self.size.value, self._random(truth.seed))

    def _random(self, seed: int) -> np.random.Generator:
        """Return the fault's own random generator, from the seed and the fault's kind.

        Directions, signs and bodies are then the same whatever other faults there are.
        """
        # CRC-32 instead of hash(), which differs from process to process.
        return np.random.default_rng([seed, 13, crc32(self.kind.encode())])

    @property
    def outcome(self) -> Outcome:
        """What the robot must do with the fault at its moment."""
        return self.outcomes[self.moment]

    def at(self, moment: Moment) -> Fault:
        """Return the same fault at another moment, one in `outcomes`."""
        return replace(self, moment=moment, name=f"{self.name}{AT}{moment.typed}")

    def resize(self, size: Size) -> Fault:
        """Return the same fault with another size."""
        return replace(self, size=size, name=f"{self.name}{OF}{size.value:g}")


def mismatch(
    name: str,
    what: str,
    hidden: Callable[[Truth, float, np.random.Generator], Truth],
    size: Size,
    noticed: str = "",
) -> Fault:
    """Build a fault of the robot that flies: it is so from the day's beginning, and no preflight can find it."""
    outcomes = {Moment.POWERED: Outcome.FLIES}
    return Fault(
        name, what, Moment.POWERED, outcomes, noticed=noticed, preflight=(), size=size, hidden=hidden
    )


FAULT: Columns = fields("name what moment=moment.typed when=moment.value outcome=outcome.value")
"""Of a fault, for JSON."""
SIZE = fields("size=size.value unit=size.unit")
"""None of a fault that has no size."""
