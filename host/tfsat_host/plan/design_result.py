"""A design as the maneuver that is written: its checks by sequencer and drop tower, as JSON and for people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.checked_maneuver import (
    CHECKED,
    CheckedManeuver,
    check_design,
    flight_warnings,
    verdict_and_next_step,
)
from tfsat_host.plan.loops import format_sequence
from tfsat_host.plan.maneuver_design import Candidate, Design, Robust, scheduled_candidate
from tfsat_host.quantity import Column, Columns, Table, columns_of, fields, number, vector
from tfsat_host.robot import RobotModel

PAPER_ANGLES_DEG = (59.0, 70.0)
"""Of joints 1 and 2 in the paper's drop test, flown as +1 +2 -1 -2."""
_PAPER_SEQUENCE = (1, 2, -1, -2)


@dataclass(frozen=True, eq=False)
class Proposal:
    """A designed maneuver and what is known of flying it.

    Attributes:
        design: What was found.
        written: The choice as it is commanded.
        checked: Its maneuver, against sequencer and drop tower.
    """

    design: Design
    written: Candidate
    checked: CheckedManeuver


def propose(design: Design, robot: RobotModel, path: Path, *, swarm: bool) -> Proposal:
    """Propose the maneuver to fly, with the sequencer's verdict and the drop tower's checks.

    The choice is the optimum (the robust one if it was asked for), or the swarm's result if `swarm` is true.
    """
    best = design.optimum if design.robust is None else design.robust.maneuver
    chosen = design.swarm if swarm else best
    written = design.round_candidate(chosen)
    name = (
        f"designed: {format_sequence(written.sequence)} for {robot.name}, {written.reorientation_deg:.3f} deg"
    )
    return Proposal(design, written, check_design(robot, design.maneuver(chosen, name), path))


def paper_candidate(proposal: Proposal) -> Candidate | None:
    """Compute the paper's maneuver 59/70, if this robot could fly it but for the time limit that was asked for."""
    problem = proposal.design.problem
    displacements = np.zeros(len(problem.joints))
    displacements[:2] = np.radians(PAPER_ANGLES_DEG)
    is_possible = (
        proposal.checked.robot.has_sequencer
        and problem.joints[:2] == (0, 1)
        and bool((displacements <= problem.limit_rad).all())
    )
    paper = scheduled_candidate(problem, displacements, _PAPER_SEQUENCE) if is_possible else None
    return paper if paper is not None and paper.duration_s > problem.time_limit_s else None


CANDIDATE: Columns = (
    Column("alpha_deg", "displacements", form=".2f"),
    Column("sequence", "sequence", words=lambda candidate: format_sequence(candidate.sequence)),
    *fields("rotation_vector_deg"),
    Column("reorientation_deg", "turns"),
    Column("duration_s", "time", form=".4f"),
    Column("efficiency", "turn per travel", form=".4f"),
)
_SWARM: Columns = (
    *columns_of("swarm", CANDIDATE),
    Column("best_objective_deg", of=lambda design: np.degrees(design.search.best_values)),
    *fields("evaluations=search.evaluations"),
)
_OPTIMUM: Columns = (
    *columns_of("optimum", CANDIDATE),
    Column("gain_deg_per_s", of=lambda design: math.degrees(design.summit.gain_rad_s)),
    *fields("gradient_left_deg_per_deg=summit.residual summits_climbed=summits"),
)
_ROBUST: Columns = (
    *columns_of("maneuver", CANDIDATE),
    *fields("k mean_deg=spread.mean_rad std_deg=spread.std_rad"),
    *fields("optimum_mean_deg=of_optimum.mean_rad optimum_std_deg=of_optimum.std_rad"),
)


def _format_maneuver(proposal: Proposal) -> str:
    joints = ", ".join(str(joint + 1) for joint in proposal.design.problem.joints)
    written = proposal.written
    angles, sequence = vector(written.alpha_deg, form=".2f"), format_sequence(written.sequence)
    return f"{angles} deg of joints {joints}, in the order {sequence}"


