"""How steady an operator of an emulated robot is, and what is done to the robot by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.library import EmulationError, interface, vector
from tfsat_host.protocol.limits import JOINT_COUNT

LEAD_S = 1.0
"""Each motion begins with so much rest."""


@dataclass(frozen=True, slots=True)
class Operator:
    """How far one person's motions are from a machine's. The defaults are a machine's.

    Attributes:
        tremor_deg_s: Root mean square rate that a moved joint has on top of its path, 2 to 8 Hz.
        sway_deg_s: Root mean square rate about each axis of bodies that are held while something moves,
            0.3 to 6 Hz.
        reaction: Held bodies turn by this fraction of the angle by which the joint moves: a hand gives way.
        placing_deg: Standard deviation of the angle at which a turned robot comes to lie against its edge.
        tilt_deg: Root mean square angle between the axis that the robot is turned about and its body axis.
        variation: Relative standard deviation of each swing's amplitude and of each motion's duration.
        stopping_deg: A sweep stops within this of where it should.
        pace: 1 is nominal; a larger one is slower.
        seed: For all of it.
    """

    tremor_deg_s: float = 0.0
    sway_deg_s: float = 0.0
    reaction: float = 0.0
    placing_deg: float = 0.0
    tilt_deg: float = 0.0
    variation: float = 0.0
    stopping_deg: float = 0.0
    pace: float = 1.0
    seed: int = 1

    @classmethod
    def steady(cls) -> Self:
        """Exact, as no person is."""
        return cls()

    @classmethod
    def human(cls, seed: int) -> Self:
        """Draw a careful human operator with tremor, sway and reaction, from a seed."""
        random = np.random.default_rng(seed)
        return cls(
            tremor_deg_s=random.uniform(1.0, 5.0),
            sway_deg_s=random.uniform(0.2, 1.0),
            reaction=random.uniform(0.0, 0.01),
            placing_deg=0.1,
            tilt_deg=0.28,
            variation=0.04,
            stopping_deg=3.0,
            pace=random.uniform(0.8, 1.5),
            seed=seed,
        )


@dataclass(frozen=True, slots=True)
class Leg:
    """From where the last leg ended to an angle, with neither speed nor acceleration at the ends, and a rest.

    Attributes:
        target_rad: A joint's angle; of a turn, the angle from where it began.
        duration_s: Of the way, more than 0.
        rest_s: At the target. At 0 the next leg follows at once.
    """

    target_rad: float
    duration_s: float
    rest_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Motion:
    """What one hand does, after `LEAD_S` of rest.

    Attributes:
        legs: One after the other.
        operator: Whose tremor, sway and reaction it has; the legs have the rest.
        seed: Of this one motion's tremor and sway.
    """

    legs: tuple[Leg, ...]
    operator: Operator
    seed: int

    @property
    def duration_s(self) -> float:
        """Rests included."""
        return LEAD_S + sum(leg.duration_s + leg.rest_s for leg in self.legs)


class OperatorMotion:
    """What an operator does to the robot by hand. Valid as long as the robot is.

    Held bodies are those that `EmulatedRobot.hold` named; that call also ends what the operator does to them.
    """

    def __init__(self, library: Any, robot: Any) -> None:
        self._library = library
        self._robot = robot

    def move_joint(self, joint: int, motion: Motion) -> None:
        """Moves a limp joint (1 to 3) along the legs, while the other hand keeps the held bodies.

        Raises:
            EmulationError: its servo holds the joint, a leg ends outside its range, or the robot falls.
        """
        legs = _legs(motion)
        # The library decides, for it knows servos and stops, and answers 0 without having moved anything.
        moved = 1 <= joint <= JOINT_COUNT and self._library.tfsat_move_joint(
            self._robot, _hands(motion), joint - 1, legs, len(legs)
        )
        if not moved:
            raise EmulationError(
                what=f"Joint {joint} cannot be moved by hand.",
                meaning="Its servo holds it, it would leave its range, the robot falls, or there is no such joint.",
                next_step="Disarm the sequencer first, or move it less.",
            )

    def turn(self, axis: FloatArray, motion: Motion) -> None:
        """Turns the held bodies as one, by the legs' angles about `axis` (3,).

        It is a unit vector in the frame of the first held body, about whose origin it turns.
        """
        legs = _legs(motion)
        self._library.tfsat_turn(self._robot, _hands(motion), vector(axis), legs, len(legs))

    def hold_against(self, joint: int, motion: Motion) -> None:
        """Keeps the held bodies in hand while the servo of a joint (1 to 3) moves, until the next `hold`."""
        self._library.tfsat_hold_against(self._robot, _hands(motion), joint - 1)

    def put_joint(self, joint: int, angle_rad: float = 0.0) -> None:
        """Puts a limp joint (1 to 3) at an angle, 0 as the holding attachment does. Takes no time.

        Raises:
            EmulationError: its servo holds the joint, the angle is outside its range, or the robot falls.
        """
        if not (
            1 <= joint <= JOINT_COUNT and self._library.tfsat_set_joint(self._robot, joint - 1, angle_rad)
        ):
            angle = f"{math.degrees(angle_rad):g} deg"
            raise EmulationError(
                what=f"Joint {joint} cannot be put at {angle} by hand.",
                meaning=f"Its servo holds it, {angle} is outside its range, the robot falls, or no such joint exists.",
                next_step="Disarm the sequencer first.",
            )


def _legs(motion: Motion) -> Any:
    """Return the motion's legs as a C array."""
    legs = [(leg.target_rad, leg.duration_s, leg.rest_s) for leg in motion.legs]
    return interface().new("TfsatLeg[]", legs)


def _hands(motion: Motion) -> Any:
    """Return the motion's unsteadiness as the library's structure."""
    operator = motion.operator
    hands = {
        "seed": motion.seed,
        "lead_s": LEAD_S,
        "tremor_rad_s": math.radians(operator.tremor_deg_s),
        "sway_rad_s": math.radians(operator.sway_deg_s),
        "reaction": operator.reaction,
    }
    return interface().new("TfsatHands*", hands)
