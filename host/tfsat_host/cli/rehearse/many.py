"""Many rehearsed drops: flown on all cores, told as a distribution."""

from __future__ import annotations

import argparse
import shlex
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.stopping import stop_wish
from tfsat_host.errors import DataLossError, Interrupted, RefusedError
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import Column, Columns
from tfsat_host.run.files import MANEUVER, ROBOT

if TYPE_CHECKING:
    from tfsat_host.maneuver import Maneuver, Schedule
    from tfsat_host.rehearsal.faults.fault import Fault
    from tfsat_host.rehearsal.many import Distribution
    from tfsat_host.rehearsal.prepared import RehearsalOptions
    from tfsat_host.robot import RobotModel

_LEAST_FOR_SHARE = 20
"""Below, the intervals that hold are counted."""


def rehearse_many(
    args: argparse.Namespace,
    options: RehearsalOptions,
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
    from tfsat_host.rehearsal.result_folder import ResultFolder
    from tfsat_host.rehearsal.series_files import TABLE, series_as_dict, write_series

    image = options.image(out.note)
    series = Series(
        schedule,
        filed,
        args.seed,
        as_filed=options.as_filed,
        hex_path=image,
        faults=tuple(fault.name for fault in faults),
        part=options.part(),
        preflight=options.preflight(schedule, filed, image),
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
    result = series_as_dict(series, args.runs, outcomes, told)
    write_series(folder, maneuver, filed, outcomes, result)
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


def _again(args: argparse.Namespace) -> str:
    """What flies one of the drops alone; its seed and folder are to be filled in."""
    files = f"--file {shlex.quote(str(args.out / MANEUVER))} --robot {shlex.quote(str(args.out / ROBOT))}"
    options = [f"--fault {name}" for name in args.fault]
    options += [f"--imu {shlex.quote(args.imu)}"] if args.imu else []
    options += ["--as-filed"] if args.as_filed else []
    options += ["--despite-preflight"] if args.despite_preflight else []
    options += [f"--sequencer {args.sequencer}"] if args.sequencer != "native" else []
    return " ".join(("tfsat-host rehearse", files, *options, "--seed SEED --out DIR"))


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


_DISTRIBUTIONS: Columns = (
    Column("name", "number"),
    Column("unit", "unit"),
    Column("mean_true", "true, mean"),
    Column("spread_true", "spread"),
    Column("rms_error", "error, rms", form=".4f"),
    Column("largest_error", "largest", form=".4f"),
    Column("stated_std", "stated ±", form=".4f"),
    Column("held", "95 % hold", words=_held),
)


def _show(
    result: dict[str, Any], told: tuple[Distribution, ...], args: argparse.Namespace, out: Output
) -> None:
    from tfsat_host.rehearsal.series_files import TABLE

    imu = f"IMUs {result['imu']}" if result["imu"] else "exactly as its file says"
    out.line(f"Drawn from seed {result['seed']}, robots of {result['robot']['file']}, {imu}.")
    for fault in result["faults_noticed"]:
        out.line(f"Thrown into each: {fault['name']}. {_who_noticed(fault)}")
    if result["broke_design"]:
        drops = ", ".join(map(str, result["broke_design"]))
        out.line(f"The robot did NOT do what it must with these faults, by the truth, in drop {drops}.")
    if told:
        show_rows(_DISTRIBUTIONS, told, out, title=f"What {result['runs']} evaluations found, and the truth")
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
