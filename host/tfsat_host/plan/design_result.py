"""A design as the maneuver that is written: its checks by sequencer and drop tower, as a document and for people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from tfsat_host.maneuver import Maneuver, ManeuverError, Schedule, schedule_maneuver
from tfsat_host.maneuver.schedule import servo_speed_notices
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.facility import load_tower
from tfsat_host.plan.loops import format_sequence
from tfsat_host.plan.maneuver_design import Candidate, Design, Robust
from tfsat_host.plan.reach_envelope import EnvelopeError, envelope_of
from tfsat_host.plan.tower_checks import Check, check_maneuver
from tfsat_host.quantity import Column, Table, vector
from tfsat_host.robot import RobotModel


@dataclass(frozen=True, eq=False)
class Proposal:
    """A designed maneuver and what is known of flying it.

    Attributes:
        flown: As it is commanded.
        maneuver: To be written.
        schedule: Its times; None if no sequencer commands the robot, or it would refuse.
        refusal: Why it would.
        checks: Against the drop tower; none without a schedule.
        notices: What else a person should know.
    """

    flown: Candidate
    maneuver: Maneuver
    schedule: Schedule | None = None
    refusal: str = ""
    checks: tuple[Check, ...] = ()
    notices: tuple[str, ...] = ()

    @property
    def failed(self) -> list[Check]:
        """The checks that did not pass."""
        return [check for check in self.checks if not check.passed]


def propose(design: Design, robot: RobotModel, *, swarm: bool) -> Proposal:
    """Propose the maneuver to fly, with the sequencer's verdict and the drop tower's checks.

    The choice is the optimum (the robust one if it was asked for), or the swarm's result if `swarm` is true.
    """
    best = design.optimum if design.robust is None else design.robust.maneuver
    chosen = design.swarm if swarm else best
    candidate = design.round_candidate(chosen)
    name = f"designed: {format_sequence(candidate.sequence)} for {robot.name}, {candidate.reorientation_deg:.3f} deg"
    proposal = Proposal(candidate, design.maneuver(chosen, name))
    # Without pulses in the robot file no board flies it: neither sequencer nor drop tower matters.
    if not robot.has_sequencer:
        return proposal
    try:
        schedule = schedule_maneuver(proposal.maneuver)
    except ManeuverError as error:
        # A refused design is still shown and written, with the reason.
        return replace(proposal, refusal=error.what)
    proposal = replace(proposal, schedule=schedule, notices=servo_speed_notices(schedule, robot.path))
    tower = load_tower()
    try:
        envelope = envelope_of(robot, schedule, until_s=tower.fall_s)
    except EnvelopeError as error:
        # Without outlines the reach is unknown: that is a notice, not a failed check.
        return replace(
            proposal, notices=(*proposal.notices, f"Not checked against the drop tower: {error.what}")
        )
    return replace(proposal, checks=check_maneuver(schedule, robot, tower, envelope))


def document(design: Design, proposal: Proposal, path: Path) -> dict[str, Any]:
    """Build the `--json` document: the maneuver as written, then swarm and optimum as found."""
    schedule = proposal.schedule
    return {
        **asdict(proposal.flown),
        "joints": [joint + 1 for joint in design.problem.joints],
        "swarm": {
            **asdict(design.swarm),
            "best_objective_deg": [math.degrees(value) for value in design.search.best_values],
            "evaluations": design.search.evaluations,
        },
        "optimum": {
            **asdict(design.optimum),
            "gain_deg_per_s": math.degrees(design.summit.gain_rad_s),
            "gradient_left_deg_per_deg": design.summit.residual,
            "summits_climbed": design.summits,
        },
        "swarm_behind_optimum_deg": design.gap_deg,
        "robust": None if design.robust is None else _robust(design.robust),
        "file": path,
        "schedule": None if schedule is None else schedule.as_rows(),
        "end_s": None if schedule is None else schedule.end_s,
        "sequencer_refuses": proposal.refusal or None,
        "checks": [asdict(check) for check in proposal.checks],
        "notices": list(proposal.notices),
    }


def lines(design: Design, proposal: Proposal, path: Path, robot_option: str) -> Iterator[str | Table]:
    """Yield the report for people: swarm, optimum, the written maneuver, its checks and the next command."""
    robust = [] if design.robust is None else [("robust", design.robust.maneuver)]
    rows = [
        {**asdict(candidate), "who": who, "sequence": format_sequence(candidate.sequence)}
        for who, candidate in (
            ("swarm", design.swarm),
            ("optimum", design.optimum),
            *robust,
            ("written", proposal.flown),
        )
    ]
    columns = (
        Column("who", " "),
        Column(
            "alpha_deg", f"joints {', '.join(str(joint + 1) for joint in design.problem.joints)}", form=".2f"
        ),
        Column("sequence", "sequence"),
        Column("reorientation_deg", "turns"),
        Column("duration_s", "time", form=".4f"),
        Column("efficiency", "turn per travel", form=".4f"),
    )
    yield Table("", columns, rows)
    yield f"Rotation vector of what was written: {vector(proposal.flown.rotation_vector_deg)} deg."
    if design.gap_deg is not None:
        # The time limit's multiplier, degrees a second, to first order.
        gain = 0.1 * math.degrees(design.summit.gain_rad_s)
        gain_text = f"; 0.1 s more would give {gain:.2f} deg more" if gain > 0.0 else ""
        yield f"The swarm stays {design.gap_deg:.3f} deg behind the optimum{gain_text}."
    if design.robust is not None:
        yield _robust_words(design.robust)
    named = f"--file {path}{robot_option}"
    if proposal.checks and not proposal.failed:
        yield f"It fits the drop tower: all {len(proposal.checks)} checks passed (tfsat-host envelope {named})."
    if proposal.schedule is None:
        yield f"Written to {path}."
        yield f"Next: tfsat-host simulate {named}"
        return
    yield f"Written to {path}; ends {proposal.schedule.end_s:.2f} s after release."
    if proposal.failed:
        yield "Do not fly it: design with a shorter --time-limit, smaller --limit or a true --speed."
    else:
        yield Advice("Next: ", NextStep("upload-sequence", ("--file", str(path))))


def _robust(robust: Robust) -> dict[str, Any]:
    spreads = {"": robust.spread, "optimum_": robust.of_optimum}
    return {
        **asdict(robust.maneuver),
        "k": robust.k,
        **{f"{who}mean_deg": math.degrees(spread.mean_rad) for who, spread in spreads.items()},
        **{f"{who}std_deg": math.degrees(spread.std_rad) for who, spread in spreads.items()},
    }


def _robust_words(robust: Robust) -> str:
    robust_text, plain = (
        f"{math.degrees(spread.mean_rad):.2f} ± {math.degrees(spread.std_rad):.2f} deg, less {robust.k:g} ±: "
        f"{math.degrees(spread.less(robust.k)):.2f} deg"
        for spread in (robust.spread, robust.of_optimum)
    )
    return f"With the robot file's uncertainty the robust maneuver turns by {robust_text}; the optimum by {plain}."


def warnings(design: Design, proposal: Proposal) -> Iterator[str]:
    """Yield warnings against flying the maneuver, one sentence each."""
    if design.gap_deg is None:
        yield (
            f"The swarm takes {design.swarm.duration_s:.3f} s, longer than the time limit of "
            f"{design.problem.time_limit_s:g} s: its penalty is too small to keep it."
        )
    yield from proposal.notices
    yield from (f"The check {check.name} failed: {check.sentence}" for check in proposal.failed)
    if proposal.refusal:
        yield f"The drop robot's sequencer would refuse it: {proposal.refusal}"
