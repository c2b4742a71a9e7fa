"""One rehearsed drop: flown, decoded, evaluated, reported, and held against the truth."""

from __future__ import annotations

import argparse
import io
from math import isnan
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output
from tfsat_host.cli.rehearse.one_words import show, simulate_command
from tfsat_host.cli.rehearse.prepared import image_of, preflight_of, strokes_of, truth_of
from tfsat_host.cli.rehearse.run_folder import RunFolder
from tfsat_host.errors import DataLossError, RefusedError, TfsatError

if TYPE_CHECKING:
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun
    from tfsat_host.maneuver import Maneuver, Schedule
    from tfsat_host.rehearsal.compared import Compared
    from tfsat_host.rehearsal.drop import Drop
    from tfsat_host.rehearsal.faults.fault import Fault
    from tfsat_host.rehearsal.truth import Truth
    from tfsat_host.robot import RobotModel
    from tfsat_host.sdlog import DropLog

LOOK_MARGIN_S = 0.05
"""What is looked at ends this long before the landing."""
_STEPS = 6


def rehearse_one(
    args: argparse.Namespace,
    maneuver: Maneuver,
    schedule: Schedule,
    filed: RobotModel,
    faults: tuple[Fault, ...],
    notices: tuple[str, ...],
    out: Output,
) -> int:
    """Returns the exit code: 0 if all went as planned."""
    from tfsat_host.rehearsal.compared import compared
    from tfsat_host.rehearsal.truth_file import truth_text

    folder = RunFolder(args.out, force=args.force)
    truth = truth_of(args, filed, args.seed)
    drop = _fly(args, schedule, filed, truth, faults, out)
    told = truth_text(truth, drop, filed, tuple(one.name for one in faults))
    log = folder.write(maneuver, drop, filed, told)
    for stale in folder.removed:
        out.note(f"Removed {stale}: it was made of the recording that this one replaces.")
    evaluated = _evaluated(args, folder, out) if log is not None and log.release_us is not None else None
    beside = () if evaluated is None else compared(evaluated.found, drop, truth, filed)
    result = {
        "schedule": schedule.as_rows(),
        "end_s": schedule.end_s,
        "sequencer": args.sequencer,
        "seed": args.seed,
        "faults": [fault.name for fault in faults],
        "notices": notices,
        **_day(drop),
        **_flight(schedule, truth, drop, log, filed, folder),
        **_evaluation(evaluated, beside),
        "files": [str(path) for path in folder.files],
    }
    folder.write_summary(result)
    out.result(result, lambda: show(schedule, result, folder, out))
    for warning in result["warnings"]:
        out.warn(warning)
    good = evaluated is not None and evaluated.verdict.level == "good"
    as_planned = good and log is not None and log.verdict == "complete" and not result["warnings"]
    if drop.checked is not None and drop.refused is not None and not drop.checked.go:
        return RefusedError.exit_code
    return 0 if as_planned else DataLossError.exit_code


def _fly(
    args: argparse.Namespace,
    schedule: Schedule,
    filed: RobotModel,
    truth: Truth,
    faults: tuple[Fault, ...],
    out: Output,
) -> Drop:
    from tfsat_host.rehearsal.rehearse import rehearse

    hex_path = image_of(args, out)
    with out.progress("rehearsing", total=_STEPS) as advance:
        return rehearse(
            schedule,
            filed,
            truth,
            hex_path=hex_path,
            preflight=preflight_of(args, schedule, filed, hex_path),
            faults=faults,
            progress=lambda _: advance(1),
        )


def _evaluated(args: argparse.Namespace, folder: RunFolder, out: Output) -> EvaluatedRun | None:
    """As `evaluate` and `report` would, typed for this folder; None if the recording cannot be evaluated."""
    from tfsat_host.cli import report

    parser = argparse.ArgumentParser()
    report.configure(parser)
    typed = parser.parse_args([str(folder.path), *(["--robot", args.robot] if args.robot else [])])
    quiet = Output(json_mode=True, yes=True, stdout=io.StringIO(), stderr=io.StringIO())
    try:
        done, written = report.report_on(typed, quiet)
    except TfsatError as error:
        out.warn(f"No evaluation. {error.what} {error.meaning}")
        return None
    folder.files += written
    return done


