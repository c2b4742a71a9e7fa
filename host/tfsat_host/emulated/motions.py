"""The motions of a calibration as a person's hands make them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.steps.step import AXES, SWEEP_ROUNDS, SWEEP_STOPS_DEG, Axis
from tfsat_host.emulated.hands import Hands, Leg, Motion

FloatArray = NDArray[np.float64]

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
