"""What `tfsat-host design` says of a design."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from tfsat_host.design import Candidate, Design
    from tfsat_host.facility import Check
    from tfsat_host.maneuver import Schedule


def result_of(
    found: Design,
    chosen: Candidate,
    path: Path,
    schedule: Schedule | None,
    refusal: str,
    checks: tuple[Check, ...],
) -> dict[str, Any]:
    """What `--json` prints."""
    return {
        **asdict(chosen),
        "joints": [joint + 1 for joint in found.problem.joints],
        "swarm": {
            **asdict(found.swarm),
            "best_reorientation_deg": [-math.degrees(value) for value in found.search.best_values],
            "evaluations": found.search.evaluations,
        },
        "optimum": {
            **asdict(found.optimum),
            "gain_deg_per_s": math.degrees(found.summit.gain_rad_s),
            "gradient_left_deg_per_deg": found.summit.residual,
            "summits_climbed": found.summits,
        },
        "swarm_behind_optimum_deg": found.gap_deg,
        "file": path,
        "schedule": None if schedule is None else schedule.as_rows(),
        "end_s": None if schedule is None else schedule.end_s,
        "sequencer_refuses": refusal or None,
        "checks": [asdict(check) for check in checks],
    }


def show(
    found: Design,
    chosen: Candidate,
    path: Path,
    schedule: Schedule | None,
    refusal: str,
    checks: tuple[Check, ...],
    out: Output,
) -> None:
    """What a person reads: swarm and optimum, what the drop tower says, what to type next."""
    from tfsat_host.design.sequences import written

    joints = [f"joint {joint + 1} / deg" for joint in found.problem.joints]
    columns = ("", *joints, "sequence", "turns / deg", "time / s", "turn per travel")
    rows = [
        (
            name,
            *(f"{alpha:.2f}" for alpha in one.alpha_deg),
            written(one.sequence),
            f"{one.reorientation_deg:.3f}",
            f"{one.duration_s:.4f}",
            f"{one.efficiency:.4f}",
        )
        for name, one in (("swarm", found.swarm), ("optimum", found.optimum))
    ]
    out.table(columns, rows)
    x, y, z = chosen.rotation_vector_deg
    out.line(
        f"Rotation vector of the {'swarm' if chosen is found.swarm else 'optimum'}: {x:.3f}, {y:.3f}, {z:.3f} deg."
    )
    out.line(f"The swarm stays {found.gap_deg:.3f} deg behind the optimum{_gain(found)}.")
    for check in checks:
        if not check.passed:
            out.warn(f"{check.name}: {check.sentence}")
    if schedule is None:
        out.warn(f"The drop robot's sequencer would refuse it: {refusal}")
        out.line(f"Written to {path}. Look at it: tfsat-host simulate --file {path}")
        return
    if checks and all(check.passed for check in checks):
        out.line(
            f"It fits the drop tower: all {len(checks)} checks passed (tfsat-host envelope --file {path})."
        )
    out.line(
        f"Written to {path}, ends {schedule.end_s:.2f} s after release. Next: tfsat-host upload-sequence --file {path}"
    )


def _gain(found: Design) -> str:
    """What more time would give, where time is what limits."""
    gain = math.degrees(found.summit.gain_rad_s)
    return f"; 0.1 s more would give {0.1 * gain:.2f} deg more" if gain > 0.0 else ""
