"""The result of one rehearsal, as `--json` prints it and `summary.json` keeps it."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.quick_look import disagreements, quick_look, reached_deg
from tfsat_host.json_values import error_as_dict
from tfsat_host.maneuver import Schedule
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import Notices
from tfsat_host.preflight.preflight_check import CHECK
from tfsat_host.protocol.limits import SWITCH_COUNT
from tfsat_host.quantity import records
from tfsat_host.rehearsal.day import DROPPED, NoGo
from tfsat_host.rehearsal.judgement import JudgedDay, moved_deg
from tfsat_host.rehearsal.rehearsed_drop import HOOK_S, Drop
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.rehearsal.truth_comparison import COMPARED, compare_with_truth, turned_rad
from tfsat_host.robot import RobotModel
from tfsat_host.run.drop_evaluation import EvaluatedRun
from tfsat_host.run.files import MANEUVER, PREFLIGHT, ROBOT
from tfsat_host.sdlog import DropLog
from tfsat_host.units import s_from_us

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


def result_of(
    judged: JudgedDay,
    evaluated: EvaluatedRun | None,
    truth: Truth,
    schedule: Schedule,
    filed: RobotModel,
    folder: Path,
    notices: Notices,
) -> Json:
    """Robot, faults, day, flight, evaluation, and the truth next to it.

    Args:
        judged: The day and what was made of its recording.
        evaluated: None: it was not.
        truth: The robot that flew.
        schedule: What it was to fly.
        filed: The robot as its file has it.
        folder: The run's.
        notices: For why there is no quick look either.
    """
    drop, log = judged.drop, judged.log
    result: Json = {
        "schedule": schedule.as_rows(),
        "end_s": schedule.end_s,
        "seed": truth.seed,
        "robot": {"name": filed.name, "file": str(filed.path)},
        "imu": truth.imu or None,
        "faults": judged.faults(),
        "notices": schedule_notices(schedule),
        **_day(drop, folder),
        **_flight(schedule, truth, drop, log, folder),
        "evaluation": None if evaluated is None else _evaluation(evaluated),
        "evaluation_refused": None if judged.refusal is None else error_as_dict(judged.refusal),
        "compared": []
        if judged.found is None
        else records(COMPARED, compare_with_truth(judged.found, drop, truth, filed)),
        "quick_look": None,
    }
    # Without an evaluation, at least what the log shows without calibration.
    if evaluated is None and log is not None and log.release_us is not None and drop.refused is None:
        try:
            result["quick_look"] = _quick_look(schedule, drop, log, filed)
        except TfsatError as error:
            notices.warn(f"No quick look either. {error.what} {error.meaning}")
    return {**result, "warnings": _stroke_warnings(schedule, result)}


def schedule_notices(schedule: Schedule) -> tuple[str, ...]:
    """List the notices about a schedule that a person should read before it flies."""
    from tfsat_host.maneuver.schedule import servo_speed_notices

    return (*schedule.notices, *servo_speed_notices(schedule))


def _day(drop: Drop, folder: Path) -> Json:
    """Summarize the day up to the drop and the sequencer's state after it."""
    refused, checked, sequencer = drop.refused, drop.checked, drop.sequencer
    red = () if checked is None else checked.wrong
    return {
        "verified": drop.upload is not None,
        "preflight": None if checked is None else "go" if checked.go else "no-go",
        "preflight_file": None if checked is None else str(folder / PREFLIGHT),
        "no_go": [check.name for check in red],
        "no_go_checks": records(CHECK, red),
        "refused": None if refused is None else f"{refused.what} {refused.meaning} {refused.next_step}",
        "refused_by": None if refused is None else "preflight" if isinstance(refused, NoGo) else "board",
        "setbacks": list(drop.setbacks),
        "sequencer_state": None if sequencer is None else sequencer.state.name.lower(),
        "knocks": None if sequencer is None else sequencer.knocks,
        "false_releases": None if sequencer is None else sequencer.false_releases,
    }


