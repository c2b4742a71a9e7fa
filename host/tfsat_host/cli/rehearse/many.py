"""Many rehearsed drops: flown on all cores, told as a distribution."""

from __future__ import annotations

import argparse
import csv
import io
import json
import shlex
from collections import Counter
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.advice import Interrupted
from tfsat_host.cli.evaluate.run_files import MANEUVER, ROBOT
from tfsat_host.cli.output import Output
from tfsat_host.cli.rehearse.prepared import image_of, part_of, preflight_of
from tfsat_host.cli.rehearse.result_folder import ResultFolder
from tfsat_host.cli.stopping import stop_wish
from tfsat_host.errors import DataLossError, RefusedError

if TYPE_CHECKING:
    from tfsat_host.maneuver import Maneuver, Schedule
    from tfsat_host.rehearsal.faults.fault import Fault
    from tfsat_host.rehearsal.many import Distribution, Flown, Series
    from tfsat_host.robot import RobotModel

TABLE, SUMMARY = "runs.csv", "runs.json"
_LEAST_FOR_SHARE = 20
"""Below, the intervals that hold are counted."""


def rehearse_many(
    args: argparse.Namespace,
    maneuver: Maneuver,
    schedule: Schedule,
    filed: RobotModel,
    faults: tuple[Fault, ...],
    out: Output,
) -> int:
    """Returns the exit code: 0 if every drop was flown, recorded whole and evaluated; 4: the preflight let none go.

    Raises:
        Interrupted: Ctrl-C; what was flown until then is written and shown.
    """
    from tfsat_host.rehearsal.many import Series, distributions, fly_many

    image = image_of(args, out)
    series = Series(
        schedule,
        filed,
        args.seed,
        as_filed=args.as_filed,
        hex_path=image,
        faults=tuple(fault.name for fault in faults),
        part=part_of(args),
        preflight=preflight_of(args, schedule, filed, image),
    )
    folder = ResultFolder(args.out, force=args.force)
    with stop_wish() as stop, out.progress("rehearsing", total=args.runs) as advance:
        outcomes = fly_many(series, args.runs, progress=lambda: advance(1), stop=stop)
    if not outcomes:
        raise Interrupted(
            what=f"Interrupted after 0 of {args.runs} drops.",
            meaning="There is nothing to tell; nothing was written.",
            next_step="Run the same command again.",
        )
    told = distributions(outcomes)
    result = _result(series, args.runs, outcomes, told)
    _write(folder, maneuver, filed, outcomes, result)
    out.result(result, lambda: _show(result, told, args, out))
    if len(outcomes) < args.runs:
        raise Interrupted(
            what=f"Interrupted after {len(outcomes)} of {args.runs} drops.",
            meaning=f"These are whole, and in {args.out / TABLE}; nothing is known of the others.",
            next_step=f"For all of them run the same command again; {args.out} is then made anew.",
        )
    if result["no_go"] and not result["dropped"]:
        return RefusedError.exit_code
    as_planned = result["good"] == result["runs"] and not result["broke_design"]
    return 0 if as_planned else DataLossError.exit_code


def _write(
    folder: ResultFolder,
    maneuver: Maneuver,
    filed: RobotModel,
    outcomes: tuple[Flown, ...],
    result: dict[str, Any],
) -> None:
    from tfsat_host.maneuver import format_maneuver

    robot = filed.path.read_bytes()  # which may lie in this very folder
    with folder.replaced():
        folder.file(MANEUVER).write_text(format_maneuver(maneuver), encoding="utf-8")
        folder.file(ROBOT).write_bytes(robot)
        folder.file(TABLE).write_text(_rows(outcomes), encoding="utf-8")
        folder.file(SUMMARY).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        folder.sealed()


def _again(args: argparse.Namespace) -> str:
    """What flies one of the drops alone; its seed and folder are to be filled in."""
    files = f"--file {shlex.quote(str(args.out / MANEUVER))} --robot {shlex.quote(str(args.out / ROBOT))}"
    options = [f"--fault {name}" for name in args.fault]
    options += [f"--imu {shlex.quote(args.imu)}"] if args.imu else []
    options += ["--as-filed"] if args.as_filed else []
    options += ["--despite-preflight"] if args.despite_preflight else []
    options += [f"--sequencer {args.sequencer}"] if args.sequencer != "native" else []
    return " ".join(("tfsat-host rehearse", files, *options, "--seed SEED --out DIR"))


