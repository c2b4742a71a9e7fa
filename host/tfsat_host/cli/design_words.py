"""What `tfsat-host design` says of a design."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.maneuver import Schedule
    from tfsat_host.plan.design import Candidate, Design
    from tfsat_host.plan.tower_checks import Check


@dataclass(frozen=True, eq=False)
class Made:
    """What was made of a design.

    Attributes:
        flown: The maneuver as it was written.
        path: Where.
        robot_option: What commands that look at it need to be told of the robot.
        schedule: Its times; None if no sequencer commands the robot, or it would refuse.
        refusal: Why it would.
        checks: Against the drop tower; none without a schedule.
        notices: What else a person should know.
    """

    flown: Candidate
    path: Path
    robot_option: str
    schedule: Schedule | None = None
    refusal: str = ""
    checks: tuple[Check, ...] = ()
    notices: tuple[str, ...] = ()


def result_of(found: Design, made: Made) -> dict[str, Any]:
    """What `--json` prints: the maneuver as it was written, then swarm and optimum as they were found."""
    schedule = made.schedule
    return {
        **asdict(made.flown),
        "joints": [joint + 1 for joint in found.problem.joints],
        "swarm": {
            **asdict(found.swarm),
            "best_objective_deg": [math.degrees(value) for value in found.search.best_values],
            "evaluations": found.search.evaluations,
        },
        "optimum": {
            **asdict(found.optimum),
            "gain_deg_per_s": math.degrees(found.summit.gain_rad_s),
            "gradient_left_deg_per_deg": found.summit.residual,
            "summits_climbed": found.summits,
        },
        "swarm_behind_optimum_deg": found.gap_deg,
        "file": made.path,
        "schedule": None if schedule is None else schedule.as_rows(),
        "end_s": None if schedule is None else schedule.end_s,
        "sequencer_refuses": made.refusal or None,
        "checks": [asdict(check) for check in made.checks],
        "notices": list(made.notices),
    }


def show(found: Design, made: Made, out: Output) -> None:
    """What a person reads: swarm, optimum and what was written, what the drop tower says, what to type next."""
    _show_candidates(found, made, out)
    for notice in made.notices:
        out.warn(notice)
    failed = [check for check in made.checks if not check.passed]
    for check in failed:
        out.warn(f"The check {check.name} failed: {check.sentence}")
    named = f"--file {made.path}{made.robot_option}"
    if made.checks and not failed:
        out.line(
            f"It fits the drop tower: all {len(made.checks)} checks passed (tfsat-host envelope {named})."
        )
    if made.schedule is not None:
        out.line(f"Written to {made.path}; ends {made.schedule.end_s:.2f} s after release.")
    else:
        if made.refusal:
            out.warn(f"The drop robot's sequencer would refuse it: {made.refusal}")
        out.line(f"Written to {made.path}.")
    if made.schedule is None:
        out.line(f"Next: tfsat-host simulate {named}")
    elif failed:
        out.line("Do not fly it: design with a shorter --time-limit, smaller --limit or a true --speed.")
    else:
        out.line(f"Next: tfsat-host upload-sequence --file {made.path}")


def _show_candidates(found: Design, made: Made, out: Output) -> None:
    from tfsat_host.plan.loops import written

    joints = [f"joint {joint + 1} / deg" for joint in found.problem.joints]
    rows = [
        (
            name,
            *(f"{alpha:.2f}" for alpha in one.alpha_deg),
            written(one.sequence),
            f"{one.reorientation_deg:.3f}",
            f"{one.duration_s:.4f}",
            f"{one.efficiency:.4f}",
        )
        for name, one in (("swarm", found.swarm), ("optimum", found.optimum), ("written", made.flown))
    ]
    out.table(("", *joints, "sequence", "turns / deg", "time / s", "turn per travel"), rows)
    x, y, z = made.flown.rotation_vector_deg
    out.line(f"Rotation vector of what was written: {x:.3f}, {y:.3f}, {z:.3f} deg.")
    if found.gap_deg is None:
        out.warn(
            f"The swarm takes {found.swarm.duration_s:.3f} s, longer than the time limit of "
            f"{found.problem.time_limit_s:g} s: its penalty is too small to keep it."
        )
    else:
        out.line(f"The swarm stays {found.gap_deg:.3f} deg behind the optimum{_gain(found)}.")


def _gain(found: Design) -> str:
    """What more time would give, where time is what limits."""
    gain = math.degrees(found.summit.gain_rad_s)
    return f"; 0.1 s more would give {0.1 * gain:.2f} deg more" if gain > 0.0 else ""
