"""A design of joints that move together, beside what one joint at a time reaches and what the tower's limits cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.maneuver import Maneuver, Stroke
from tfsat_host.maneuver.schedule import STROKES
from tfsat_host.plan import maneuver_design
from tfsat_host.plan.checked_maneuver import CHECKED, CheckedManeuver, check_design
from tfsat_host.plan.design_result import CANDIDATE
from tfsat_host.plan.facility import load_tower
from tfsat_host.plan.loops import format_sequence
from tfsat_host.plan.maneuver_design import Candidate
from tfsat_host.plan.problem import DesignError, DesignSettings, Problem
from tfsat_host.plan.robust import Spread, Uncertain
from tfsat_host.plan.study import end_at_interrupt, usable_cores
from tfsat_host.plan.together import OverlappingStrokes
from tfsat_host.plan.tower_room import TowerRoom
from tfsat_host.quantity import Column, Columns, Table, columns_of, fields, vector
from tfsat_host.robot import RobotModel
from tfsat_host.worker_processes import worker_pool


@dataclass(frozen=True, eq=False)
class OverlappingManeuver:
    """A loop of strokes that may overlap, on the sequencer's grid.

    Attributes:
        alpha_deg: (d,) displacements of the joints that may move; negative where a joint moves out that way.
        strokes: In the order of their times.
        rotation_vector_deg: (3,) of the loop, base axes.
        duration_s: From the first stroke's start to the last arrival.
        spread: Of the reorientation over what the robot may be; None: not asked for.
    """

    alpha_deg: FloatArray
    strokes: tuple[Stroke, ...]
    rotation_vector_deg: FloatArray
    duration_s: float
    spread: Spread | None = None

    @property
    def reorientation_deg(self) -> float:
        """Length of the rotation vector."""
        return float(np.linalg.norm(self.rotation_vector_deg))


@dataclass(frozen=True, eq=False)
class TogetherProposal:
    """A designed maneuver of joints that move together, and what it is compared with.

    Attributes:
        asked_time_limit_s: What was asked for.
        problem: The same, but with no more time than the drop tower leaves.
        written: The maneuver within the drop tower's limits.
        optimum: The same for a robot as filed; None: `written` is.
        unlimited: What only time and the joints' ranges limit; None: there are no other limits.
        sequential: What one joint at a time reaches in the same time.
        sequential_spread: Its spread; None: not asked for.
        robust: K of mean less K standard deviations; 0: not asked for.
        checked: The written maneuver against sequencer and drop tower.
    """

    asked_time_limit_s: float
    problem: Problem
    written: OverlappingManeuver
    optimum: OverlappingManeuver | None
    unlimited: OverlappingManeuver | None
    sequential: Candidate
    sequential_spread: Spread | None
    robust: float
    checked: CheckedManeuver

    @property
    def gain_deg(self) -> float:
        """What moving together adds to the reorientation."""
        return self.written.reorientation_deg - self.sequential.reorientation_deg

    @property
    def cost_of_tower_deg(self) -> float | None:
        """What the drop tower's limits take from the reorientation; None: there are none."""
        if self.unlimited is None:
            return None
        return self.unlimited.reorientation_deg - (self.optimum or self.written).reorientation_deg


def propose_together(
    robot: RobotModel,
    settings: DesignSettings,
    path: Path,
    progress: Callable[[float], None] = lambda _done: None,
) -> TogetherProposal:
    """Search for the maneuver of joints that move together, which is to be written to `path`, and check it.

    `progress` is called with the share of the work that was done.

    Raises:
        DesignError: the settings do not fit the robot, or its file states no uncertainty for `settings.robust`.
    """
    room = _tower_room(robot)
    free = OverlappingStrokes(Problem.of(robot, settings))
    # All but the comparison without the tower is to be flown: its time is the tower's.
    if room is not None:
        settings = replace(settings, time_limit_s=min(settings.time_limit_s, room.max_moving_s))
    sequential = maneuver_design.design(robot, settings)
    problem = sequential.problem
    space, unlimited = free, None
    with worker_pool(usable_cores(), end_at_interrupt) as pool:
        summits = free.summits(settings.seed, (), lambda share: progress(0.4 * share), pool)
        if room is not None:
            unlimited = _maneuver(free, free.carry_to_grid(summits[0]))
            space = OverlappingStrokes(problem, room)
            # Summits without the tower's limits, in no more than its time, lead to the best of those within.
            if problem.time_limit_s < free.problem.time_limit_s:
                summits = OverlappingStrokes(problem).summits(settings.seed, summits, pool=pool)
            summits = space.summits(settings.seed, summits, lambda share: progress(0.6 * share), pool)
    written, optimum = _maneuver(space, space.carry_to_grid(summits[0])), None
    if sequential.robust is not None and robot.uncertainty is not None:
        uncertain = Uncertain(robot, robot.uncertainty)
        written, optimum = _most_robust(space, summits, uncertain, settings.robust)
    best_sequential = sequential.optimum if sequential.robust is None else sequential.robust.maneuver
    maneuver = Maneuver(
        written.strokes,
        speed_deg_s=round(math.degrees(problem.speed_rad_s), 9),
        name=f"designed: joints together for {robot.name}, {written.reorientation_deg:.3f} deg",
    )
    return TogetherProposal(
        free.problem.time_limit_s,
        problem,
        written,
        optimum,
        unlimited,
        sequential.round_candidate(best_sequential),
        None if sequential.robust is None else sequential.robust.spread,
        settings.robust,
        check_design(robot, maneuver, path),
    )


def _tower_room(robot: RobotModel) -> TowerRoom | None:
    """Without pulses the robot falls in no tower; without outlines its reach is unknown."""
    has_shapes = all(len(shape) for shape in robot.shape_m)
    return TowerRoom(robot, load_tower()) if robot.has_sequencer and has_shapes else None


