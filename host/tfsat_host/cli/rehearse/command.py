"""The command: what to rehearse, on which robot, what goes wrong, how often."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.maneuver_argument import add_maneuver_arguments, maneuver_from, schedule_from
from tfsat_host.cli.options import add_output_options, file_name, seed
from tfsat_host.cli.rehearse.thrown import FAULT
from tfsat_host.errors import UsageError
from tfsat_host.present.output import Output
from tfsat_host.quantity import Column, fields, records

if TYPE_CHECKING:
    from tfsat_host.rehearsal.faults.fault import Fault

MOST_RUNS = 100_000


def configure(parser: argparse.ArgumentParser) -> None:
    """What to fly, on which robot, and where the results go."""
    parser.description = (
        "Live through a drop on a desk: upload, preflight, recording, arming, crane lift with a knock, release with "
        "contact bounce, strokes, fall, landing; then decode the card, evaluate, report, and compare with the hidden "
        "truth. The firmware is the one that is flashed. Each seed is another robot: sensors, servos, clocks and "
        "centers of mass are off as real ones are."
    )
    add_maneuver_arguments(parser, nothing_done="Nothing was flown.")
    drop = parser.add_argument_group("drop")
    drop.add_argument(
        "--sequencer",
        choices=("native", "avr"),
        default="native",
        help="the firmware's core on this computer, or the HEX that is flashed in an emulated ATmega32U4",
    )
    drop.add_argument("--robot", metavar="FILE", help="robot file, or the name of a shipped one (drop_tower)")
    drop.add_argument(
        "--as-filed",
        action="store_true",
        help="a robot that is exactly what its file says, with exact servos; `simulate` computes the same drop",
    )
    drop.add_argument(
        "--imu",
        metavar="NAME",
        help="another IMU than the robot's mpu6050 on every body: adis16465_2, or a file like theirs",
    )
    drop.add_argument(
        "--seed", metavar="N", type=seed, default=1, help="of the robot, of noise and bounce (default 1)"
    )
    drop.add_argument(
        "--fault",
        metavar="NAME[@MOMENT]",
        action="append",
        default=[],
        help="let something go wrong, at its own moment or at another one that it can be at (NAME@MOMENT, see "
        "--list-faults); may be given more than once",
    )
    drop.add_argument(
        "--despite-preflight",
        action="store_true",
        help="drop the robot even if the preflight says NO-GO, to see what comes of it",
    )
    drop.add_argument(
        "--list-faults", action="store_true", help="what may go wrong, and what must then happen"
    )
    drop.add_argument(
        "--runs",
        metavar="N",
        type=_runs,
        default=1,
        help="as many drops, each of another robot; prints how their results are distributed",
    )
    parser.add_argument(
        "--out", metavar="DIR", type=file_name, default=Path("run"), help="folder of results (run)"
    )
    parser.add_argument("--force", action="store_true", help="overwrite files that are something else")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """One drop, many, or the list of what may go wrong."""
    from tfsat_host.maneuver.schedule import servo_speed_notices
    from tfsat_host.rehearsal.prepared import RehearsalOptions

    if args.list_faults:
        return _list_faults(out)
    faults = _faults(args.fault)
    maneuver = maneuver_from(args)
    schedule = schedule_from(args, maneuver)
    notices = (*schedule.notices, *servo_speed_notices(schedule))
    for notice in notices:
        out.warn(notice)
    options = RehearsalOptions(args.sequencer, args.robot, args.as_filed, args.imu, args.despite_preflight)
    filed = options.filed()
    if args.runs > 1:
        from tfsat_host.cli.rehearse.many import rehearse_many

        return rehearse_many(args, options, maneuver, schedule, filed, faults, out)
    from tfsat_host.cli.rehearse.one import rehearse_one

    return rehearse_one(args, options, maneuver, schedule, filed, faults, notices, out)


def _runs(text: str) -> int:
    if not text.isdigit() or not 1 <= int(text) <= MOST_RUNS:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of runs from 1 to {MOST_RUNS}")
    return int(text)


def _faults(names: list[str]) -> tuple[Fault, ...]:
    from tfsat_host.rehearsal.faults.known import fault_named, require_different_parts

    if len(set(names)) < len(names):
        raise UsageError(
            what="A fault is named twice.", meaning="Nothing was flown.", next_step="Name each fault once."
        )
    faults = tuple(fault_named(name) for name in names)
    require_different_parts(faults)
    return faults


def _moments(fault: Fault) -> dict[str, str]:
    return {moment.typed: outcome.value for moment, outcome in fault.outcomes.items()}


def _list_faults(out: Output) -> int:
    from tfsat_host.rehearsal.faults.known import FAULTS
    from tfsat_host.rehearsal.moment import words_of

    rows = [
        (fault.name, fault.what, fault.moment.typed, words_of(fault.outcomes), fault.outcome.value)
        for fault in FAULTS
    ]
    listed = records((*FAULT, Column("moments", of=_moments), *fields("complete noticed")), FAULTS)
    columns = ("fault", "what happens", "when", "or @", "the robot then")
    out.result({"faults": listed}, lambda: out.table(columns, rows))
    return 0
