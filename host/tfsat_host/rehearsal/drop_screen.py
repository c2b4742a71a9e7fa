"""One rehearsed drop on a terminal: a screen that a tired team reads, or everything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.result.drop_result import JOINTS, joints
from tfsat_host.evaluation.result.evaluation_tables import reasons_of
from tfsat_host.evaluation.result.first_screen import PredictionRow, prediction_table, stroke_summary
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.preflight_check import join_steps
from tfsat_host.present.evaluation_text import show_verdict
from tfsat_host.present.output import Output
from tfsat_host.present.sequencer_state import with_fault
from tfsat_host.present.terminal import bullets, printable, show_facts, show_rows, show_table, write_verdict
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.quantity import Column, Columns, Quantity, Table, decimals_of, number, plus_minus
from tfsat_host.rehearsal.faults.fault import Outcome
from tfsat_host.rehearsal.judgement import DETECTORS, STILL_DEG, JudgedFault, outcome_missed
from tfsat_host.rehearsal.result import MissingRelease, RehearsalResult, SwitchRecord, UncalibratedMotion
from tfsat_host.rehearsal.run_folder import SUMMARY
from tfsat_host.rehearsal.truth_comparison import COMPARED, EstimateAndTruth
from tfsat_host.robot.absent_parts import list_absent
from tfsat_host.run.drop_report import PAGE
from tfsat_host.run.files import PREFLIGHT, RECORDING

MAX_SIGMAS = 3.0
"""An error beyond it is named on the first screen."""
_MAX_NAMED = 3
_RED = "1;31"


def show_drop(result: RehearsalResult, out: Output, *, full: bool) -> None:
    """Show the verdict, faults, prediction and measurement, strokes, the day, and the verdict again.

    `full`: every number, not one screen.
    """
    _show_verdict(result, out, brief=False)
    out.line()
    for fault in result.judged.faults:
        show_facts(_fault_facts(result.judged.faults), fault, out)
        out.line()
    if not result.refused_by_preflight:
        _show_fall(result, out)
    if full:
        _show_everything(result, out)
    elif not result.refused_by_preflight:
        show_facts((*_DAY, *_RESULTS, _MORE), result, out)
        out.line()
    # The last line on the screen is the one that is read.
    _show_verdict(result, out, brief=True)


def _show_verdict(result: RehearsalResult, out: Output, *, brief: bool) -> None:
    """Write what the day came to; the reasons, too, if it is not brief."""
    drop, verdict = result.drop, result.judged.verdict
    evaluation, refusal = result.judged.evaluation, result.judged.refusal
    if verdict is not None and evaluation is not None:
        line = verdict.brief() if brief else verdict.line()
        # What the evaluation finds good may still be wrong by the truth.
        missed = ". Outcome with these faults: NOT as expected" if outcome_missed(drop) else ""
        show_verdict(verdict, f"{line}{missed}", out)
        bullets(() if brief else reasons_of(evaluation, verdict), out)
    # Without an evaluation: nothing was dropped, the recording cannot be evaluated, or there is none.
    elif result.refused_by_preflight:
        show_facts((_NO_GO_BRIEF,) if brief else _NO_GO, result, out, color=_RED)
    elif drop.refused is not None:
        more = "" if brief else f" {drop.refused.what} {drop.refused.meaning}"
        write_verdict(f"NOT DROPPED: refused by a board.{more}", _RED, out)
        bullets(() if brief else (drop.refused.next_step,), out)
    elif refusal is not None:
        more = "" if brief else f" {refusal.meaning}"
        write_verdict(f"NOT EVALUATED: {refusal.what}{more}", _RED, out)
        bullets(() if brief else (refusal.next_step,), out)
    else:
        write_verdict("NOT EVALUATED: no recording on the logger", _RED, out)


def _blocking_text(result: RehearsalResult) -> str:
    named = [f"{check.name} ({check.sentence.rstrip('.')})" for check in result.drop.blocking]
    return f"NO-GO: {'; '.join(named)}"


def _fault_facts(faults: Sequence[JudgedFault]) -> Columns:
    """Columns of one of a day's faults."""

    def undetected(fault: JudgedFault) -> str:
        if not fault.detectable:
            return "not detected (it changes nothing that is to be detected)"
        others = [other.fault.name for other in faults if other is not fault and other.detections]
        if not others:
            return "not detected"
        return f"not detected by its name ({' and '.join(others)} may hide it: rehearse it alone)"

    def detected_by(fault: JudgedFault) -> str:
        if fault.injected_s is None:
            return ""
        named = [
            f"{DETECTORS[detection.who]}{'' if detection.by_name else ', not by its name'}: "
            f"{detection.what.rstrip('.')}"
            for detection in fault.detections
        ]
        return "; ".join(named) or undetected(fault)

    return (
        Column(
            "", "Fault", words=lambda row: f"{row.fault.name} ({row.fault.moment.value}): {row.fault.what}"
        ),
        Column("", "Expected outcome", words=_expected_outcome),
        Column("", "Actual outcome", words=_actual_outcome),
        Column("", "Detected by", words=detected_by),
    )