def _most_robust(
    space: OverlappingStrokes, summits: Sequence[FloatArray], uncertain: Uncertain, k: float
) -> tuple[OverlappingManeuver, OverlappingManeuver]:
    """Return the maneuver of the greatest mean less K standard deviations, and the optimum, both with their spread."""

    def spread(candidate: FloatArray) -> Spread:
        return uncertain.spread_in_time(space.strokes(candidate), space.problem.speed_rad_s)

    def worth(candidates: FloatArray) -> FloatArray:
        return np.array([spread(candidate).less(k) for candidate in np.moveaxis(candidates, 2, 0)])

    # Climb on from the nominal summit that is worth most.
    start = max(summits, key=lambda summit: float(worth(space.candidates(summit[:, None]))[0]))
    best = space.carry_to_grid(space.climb(start, worth), worth)
    robust, optimum = (
        replace(_maneuver(space, candidate), spread=spread(candidate))
        for candidate in (best, space.carry_to_grid(summits[0]))
    )
    return robust, optimum


def _maneuver(space: OverlappingStrokes, candidate: FloatArray) -> OverlappingManeuver:
    turned, _ = space.fly(candidate[..., None])
    alpha_deg = np.round(np.degrees(candidate[0]), 2) + 0.0
    if not alpha_deg.any():
        raise DesignError(
            "time limit", "In the time that the sequencer's grid leaves no joint turns by 0.01 deg."
        )
    # From the first start to the last arrival of the joints that move.
    ends_s = candidate[2] + space.problem.stroke_s(np.abs(candidate[0]))
    moves = alpha_deg != 0.0
    return OverlappingManeuver(
        alpha_deg,
        tuple(
            Stroke(stroke.joint + 1, round(math.degrees(stroke.delta_rad), 2), round(stroke.start_s, 2))
            for stroke in space.strokes(candidate)
        ),
        np.degrees(turned[:, 0]),
        float(ends_s[moves].max() - candidate[1][moves].min()),
    )


_OVERLAPPING: Columns = (
    *fields("alpha_deg rotation_vector_deg reorientation_deg duration_s"),
    *fields("mean_deg=spread.mean_rad std_deg=spread.std_rad"),
    Column("strokes", columns=STROKES),
)


def _format_maneuver(proposal: TogetherProposal) -> str:
    joints = ", ".join(str(joint + 1) for joint in proposal.problem.joints)
    written, schedule = proposal.written, proposal.checked.schedule
    at_once = (
        ""
        if schedule is None
        else f", up to {schedule.moving_at_once} at once (servo settings: moving_at_once)"
    )
    return f"{vector(written.alpha_deg, form='.2f')} deg of joints {joints}{at_once}"


def _format_reorientation(proposal: TogetherProposal) -> str:
    written, is_shorter = proposal.written, proposal.problem.time_limit_s < proposal.asked_time_limit_s
    of_tower = f", the drop tower's; asked for: {proposal.asked_time_limit_s:g} s" if is_shorter else ""
    return (
        f"{written.reorientation_deg:.3f} deg in {written.duration_s:.4f} s "
        f"(time limit {proposal.problem.time_limit_s:g} s{of_tower})"
    )


def _format_sequential(proposal: TogetherProposal) -> str:
    sequential = proposal.sequential
    return (
        f"{sequential.reorientation_deg:.3f} deg in {sequential.duration_s:.4f} s, "
        f"{format_sequence(sequential.sequence)} (together: {proposal.gain_deg:+.3f} deg)"
    )


def _format_unlimited(proposal: TogetherProposal) -> str:
    if proposal.unlimited is None or proposal.cost_of_tower_deg is None:
        return ""
    return f"{proposal.unlimited.reorientation_deg:.3f} deg (the limits cost {proposal.cost_of_tower_deg:.3f} deg)"


def _format_robust(proposal: TogetherProposal) -> str:
    spreads = {
        "": proposal.written.spread,
        "; the optimum: ": None if proposal.optimum is None else proposal.optimum.spread,
        "; one joint at a time: ": proposal.sequential_spread,
    }
    return "".join(
        f"{words}{math.degrees(spread.mean_rad):.2f} ± {math.degrees(spread.std_rad):.2f} deg (less "
        f"{proposal.robust:g} ±: {math.degrees(spread.less(proposal.robust)):.2f} deg)"
        for words, spread in spreads.items()
        if spread is not None
    )


TOGETHER: Columns = (
    Column("", "Maneuver", words=_format_maneuver),
    Column("", "Reorientation", words=_format_reorientation),
    *columns_of("written", _OVERLAPPING),
    *fields("time_limit_s=problem.time_limit_s asked_time_limit_s"),
    Column("joints", of=lambda proposal: [joint + 1 for joint in proposal.problem.joints]),
    Column("sequential", "One joint at a time", words=_format_sequential, columns=CANDIDATE),
    *fields("gain_deg"),
    Column(
        "without_tower", "Without the tower", of="unlimited", words=_format_unlimited, columns=_OVERLAPPING
    ),
    *fields("cost_of_tower_deg"),
    Column("optimum", "With uncertainty", words=_format_robust, columns=_OVERLAPPING),
    *fields(
        "robust sequential_mean_deg=sequential_spread.mean_rad sequential_std_deg=sequential_spread.std_rad"
    ),
    *columns_of("checked", CHECKED),
)
"""A proposal as `tfsat-host design --together` shows it: all of it in `--json`, what has a label for people."""


def stroke_table(proposal: TogetherProposal) -> Table:
    """Return the strokes in the order of their times."""
    return Table("", STROKES, proposal.written.strokes)
