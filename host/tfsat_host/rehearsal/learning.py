"""Which maneuver tells most of a robot: by the information of the evaluation's own fit, in emulated drops.

Each candidate is flown by the emulated robot as its file has it, recorded by the logger's firmware and evaluated. What
the fit then knows of the wanted numbers, all others uncertain as the file says, is compared: the root mean square of
their standard deviations (A-optimality). Two drops add their information.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.errors import UsageError
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, linearize
from tfsat_host.evaluation.com_fit.offsets import Offsets
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.maneuver import Maneuver, ManeuverError, Schedule, four_stroke, schedule_maneuver
from tfsat_host.plan.loops import Sequence as Loop
from tfsat_host.plan.loops import classes, format_sequence
from tfsat_host.plan.maneuver_design import maneuver_of
from tfsat_host.plan.problem import DesignSettings, Problem
from tfsat_host.plan.study import end_at_interrupt, usable_cores
from tfsat_host.protocol.limits import FALL_US, PAUSE_MIN_US, SCHEDULE_GRID_US
from tfsat_host.rehearsal.hidden import hidden_drop
from tfsat_host.rehearsal.truth import truth_as_filed
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import fill_places
from tfsat_host.worker_processes import worker_pool

WANTED = ("com", "masses", "inertias", "hinge-points")
"""What can be learnt: the centers of mass of bodies 1 to 3, and all numbers of a kind."""
USUAL = ("59/70", replace(four_stroke(59.0, 70.0), name="to learn: 59/70"))
"""The paper's maneuver, which others are compared with."""
_KINDS = {"masses": "mass", "inertias": "inertia", "hinge-points": "point"}
_SHARES = {2: ((0.5, 0.5), (0.4, 0.6), (0.6, 0.4)), 3: ((1 / 3, 1 / 3, 1 / 3), (0.4, 0.4, 0.2))}
"""Of the travel that the time allows, for loops of two and of three joints."""
_MAX_STROKES = 6
_SEED = 1


@dataclass(frozen=True, eq=False)
class Lesson:
    """What one maneuver tells.

    Attributes:
        name: Of the maneuver.
        maneuver: Itself.
        fit: Of its drop.
    """

    name: str
    maneuver: Maneuver
    fit: ModelFit


@dataclass(frozen=True, eq=False)
class Learnt:
    """The search.

    Attributes:
        wanted: One of `WANTED`.
        names: k names of its numbers.
        unit: Of their standard deviations.
        usual: What 59/70 tells.
        lessons: All candidates, the one that tells most first.
        pair: The two that tell most together, of which one may be flown twice.
    """

    wanted: str
    names: tuple[str, ...]
    unit: str
    usual: Lesson
    lessons: tuple[Lesson, ...]
    pair: tuple[Lesson, Lesson]

    def std(self, *lessons: Lesson) -> FloatArray:
        """(k,) of the wanted numbers after drops with these maneuvers."""
        return _std([lesson.fit for lesson in lessons], self.wanted)

    def rms(self, *lessons: Lesson) -> float:
        """Root mean square of that."""
        return float(np.sqrt(np.mean(self.std(*lessons) ** 2)))


def learn(
    robot: RobotModel, quantity: str, progress: Callable[[float], None] = lambda _share: None
) -> Learnt:
    """Flies and compares; about a minute on two cores.

    The robot has IMUs, servos and pulses, as the boards fly it; `quantity` is one of `WANTED`. `progress` is
    called with the share of the work that was done.

    Raises:
        UsageError: the robot is none that the boards fly, or its file takes what is wanted for exact.
    """
    if not robot.has_sequencer:
        raise _refusal(
            f"{robot.path} is no robot that both boards fly.", "Give the file of the robot that is dropped."
        )
    robot = fill_places(robot)
    candidates = [USUAL, *_candidates(robot)]
    lessons = []
    # The order of candidates is kept, whichever process is done first: the usual maneuver stays in front.
    with worker_pool(usable_cores(), end_at_interrupt) as pool:
        fits = pool.map(partial(_fit_of, robot), [schedule_maneuver(maneuver) for _, maneuver in candidates])
        for (name, maneuver), fit in zip(candidates, fits, strict=True):
            lessons.append(Lesson(name, maneuver, fit))
            progress(1.0 / len(candidates))
    usual, offsets = lessons[0], lessons[0].fit.offsets
    rows = _rows(offsets, quantity)
    if not len(rows):
        raise _refusal(
            f"{robot.path} takes the {quantity} for exact.", "State their [uncertainty], or want another one."
        )
    # A-optimality: the smallest trace of the wanted part of the covariance.
    ranked = sorted(lessons, key=lambda lesson: float(np.sum(_std([lesson.fit], quantity) ** 2)))
    # With replacement: to fly one maneuver twice may tell more than two different ones.
    pairs = itertools.combinations_with_replacement(ranked, 2)
    pair = min(pairs, key=lambda two: float(np.sum(_std([lesson.fit for lesson in two], quantity) ** 2)))
    names = tuple(offsets.names[k] for k in rows)
    return Learnt(quantity, names, offsets.units[rows[0]], usual, tuple(ranked), pair)


