"""One rehearsed drop: flown, decoded, evaluated, reported, and held against the truth."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.rehearse.one_result import (
    day_facts,
    evaluation_facts,
    flight_facts,
    quick_facts,
    robot_facts,
    stroke_warnings,
)
from tfsat_host.cli.rehearse.one_words import show
from tfsat_host.cli.rehearse.thrown import Thrown, broke_design
from tfsat_host.errors import DataLossError, RefusedError, TfsatError
from tfsat_host.json_values import jsonable
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.maneuver import Maneuver, Schedule
    from tfsat_host.rehearsal.drop import Drop
    from tfsat_host.rehearsal.faults.fault import Fault
    from tfsat_host.rehearsal.prepared import RehearsalOptions
    from tfsat_host.rehearsal.run_folder import RunFolder
    from tfsat_host.rehearsal.truth import Truth
    from tfsat_host.robot import RobotModel
    from tfsat_host.run.evaluated import EvaluatedRun
    from tfsat_host.sdlog import DropLog

_STEPS = 7


def rehearse_one(
    args: argparse.Namespace,
    options: RehearsalOptions,
    maneuver: Maneuver,
    schedule: Schedule,
    filed: RobotModel,
    faults: tuple[Fault, ...],
    notices: tuple[str, ...],
    out: Output,
) -> int:
    """Returns the exit code: 0 if all went as planned."""
    from tfsat_host.rehearsal.run_folder import RunFolder
    from tfsat_host.rehearsal.truth_file import truth_text

    folder = RunFolder(args.out, force=args.force)
    truth = options.truth(filed, args.seed)
    thrown = Thrown(faults)
    drop = _fly(options, schedule, filed, truth, thrown.faults, out)
    told = truth_text(truth, drop, filed, tuple(one.name for one in faults))
    robot = filed.path.read_bytes()  # which may lie in this very folder
    with folder.replaced():
        log = folder.write(maneuver, drop, robot, told)
        evaluated, refusal = _evaluated(folder, drop, log)
        result = {
            "schedule": schedule.as_rows(),
            "end_s": schedule.end_s,
            **robot_facts(options, truth, filed),
            "faults": thrown.facts(drop, log, evaluated, refusal),
            "notices": notices,
            **_found(schedule, truth, drop, log, filed, folder, evaluated, refusal, out),
            "files": [str(path) for path in folder.files],
        }
        result = jsonable(result)
        folder.write_summary(result)
    for stale in folder.removed:
        out.note(f"Removed {stale}: it was made of the recording that this one replaces.")
    out.result(result, lambda: show(schedule, result, folder, out))
    for warning in result["warnings"]:
        out.warn(warning)
    return _exit_code(drop, log, evaluated, result)


def _exit_code(drop: Drop, log: DropLog | None, evaluated: EvaluatedRun | None, result: Any) -> int:
    if drop.checked is not None and drop.refused is not None and not drop.checked.go:
        return RefusedError.exit_code
    good = evaluated is not None and evaluated.verdict.level == "good"
    by_design = not result["warnings"] and not broke_design(result["faults"])
    as_planned = good and log is not None and log.verdict == "complete" and by_design
    return 0 if as_planned else DataLossError.exit_code


def _fly(
    options: RehearsalOptions,
    schedule: Schedule,
    filed: RobotModel,
    truth: Truth,
    faults: tuple[Fault, ...],
    out: Output,
) -> Drop:
    from tfsat_host.rehearsal.rehearse import rehearse

    hex_path = options.image(out.note)
    with out.progress("rehearsing", total=_STEPS) as advance:
        return rehearse(
            schedule,
            filed,
            truth,
            hex_path=hex_path,
            preflight=options.preflight(schedule, filed, hex_path),
            faults=faults,
            progress=lambda _: advance(1),
        )


def _evaluated(
    folder: RunFolder, drop: Drop, log: DropLog | None
) -> tuple[EvaluatedRun | None, TfsatError | None]:
    """As `report` would; or why the recording cannot be evaluated. Neither: nothing fell."""
    from tfsat_host.run import reporting

    if log is None or drop.refused is not None:
        return None, None
    folder.announced(reporting.PAGE)
    try:
        made = reporting.report([folder.path], made_at=folder.collected)
    except TfsatError as error:
        return None, error
    folder.files += made.files
    return made.runs[0], None


def _found(
    schedule: Schedule,
    truth: Truth,
    drop: Drop,
    log: DropLog | None,
    filed: RobotModel,
    folder: RunFolder,
    evaluated: EvaluatedRun | None,
    refusal: TfsatError | None,
    out: Output,
) -> dict[str, Any]:
    """What came of the day, the drop and its recording."""
    from tfsat_host.rehearsal.compared import compared
    from tfsat_host.run.files import PREFLIGHT

    beside = () if evaluated is None else compared(evaluated.found, drop, truth, filed)
    found = {
        **day_facts(drop, folder.path / PREFLIGHT),
        **flight_facts(schedule, truth, drop, log, folder.path),
        **evaluation_facts(evaluated, refusal, beside),
        "quick_look": None,
    }
    if evaluated is None and log is not None and log.release_us is not None and drop.refused is None:
        try:
            found["quick_look"] = quick_facts(schedule, drop, log, filed)
        except TfsatError as error:
            out.warn(f"No quick look either. {error.what} {error.meaning}")
    return {**found, "warnings": stroke_warnings(schedule, found)}