def _format_swarm(design: Design) -> str:
    turned = f"{design.swarm.reorientation_deg:.3f} deg"
    if design.gap_deg is None:
        return f"{turned}, beyond the time limit"
    return f"{turned}, {design.gap_deg:.3f} deg behind the optimum"


def _format_gain(design: Design) -> str:
    """Format what 0.1 s more would give, to first order by the time limit's multiplier; empty: nothing."""
    gain_deg = 0.1 * math.degrees(design.summit.gain_rad_s)
    return f"{number(gain_deg, '+.2f')} deg" if gain_deg > 0.0 else ""


def _format_robust(robust: Robust | None) -> str:
    if robust is None:
        return ""
    robust_text, optimum_text = (
        f"{math.degrees(spread.mean_rad):.2f} ± {math.degrees(spread.std_rad):.2f} deg (less {robust.k:g} ±: "
        f"{math.degrees(spread.less(robust.k)):.2f} deg)"
        for spread in (robust.spread, robust.of_optimum)
    )
    return f"{robust_text}; the optimum: {optimum_text}"


PROPOSAL: Columns = (
    Column("", "Maneuver", words=_format_maneuver),
    Column(
        "",
        "Reorientation",
        words=lambda proposal: (
            f"{proposal.written.reorientation_deg:.3f} deg in {proposal.written.duration_s:.4f} s "
            f"(time limit {proposal.design.problem.time_limit_s:g} s)"
        ),
    ),
    *(replace(column, label="") for column in columns_of("written", CANDIDATE)),
    Column("joints", of=lambda proposal: [joint + 1 for joint in proposal.design.problem.joints]),
    Column(
        "swarm", "Swarm", of="design", words=lambda proposal: _format_swarm(proposal.design), columns=_SWARM
    ),
    Column(
        "optimum",
        "Gain of 0.1 s more",
        of="design",
        words=lambda proposal: _format_gain(proposal.design),
        columns=_OPTIMUM,
    ),
    *fields("swarm_behind_optimum_deg=design.gap_deg"),
    Column(
        "robust",
        "With uncertainty",
        of="design.robust",
        words=lambda proposal: _format_robust(proposal.design.robust),
        columns=_ROBUST,
    ),
    *columns_of("checked", CHECKED),
)
"""A proposal as `tfsat-host design` shows it: all of it in `--json`, what has a label as facts for people."""


@dataclass(frozen=True, slots=True)
class _Row:
    name: str
    candidate: Candidate


def candidate_table(proposal: Proposal) -> Table:
    """Return what was found, what is written, and the paper's maneuver where the time limit is too short for it."""
    design, paper = proposal.design, paper_candidate(proposal)
    candidates = {
        "swarm": design.swarm,
        "optimum": design.optimum,
        "robust": None if design.robust is None else design.robust.maneuver,
        "written": proposal.written,
        "paper's 59/70": paper,
    }
    rows = [_Row(name, found) for name, found in candidates.items() if found is not None]
    return Table("", (Column("name", "maneuver"), *columns_of("candidate", CANDIDATE)), rows)


def conclusions(proposal: Proposal, robot_option: tuple[str, ...]) -> Iterator[str]:
    """Yield why the paper's maneuver turns farther, the verdict, and the next command for the robot that was named."""
    paper, limit_s = paper_candidate(proposal), proposal.design.problem.time_limit_s
    if paper is not None and paper.reorientation_deg > proposal.written.reorientation_deg:
        longer_s = f"{math.ceil(1e3 * paper.duration_s) / 1e3:g}"
        yield Advice(
            f"The paper's 59/70 turns farther because it takes {longer_s} s; the time limit here is {limit_s:g} s. "
            "With as much time: ",
            NextStep("design", ("--time-limit", longer_s, *robot_option)),
        )
    yield from verdict_and_next_step(proposal.checked, robot_option)


def warnings(proposal: Proposal) -> Iterator[str]:
    """Yield warnings against flying the maneuver, one sentence each."""
    design = proposal.design
    if design.gap_deg is None:
        yield (
            f"The swarm takes {design.swarm.duration_s:.3f} s, longer than the time limit of "
            f"{design.problem.time_limit_s:g} s: its penalty is too small to keep it."
        )
    yield from flight_warnings(proposal.checked)