def _fit_of(robot: RobotModel, schedule: Schedule) -> ModelFit:
    drop = hidden_drop(schedule, robot, truth_as_filed(robot, _SEED))
    fit = evaluate(drop.log, robot, drop.calibration, schedule).explained.fit
    # Drops that are added up are linearized at the same offsets: see `fit_jointly`.
    as_filed = fit.equations.place_at(np.zeros(len(fit.offsets)))
    return replace(fit, equations=linearize(fit.offsets, fit.flown, as_filed, fit.widening))


def _rows(offsets: Offsets, quantity: str) -> list[int]:
    if quantity == "com":
        return list(range(offsets.sought))
    return [k for k, kind in enumerate(offsets.kinds) if kind == _KINDS[quantity]]


def _std(fits: Sequence[ModelFit], quantity: str) -> FloatArray:
    """(k,) by the information of all drops and the priors, which count once."""
    offsets = fits[0].offsets
    # Information of independent drops adds up; the prior is the same knowledge in all and counts once.
    information = np.diag(offsets.prior_std**-2.0) + sum(fit.information for fit in fits)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))[_rows(offsets, quantity)]))


def _candidates(robot: RobotModel) -> Iterator[tuple[str, Maneuver]]:
    """Closed loops of two and of three joints that use the time of the fall, as far as the sequencer takes them."""
    # What the fall leaves after the pause, less the grid that each stroke's start may be rounded up by.
    room_s = (FALL_US - PAUSE_MIN_US - _MAX_STROKES * SCHEDULE_GRID_US) / 1e6
    joints = range(robot.n_joints)
    for count, shares in _SHARES.items():
        for moving in itertools.combinations(joints, count):
            problem = Problem.of(robot, DesignSettings(joints=moving, time_limit_s=room_s))
            for loop, share in itertools.product(_loops(count), shares):
                try:
                    maneuver = _maneuver(problem, loop, np.array(share))
                    schedule_maneuver(maneuver)
                except ManeuverError:
                    continue
                yield maneuver.name, maneuver


def _loops(joints: int) -> tuple[Loop, ...]:
    return ((1, 2, -1, -2), (2, 1, -2, -1)) if joints == 2 else classes(joints)


def _maneuver(problem: Problem, loop: Loop, share: FloatArray) -> Maneuver:
    # Each joint goes out and back, so half the time is for its way out, within its range.
    far = np.minimum(share * problem.farthest_rad(0.5 * problem.time_limit_s), problem.limit_rad)
    alpha_deg = problem.commanded_deg(np.degrees(problem.within_time(far)))
    joints = tuple(
        # A loop numbers the joints that move, signed by their sense: give them the robot's numbers.
        int(math.copysign(problem.joints[abs(signed_joint) - 1] + 1, signed_joint))
        for signed_joint in loop
    )
    sizes = "/".join(f"{size_deg:.0f}" for size_deg in alpha_deg)
    return maneuver_of(problem, joints, alpha_deg, f"to learn: {format_sequence(joints)} by {sizes}")


def _refusal(what: str, cure: str) -> UsageError:
    return UsageError(what=what, meaning="Nothing was designed.", next_step=cure)