def _expected_outcome(fault: JudgedFault) -> str:
    outcome = fault.fault.outcome
    judged = fault.reached is not None or outcome is Outcome.NOT_DROPPED
    return outcome.value if judged else f"{outcome.value}, if it is dropped"


def _actual_outcome(fault: JudgedFault) -> str:
    """Return what the robot did, by the truth, held against what it must do with the fault."""
    if fault.injected_s is None:
        return "not injected: the day ended before"
    if fault.reached is None:
        return "not dropped"
    if fault.reached:
        return "as expected"
    if fault.fault.outcome is Outcome.NOT_DROPPED:
        return "NOT as expected: dropped"
    # A fault that lets the robot do less overrules this one: judge the day by that.
    if fault.fault.outcome is not fault.expected and fault.expected_reached:
        return f"{fault.expected.value}, as expected of another fault"
    return f"NOT as expected: {_moved_text(fault.moved_deg.tolist())}"


def _moved_text(moved_deg: Sequence[float]) -> str:
    if max(moved_deg) < STILL_DEG:
        return f"no joint moved by more than {max(moved_deg):.1f} deg (truth)"
    joint_list = ", ".join(f"joint {joint} {moved:.1f}" for joint, moved in enumerate(moved_deg, 1))
    return f"largest motion {joint_list} deg (truth)"


def _show_fall(result: RehearsalResult, out: Output) -> None:
    """Show what the recording holds of the fall: evaluated, without calibration, or no release."""
    if result.judged.evaluation is not None:
        show_table(_prediction_and_truth(result.judged.evaluation, result.compared), out)
        strokes = stroke_summary(result.judged.evaluation)
        show_table(strokes, out)
        if strokes.caption:
            out.line()
    elif result.quick_look is not None:
        show_table(_uncalibrated_strokes(result, result.quick_look), out)
        show_facts(_UNCALIBRATED, result, out)
        out.line()
    if result.missing_release is not None:
        show_facts(_MISSING_RELEASE, result.missing_release, out)
        out.line()


def _prediction_and_truth(evaluation: Evaluation, compared: Sequence[EstimateAndTruth]) -> Table:
    """Return the evaluation's table, and the emulator's truth below it."""
    table = prediction_table(evaluation)
    true = [Quantity(estimate.true, None, estimate.unit) for estimate in compared[:1]]
    return replace(table, rows=[*table.rows, *(PredictionRow("truth (emulator)", turn, "") for turn in true)])


_UNCALIBRATED_STROKES: Columns = (
    Column("", "stroke", words=lambda row: f"{row[0]}: joint {row[1].joint}"),
    Column("", "commanded / deg", words=lambda row: f"{row[1].angle_deg:+.2f}"),
    Column("", "scheduled / s", words=lambda row: f"{row[1].t_s:.2f}"),
    Column("", "logged / s", words=lambda row: number(row[2], ".4f", "MISSING")),
    Column("", "flown / deg", words=lambda row: f"{number(row[3], '+.2f')} ± unknown"),
)


def _uncalibrated_strokes(result: RehearsalResult, motion: UncalibratedMotion) -> Table:
    strokes = result.schedule.strokes
    # A run that ended early has fewer strokes in the log than in the schedule.
    logged_s = [*result.strokes_s, *[np.nan] * len(strokes)]
    rows = [
        (index + 1, stroke, logged_s[index], motion.strokes_deg[index])
        for index, stroke in enumerate(strokes)
    ]
    return Table("Strokes, a quick look without calibration", _UNCALIBRATED_STROKES, rows)


