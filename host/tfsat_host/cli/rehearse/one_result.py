"""The result of one rehearsal, as `--json` prints it and `summary.json` keeps it."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.rehearse.one_words import COMPARED, simulate_command
from tfsat_host.quantity import records

if TYPE_CHECKING:
    from pathlib import Path

    from tfsat_host.errors import TfsatError
    from tfsat_host.maneuver import Schedule
    from tfsat_host.rehearsal.compared import Compared
    from tfsat_host.rehearsal.drop import Drop
    from tfsat_host.rehearsal.prepared import RehearsalOptions
    from tfsat_host.rehearsal.truth import Truth
    from tfsat_host.robot import RobotModel
    from tfsat_host.run.evaluated import EvaluatedRun
    from tfsat_host.sdlog import DropLog

Json = dict[str, Any]

_STROKE = [
    "stroke",
    "joint",
    "scheduled_s",
    "logged_s",
    "commanded_deg",
    "size_deg",
    "size_deg_std",
    "remark",
]
_JOINT = ["joint", "initial_deg", "initial_deg_std", "final_deg", "final_deg_std", "sensed"]
LOOK_MARGIN_S = 0.05
"""What is looked at ends this long before the landing."""


def robot_facts(options: RehearsalOptions, truth: Truth, filed: RobotModel) -> Json:
    """Which robot flew."""
    return {
        "sequencer": options.sequencer,
        "seed": truth.seed,
        "robot": {"name": filed.name, "file": str(filed.path)},
        "as_filed": options.as_filed,
        "imu": truth.imu or None,
    }


def day_facts(drop: Drop, preflight: Path) -> Json:
    """How the day went until the drop, and how the sequencer was found after it.

    Args:
        drop: The day.
        preflight: Its file.
    """
    from tfsat_host.rehearsal.checked import NoGo

    refused, checked = drop.refused, drop.checked
    red = () if checked is None else checked.wrong
    return {
        "verified": drop.upload is not None,
        "preflight": None if checked is None else "go" if checked.go else "no-go",
        "preflight_file": None if checked is None else str(preflight),
        "no_go": [check.name for check in red],
        "no_go_checks": [check.as_dict() for check in red],
        "refused": None if refused is None else f"{refused.what} {refused.meaning} {refused.next_step}",
        "refused_by": None if refused is None else "preflight" if isinstance(refused, NoGo) else "board",
        "setbacks": list(drop.setbacks),
        "sequencer_state": None if drop.sequencer is None else drop.sequencer.state.name.lower(),
        "knocks": None if drop.sequencer is None else drop.sequencer.knocks,
        "false_releases": None if drop.sequencer is None else drop.sequencer.false_releases,
    }


def flight_facts(schedule: Schedule, truth: Truth, drop: Drop, log: DropLog | None, folder: Path) -> Json:
    """What the recording is, and what was true of the fall."""
    import numpy as np

    from tfsat_host.emulated.truth import true_reorientation_deg
    from tfsat_host.run.files import MANEUVER, ROBOT

    rate_deg_s = [round(float(rate), 6) for rate in np.rad2deg(truth.rate_rad_s)]
    found: Json = {
        "initial_rate_deg_s": rate_deg_s,
        "initial_rate_body": 3,
        "simulate_command": None,
        "verdict": None if log is None else log.verdict,
        "recording_from": "ram" if drop.from_ram else "card",
        "samples": 0 if log is None else len(log),
        "samples_lost": None if log is None else log.samples_lost,
        "rate_hz": None if log is None else log.rate_hz,
        "strokes_s": [],
        "reorientation_true_deg": None,
        "reorientation_true_until_s": None,
        "no_release": None,
    }
    if drop.released_s is None or drop.landed_s is None:
        return found
    if log is None or log.release_us is None:
        return found | {"no_release": _no_release(drop, log)}
    until_s = drop.landed_s - drop.released_s - LOOK_MARGIN_S
    return found | {
        "simulate_command": simulate_command(
            schedule, until_s, folder / MANEUVER, folder / ROBOT, rate_deg_s
        ),
        "strokes_s": [log.seconds(event.t_us) for event in log.events if event.name == "stroke"],
        "reorientation_true_deg": true_reorientation_deg(drop.truth, drop.released_s, until_s),
        "reorientation_true_until_s": until_s,
    }


def _no_release(drop: Drop, log: DropLog | None) -> Json:
    """What a robot did that fell without a release in its recording."""
    from tfsat_host.protocol.limits import SWITCH_COUNT
    from tfsat_host.rehearsal.outcome import moved_deg
    from tfsat_host.rehearsal.rehearse import HOOK_S

    events = [] if log is None else [one for one in log.events if one.name == "switch_edge"]
    return {
        "hook_min": HOOK_S / 60.0,
        "fall_s": (drop.landed_s or 0.0) - (drop.released_s or 0.0),
        "joints_moved_true_deg": [float(moved) for moved in moved_deg(drop)],
        "strokes_started": _strokes_started(drop),
        "recording_ended_before_release_s": _ended_before_release_s(drop, log),
        "switches": [
            {
                "switch": index + 1,
                "edges_s": [log.seconds(one.t_us) for one in events if one.index == index],
                "open_at_the_end": bool(log.switch_open[-1, index]),
            }
            for index in range(SWITCH_COUNT)
        ]
        if log is not None and len(log)
        else [],
    }


def _strokes_started(drop: Drop) -> int | None:
    """As the sequencer tells it; None: it does not answer, or started anew since the release and knows no run."""
    from tfsat_host.rehearsal.day import DROPPED

    if drop.sequencer is None or drop.released_s is None:
        return None
    told = drop.sequencer.strokes_started
    now_s = (drop.collected - DROPPED).total_seconds()
    restarted = drop.sequencer.uptime_ms / 1000.0 < now_s - drop.released_s
    return None if restarted and told == 0 else told


def _ended_before_release_s(drop: Drop, log: DropLog | None) -> float | None:
    """How long before the release a recording without an end breaks off; None: it holds the release's time, or all."""
    if (
        log is None
        or log.footer is not None
        or not len(log)
        or drop.released_s is None
        or not len(drop.truth)
    ):
        return None
    length_s = float(log.t_us[-1] - log.t_us[0]) / 1e6
    before_s = drop.released_s - (float(drop.truth[0, 0]) + length_s)
    return before_s if before_s > 0.0 else None


