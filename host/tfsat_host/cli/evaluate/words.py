"""One evaluated drop for people: what a tired team wants to know, in that order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tfsat_host.present.output import Output
from tfsat_host.present.terminal import bullets, labelled, printable, sentences, show_quantities, show_table
from tfsat_host.quantity import plus_minus, vector

if TYPE_CHECKING:
    from tfsat_host.evaluation.evaluation import Evaluation
    from tfsat_host.run.evaluated import EvaluatedRun


def show(run: EvaluatedRun, out: Output) -> None:
    """Verdict, key numbers, where they come from, tables, notes."""
    import numpy as np

    from tfsat_host.evaluation.result.key_numbers import key_numbers_of
    from tfsat_host.evaluation.result.model import remarks
    from tfsat_host.evaluation.result.tables import reasons_of, tables_of

    labelled("Verdict", f"{run.verdict.level.upper()}. {run.verdict.sentence}", out)
    bullets(reasons_of(run.found, run.verdict), out)
    out.line()
    show_quantities((one for one in key_numbers_of(run.found) if one.group != "Strokes"), out)
    turn = run.found.reorientation
    axes = {"Rotation vector x, y, z": turn.rotation_vector_rad, "Euler angles z, y, x": turn.euler_zyx_rad}
    sentences(
        [f"{name}: {vector(np.rad2deg(angles), form='+.2f')} deg" for name, angles in axes.items()], out
    )
    out.line()
    _show_sources(run, out)
    for table in tables_of(run.found):
        out.line()
        show_table(table, out)
    sentences(remarks(run.found), out)
    others = [note for note in (*run.found.notes, *run.remarks) if note not in run.verdict.reasons]
    if others:
        out.line()
        out.line("Notes")
        bullets(others, out)


def _show_sources(run: EvaluatedRun, out: Output) -> None:
    log = run.found.log
    when = "at an unknown time of day" if run.recorded is None else f"{run.recorded:%Y-%m-%d %H:%M:%S} UTC"
    labelled(
        "Recording",
        f"{printable(run.files.recording)}, {log.session:08x}, released {when}: {log.verdict}",
        out,
    )
    labelled("", f"{len(log)} samples at {log.rate_hz:.1f} Hz, {log.samples_lost} lost", out)
    labelled("Gyros", _lag_words(run.found), out)
    held = "none" if run.held is None else printable(run.held.path)
    if run.held is not None:
        held += ", which does not hold as it is" if run.held.said else ", which holds"
    labelled("Calibrated", held, out)
    labelled("Maneuver", "unknown" if run.files.maneuver is None else printable(run.files.maneuver), out)


def _lag_words(found: Evaluation) -> str:
    lag = found.motion.lag
    late = f"{plus_minus(1e3 * lag.delay_s, 1e3 * lag.delay_std_s)} ms late"
    if not lag.measured:
        return f"{late} by their data sheet, taken off"
    return f"{late} by the strokes, taken off; {1e3 * lag.expected_s:.1f} ms by their data sheet"