def _joint_change_text(motion: UncalibratedMotion) -> str:
    changes = enumerate(motion.look.joint_change_deg, 1)
    listed = ", ".join(f"joint {joint} {change:+.1f}" for joint, change in changes)
    return f"{listed} ± unknown deg (one angle sensor each)"


def _turn_text(motion: UncalibratedMotion, true_deg: float | None) -> str:
    look = motion.look
    return (
        f"{look.reorientation_deg:.2f} ± unknown deg, release to {look.until_s:.2f} s "
        f"(truth: {number(true_deg or np.nan, '.2f')} deg)"
    )


_UNCALIBRATED: Columns = (
    Column("", "Largest change", words=lambda result: _joint_change_text(result.quick_look)),
    Column("", "Body 1 turned by", words=lambda result: _turn_text(result.quick_look, result.true_turn_deg)),
)


def _robot_motion_text(release: MissingRelease) -> str:
    strokes = release.strokes_started
    started = "unknown to both boards" if strokes is None else str(strokes)
    return (
        f"{release.hook_min:g} min on the hook, {release.fall_s:.2f} s fall; strokes started: {started}; "
        f"{_moved_text(release.joints_moved_true_deg.tolist())}"
    )


def _recording_blamed(release: MissingRelease) -> bool:
    """Whether the recording, and no switch, is why no release was seen."""
    return release.recording_ended_before_release_s is not None or not release.switches


def _recording_end_text(release: MissingRelease) -> str:
    if not _recording_blamed(release):
        return ""
    ended_s = release.recording_ended_before_release_s
    return "none left" if ended_s is None else f"breaks off {ended_s:.1f} s before the release"


def _switches_text(release: MissingRelease) -> str:
    return "" if _recording_blamed(release) else "; ".join(map(_switch_text, release.switches))


def _switch_text(switch: SwitchRecord) -> str:
    edges = switch.edges_s
    times = f"changed {len(edges)} times, first at {edges[0]:.3f} s" if edges else "never changed"
    return f"switch {switch.switch} {times}, {'open' if switch.open_at_the_end else 'closed'} at the end"


def _release_advice(release: MissingRelease) -> Advice:
    if _recording_blamed(release):
        return Advice(
            "disarm the robot, then check the logger's card and supply: ",
            NextStep("status"),
            ", ",
            NextStep("log list"),
        )
    return Advice(
        "a release is both switches open for 5 ms. Disarm the robot, press and let go of each switch and watch: ",
        NextStep("monitor"),
    )


_MISSING_RELEASE: Columns = (
    Column("", "Release", words=lambda _: "none in the recording: nothing to evaluate, no report"),
    Column("", "Robot's motion", words=_robot_motion_text),
    Column("", "End of recording", words=_recording_end_text),
    Column("", "Release switches", words=_switches_text),
    Column("", "To check", words=_release_advice),
)


def _robot_text(result: RehearsalResult) -> str:
    imu = f"IMUs {result.truth.imu}" if result.truth.imu else "exactly as its file says"
    absent = f", without {', '.join(parts)}" if (parts := list_absent(result.filed)) else ""
    return f"seed {result.truth.seed} of {printable(result.filed.path.name)}, {imu}{absent}"


def _preflight_text(result: RehearsalResult) -> str:
    if result.preflight_go is None:
        return ""
    despite = "" if result.refused_by_preflight else "; dropped by --despite-preflight"
    return "GO" if result.preflight_go else f"{_blocking_text(result)}{despite}"


def _recording_text(result: RehearsalResult) -> str:
    if result.log is None:
        return ""
    source = "RAM of the logger" if result.drop.from_ram else "card"
    log = result.log
    return f"{log.verdict}, {len(log)} samples at {log.rate_hz:.1f} Hz, {log.samples_lost} lost ({source})"


