"""One evaluated drop for people: what a tired team wants to know, in that order."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from tfsat_host.cli.evaluate.phrases import bullets, labelled, number, plus_minus, printable
from tfsat_host.cli.evaluate.words_model import show_model
from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun
    from tfsat_host.evaluation.checks.check import Check
    from tfsat_host.evaluation.clocks.clock_fit import ClockFit
    from tfsat_host.evaluation.evaluation import Evaluation
    from tfsat_host.evaluation.strokes.strokes_flown import FlownStroke
    from tfsat_host.evaluation.witnesses.laser import ReleaseVelocity
    from tfsat_host.robot.model import FloatArray


def show(run: EvaluatedRun, out: Output) -> None:
    """Verdict, key numbers, strokes, joints, the model, checks, notes."""
    _show_verdict(run, out)
    out.line()
    _show_drop(run, out)
    out.line()
    _show_strokes(run.found, out)
    _show_joints(run.found, out)
    show_model(run.found, out)
    _show_checks(run.found.checks, out)
    others = [note for note in (*run.found.notes, *run.remarks) if note not in run.verdict.reasons]
    if others:
        out.line("Notes")
        bullets(others, out)


def _show_verdict(run: EvaluatedRun, out: Output) -> None:
    """Each reason once; a check's comes with its cause and cure."""
    from tfsat_host.report.contents.reasons import reasons_of

    labelled("Verdict", f"{run.verdict.level.upper()}. {run.verdict.sentence}", out)
    bullets(reasons_of(run.found, run.verdict), out)


def _show_drop(run: EvaluatedRun, out: Output) -> None:
    import numpy as np

    from tfsat_host.report.contents.correction import MISSED

    found, turn = run.found, run.found.reorientation
    bridged = ", with parts of it bridged from other bodies" if turn.bridged else ""
    angle, std = np.rad2deg([turn.angle_rad, turn.std_rad])
    labelled(
        "Body 1",
        f"turned by {plus_minus(angle, std)} deg in the {found.motion.t_s[-1]:.2f} s after the release{bridged}",
        out,
    )
    labelled("", f"rotation vector x, y, z: {_three(turn.rotation_vector_rad)} deg", out)
    labelled("", f"Euler angles z, y, x: {_three(turn.euler_zyx_rad)} deg", out)
    rate = found.initial_rates[0]
    pairs = zip(np.rad2deg(rate.rate_rad_s), np.rad2deg(rate.std_rad_s), strict=True)
    labelled(
        "Released",
        f"turning at {', '.join(plus_minus(r, s, sign=True) for r, s in pairs)} deg/s about x, y, z",
        out,
    )
    if found.release_velocity is not None:
        labelled("", _velocity_words(found.release_velocity), out)
    before, after = found.explained.before.error, found.explained.after.error
    labelled(
        "Model",
        f"misses the attitude by {number(np.rad2deg(before.final_norm_rad), 3)} deg at the end, "
        f"{before.mahalanobis:.1f} standard deviations; corrected, by {number(np.rad2deg(after.final_norm_rad), 3)} "
        f"deg, {after.mahalanobis:.1f} ({MISSED})",
        out,
    )
    labelled("Gyros", _lag_words(found), out)
    if found.clocks is not None and found.clocks.sequencer is not None:
        labelled("Clocks", _clock_words(found.clocks.sequencer), out)
    if found.clocks is not None and found.clocks.video is not None:
        labelled("", _clock_words(found.clocks.video), out)
    _show_sources(run, out)


def _show_sources(run: EvaluatedRun, out: Output) -> None:
    log = run.found.log
    when = "at an unknown time of day" if run.recorded is None else f"{run.recorded:%Y-%m-%d %H:%M:%S} UTC"
    labelled(
        "Recording",
        f"{printable(run.files.recording)}, {log.session:08x}, released {when}: {log.verdict}",
        out,
    )
    labelled("", f"{len(log)} samples at {log.rate_hz:.1f} Hz, {log.samples_lost} lost", out)
    held = "none" if run.held is None else printable(run.held.path)
    if run.held is not None:
        held += ", which does not hold as it is" if run.held.said else ", which holds"
    labelled("Calibrated", held, out)
    labelled("Maneuver", "unknown" if run.files.maneuver is None else printable(run.files.maneuver), out)


