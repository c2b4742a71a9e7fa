"""The hands of a person at an emulated robot: how steady they are, and what they can do."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.step import AXES, SWEEP_ROUNDS, SWEEP_STOPS_DEG, Axis
from tfsat_host.emulated.library import EmulationError, structures
from tfsat_host.protocol.limits import JOINT_COUNT

LEAD_S = 1.0
"""Each motion begins with so much rest."""


@dataclass(frozen=True, slots=True)
class Hands:
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
        """A person who takes care."""
        random = np.random.default_rng(seed)
        return cls(
            tremor_deg_s=random.uniform(1.0, 5.0),
            sway_deg_s=random.uniform(0.2, 1.0),
            reaction=random.uniform(0.0, 0.01),
            placing_deg=0.1,
            tilt_deg=0.1,
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
        hands: Whose tremor, sway and reaction it has; the legs have the rest.
        seed: Of this one motion's tremor and sway.
    """

    legs: tuple[Leg, ...]
    hands: Hands
    seed: int

    @property
    def duration_s(self) -> float:
        """Rests included."""
        return LEAD_S + sum(leg.duration_s + leg.rest_s for leg in self.legs)


class HandsOn:
    """A person's hands on the robot. Valid as long as the robot is.

    Held bodies are those that `EmulatedRobot.hold` named; that call also ends what hands do to them.
    """

    def __init__(self, library: ctypes.CDLL, robot: int) -> None:
        self._library = library
        self._robot = robot

    def move_joint(self, joint: int, motion: Motion) -> None:
        """Moves a limp joint (1 to 3) along the legs, while the other hand keeps the held bodies.

        Raises:
            EmulationError: its servo holds the joint, a leg ends outside its range, or the robot falls.
        """
        legs = _legs(motion.legs)
        config = _config(motion)
        moved = 1 <= joint <= JOINT_COUNT and self._library.tfsat_move_joint(
            self._robot, ctypes.byref(config), joint - 1, legs, len(legs)
        )
        if not moved:
            raise EmulationError(
                what=f"Joint {joint} cannot be moved by hand.",
                meaning="Its servo holds it, it would leave its range, the robot falls, or there is no such joint.",
                next_step="Disarm the sequencer first, or move it less.",
            )

    def turn(self, axis: FloatArray, motion: Motion) -> None:
        """Turns the held bodies as one.

        Args:
            axis: (3,) unit vector in the frame of the first held body, about whose origin it turns.
            motion: The legs' angles are about `axis`.
        """
        legs = _legs(motion.legs)
        config = _config(motion)
        self._library.tfsat_turn(
            self._robot, ctypes.byref(config), (ctypes.c_double * 3)(*axis.tolist()), legs, len(legs)
        )

    def hold_against(self, joint: int, motion: Motion) -> None:
        """Keeps the held bodies in the hands while the servo of a joint (1 to 3) moves, until the next `hold`."""
        config = _config(motion)
        self._library.tfsat_hold_against(self._robot, ctypes.byref(config), joint - 1)

    def close_joint(self, joint: int) -> None:
        """Puts a limp joint (1 to 3) at angle 0, as the holding attachment does. Takes no time.

        Raises:
            EmulationError: its servo holds the joint, 0 is outside its range, or the robot falls.
        """
        if not (1 <= joint <= JOINT_COUNT and self._library.tfsat_set_joint(self._robot, joint - 1, 0.0)):
            raise EmulationError(
                what=f"Joint {joint} cannot be closed by hand.",
                meaning="Its servo holds it, 0 deg is outside its range, the robot falls, or there is no such joint.",
                next_step="Disarm the sequencer first.",
            )


def _legs(legs: Sequence[Leg]) -> Any:
    leg = structures()["TfsatLeg"]
    return (leg * len(legs))(*(leg(one.target_rad, one.duration_s, one.rest_s) for one in legs))


def _config(motion: Motion) -> Any:
    hands = motion.hands
    return structures()["TfsatHands"](
        seed=motion.seed,
        lead_s=LEAD_S,
        tremor_rad_s=np.deg2rad(hands.tremor_deg_s),
        sway_rad_s=np.deg2rad(hands.sway_deg_s),
        reaction=hands.reaction,
    )


SWING_DEG = 60.0
SWING_PERIOD_S = 2.0
SWING_CYCLES = 5
SWEEP_LEG_S = 1.5
SWEEP_REST_S = 1.0
TURN_RATE_DEG_S = 90.0
SHORTEST_TURN_S = 2.0
TURN_REST_S = 1.2
TAIL_S = 1.0
"""Each motion ends with so much rest more."""