def _sequencer_text(result: RehearsalResult) -> str:
    status = result.drop.sequencer
    if status is None:
        return "does not respond"
    state = status.state.name.lower()
    parts: list[str | NextStep] = [with_fault(state, status.fault.name.lower())]
    if status.state is SequencerState.FAULT:
        parts.append(f" (last start: {status.reset_cause.name.lower().replace('_', ' ')})")
    if status.knocks:
        parts.append(f", {status.knocks} false trigger{'' if status.knocks == 1 else 's'} rejected")
    if status.false_releases:
        times = f"{status.false_releases} false release{'' if status.false_releases == 1 else 's'}"
        parts.append(f", {times} (both switches opened and closed again; no joint moved)")
    # An armed robot moves as soon as both switches open: whoever takes it out of the tower must know.
    if state == "armed":
        parts += [". STILL ARMED, servos move when both switches open. First: ", NextStep("disarm")]
    return Advice(*parts)


def _estimate_text(result: RehearsalResult) -> str:
    """Return how many numbers have a truth, the largest error, and the errors that are too large."""
    compared = [row for row in result.compared if np.isfinite(row.deviations)]
    if not compared:
        return ""
    ranked = sorted(compared, key=lambda row: -abs(row.deviations))
    outliers = [row for row in ranked if abs(row.deviations) > MAX_SIGMAS]
    named = [f"{row.name} {row.deviations:+.1f} σ" for row in outliers[:_MAX_NAMED]]
    if not outliers:
        worst = ranked[0]
        estimate = plus_minus(worst.estimate, worst.std)
        true = number(worst.true, f".{decimals_of(worst.std)}f")
        return (
            f"{len(compared)} numbers, largest error {worst.deviations:+.1f} σ ({worst.name}: "
            f"{estimate} {worst.unit}, truth {true})"
        )
    return f"{len(compared)} numbers, {len(outliers)} off by more than {MAX_SIGMAS:g} σ: {', '.join(named)}"


_DAY: Columns = (
    Column("", "Robot", words=_robot_text),
    Column("", "Preflight", words=_preflight_text),
    Column("", "Setbacks", words=lambda result: join_steps(" ", result.drop.setbacks)),
    Column("", "Recording", words=_recording_text),
    Column("", "Sequencer", words=_sequencer_text),
    Column("", "Estimate and truth", words=_estimate_text),
)


def _next_command(result: RehearsalResult) -> str:
    if result.evaluated is not None:
        return Advice(NextStep("evaluate", (str(result.folder),)))
    if result.log is None:
        return ""
    return Advice(NextStep("decode", (str(result.folder / RECORDING),)))


_RESULTS: Columns = (
    Column(
        "",
        "Results",
        words=lambda result: f"{result.folder}{'' if result.evaluated is None else f' (open {PAGE})'}",
    ),
    Column("", "Next", words=_next_command),
)
_MORE = Column("", "More", words=lambda result: f"the same command with --full, or {result.folder / SUMMARY}")
_NO_GO: Columns = (
    Column("", "Preflight", words=_blocking_text),
    Column(
        "", "All checks", words=lambda result: f"the same command with --full, or {result.folder / PREFLIGHT}"
    ),
    Column("", "To drop anyway", words=lambda _: "the same command with --despite-preflight"),
)
_NO_GO_BRIEF = Column(
    "",
    "Preflight",
    words=lambda result: f"NO-GO: {', '.join(check.name for check in result.drop.blocking)}",
)


def _release_rate_text(result: RehearsalResult) -> str:
    if result.true_until_s is None:
        return ""
    rates = ", ".join(f"{rate:g}" for rate in result.initial_rate_deg_s)
    return f"{rates} deg/s (x, y, z of body 3, emulator)"


_TRUTH: Columns = (
    Column("", "True release rate", words=_release_rate_text),
    Column("", "Simulate this drop", words=lambda result: result.simulate_command or ""),
)


def _show_everything(result: RehearsalResult, out: Output) -> None:
    """Show the day, and what the first screen leaves out."""
    steps = [
        Advice(f"{check.name}: {check.sentence} On the day: ", check.next_step)
        for check in result.drop.blocking
    ]
    if steps:
        bullets(steps, out)
        out.line()
    show_facts((*_DAY, *_TRUTH), result, out)
    out.line()
    if result.evaluated is not None:
        shown = tuple(column for column in JOINTS if column.key in ("joint", "initial_deg", "final_deg"))
        show_rows(shown, joints(result.evaluated.found), out, title="Joint angles")
    if result.compared:
        show_rows(COMPARED, result.compared, out, title="Estimate and truth")
    show_facts(_RESULTS, result, out)
    out.line()