def evaluation_facts(
    evaluated: EvaluatedRun | None, refusal: TfsatError | None, beside: tuple[Compared, ...]
) -> Json:
    """What the evaluation found, or why there is none; and what was found beside what was true."""
    from tfsat_host.json_values import error_as_dict

    if evaluated is None:
        return {
            "evaluation": None,
            "evaluation_refused": None if refusal is None else error_as_dict(refusal),
            "compared": [],
        }
    return {
        "evaluation": _found(evaluated),
        "evaluation_refused": None,
        "compared": records(COMPARED, beside),
    }


def _found(evaluated: EvaluatedRun) -> Json:
    """The keys of `evaluate --json` that tell of the maneuver."""
    whole = evaluated.as_dict()
    return {
        **whole["verdict"],
        **{key: whole[key] for key in ("reorientation_deg", "reorientation_deg_std", "until_s")},
        "strokes": [{key: one[key] for key in _STROKE} for one in whole["strokes"]],
        "joints": [{key: one[key] for key in _JOINT} for one in whole["joints"]],
    }


def quick_facts(schedule: Schedule, drop: Drop, log: DropLog, filed: RobotModel) -> Json:
    """The quick look, for a drop that cannot be evaluated: no calibration, no uncertainty. Raises EvaluationError."""
    from tfsat_host.evaluation.quick_look import quick_look, reached_deg

    fall_s = (drop.landed_s or 0.0) - (drop.released_s or 0.0)
    starts_s = [stroke.t_s for stroke in schedule.strokes]
    joints = [stroke.joint for stroke in schedule.strokes]
    look = quick_look(log, filed, until_s=fall_s - LOOK_MARGIN_S)
    reached = reached_deg(log, filed, joints, starts_s, fall_s)
    return {
        "strokes_deg": [float(angle) for angle in reached],
        "joint_change_deg": [float(change) for change in look.joint_change_deg],
        "reorientation_deg": look.reorientation_deg,
        "until_s": look.until_s,
    }


def stroke_warnings(schedule: Schedule, result: Json) -> list[str]:
    """Where strokes were not as commanded: by the evaluation, or by the quick look where there is none."""
    from tfsat_host.evaluation.quick_look import disagreements

    starts_s = [stroke.t_s for stroke in schedule.strokes]
    commanded_deg = [stroke.angle_deg for stroke in schedule.strokes]
    if result["evaluation"] is not None:
        sizes = [stroke["size_deg"] for stroke in result["evaluation"]["strokes"]]
    elif result["quick_look"] is not None:
        sizes = result["quick_look"]["strokes_deg"]
    else:
        return []
    sizes = [size if size is not None and isfinite(size) else float("nan") for size in sizes]
    return disagreements(starts_s, result["strokes_s"], commanded_deg, sizes)