def _result(
    series: Series, asked: int, outcomes: tuple[Flown, ...], told: tuple[Distribution, ...]
) -> dict[str, Any]:
    verdicts = [one.verdict for one in outcomes]
    timing = [abs(off) for one in outcomes for off in one.strokes_off_us if off == off]
    return {
        "runs": len(outcomes),
        "asked": asked,
        "seed": series.seed,
        "robot": {"name": series.filed.name, "file": str(series.filed.path)},
        "as_filed": series.as_filed,
        "imu": outcomes[0].imu or None,
        "faults": list(series.faults),
        "faults_noticed": [_noticed(name, outcomes) for name in series.faults],
        "broke_design": [one.number for one in outcomes if one.broke_design],
        "dropped": sum(not one.refused for one in outcomes),
        "no_go": dict(Counter(name for one in outcomes for name in one.no_go)),
        **{level: verdicts.count(level) for level in ("good", "doubtful", "failed", "none")},
        "samples_lost": sum(max(0, one.samples_lost) for one in outcomes),
        "stroke_timing_us": {
            "rms": (sum(off**2 for off in timing) / len(timing)) ** 0.5 if timing else None,
            "largest": max(timing, default=None),
        },
        "distributions": [asdict(one) for one in told],
        "refused": [
            {"number": one.number, "seed": one.seed, "why": one.refused} for one in outcomes if one.refused
        ],
    }


def _rows(outcomes: tuple[Flown, ...]) -> str:
    """CSV: a row for each drop, with the seed that flies it again alone."""
    names = list(dict.fromkeys(one.name for outcome in outcomes for one in outcome.compared))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = [f"{name} {what}" for name in names for what in ("found", "std", "true")]
    writer.writerow(["number", "seed", "no_go", "refused", "verdict", "samples_lost", *columns])
    for outcome in outcomes:
        by_name = {one.name: (one.found, one.std, one.true) for one in outcome.compared}
        values = [f"{value:.9g}" for name in names for value in by_name.get(name, (float("nan"),) * 3)]
        told = (" ".join(outcome.no_go), outcome.refused, outcome.verdict, outcome.samples_lost)
        writer.writerow([outcome.number, outcome.seed, *told, *values])
    return text.getvalue()


def _noticed(name: str, outcomes: tuple[Flown, ...]) -> dict[str, Any]:
    """In how many drops a fault struck and was noticed, and by whom."""
    told = [one.noticed[name] for one in outcomes if name in one.noticed]
    return {
        "name": name,
        "struck": len(told),
        "noticed": sum(bool(who) for who in told),
        "noticed_by": dict(Counter(who for each in told for who in each)),
    }


def _who_noticed(fault: dict[str, Any]) -> str:
    from tfsat_host.cli.rehearse.thrown import WHO

    by = "; ".join(f"{WHO[who]}: {times}" for who, times in fault["noticed_by"].items())
    named = f" ({by})" if by else ""
    return f"It struck in {fault['struck']} and was noticed in {fault['noticed']} of them{named}."


def _held(one: Distribution) -> str:
    """A share of few drops says less than their number."""
    if one.count < _LEAST_FOR_SHARE:
        return f"{round(one.held * one.count)} of {one.count}"
    return f"{100.0 * one.held:.0f} %"


def _show(
    result: dict[str, Any], told: tuple[Distribution, ...], args: argparse.Namespace, out: Output
) -> None:
    imu = f"IMUs {result['imu']}" if result["imu"] else "exactly as its file says"
    out.line(f"Drawn from seed {result['seed']}, robots of {result['robot']['file']}, {imu}.")
    for fault in result["faults_noticed"]:
        out.line(f"Thrown into each: {fault['name']}. {_who_noticed(fault)}")
    if result["broke_design"]:
        drops = ", ".join(map(str, result["broke_design"]))
        out.line(f"The robot did NOT do what it must with these faults, by the truth, in drop {drops}.")
    rows = [
        (
            one.name,
            one.unit,
            f"{one.mean_true:.3f}",
            f"{one.spread_true:.3f}",
            f"{one.rms_error:.4f}",
            f"{one.largest_error:.4f}",
            f"{one.stated_std:.4f}",
            _held(one),
        )
        for one in told
    ]
    columns = ("", "unit", "true, mean", "spread", "error, rms", "largest", "stated ±", "95 % hold")
    if rows:
        out.table(columns, rows, title=f"What {result['runs']} evaluations found, beside the truth")
    out.line(
        f"Dropped {result['dropped']} of {result['runs']}: {result['good']} good, {result['doubtful']} doubtful, "
        f"{result['failed'] + result['none']} without an evaluation. Samples lost: {result['samples_lost']}."
    )
    timing = result["stroke_timing_us"]
    if timing["rms"] is not None:
        out.line(
            f"Strokes came {timing['rms']:.0f} us rms from their schedule, {timing['largest']:.0f} us at most, by the "
            "logger's clock."
        )
    for name, times in result["no_go"].items():
        out.line(f"Preflight said NO-GO by {name} {times} times.")
    for one in result["refused"][:3]:
        out.line(f"Drop {one['number']} was not let go: {one['why']}")
    out.line(f"Each drop: {args.out / TABLE}; one of them again, with its seed from there:")
    out.line(_again(args))
