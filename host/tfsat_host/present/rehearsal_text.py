"""A rehearsal on a terminal: the result of one drop, or the distribution of many."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import printable, show_rows
from tfsat_host.quantity import Column, Columns, plus_minus

Json = dict[str, Any]
Line = tuple[str, str]
"""What a line begins with, empty for one that goes on, and its text."""

_WIDTH = 22
_NOT_DROPPED = "is not dropped"
_MIN_RUNS_FOR_SHARE = 20
"""Below, the intervals that hold are counted: a share of few drops says less than their number."""
WHO = {
    "preflight": "the preflight's checks",
    "refusal": "a board, which refused to go on",
    "board": "a board after the landing",
    "log": "the log",
    "report": "the evaluation",
    "report refuses": "the evaluation, which refused",
}


def _logged_time(stroke: Json) -> str:
    return "MISSING" if stroke["logged_s"] is None else f"{stroke['logged_s']:.4f}"


_FLOWN: Columns = (
    Column("scheduled_s", "scheduled", form=".2f"),
    Column("logged_s", "in the log", words=_logged_time),
    Column("joint", "joint"),
    Column("commanded_deg", "commanded", form="+.2f"),
    Column("size_deg", "flown", std="size_std_deg", form="+.2f"),
)
_COMPARED: Columns = (
    Column("name", "number"),
    Column("found", "estimate"),
    Column("std", "±"),
    Column("true", "true"),
    Column("unit", "unit"),
    Column("deviations", "error (σ)", form="+.1f"),
)


def show(result: Json, folder: Path, still_deg: float, out: Output) -> None:
    """Show the day in a few lines.

    They are robot, faults, preflight, strokes, attitude, card, verdict, and found values next to true ones.

    Args:
        result: Of `Rehearsal.run`.
        folder: The run's.
        still_deg: A joint that moved by less stood still.
        out: The terminal.
    """
    imu = f"IMUs {result['imu']}" if result["imu"] else "exactly as its file says"
    robot = f"seed {result['seed']} of {printable(result['robot']['file'])}, {imu}."
    _lines([("The robot:", robot), *_faults(result["faults"]), *_preflight(result)], out)
    # One of three days: nothing was dropped, it fell without a recorded release, or it flew.
    if result["refused"]:
        _lines(_refusal_lines(result), out)
    elif result["no_release"]:
        _lines(_no_release(result["no_release"], folder, still_deg), out)
    else:
        _show_flight(result, out)
    _lines([*_after(result), *_evaluation(result)], out)
    if result["compared"]:
        show_rows(_COMPARED, result["compared"], out, title="Estimate and truth")
    if verdict := result["evaluation"]:
        of_drop = ("The evaluation:", f"{verdict['level'].upper()}. {verdict['sentence']}")
        _lines([of_drop, *(("", reason) for reason in verdict["reasons"])], out)
    _lines([("Results:", str(folder))], out)


def _lines(lines: Iterable[Line], out: Output) -> None:
    for label, text in lines:
        # A label that is too long still has a space behind it.
        out.line(Advice(f"{label:<{_WIDTH - 1}} ", text))


def _faults(faults: Sequence[Json]) -> Iterator[Line]:
    """Yield a few lines for each fault."""
    for fault in faults:
        yield "Fault:", f"{fault['name']} ({fault['when']}): {fault['what']}"
        if fault["struck_s"] is None:
            yield "", "It did not strike: the day ended before."
            continue
        yield "", f"By design the robot then {fault['outcome']}{_if_dropped(fault)}.{_came_of(fault)}"
        for notice in fault["noticed_by"]:
            unnamed = "" if notice["by_name"] else ", not by the fault's name"
            yield "", f"Noticed by {WHO[notice['who']]}{unnamed}: {notice['what']}"
        if not fault["noticed_by"]:
            yield "", _unnoticed_text(fault, faults)


def _if_dropped(fault: Json) -> str:
    judged = fault["came_of_it"] is not None
    return "" if judged or fault["outcome"] == _NOT_DROPPED else ", if it is dropped"


def _came_of(fault: Json) -> str:
    """Format whether the outcome by design came about; empty if it was not judged, as without a drop."""
    did = fault["came_of_it"]
    if did is None:
        return ""
    if fault["outcome"] == _NOT_DROPPED:
        return " It was not." if did else " It WAS."
    if did:
        return " It did."
    # A fault that lets the robot do less overruled this one: judge the day by that.
    if fault["outcome"] != fault["outcome_of_all"] and fault["all_came_of_it"]:
        return f" It did not, for another fault: with that it {fault['outcome_of_all']}, and it did."
    moved = ", ".join(f"{moved:.1f}" for moved in fault["joints_moved_true_deg"])
    return f" It did NOT: in truth joints 1, 2, 3 moved by up to {moved} deg."


def _unnoticed_text(fault: Json, faults: Sequence[Json]) -> str:
    if not fault["to_be_noticed"]:
        return "Not noticed. It changes nothing that is to be noticed."
    others = [
        other_fault["name"]
        for other_fault in faults
        if other_fault is not fault and other_fault["noticed_by"]
    ]
    if not others:
        return "Not noticed."
    return f"Not noticed by its own name. What {' and '.join(others)} did may hide it: rehearse it alone."


def _preflight(result: Json) -> Iterator[Line]:
    if result["preflight"] == "go":
        yield "Preflight:", "GO."
    if result["preflight"] != "no-go":
        return
    yield "Preflight:", f"NO-GO: {', '.join(result['no_go'])}."
    for check in result["no_go_checks"]:
        yield f"  {check['name']}", check["sentence"]
        if check["next_step"]:
            yield "", f"On the day: {check['next_step']}"
    yield "", f"All checks, with the numbers behind them: {result['preflight_file']}"
    if not result["refused"]:
        yield "", "It was dropped all the same: --despite-preflight."


def _refusal_lines(result: Json) -> Iterator[Line]:
    if result["refused_by"] != "preflight":
        yield "Nothing was dropped:", result["refused"]
        return
    yield "Nothing was dropped:", "the preflight says NO-GO."
    yield "", "To see what would have come of it: the same command with --despite-preflight."


def _no_release(facts: Json, folder: Path, still_deg: float) -> Iterator[Line]:
    """Yield lines on the robot's drop, the logger's record of its switches, and what to check next."""
    yield "No release:", "the recording holds none: there is nothing to evaluate, and no report."
    strokes = facts["strokes_started"]
    started = (
        "how many strokes it started no board knows"
        if strokes is None
        else f"it started {strokes} stroke{'' if strokes == 1 else 's'}"
    )
    yield (
        "What the robot did:",
        f"it hung {facts['hook_min']:g} minutes on the hook, was let go and fell {facts['fall_s']:.2f} s; {started}; "
        f"in truth {_moved_text(facts['joints_moved_true_deg'], still_deg)}.",
    )
    ended_s = facts["recording_ended_before_release_s"]
    if ended_s is not None or not facts["switches"]:
        # The switches are not to blame: nothing recorded what they did.
        broken = f"of the drop: the recording breaks off {ended_s or 0.0:.1f} s before the release."
        yield (
            "What the logger saw:",
            f"nothing{': no recording is left.' if ended_s is None else f' {broken}'}",
        )
        yield (
            "Next:",
            "find out why nothing more was kept: card and supply of the logger, robot disarmed:",
        )
        yield "", Advice(NextStep("status"), ", ", NextStep("log list"))
        return
    for switch in facts["switches"]:
        edges = switch["edges_s"]
        times = f"changed {len(edges)} times, first at {edges[0]:.3f} s" if edges else "never changed"
        end = "open" if switch["open_at_the_end"] else "closed"
        yield "What the logger saw:", f"switch {switch['switch']} {times}, and was {end} at the end."
    yield "Next:", "both switches must be open for 5 ms. Press and let go of each, robot disarmed,"
    yield "", Advice("and watch them: ", NextStep("monitor"), ". Their edges in this recording:")
    yield "", Advice(NextStep("decode", (str(folder / "SD.bin"),)))


def _moved_text(moved_deg: Sequence[float], still_deg: float) -> str:
    if max(moved_deg) < still_deg:
        return f"no joint moved by more than {max(moved_deg):.1f} deg"
    each = ", ".join(f"joint {joint} by up to {moved:.1f} deg" for joint, moved in enumerate(moved_deg, 1))
    return f"its joints moved: {each}"


def _show_flight(result: Json, out: Output) -> None:
    if result["evaluation"] is not None:
        _show_motion(result["evaluation"], out)
    elif result["quick_look"] is not None:
        _show_quick_look(result, out)
    rates = ", ".join(f"{rate:g}" for rate in result["initial_rate_deg_s"])
    lines = [
        (
            "True release rate:",
            f"{rates} deg/s (x, y, z of body {result['initial_rate_body']}, emulator)",
        )
    ]
    if result["simulate_command"]:
        lines.append(("Simulate this drop:", result["simulate_command"]))
    _lines(lines, out)


def _show_motion(evaluation: Json, out: Output) -> None:
    show_rows(_FLOWN, evaluation["strokes"], out, title="Strokes after the release, as evaluated")
    lines = []
    end = f" ({evaluation['until_s']:.2f} s)"
    for name, when, note in (("initial", "at release", ""), ("final", "at the end", end)):
        angles = ", ".join(
            f"joint {joint['joint']} {_format_estimate(joint[f'{name}_deg'], joint[f'{name}_deg_std'], sign=True)}"
            for joint in evaluation["joints"]
        )
        lines.append((f"Angles {when}:", f"{angles} deg{note}"))
    turned = _format_estimate(evaluation["reorientation_deg"], evaluation["reorientation_deg_std"])
    lines.append(("Body 1 turned by:", f"{turned} deg from the release to {evaluation['until_s']:.2f} s."))
    _lines(lines, out)


def _format_estimate(value: float | None, std: float | None, *, sign: bool = False) -> str:
    """Format a number with its standard deviation; null is unknown, or withheld."""
    if value is None:
        return "unknown"
    return plus_minus(value, float("nan") if std is None else std, sign=sign)


def _show_quick_look(result: Json, out: Output) -> None:
    """Without an evaluation: what the log shows at first sight, of unknown accuracy."""
    look, logged = result["quick_look"], result["strokes_s"]
    rows = [
        {
            "scheduled_s": stroke["t_s"],
            # A run that ended early has fewer strokes in the log than in the schedule.
            "logged_s": logged[i] if i < len(logged) else None,
            "joint": stroke["joint"],
            "commanded_deg": stroke["angle_deg"],
            "size_deg": look["strokes_deg"][i],
        }
        for i, stroke in enumerate(result["schedule"])
    ]
    show_rows(_FLOWN, rows, out, title="Strokes after the release, a quick look: no calibration")
    changes = ", ".join(f"joint {i} {change:+.1f}" for i, change in enumerate(look["joint_change_deg"], 1))
    turned = (
        f"{look['reorientation_deg']:.2f} deg from the release to {look['until_s']:.2f} s by its gyro less its rest, "
        f"± unknown; the truth is {result['reorientation_true_deg']:.2f} deg."
    )
    change = f"{changes} deg from before the release, by one angle sensor each, ± unknown."
    _lines([("Greatest change of:", change), ("Body 1 turned by:", turned)], out)


def _after(result: Json) -> Iterator[Line]:
    """Yield lines on the card, and on the sequencer after the landing."""
    for setback in result["setbacks"]:
        yield "On the way:", setback
    if result["verdict"]:
        yield (
            "The card:" if result["recording_from"] == "card" else "RAM of the logger:",
            f"{result['verdict']}, {result['samples']} samples at {result['rate_hz']:.1f} Hz, "
            f"{result['samples_lost']} lost.",
        )
    state, knocks = result["sequencer_state"], result["knocks"]
    if state is None:
        yield "The sequencer:", "does not answer."
        return
    blow = "(a blow in the lift opens one switch)"
    ignored = f", {knocks} false trigger{'' if knocks == 1 else 's'} rejected {blow}" if knocks else ""
    yield "The sequencer:", f"{state}{ignored}."
    if false_releases := result["false_releases"]:
        times = "once" if false_releases == 1 else f"{false_releases} times"
        yield (
            "",
            f"Both switches opened and closed again for good {times}: no release, and nothing moved for it.",
        )
    # An armed robot moves as soon as both switches open: whoever takes it out of the tower must know.
    if state == "armed":
        yield "", "STILL ARMED: its servos would move when both switches open. First of all:"
        yield "", Advice(NextStep("disarm"))


def _evaluation(result: Json) -> Iterator[Line]:
    if (refused := result["evaluation_refused"]) is not None:
        yield "The evaluation:", f"REFUSED. {refused['what']} {refused['meaning']}"
        yield "", refused["next_step"]


def _held_pose_text(distribution: Any) -> str:
    if distribution.count < _MIN_RUNS_FOR_SHARE:
        return f"{round(distribution.held * distribution.count)} of {distribution.count}"
    return f"{100.0 * distribution.held:.0f} %"


_DISTRIBUTIONS: Columns = (
    Column("name", "number"),
    Column("unit", "unit"),
    Column("mean_true", "true, mean"),
    Column("spread_true", "spread"),
    Column("rms_error", "error, rms", form=".4f"),
    Column("largest_error", "largest", form=".4f"),
    Column("stated_std", "stated ±", form=".4f"),
    Column("held", "95 % hold", words=_held_pose_text),
)


def show_series(result: Json, spread: Sequence[Any], table: Path, again: str, out: Output) -> None:
    """Show the distributions of the numbers of many drops.

    Args:
        result: Of `Rehearsal.run_many`.
        spread: Distributions of the numbers that were compared with the truth.
        table: The file with a row for each drop.
        again: What to type to fly one of them again.
        out: The terminal.
    """
    imu = f"IMUs {result['imu']}" if result["imu"] else "exactly as its file says"
    out.line(f"Drawn from seed {result['seed']}, robots of {result['robot']['file']}, {imu}.")
    for fault in result["faults_noticed"]:
        by = "; ".join(f"{WHO[who]}: {times}" for who, times in fault["noticed_by"].items())
        out.line(
            f"Fault of each: {fault['name']}. It struck in {fault['struck']} and was noticed in {fault['noticed']} of "
            f"them{f' ({by})' if by else ''}."
        )
    if result["broke_design"]:
        drops = ", ".join(map(str, result["broke_design"]))
        out.line(f"The robot did NOT do what it must with these faults, by the truth, in drop {drops}.")
    if spread:
        show_rows(
            _DISTRIBUTIONS, spread, out, title=f"What {result['runs']} evaluations found, and the truth"
        )
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
    # Three show the pattern; the table has all.
    for refusal in result["refused"][:3]:
        out.line(f"Drop {refusal['number']} was not let go: {refusal['why']}")
    out.line(f"Each drop: {table}; one of them again, with its seed from there:")
    out.line(again)
