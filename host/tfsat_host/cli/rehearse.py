"""`tfsat-host rehearse`: one drop of the emulated robot, or many."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.emulate import SEQUENCER
from tfsat_host.cli.maneuver_argument import (
    add_maneuver_options,
    maneuver_from,
    maneuver_usage,
    schedule_from,
)
from tfsat_host.cli.stopping import stop_wish
from tfsat_host.cli.usage import OUTPUT, seed, whole_number
from tfsat_host.errors import Interrupted
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import record, records

if TYPE_CHECKING:
    from tfsat_host.rehearsal.rehearsal import Rehearsal

MAX_RUNS = 100_000


_USAGE = f"""
Rehearse a drop on a desk: upload, preflight, recording, arming, crane lift with a false trigger, release with contact
bounce, strokes, fall, landing; then decode the card, evaluate, report, and compare with the hidden truth. The firmware
is the one that is flashed. Each seed is another robot: sensors, servos, clocks and centers of mass are off as real ones
are.

{maneuver_usage()}
drop:
--sequencer {{native,avr}}      {SEQUENCER}
--robot FILE                  robot file, or the name of a shipped one (drop_tower)
--imu NAME                    another IMU than the mpu6050: adis16465_2, or a file like theirs
--as-filed                    exactly as in its file: `simulate` computes the same drop
--despite-preflight           drop the robot even if the preflight says NO-GO
--list-faults                 what may go wrong, and what must then happen
--seed N                      of the robot, of noise and bounce (default 1)
--fault NAME[=SIZE][@MOMENT]  a fault, of its own or another size, at its own or another moment; may be given more than
                              once
--runs N                      as many drops, each of another robot; prints how their results are distributed
options:
--out DIR  folder of results (run)
--full     every number of the drop, not one screen
--force    overwrite files that are something else
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for maneuver, robot, drop and results."""
    faults = {"action": "append", "default": []}
    kinds = {"robot": str, "seed": seed, "runs": whole_number("runs", 1, MAX_RUNS), "fault": faults}
    add_maneuver_options(parser, _USAGE, nothing_done="Nothing was flown.", **kinds)
    parser.set_defaults(sequencer="native", seed=1, runs=1, out=Path("run"))


def run(args: argparse.Namespace, out: Output) -> int:
    """Rehearse one drop or a series, or list the faults."""
    from tfsat_host.rehearsal.drop_screen import show_drop
    from tfsat_host.rehearsal.faults.fault_catalog import FAULT_OF_CATALOG, FAULTS
    from tfsat_host.rehearsal.rehearsal import Rehearsal, RehearsalOptions
    from tfsat_host.rehearsal.result import REHEARSAL, schedule_notices

    if args.list_faults:
        faults = {"faults": records(FAULT_OF_CATALOG, FAULTS)}
        out.result(faults, lambda: show_rows(FAULT_OF_CATALOG, FAULTS, out))
        return 0
    maneuver = maneuver_from(args)
    schedule = schedule_from(args, maneuver)
    out.warn_each(schedule_notices(schedule))
    options = RehearsalOptions(args.sequencer, args.robot, args.as_filed, args.imu, args.despite_preflight)
    rehearsal = Rehearsal.of(maneuver, options, args.fault, schedule)
    if args.runs > 1:
        return _series(rehearsal, args, out)
    result = rehearsal.run(args.out, args.seed, force=args.force, notices=out)
    out.result(record(REHEARSAL, result), lambda: show_drop(result, out, full=args.full))
    out.warn_each(result.warnings)
    return result.exit_code


def _series(rehearsal: Rehearsal, args: argparse.Namespace, out: Output) -> int:
    """Raises Interrupted on Ctrl-C; what was flown until then is written and shown."""
    from tfsat_host.rehearsal.series_result import SERIES
    from tfsat_host.rehearsal.series_screen import show_series

    with stop_wish() as stop:
        series = rehearsal.run_many(args.out, args.runs, args.seed, force=args.force, notices=out, stop=stop)
    if series is None:
        raise Interrupted(
            what=f"Interrupted after 0 of {args.runs} drops.",
            meaning="Nothing is known, and nothing was written.",
            next_step="Run the same command again.",
        )
    out.result(record(SERIES, series), lambda: show_series(series, out))
    if series.runs < args.runs:
        raise Interrupted(
            what=f"Interrupted after {series.runs} of {args.runs} drops.",
            meaning=f"These are whole, and in {series.table}; nothing is known of the others.",
            next_step=f"For all of them run the same command again; {args.out} is then replaced.",
        )
    return series.exit_code
