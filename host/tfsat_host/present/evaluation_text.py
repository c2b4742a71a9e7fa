"""One evaluated drop for people: one screen that a tired team reads, or everything; and what several say together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.result.evaluation_tables import reasons_of, tables_of
from tfsat_host.evaluation.result.first_screen import change_sentence, prediction_table, stroke_summary
from tfsat_host.evaluation.result.key_numbers import key_numbers_of
from tfsat_host.evaluation.result.model_result import remarks as model_remarks
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.next_step import NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import (
    bullets,
    sentences,
    show_quantities,
    show_table,
    write_labelled,
    write_verdict,
)
from tfsat_host.quantity import Table, plus_minus, vector


def show_evaluation(
    evaluation: Evaluation,
    verdict: Verdict,
    recording: str,
    sources: Iterable[tuple[str, str]],
    remarks: Sequence[str],
    out: Output,
    *,
    more: NextStep | None,
) -> None:
    """Show the verdict, what decides about the next drop, and the verdict again.

    Args:
        evaluation: The evaluation.
        verdict: What it is worth.
        recording: Where it was, and of when.
        sources: Label and text of each other file that it was made of.
        remarks: What else a reader should know.
        out: Where to.
        more: What shows every number and table; None: they are shown.
    """
    show_verdict(verdict, verdict.line(), out)
    bullets(reasons_of(evaluation, verdict), out)
    out.line()
    notes = [note for note in (*evaluation.notes, *remarks) if note not in verdict.reasons]
    if more is None:
        _show_everything(evaluation, recording, sources, notes, out)
    else:
        show_table(prediction_table(evaluation), out)
        sentences([change_sentence(evaluation)], out)
        out.line()
        show_table(stroke_summary(evaluation), out)
        log = evaluation.log
        write_labelled("Recording:", f"{recording}: {log.verdict}, {log.samples_lost} samples lost", out)
        for label, text in sources:
            write_labelled(f"{label}:", text, out)
        notes_text = f", {len(notes)} note{'' if len(notes) == 1 else 's'}" if notes else ""
        write_labelled("More:", f"all numbers and tables{notes_text}: {more}", out)
    out.line()
    # The last line on the screen is the one that is read.
    show_verdict(verdict, verdict.brief(), out)


def show_verdict(verdict: Verdict, line: str, out: Output) -> None:
    """Write a verdict's line, coloured on a terminal by its level."""
    write_verdict(line, _COLORS[verdict.level], out)


_COLORS = {"good": "1;32", "doubtful": "1;33", "failed": "1;31"}


def _show_everything(
    evaluation: Evaluation,
    recording: str,
    sources: Iterable[tuple[str, str]],
    notes: Sequence[str],
    out: Output,
) -> None:
    # Strokes have a table of their own below.
    show_quantities((quantity for quantity in key_numbers_of(evaluation) if quantity.group != "Strokes"), out)
    turn = evaluation.reorientation
    axes = {"Rotation vector x, y, z": turn.rotation_vector_rad, "Euler angles z, y, x": turn.euler_zyx_rad}
    sentences(
        [f"{name}: {vector(np.rad2deg(angles), form='+.2f')} deg" for name, angles in axes.items()], out
    )
    out.line()
    log = evaluation.log
    write_labelled("Recording:", f"{recording}: {log.verdict}", out)
    write_labelled("", f"{len(log)} samples at {log.rate_hz:.1f} Hz, {log.samples_lost} lost", out)
    write_labelled("Gyro delay:", _lag_words(evaluation), out)
    for label, text in sources:
        write_labelled(f"{label}:", text, out)
    for table in tables_of(evaluation):
        out.line()
        show_table(table, out)
    sentences(model_remarks(evaluation), out)
    if notes:
        out.line()
        out.line("Notes")
        bullets(notes, out)


def show_comparison(tables: Sequence[Table], remarks: Sequence[str], out: Output) -> None:
    """Show the joint results of several drops; without tables, say that no joint correction is to be made."""
    if not tables:
        out.line("Correction by all drops: withheld (that of each drop is)")
        sentences(remarks, out)
    for table in tables:
        show_table(table, out)


def _lag_words(evaluation: Evaluation) -> str:
    if not evaluation.is_given("rates"):
        return "withheld"
    lag = evaluation.motion.lag
    delay = f"{plus_minus(1e3 * lag.delay_s, 1e3 * lag.delay_std_s)} ms"
    if not lag.measured:
        return f"{delay}, compensated (data sheet)"
    return f"{delay}, estimated and compensated (data sheet: {1e3 * lag.expected_s:.1f} ms)"