def swing_motion(
    start_rad: float, range_rad: FloatArray, hands: Hands, random: np.random.Generator
) -> Motion:
    """Out and back, `SWING_CYCLES` times; comes back to within `hands.stopping_deg`, at last to where it began.

    Args:
        start_rad: The joint's angle now.
        range_rad: (2,) its least and greatest angle.
        hands: Whose.
        random: Draws what the hands vary.
    """
    amplitude = np.deg2rad(SWING_DEG) * (1 + hands.variation * random.standard_normal(SWING_CYCLES))
    short = _stops(np.full(SWING_CYCLES, start_rad), range_rad, hands, random)
    short[-1] = start_rad
    targets = np.column_stack([np.clip(start_rad + amplitude, *range_rad), short]).ravel()
    return _motion(targets, SWING_PERIOD_S / 2, 0.0, hands, random)


def sweep_motion(range_rad: FloatArray, hands: Hands, random: np.random.Generator) -> Motion:
    """From where the joint is, taken for the first of them, through `SWEEP_STOPS_DEG`, `SWEEP_ROUNDS` times.

    Args:
        range_rad: (2,) the joint's least and greatest angle; stops outside are taken as its ends.
        hands: Whose.
        random: Draws what the hands vary.
    """
    rounds = np.tile(np.deg2rad(SWEEP_STOPS_DEG[1:]), SWEEP_ROUNDS)
    return _motion(_stops(rounds, range_rad, hands, random), SWEEP_LEG_S, SWEEP_REST_S, hands, random)


def turn_motion(angle_deg: float, rounds: int, hands: Hands, random: np.random.Generator) -> Motion:
    """There and back `rounds` times. Where it lies before is as badly placed as where it comes to lie."""
    nominal = np.deg2rad(np.tile([angle_deg, 0.0], rounds))
    placing = np.deg2rad(hands.placing_deg) * random.standard_normal(2 * rounds + 1)
    return _motion(nominal + placing[1:] - placing[0], turn_leg_s(angle_deg), TURN_REST_S, hands, random)


def turn_leg_s(angle_deg: float) -> float:
    """How long a turn takes one way, at nominal pace."""
    return max(SHORTEST_TURN_S, abs(angle_deg) / TURN_RATE_DEG_S)


def turn_axis(axis: Axis, hands: Hands, random: np.random.Generator) -> FloatArray:
    """(3,) the body axis as it was meant, tilted by a hand: unit vector in body axes."""
    meant = np.eye(3)[AXES.index(axis)]
    tilt = np.deg2rad(hands.tilt_deg) / np.sqrt(2) * random.standard_normal(3)
    tilted = meant + np.where(meant == 0.0, tilt, 0.0)
    return np.asarray(tilted / np.linalg.norm(tilted))


def servo_motion(hands: Hands, random: np.random.Generator) -> Motion:
    """None of its own: the servo moves, the hands hold."""
    return Motion((), hands, _seed(random))


def _stops(
    nominal_rad: FloatArray, range_rad: FloatArray, hands: Hands, random: np.random.Generator
) -> FloatArray:
    off = np.deg2rad(hands.stopping_deg) * random.uniform(-1, 1, len(nominal_rad))
    least, most = range_rad
    stops = np.clip(nominal_rad, least, most) + off
    # What would be beyond a mechanical stop lies as far before it: people do not lean on it each time.
    inside: FloatArray = np.clip(most - np.abs(most - (least + np.abs(stops - least))), least, most)
    return inside


def _motion(
    targets_rad: FloatArray, leg_s: float, rest_s: float, hands: Hands, random: np.random.Generator
) -> Motion:
    """Legs that vary in duration and together take as long as nominal ones at this pace, and `TAIL_S`."""
    n_legs = len(targets_rad)
    share = np.clip(1 + hands.variation * random.standard_normal(n_legs), 0.5, 1.5)
    durations_s = leg_s * hands.pace * n_legs * share / share.sum()
    rests_s = np.full(n_legs, rest_s * hands.pace)
    rests_s[-1] += TAIL_S
    columns = (targets_rad.tolist(), durations_s.tolist(), rests_s.tolist())
    return Motion(tuple(Leg(*row) for row in zip(*columns, strict=True)), hands, _seed(random))


def _seed(random: np.random.Generator) -> int:
    return int(random.integers(2**63))
