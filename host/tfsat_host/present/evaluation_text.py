"""One evaluated drop for people: one screen that a tired team reads, or everything; and what several say together."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.result.evaluation_tables import reasons_of, tables_of
from tfsat_host.evaluation.result.first_screen import change_sentence, prediction_table, stroke_summary
from tfsat_host.evaluation.result.key_numbers import key_numbers_of
from tfsat_host.evaluation.result.model_result import remarks as model_remarks
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import (
    bullets,
    sentences,
    show_quantities,
    show_table,
    wrap_bullet,
    wrap_sentence,
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

    `recording` tells where it was, and of when; `sources` has label and text of each other file that it was
    made of. `more` shows every number and table; None: they are shown.
    """
    show_verdict(verdict, verdict.line(), out)
    reasons = reasons_of(evaluation, verdict)
    change = change_sentence(evaluation)
    if more is None:
        bullets(reasons, out)
    else:
        # Reasons get what the rest of the screen leaves, which has a line for each stroke.
        wrapped_lines = sum(len(wrap_sentence(text, out)) for text in (verdict.line(), change))
        room = MAX_LINES - _OTHER_LINES - len(evaluation.strokes) - wrapped_lines
        _show_first_reasons(reasons, room, more, out)
    out.line()
    notes = [note for note in (*evaluation.notes, *remarks) if note not in verdict.reasons]
    if more is None:
        _show_everything(evaluation, recording, sources, notes, out)
    else:
        show_table(prediction_table(evaluation), out)
        sentences([change], out)
        out.line()
        # Remarks on strokes are reasons of the verdict.
        show_table(replace(stroke_summary(evaluation), caption=""), out)
        log = evaluation.log
        write_labelled("Recording:", f"{recording}: {log.verdict}, {log.samples_lost} samples lost", out)
        for label, text in sources:
            write_labelled(f"{label}:", text, out)
        notes_text = f", {len(notes)} note{'' if len(notes) == 1 else 's'}" if notes else ""
        write_labelled("More:", f"all numbers and tables{notes_text}: {more}", out)
    out.line()
    # The last line on the screen is the one that is read.
    show_verdict(verdict, verdict.brief(), out)


def _show_first_reasons(reasons: Sequence[str], room: int, more: NextStep, out: Output) -> None:
    """Show the gravest reasons, in full where they fit, else their first sentences; then how many more there are.

    The first is the gravest: it has its first sentence even if there is no `room`, in lines. `more` shows all
    of them.
    """

    def lines(texts: Iterable[str]) -> int:
        return sum(len(wrap_bullet(text, out)) for text in texts)

    if len(reasons) <= MAX_REASONS and lines(reasons) <= room:
        bullets(reasons, out)
        return
    shown = [_SENTENCE_END.split(out.complete(reason), 1)[0] for reason in reasons[:MAX_REASONS]]
    room -= len(wrap_bullet(f"{len(reasons)} more reasons: {more}", out))
    while len(shown) > 1 and lines(shown) > room:
        shown.pop()
    # Likely cause and next step of the gravest reason, if there is room for them.
    if lines([reasons[0], *shown[1:]]) <= room:
        shown[0] = reasons[0]
    bullets(shown, out)
    hidden = len(reasons) - len(shown)
    label = f"{hidden} more reason{'' if hidden == 1 else 's'}" if hidden else "Reasons in full"
    out.line(Advice(f"  {label}: ", more))


def show_verdict(verdict: Verdict, line: str, out: Output) -> None:
    """Write a verdict's line, coloured on a terminal by its level."""
    write_verdict(line, _COLORS[verdict.level], out)


MAX_LINES = 40
"""Of the first screen, at 80 columns."""
MAX_REASONS = 5
"""On the first screen."""
_OTHER_LINES = 23
"""Of the first screen, but for the first verdict, the reasons, the correction and the strokes."""
_SENTENCE_END = re.compile(r"(?<=[^.][.!?]) (?=[A-Z])")
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
    ends_with_text = True
    for table in tables_of(evaluation):
        # Rows end with an empty line of their own.
        if ends_with_text:
            out.line()
        show_table(table, out)
        ends_with_text = bool(table.caption or table.fold)
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
