"""What one rehearsal shows."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.rehearse.thrown import show_thrown
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import printable, show_rows
from tfsat_host.quantity import Column, Columns, plus_minus
from tfsat_host.units import s_from_us

if TYPE_CHECKING:
    from tfsat_host.maneuver import Schedule
    from tfsat_host.rehearsal.run_folder import RunFolder

Json = dict[str, Any]

_INDENT = " " * 22


def _logged(stroke: Json) -> str:
    return "MISSING" if stroke["logged_s"] is None else f"{stroke['logged_s']:.4f}"


_FLOWN: Columns = (
    Column("scheduled_s", "scheduled", form=".2f"),
    Column("logged_s", "in the log", words=_logged),
    Column("joint", "joint"),
    Column("commanded_deg", "commanded", form="+.2f"),
    Column("size_deg", "flown", std="size_std_deg", form="+.2f"),
)
COMPARED: Columns = (
    Column("name", "number"),
    Column("found", "evaluated"),
    Column("std", "±"),
    Column("true", "true"),
    Column("unit", "unit"),
    Column("deviations", "off / ±", form="+.1f"),
)
"""Numbers of the evaluation, each against the truth."""


def simulate_command(
    schedule: Schedule, until_s: float, maneuver: Path, robot: Path, rate_deg_s: Sequence[float]
) -> str:
    """What computes the same drop of a robot as its file says, to the moment at which the truth is taken."""
    rates = " ".join(f"{rate:g}" for rate in rate_deg_s)
    until_s = max(until_s, s_from_us(schedule.end_us))  # `simulate` follows the joints to their rest
    return (
        f"tfsat-host simulate --file {shlex.quote(str(maneuver))} --initial-rate {rates} --until {until_s:.3f} "
        f"--robot {shlex.quote(str(robot))}"
    )


def show(schedule: Schedule, result: Json, folder: RunFolder, out: Output) -> None:
    """The day in a few lines: robot, faults, preflight, strokes, attitude, card, verdict, and found beside true."""
    imu = f"IMUs {result['imu']}" if result["imu"] else "exactly as its file says"
    out.line(f"The robot:            seed {result['seed']} of {printable(result['robot']['file'])}, {imu}.")
    show_thrown(result["faults"], out)
    _show_preflight(result, out)
    if result["refused"]:
        _show_refused(result, out)
    elif result["no_release"]:
        _show_no_release(result, folder, out)
    else:
        _show_flight(schedule, result, out)
    for setback in result["setbacks"]:
        out.line(f"On the way:           {setback}")
    if result["verdict"]:
        out.line(
            f"{'The card:' if result['recording_from'] == 'card' else 'RAM of the logger:':<22}"
            f"{result['verdict']}, {result['samples']} samples at {result['rate_hz']:.1f} Hz, "
            f"{result['samples_lost']} lost."
        )
    _show_sequencer(result, out)
    _show_evaluation(result, out)
    out.line(f"Results:              {folder.path}")


def _show_preflight(result: Json, out: Output) -> None:
    if result["preflight"] == "go":
        out.line("Preflight:            GO.")
    if result["preflight"] != "no-go":
        return
    out.line(f"Preflight:            NO-GO: {', '.join(result['no_go'])}.")
    for check in result["no_go_checks"]:
        out.line(f"  {check['name']:<20}{check['sentence']}")
        if check["next_step"]:
            out.line(f"{_INDENT}On the day: {check['next_step']}")
    out.line(f"{_INDENT}All checks, with the numbers behind them: {result['preflight_file']}")
    if not result["refused"]:
        out.line(f"{_INDENT}It was dropped all the same: --despite-preflight.")


def _show_refused(result: Json, out: Output) -> None:
    if result["refused_by"] == "preflight":
        out.line("Nothing was dropped:  the preflight says NO-GO, and nobody drops a robot then.")
        out.line(f"{_INDENT}To see what would have come of it: the same command with --despite-preflight.")
    else:
        out.line(f"Nothing was dropped:  {result['refused']}")


def _show_no_release(result: Json, folder: RunFolder, out: Output) -> None:
    """What the robot did, what the logger saw of its switches, and where to look."""
    found = result["no_release"]
    out.line("No release:           the recording holds none: there is nothing to evaluate, and no report.")
    strokes = found["strokes_started"]
    started = (
        "how many strokes it started no board knows"
        if strokes is None
        else f"it started {strokes} stroke{'' if strokes == 1 else 's'}"
    )
    joints = f"; in truth {_moved(found['joints_moved_true_deg'])}"
    out.line(
        f"What the robot did:   it hung {found['hook_min']:g} minutes on the hook, was let go and fell "
        f"{found['fall_s']:.2f} s; {started}{joints}."
    )
    ended_s = found["recording_ended_before_release_s"]
    if ended_s is not None or not found["switches"]:
        _show_no_recording(ended_s, out)
        return
    for switch in found["switches"]:
        edges = switch["edges_s"]
        times = f"changed {len(edges)} times, first at {edges[0]:.3f} s" if edges else "never changed"
        end = "open" if switch["open_at_the_end"] else "closed"
        out.line(f"What the logger saw:  switch {switch['switch']} {times}, and was {end} at the end.")
    out.line(
        "Next:                 both switches must be open for 5 ms. Press and let go of each, robot disarmed,"
    )
    out.line(f"{_INDENT}and watch them: tfsat-host monitor. Their edges in this recording:")
    out.line(f"{_INDENT}tfsat-host decode {shlex.quote(str(folder.path / 'SD.bin'))}")


def _moved(moved_deg: Sequence[float]) -> str:
    """What the joints did, by the truth."""
    from tfsat_host.rehearsal.outcome import STILL_DEG

    if max(moved_deg) < STILL_DEG:
        return f"no joint moved by more than {max(moved_deg):.1f} deg"
    each = ", ".join(f"joint {joint} by up to {moved:.1f} deg" for joint, moved in enumerate(moved_deg, 1))
    return f"its joints moved: {each}"


def _show_no_recording(ended_s: float | None, out: Output) -> None:
    """The switches are not to blame: nobody wrote down what they did."""
    if ended_s is None:
        out.line("What the logger saw:  nothing: no recording is left.")
    else:
        out.line(
            f"What the logger saw:  nothing of the drop: the recording breaks off {ended_s:.1f} s before the release."
        )
    out.line(
        "Next:                 find out why nothing more was kept: card and supply of the logger, robot disarmed:"
    )
    out.line(f"{_INDENT}tfsat-host status, tfsat-host log list")


def _show_flight(schedule: Schedule, result: Json, out: Output) -> None:
    if result["evaluation"] is not None:
        _show_evaluated_motion(result, out)
    else:
        _show_quick_look(schedule, result, out)
    rates = ", ".join(f"{rate:g}" for rate in result["initial_rate_deg_s"])
    out.line(
        f"In truth let go at:   ({rates}) deg/s, body {result['initial_rate_body']} about its own axes x, y, z, about "
        "as the paper's robot was; `design` assumes rest."
    )
    if result["simulate_command"]:
        out.line(f"As filed, computed:   {result['simulate_command']}")


def _show_evaluated_motion(result: Json, out: Output) -> None:
    found = result["evaluation"]
    show_rows(_FLOWN, found["strokes"], out, title="Strokes after the release, as evaluated")
    for name, when in (("initial", "at the release"), ("final", f"at {found['until_s']:.2f} s")):
        angles = ", ".join(
            f"joint {one['joint']} {_told(one[f'{name}_deg'], one[f'{name}_deg_std'])}"
            for one in found["joints"]
        )
        out.line(f"Joints stood at:      {angles} deg {when}.")
    turned = plus_minus(found["reorientation_deg"], found["reorientation_deg_std"])
    out.line(f"Body 1 turned by:     {turned} deg from the release to {found['until_s']:.2f} s.")


def _told(value: float | None, std: float | None) -> str:
    """A number with its standard deviation; null is what nobody knows."""
    if value is None:
        return "unknown"
    return plus_minus(value, float("nan") if std is None else std, sign=True)


def _show_quick_look(schedule: Schedule, result: Json, out: Output) -> None:
    """Without an evaluation: what the log shows at first sight, and that nobody knows how well."""
    look = result["quick_look"]
    if look is None:
        return
    seen, sizes = result["strokes_s"], look["strokes_deg"]
    rows = [
        {
            "scheduled_s": stroke.t_s,
            "logged_s": seen[i] if i < len(seen) else None,
            "joint": stroke.joint,
            "commanded_deg": stroke.angle_deg,
            "size_deg": sizes[i],
        }
        for i, stroke in enumerate(schedule.strokes)
    ]
    show_rows(_FLOWN, rows, out, title="Strokes after the release, a quick look: no calibration")
    changes = ", ".join(f"joint {i} {change:+.1f}" for i, change in enumerate(look["joint_change_deg"], 1))
    out.line(
        f"Greatest change of:   {changes} deg from before the release, by one angle sensor each, ± unknown."
    )
    out.line(
        f"Body 1 turned by:     {look['reorientation_deg']:.2f} deg from the release to {look['until_s']:.2f} s by its "
        f"gyro less its rest, ± unknown; the truth is {result['reorientation_true_deg']:.2f} deg."
    )


def _show_sequencer(result: Json, out: Output) -> None:
    if result["sequencer_state"] is None:
        out.line("The sequencer:        does not answer.")
        return
    knocks = result["knocks"]
    ignored = (
        f"; it ignored {knocks} knock{'' if knocks == 1 else 's'} (during the lift a blow is simulated that opens one "
        "switch)"
    )
    out.line(f"The sequencer:        {result['sequencer_state']}{ignored if knocks else ''}.")
    if false_releases := result["false_releases"]:
        times = "once" if false_releases == 1 else f"{false_releases} times"
        out.line(
            f"{_INDENT}Both switches opened and closed again for good {times}: no release, and nothing moved for it."
        )
    if result["sequencer_state"] == "armed":
        out.line(f"{_INDENT}STILL ARMED: its servos would move when both switches open. First of all:")
        out.line(f"{_INDENT}tfsat-host disarm")


def _show_evaluation(result: Json, out: Output) -> None:
    verdict, refused = result["evaluation"], result["evaluation_refused"]
    if refused is not None:
        out.line(f"The evaluation:       REFUSED. {refused['what']} {refused['meaning']}")
        out.line(f"{_INDENT}{refused['next_step']}")
    if verdict is None:
        return
    if result["compared"]:
        show_rows(COMPARED, result["compared"], out, title="Evaluated, and the truth")
    out.line(f"The evaluation:       {verdict['level'].upper()}. {verdict['sentence']}")
    for reason in verdict["reasons"]:
        out.line(f"{_INDENT}{reason}")
