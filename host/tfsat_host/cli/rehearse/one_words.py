"""What one rehearsal shows."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output
from tfsat_host.units import s_from_us

if TYPE_CHECKING:
    from tfsat_host.cli.rehearse.run_folder import RunFolder
    from tfsat_host.maneuver import Schedule


def simulate_command(schedule: Schedule, until_s: float, maneuver: Path, rate_deg_s: Sequence[float]) -> str:
    """What computes the same drop of a robot as its file says, to the moment at which the truth is taken."""
    rates = " ".join(f"{rate:g}" for rate in rate_deg_s)
    until_s = max(until_s, s_from_us(schedule.end_us))  # `simulate` follows the joints to their rest
    return f"tfsat-host simulate --file {shlex.quote(str(maneuver))} --initial-rate {rates} --until {until_s:.3f}"


def show(schedule: Schedule, result: dict[str, Any], folder: RunFolder, out: Output) -> None:
    """The day in a few lines: preflight, strokes, attitude, card, verdict, and what was found beside what was true."""
    _show_preflight(result, out)
    if result["refused"]:
        out.line(f"Nothing was dropped:  {result['refused']}")
    elif result["reorientation_deg"] is not None:
        _show_flight(schedule, result, out)
    else:
        out.line("The recording holds no release.")
    for setback in result["setbacks"]:
        out.line(f"On the way:           {setback}")
    if result["verdict"]:
        out.line(
            f"The card:             {result['verdict']}, {result['samples']} samples at {result['rate_hz']:.1f} Hz, "
            f"{result['samples_lost']} lost."
        )
    _show_sequencer(result, out)
    _show_evaluation(result, out)
    out.line(f"Results:              {folder.path}")


def _show_preflight(result: dict[str, Any], out: Output) -> None:
    if result["preflight"] == "go":
        out.line("Preflight:            GO.")
    elif result["preflight"] == "no-go":
        out.line(f"Preflight:            NO-GO: {', '.join(result['no_go'])}.")


def _show_flight(schedule: Schedule, result: dict[str, Any], out: Output) -> None:
    seen = [f"{t_s:.4f}" for t_s in result["strokes_s"]]
    reached = result["reached_deg"]
    rows = [
        (
            f"{stroke.t_s:.2f}",
            seen[i] if i < len(seen) else "MISSING",
            f"joint {stroke.joint}",
            f"{stroke.angle_deg:+.2f}",
            "unknown" if i >= len(reached) or reached[i] is None else f"{reached[i]:+.1f}",
        )
        for i, stroke in enumerate(schedule.strokes)
    ]
    columns = ("scheduled / s", "in the log / s", "moves", "commanded / deg", "reached / deg")
    out.table(columns, rows, title="Strokes after release")
    changes = ", ".join(f"joint {i} {change:+.1f}" for i, change in enumerate(result["joint_change_deg"], 1))
    out.line(f"Joints went to:       {changes} deg, by the angle sensors.")
    out.line(
        f"Body 1 turned by:     {result['reorientation_deg']:.2f} deg by its gyro as it is; "
        f"the truth is {result['reorientation_true_deg']:.2f} deg."
    )
    rates = ", ".join(f"{rate:g}" for rate in result["initial_rate_deg_s"])
    out.line(
        f"Released turning at:  ({rates}) deg/s (body 3), about as the paper's robot was; `design` assumes rest."
    )
    out.line(f"As filed, computed:   {result['simulate_command']}")


def _show_sequencer(result: dict[str, Any], out: Output) -> None:
    if result["sequencer_state"] is None:
        out.line("The sequencer:        does not answer.")
        return
    knocks = result["knocks"]
    ignored = (
        f"; it ignored {knocks} knock{'' if knocks == 1 else 's'} (during the lift a blow is simulated that opens one "
        "switch)"
    )
    out.line(f"The sequencer:        {result['sequencer_state']}{ignored if knocks else ''}.")
    if result["sequencer_state"] == "armed":
        out.line(
            "                      STILL ARMED: its servos would move when both switches open. First of all:"
        )
        out.line("                      tfsat-host disarm")


def _show_evaluation(result: dict[str, Any], out: Output) -> None:
    verdict = result["evaluation"]
    if verdict is None:
        return
    if result["compared"]:
        rows = [
            (
                one["name"],
                f"{one['found']:.3f}",
                f"{one['std']:.3f}",
                f"{one['true']:.3f}",
                one["unit"],
                f"{one['deviations']:+.1f}",
            )
            for one in result["compared"]
        ]
        columns = ("", "evaluated", "±", "true", "unit", "off / ±")
        out.table(columns, rows, title="Evaluated, beside the hidden truth")
    out.line(f"The evaluation:       {verdict['level'].upper()}. {verdict['sentence']}")
    for reason in verdict["reasons"]:
        out.line(f"                      {reason}")