def _flight(schedule: Schedule, truth: Truth, drop: Drop, log: DropLog | None, folder: Path) -> Json:
    """Summarize the recording and the true motion of the fall."""
    rate_deg_s = np.rad2deg(truth.rate_rad_s).round(6).tolist()
    flight: Json = {
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
        return flight
    if log is None or log.release_us is None:
        return flight | {"no_release": _no_release(drop, log)}
    # Stop short of the landing, whose shock would count as rotation.
    until_s = drop.landed_s - drop.released_s - LOOK_MARGIN_S
    turned = turned_rad(drop.truth, drop.released_s, drop.released_s + until_s)
    return flight | {
        "simulate_command": _simulate_command(schedule, until_s, folder, rate_deg_s),
        "strokes_s": [log.seconds(event.t_us) for event in log.events if event.name == "stroke"],
        "reorientation_true_deg": float(np.rad2deg(turned)),
        "reorientation_true_until_s": until_s,
    }


def _simulate_command(schedule: Schedule, until_s: float, folder: Path, rate_deg_s: Sequence[float]) -> str:
    """Return the `simulate` command that computes the same drop of the robot as filed.

    It ends at the moment at which the truth is taken.
    """
    rates = [f"{rate:g}" for rate in rate_deg_s]
    until_s = max(until_s, s_from_us(schedule.end_us))  # `simulate` follows the joints to their rest
    maneuver, robot = (str(folder / name) for name in (MANEUVER, ROBOT))
    start = ("--file", maneuver, "--initial-rate", *rates)
    return Advice(NextStep("simulate", (*start, "--until", f"{until_s:.3f}", "--robot", robot)))


def _no_release(drop: Drop, log: DropLog | None) -> Json:
    """Describe what the robot did in a fall whose recording holds no release."""
    events = [] if log is None else [event for event in log.events if event.name == "switch_edge"]
    return {
        "hook_min": HOOK_S / 60.0,
        "fall_s": (drop.landed_s or 0.0) - (drop.released_s or 0.0),
        "joints_moved_true_deg": moved_deg(drop).tolist(),
        "strokes_started": _strokes_started(drop),
        "recording_ended_before_release_s": _ended_before_release_s(drop, log),
        "switches": [
            {
                "switch": index + 1,
                "edges_s": [log.seconds(event.t_us) for event in events if event.index == index],
                "open_at_the_end": bool(log.switch_open[-1, index]),
            }
            for index in range(SWITCH_COUNT)
        ]
        if log is not None and len(log)
        else [],
    }


def _strokes_started(drop: Drop) -> int | None:
    """Return the number of strokes started, by the sequencer.

    None: it does not answer, or it restarted since the release and knows of no run.
    """
    if drop.sequencer is None or drop.released_s is None:
        return None
    started = drop.sequencer.strokes_started
    now_s = (drop.collected - DROPPED).total_seconds()
    # Up for a shorter time than since the release: its counter of strokes began again at 0.
    restarted = drop.sequencer.uptime_ms / 1000.0 < now_s - drop.released_s
    return None if restarted and started == 0 else started


def _ended_before_release_s(drop: Drop, log: DropLog | None) -> float | None:
    """Compute how long before the release, in s, a recording without an end breaks off.

    None: the recording holds the time of the release, or it is complete.
    """
    if (
        log is None
        or log.footer is not None
        or not len(log)
        or drop.released_s is None
        or not len(drop.truth)
    ):
        return None
    length_s = float(log.t_us[-1] - log.t_us[0]) / 1e6
    # Truth and recording begin together: the first time of one plus the length of the other is its end.
    before_s = drop.released_s - (float(drop.truth[0, 0]) + length_s)
    return before_s if before_s > 0.0 else None


def _evaluation(evaluated: EvaluatedRun) -> Json:
    """Return the keys of `evaluate --json` that concern the maneuver."""
    document = evaluated.as_dict()
    return {
        **document["verdict"],
        **{key: document[key] for key in ("reorientation_deg", "reorientation_deg_std", "until_s")},
        "strokes": [{key: stroke[key] for key in _STROKE} for stroke in document["strokes"]],
        "joints": [{key: joint[key] for key in _JOINT} for joint in document["joints"]],
    }


def _quick_look(schedule: Schedule, drop: Drop, log: DropLog, filed: RobotModel) -> Json:
    """Estimate the motion of a drop that cannot be evaluated, without calibration and uncertainty.

    Raises EvaluationError.
    """
    fall_s = (drop.landed_s or 0.0) - (drop.released_s or 0.0)
    starts_s = [stroke.t_s for stroke in schedule.strokes]
    joints = [stroke.joint for stroke in schedule.strokes]
    look = quick_look(log, filed, until_s=fall_s - LOOK_MARGIN_S)
    return {
        "strokes_deg": reached_deg(log, filed, joints, starts_s, fall_s).tolist(),
        "joint_change_deg": [float(change) for change in look.joint_change_deg],
        "reorientation_deg": look.reorientation_deg,
        "until_s": look.until_s,
    }


def _stroke_warnings(schedule: Schedule, result: Json) -> list[str]:
    """Warn of strokes that were not as commanded.

    They are judged by the evaluation, or by the quick look if there is none.
    """
    if result["evaluation"] is not None:
        sizes = [stroke["size_deg"] for stroke in result["evaluation"]["strokes"]]
    elif result["quick_look"] is not None:
        sizes = result["quick_look"]["strokes_deg"]
    else:
        return []
    return disagreements(
        [stroke.t_s for stroke in schedule.strokes],
        result["strokes_s"],
        [stroke.angle_deg for stroke in schedule.strokes],
        [size if size is not None and isfinite(size) else nan for size in sizes],
    )