def _day(drop: Drop) -> dict[str, Any]:
    refused, checked = drop.refused, drop.checked
    return {
        "verified": drop.upload is not None,
        "preflight": None if checked is None else "go" if checked.go else "no-go",
        "no_go": [] if checked is None else [check.name for check in checked.wrong],
        "refused": None if refused is None else f"{refused.what} {refused.meaning} {refused.next_step}",
        "setbacks": list(drop.setbacks),
        "sequencer_state": None if drop.sequencer is None else drop.sequencer.state.name.lower(),
        "knocks": None if drop.sequencer is None else drop.sequencer.knocks,
    }


def _flight(
    schedule: Schedule, truth: Truth, drop: Drop, log: DropLog | None, filed: RobotModel, folder: RunFolder
) -> dict[str, Any]:
    import numpy as np

    rate_deg_s = [round(float(rate), 6) for rate in np.rad2deg(truth.rate_rad_s)]
    found: dict[str, Any] = {
        "initial_rate_deg_s": rate_deg_s,
        "simulate_command": None,
        "verdict": None if log is None else log.verdict,
        "samples": 0 if log is None else len(log),
        "samples_lost": None if log is None else log.samples_lost,
        "rate_hz": None if log is None else log.rate_hz,
        "strokes_s": [],
        "reached_deg": [],
        "joint_change_deg": None,
        "reorientation_deg": None,
        "reorientation_true_deg": None,
        "warnings": [],
    }
    if log is None or log.release_us is None or drop.released_s is None or drop.landed_s is None:
        return found
    return found | _looked_at(schedule, drop, log, filed, folder, rate_deg_s)


def _looked_at(
    schedule: Schedule,
    drop: Drop,
    log: DropLog,
    filed: RobotModel,
    folder: RunFolder,
    rate_deg_s: list[float],
) -> dict[str, Any]:
    from tfsat_host.emulated.truth import true_reorientation_deg
    from tfsat_host.evaluation.quick.quick_look import quick_look
    from tfsat_host.evaluation.quick.strokes import disagreements, reached_deg

    fall_s = (drop.landed_s or 0.0) - (drop.released_s or 0.0)
    starts_s, commanded_deg, joints = strokes_of(schedule)
    look = quick_look(log, filed, until_s=fall_s - LOOK_MARGIN_S)
    reached = reached_deg(log, filed, joints, starts_s, fall_s)
    return {
        "simulate_command": simulate_command(schedule, look.until_s, folder.maneuver, rate_deg_s),
        "strokes_s": [float(t_s) for t_s in look.stroke_s],
        "reached_deg": [None if isnan(angle) else float(angle) for angle in reached],
        "joint_change_deg": [float(change) for change in look.joint_change_deg],
        "reorientation_deg": look.reorientation_deg,
        "reorientation_true_deg": true_reorientation_deg(drop.truth, drop.released_s or 0.0, look.until_s),
        "warnings": disagreements(starts_s, look.stroke_s, commanded_deg, reached),
    }


def _evaluation(evaluated: EvaluatedRun | None, beside: tuple[Compared, ...]) -> dict[str, Any]:
    if evaluated is None:
        return {"evaluation": None, "compared": []}
    verdict = evaluated.verdict
    return {
        "evaluation": {
            "level": verdict.level,
            "sentence": verdict.sentence,
            "reasons": list(verdict.reasons),
        },
        "compared": [
            {
                "name": one.name,
                "unit": one.unit,
                "found": one.found,
                "std": one.std,
                "true": one.true,
                "deviations": one.deviations,
            }
            for one in beside
        ],
    }
