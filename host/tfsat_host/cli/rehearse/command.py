"""`tfsat-host rehearse`: a maneuver, flown whole on the emulated robot."""

from __future__ import annotations

import argparse
import shlex
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.maneuver_argument import add_maneuver_arguments, maneuver_from, schedule_from
from tfsat_host.cli.options import add_output_options, file_name, seed
from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError
from tfsat_host.units import s_from_us

if TYPE_CHECKING:
    from tfsat_host.emulated.rehearsal import Rehearsal
    from tfsat_host.evaluation.quick.quick_look import QuickLook
    from tfsat_host.maneuver import Schedule
    from tfsat_host.sdlog import DropLog

LOOK_MARGIN_S = 0.05
"""The integration ends this long before the landing."""


def configure(parser: argparse.ArgumentParser) -> None:
    """What to fly, on which sequencer, and where the results go."""
    parser.description = (
        "Fly a maneuver on the emulated robot: upload, arm, crane lift with a knock, release with contact "
        "bounce, strokes, fall, landing; then decode the card and compare with the truth. "
        "The firmware is the one that is flashed."
    )
    add_maneuver_arguments(parser, nothing_done="Nothing was flown.")
    parser.add_argument(
        "--sequencer",
        choices=("native", "avr"),
        default="native",
        help="the firmware's core on this computer, or the HEX that is flashed in an emulated ATmega32U4",
    )
    parser.add_argument(
        "--seed",
        metavar="N",
        type=seed,
        default=1,
        help="for sensor errors, noise and bounce (default 1)",
    )
    parser.add_argument(
        "--out", metavar="DIR", type=file_name, default=Path("run"), help="folder of results (run)"
    )
    parser.add_argument("--force", action="store_true", help="overwrite files that are something else")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Flies, writes the card, decodes it and compares."""
    from tfsat_host.cli.rehearsal_files import RunFolder
    from tfsat_host.maneuver.servo_speed import servo_speed_notices

    maneuver = maneuver_from(args)
    schedule = schedule_from(args, maneuver)
    notices = (*schedule.notices, *servo_speed_notices(schedule))
    for notice in notices:
        out.warn(notice)
    folder = RunFolder(args.out, force=args.force)
    flight = _fly(args, schedule, out)
    log = folder.write(maneuver, flight)
    if folder.removed:
        names = ", ".join(str(path.relative_to(folder.path)) for path in folder.removed)
        out.note(f"Removed from {folder.path}, for they were of the recording before: {names}.")
    look = _look(log, flight)
    result = _result(args, schedule, flight, log, look, folder) | {"notices": notices}
    folder.write_summary(result)
    out.result(result, lambda: _show(schedule, flight, log, look, result, out))
    for warning in result["warnings"]:
        out.warn(warning)
    as_planned = log.verdict == "complete" and not result["warnings"]
    return 0 if as_planned else DataLossError.exit_code


def _fly(args: argparse.Namespace, schedule: Schedule, out: Output) -> Rehearsal:
    from tfsat_host.emulated.build import Variant, ensure_built
    from tfsat_host.emulated.rehearsal import rehearse
    from tfsat_host.emulated.sequencer_image import sequencer_hex

    avr = args.sequencer == "avr"
    hex_path = None
    if avr:
        from tfsat_host.emulated.sequencer_image import sequencer_hex

        hex_path = sequencer_hex(out.note)
    ensure_built(Variant(avr=avr), out.note)
    steps = 5
    with out.progress("rehearsing", total=steps) as advance:
        return rehearse(schedule, seed=args.seed, hex_path=hex_path, progress=lambda _: advance(1))


def _look(log: DropLog, flight: Rehearsal) -> QuickLook:
    from tfsat_host.evaluation.quick.quick_look import quick_look
    from tfsat_host.robot import load_robot

    return quick_look(log, load_robot(), until_s=flight.landed_s - flight.released_s - LOOK_MARGIN_S)


def _result(
    args: argparse.Namespace,
    schedule: Schedule,
    flight: Rehearsal,
    log: DropLog,
    look: QuickLook,
    folder: Any,
) -> dict[str, Any]:
    from tfsat_host.emulated.rehearsal import RESIDUAL_RATE_DEG_S
    from tfsat_host.emulated.truth import true_reorientation_deg
    from tfsat_host.evaluation.quick.strokes import disagreements, reached_deg
    from tfsat_host.robot import load_robot

    commanded_deg = [stroke.angle_deg for stroke in schedule.strokes]
    starts_s = [stroke.t_s for stroke in schedule.strokes]
    joints = [stroke.joint for stroke in schedule.strokes]
    reached = reached_deg(log, load_robot(), joints, starts_s, flight.landed_s - flight.released_s)
    truth_deg = true_reorientation_deg(flight.truth, flight.released_s, look.until_s)
    return {
        "schedule": schedule.as_rows(),
        "end_s": schedule.end_s,
        "initial_rate_deg_s": list(RESIDUAL_RATE_DEG_S),
        "simulate_command": _simulate_command(schedule, look, folder.maneuver, RESIDUAL_RATE_DEG_S),
        "verified": True,
        "sequencer": args.sequencer,
        "seed": args.seed,
        "sequencer_state": flight.sequencer.state.name.lower(),
        "knocks": flight.sequencer.knocks,
        "strokes_s": look.stroke_s,
        "reached_deg": [None if isnan(angle) else float(angle) for angle in reached],
        "joint_change_deg": look.joint_change_deg,
        "reorientation_deg": look.reorientation_deg,
        "reorientation_true_deg": truth_deg,
        "verdict": log.verdict,
        "samples": len(log),
        "samples_lost": log.samples_lost,
        "rate_hz": log.rate_hz,
        "warnings": disagreements(starts_s, look.stroke_s, commanded_deg, reached),
        "files": [str(path) for path in folder.files],
    }


def _simulate_command(
    schedule: Schedule, look: QuickLook, maneuver: Path, rate_deg_s: tuple[float, ...]
) -> str:
    """What computes the same drop without the emulated robot, to the moment at which the truth is taken."""
    rates = " ".join(f"{rate:g}" for rate in rate_deg_s)
    until_s = max(look.until_s, s_from_us(schedule.end_us))  # `simulate` follows the joints to their rest
    return f"tfsat-host simulate --file {shlex.quote(str(maneuver))} --initial-rate {rates} --until {until_s:.3f}"


def _show(
    schedule: Schedule, flight: Rehearsal, log: DropLog, look: QuickLook, result: dict[str, Any], out: Output
) -> None:
    seen = [f"{t_s:.4f}" for t_s in look.stroke_s]
    rows = [
        (
            f"{stroke.t_s:.2f}",
            seen[i] if i < len(seen) else "MISSING",
            f"joint {stroke.joint}",
            f"{stroke.angle_deg:+.2f}",
            "unknown" if result["reached_deg"][i] is None else f"{result['reached_deg'][i]:+.1f}",
        )
        for i, stroke in enumerate(schedule.strokes)
    ]
    columns = ("scheduled / s", "in the log / s", "moves", "commanded / deg", "reached / deg")
    out.table(columns, rows, title="Strokes after release")
    changes = ", ".join(f"joint {i} {change:+.1f}" for i, change in enumerate(look.joint_change_deg, 1))
    out.line(f"Joints went to:       {changes} deg, by the angle sensors.")
    out.line(
        f"Body 1 turned by:     {look.reorientation_deg:.2f} deg by its gyro; "
        f"the truth is {result['reorientation_true_deg']:.2f} deg."
    )
    rates = ", ".join(f"{rate:g}" for rate in result["initial_rate_deg_s"])
    out.line(f"Released turning at:  ({rates}) deg/s, as the robot of the paper was; `design` assumes rest.")
    out.line(f"The same, computed:   {result['simulate_command']}")
    out.line(
        f"The card:             {log.verdict}, {len(log)} samples at {log.rate_hz:.1f} Hz, {log.samples_lost} lost."
    )
    knocks = flight.sequencer.knocks
    out.line(
        f"The sequencer:        {flight.sequencer.state.name.lower()}; it ignored {knocks} "
        f"knock{'' if knocks == 1 else 's'} (during the lift a blow is simulated that opens one switch)."
    )
    out.line(f"Results:              {Path(result['files'][0]).parent}")