def _velocity_words(found: ReleaseVelocity) -> str:
    down, across = found.downward, found.transversal_speed
    words = f"moving at {plus_minus(down.value_mm_s, down.std_mm_s)} mm/s downwards ({_JUDGED[found.downward_judged]})"
    if across is None or found.transversal_judged is None:
        return words
    sideways = plus_minus(across.value_mm_s, across.std_mm_s)
    return f"{words}, {sideways} mm/s sideways ({_JUDGED[found.transversal_judged]})"


_JUDGED = {"within": "as permitted", "outside": "NOT PERMITTED", "uncertain": "perhaps as permitted"}


def _lag_words(found: Evaluation) -> str:
    lag = found.motion.lag
    late = f"{plus_minus(1e3 * lag.delay_s, 1e3 * lag.delay_std_s)} ms late"
    if not lag.measured:
        return f"{late} by their data sheet, taken off"
    return f"{late} by the strokes, taken off; {1e3 * lag.expected_s:.1f} ms by their data sheet"


def _clock_words(fit: ClockFit) -> str:
    return (
        f"the {fit.name}'s runs {'slow' if fit.rate_ppm < 0.0 else 'fast'} by "
        f"{plus_minus(abs(fit.rate_ppm), fit.rate_ppm_std)} ppm, and was zero "
        f"{plus_minus(1e3 * fit.offset_s, 1e3 * fit.offset_std_s, sign=True)} ms after the release"
    )


def _show_strokes(found: Evaluation, out: Output) -> None:
    if found.strokes:
        columns = ("joint", "told", "went", "start / s", "late / ms", "deg/s", "beyond")
        out.table(columns, [_stroke_row(stroke) for stroke in found.strokes], title="Strokes; angles in deg")


def _stroke_row(stroke: FlownStroke) -> tuple[object, ...]:
    import numpy as np

    told, went, std, mean, beyond = np.rad2deg(
        [
            stroke.commanded_rad,
            stroke.size_rad,
            stroke.size_std_rad,
            stroke.mean_rate_rad_s,
            stroke.overshoot_rad,
        ]
    )
    return (
        str(stroke.joint),
        f"{told:+.2f}",
        plus_minus(went, std, sign=True) if np.isfinite(went) else "unknown",
        number(stroke.start_s, 4) if stroke.moved else "never",
        number(1e3 * stroke.dead_time_s, 1),
        number(mean, 1, sign=True),
        number(beyond, 2),
    )


def _show_joints(found: Evaluation, out: Output) -> None:
    import numpy as np

    release = int(np.searchsorted(found.motion.t_s, 0.0))
    rows = []
    for joint in found.motion.joints:
        angle, std = np.rad2deg(joint.angle_rad), np.rad2deg(joint.std_rad())
        apart = [number(float(np.rad2deg(sensor.rms_rad)), 3) for sensor in joint.sensors]
        ends = (plus_minus(angle[at], std[at], sign=True) for at in (release, -1))
        rows.append((str(joint.joint), *ends, *apart))
    columns = ("joint", "at release / deg", "at the end / deg", "sensor 1 off", "sensor 2 off")
    out.table(columns, rows, title="Joint angles, gyros and angle sensors fused; sensors off in deg rms")


def _show_checks(checks: tuple[Check, ...], out: Output) -> None:
    passed = sum(check.verdict == "passed" for check in checks)
    failed = [check.name for check in checks if check.verdict == "failed"]
    impossible = [check for check in checks if check.verdict == "not possible"]
    words = [f"{passed} of {len(checks)} passed"]
    if failed:
        words.append(f"failed (see the top): {', '.join(failed)}")
    if impossible:
        words.append(f"{len(impossible)} not possible:")
    labelled("Checks", "; ".join(words), out)
    bullets([f"{check.name}: {check.sentence}" for check in impossible], out)


def _three(angles_rad: FloatArray) -> str:
    return "  ".join(number(math.degrees(value), 2, sign=True) for value in angles_rad)
