"""One evaluated drop for people: what a tired team wants to know, in that order; and what several say together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.result.evaluation_tables import reasons_of, tables_of
from tfsat_host.evaluation.result.key_numbers import key_numbers_of
from tfsat_host.evaluation.result.model_result import remarks as model_remarks
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import bullets, sentences, show_quantities, show_table, write_labelled
from tfsat_host.quantity import Table, plus_minus, vector


def show_evaluation(
    evaluation: Evaluation,
    verdict: Verdict,
    recording: str,
    sources: Iterable[tuple[str, str]],
    remarks: Sequence[str],
    out: Output,
) -> None:
    """Verdict, key numbers, where they come from, tables, notes.

    Args:
        evaluation: The evaluation.
        verdict: What it is worth.
        recording: Where it was, and of when.
        sources: Label and text of each other file that it was made of.
        remarks: What else a reader should know.
        out: Where to.
    """
    write_labelled("Verdict", f"{verdict.level.upper()}. {verdict.sentence}", out)
    bullets(reasons_of(evaluation, verdict), out)
    out.line()
    # Strokes have a table of their own below.
    show_quantities((quantity for quantity in key_numbers_of(evaluation) if quantity.group != "Strokes"), out)
    turn = evaluation.reorientation
    axes = {"Rotation vector x, y, z": turn.rotation_vector_rad, "Euler angles z, y, x": turn.euler_zyx_rad}
    sentences(
        [f"{name}: {vector(np.rad2deg(angles), form='+.2f')} deg" for name, angles in axes.items()], out
    )
    out.line()
    log = evaluation.log
    write_labelled("Recording", f"{recording}: {log.verdict}", out)
    write_labelled("", f"{len(log)} samples at {log.rate_hz:.1f} Hz, {log.samples_lost} lost", out)
    write_labelled("Gyros", _lag_words(evaluation), out)
    for label, text in sources:
        write_labelled(label, text, out)
    for table in tables_of(evaluation):
        out.line()
        show_table(table, out)
    sentences(model_remarks(evaluation), out)
    others = [note for note in (*evaluation.notes, *remarks) if note not in verdict.reasons]
    if others:
        out.line()
        out.line("Notes")
        bullets(others, out)


def show_comparison(tables: Sequence[Table], remarks: Sequence[str], out: Output) -> None:
    """Show the joint results of several drops; without tables, say that no joint correction is to be made."""
    if not tables:
        out.line("No correction of all drops together: that of each drop is withheld.")
        sentences(remarks, out)
    for table in tables:
        show_table(table, out)


def _lag_words(evaluation: Evaluation) -> str:
    if not evaluation.gives("rates"):
        return "delay withheld"
    lag = evaluation.motion.lag
    late = f"{plus_minus(1e3 * lag.delay_s, 1e3 * lag.delay_std_s)} ms late"
    if not lag.measured:
        return f"{late} by their data sheet, taken off"
    return f"{late} by the strokes, taken off; {1e3 * lag.expected_s:.1f} ms by their data sheet"
