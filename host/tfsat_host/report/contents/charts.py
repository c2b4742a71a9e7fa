"""All charts of a drop, in the order in which one reads them: rates, joints, what the sensors show of each other."""

from __future__ import annotations

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.apply import apply_calibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.com_fit.model_comparison import BODY_1
from tfsat_host.evaluation.com_fit.momentum_average import PAPER_SIZE, MovingAverage, averaged_momentum
from tfsat_host.evaluation.com_fit.momentum_residual import inertial_momentum, residual_rate
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.spectra import WINDOWS, compare_spectra, leakage
from tfsat_host.quantity import plus_minus
from tfsat_host.report.contents.attitude_charts import (
    attitude_error_chart,
    attitude_spectrum_chart,
    euler_chart,
)
from tfsat_host.report.contents.chart import AXES, Chart, Kind, Line, Side, lines_of, pad_rows, spectrum_chart
from tfsat_host.report.contents.withheld_curves import withhold_curves
from tfsat_host.sdlog.droplog import rows_of
from tfsat_host.units import STANDARD_GRAVITY_M_S2, s_from_us

AVERAGED = 9
"""Samples: neighbours' noise hides what misalignment does."""
SHOWN_HZ = 5.0
_FLOOR = 1e-6
PER_KG_M2_S = 1e3
"""Of one kg m²/s, which is one N m s."""
_MOMENTUM_UNIT = "mN m s"
_MOMENTA = [f"h{axis}" for axis in AXES]
_NAMES = [f"ω{axis}" for axis in AXES]


def charts_of(evaluation: Evaluation) -> dict[str, Chart]:
    """Build all charts of an evaluation, by id, without curves that a failed check withholds."""
    charts = (
        euler_chart(evaluation),
        rate_chart(evaluation),
        joint_chart(evaluation),
        averaged_momentum_chart(evaluation),
        attitude_error_chart(evaluation),
        momentum_spectrum_chart(evaluation),
        rate_spectrum_chart(evaluation),
        attitude_spectrum_chart(evaluation),
        momentum_chart(evaluation),
        unexplained_chart(evaluation),
        gyro_residual_chart(evaluation),
        force_chart(evaluation),
        window_chart(evaluation),
    )
    return {chart.id: withhold_curves(chart, evaluation) for chart in charts}


def rate_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of the angular rate of body 1, as its own gyro measured it."""
    moved, fall = evaluation.motion.bodies[BODY_1], evaluation.motion.samples.fall
    rates = np.rad2deg(pad_rows(fall, moved.rate_rad_s))
    lag = evaluation.motion.lag
    source = "estimated" if lag.measured else "data sheet"
    return Chart(
        "rates",
        "Angular velocity of body 1",
        "rate (deg/s)",
        tuple(Line(name, rates[:, axis], axis, "measured") for axis, name in enumerate(_NAMES)),
        f"Body axes. Gyro delay: {plus_minus(1e3 * lag.delay_s, 1e3 * lag.delay_std_s)} ms ({source}, compensated).",
    )


def rate_spectrum_chart(evaluation: Evaluation) -> Chart:
    """Build the chart with the spectrum of body 1's rate error: measured − predicted."""
    sides = evaluation.explained.nominal.error, evaluation.explained.fitted.error
    before, after = (np.rad2deg(error.rate_rad_s) for error in sides)
    return spectrum_chart(
        "rate_spectrum",
        "Spectrum of the rate error of body 1",
        "deg/s",
        compare_spectra(sides[0].t_s, before, after),
        [f"δ{name}" for name in _NAMES],
    )


def unexplained_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of the base's residual rate: measured − predicted at constant momentum."""
    explained, kinematics = evaluation.explained, evaluation.explained.driven.flown
    rows = evaluation.motion.t_s >= kinematics.t_s[0]
    # Nominal model: only constant momentum explains the rate; fitted model: the residual of the fit.
    before = residual_rate(
        explained.driven.offsets.body, kinematics, explained.nominal.prediction.momentum_kg_m2_s
    )
    values = (before, explained.fit.residual_rad_s)
    filed, corrected = (np.rad2deg(pad_rows(rows, rates)) for rates in values)
    sides: list[Side] = [("before", filed, None), ("after", corrected, None)]
    return Chart(
        "unexplained",
        f"Residual rate of {evaluation.model.body_names[evaluation.model.base]}",
        "rate (deg/s)",
        tuple(lines_of(_NAMES, sides, by_side=True)),
        "Measured − predicted at constant momentum; fitted model: also − the fitted sensor errors. "
        f"Residual variance of the fit: {explained.fit.excess:.2g} times that of the sensors' noise.",
    )


def models_of(evaluation: Evaluation) -> tuple[tuple[Kind, Multibody], ...]:
    """Return the nominal and the fitted multibody model."""
    explained = evaluation.explained
    offsets = explained.driven.offsets
    return ("before", offsets.body), ("after", offsets.correct(explained.fit.values))


def momentum_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of the angular momentum, every sample without averaging."""
    kinematics = evaluation.explained.driven.flown
    rows = evaluation.motion.t_s >= kinematics.t_s[0]
    sides: list[Side] = [
        (kind, pad_rows(rows, PER_KG_M2_S * inertial_momentum(body, kinematics)), None)
        for kind, body in models_of(evaluation)
    ]
    return Chart(
        "momentum_raw",
        "Angular momentum, every sample",
        f"momentum ({_MOMENTUM_UNIT})",
        tuple(lines_of(_MOMENTA, sides, by_side=True)),
        "Not averaged: with gyro noise, and transients while joints accelerate.",
    )


def averaged_momentum_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of the angular momentum by the paper's moving average."""
    averages = dict(averages_of(evaluation))
    sides: list[Side] = [
        # The moving average has no values at the ends: place those it has by their times.
        (kind, pad_rows(np.isin(evaluation.motion.t_s, average.t_s), PER_KG_M2_S * average.values), None)
        for kind, average in averages.items()
    ]
    cutoff = averages["before"].cutoff_hz
    strayed = [1e6 * float(average.strayed.mean()) for average in averages.values()]
    return Chart(
        "momentum",
        "Angular momentum of all bodies",
        f"momentum ({_MOMENTUM_UNIT})",
        tuple(lines_of(_MOMENTA, sides, by_side=True)),
        f"Inertial axes, moving average over {PAPER_SIZE} samples (cutoff {cutoff:.1f} Hz). Mean deviation from the "
        f"first value: {strayed[0]:.3g} µN m s (nominal model), {strayed[1]:.3g} µN m s (fitted model).",
    )


def averages_of(evaluation: Evaluation) -> tuple[tuple[Kind, MovingAverage], ...]:
    """Compute the momentum by either model, averaged over the paper's window.

    A shorter record is averaged over all its samples.
    """
    kinematics = evaluation.explained.driven.flown
    # A window longer than the record would leave no value at all.
    size = min(PAPER_SIZE, len(kinematics.t_s))
    return tuple((kind, averaged_momentum(body, kinematics, size)) for kind, body in models_of(evaluation))


def momentum_spectrum_chart(evaluation: Evaluation) -> Chart:
    """Build the chart with the momentum's spectrum, computed from every sample."""
    kinematics = evaluation.explained.driven.flown
    before, after = (PER_KG_M2_S * inertial_momentum(body, kinematics) for _, body in models_of(evaluation))
    return spectrum_chart(
        "momentum_spectrum",
        "Spectrum of the momentum",
        _MOMENTUM_UNIT,
        compare_spectra(kinematics.t_s, before, after),
        _MOMENTA,
    )


def joint_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of all joint angles over the drop's times, measured and commanded."""
    lines = [
        Line(
            f"joint {joint.joint}",
            np.rad2deg(joint.angle_rad),
            joint.joint - 1,
            "measured",
            np.rad2deg(joint.std_rad()),
        )
        for joint in evaluation.motion.joints
        if not evaluation.model.servos[joint.joint - 1].absent
    ]
    commanded = commanded_rad(evaluation)
    if commanded is not None:
        lines += [
            Line(f"joint {index + 1} commanded", np.rad2deg(angle), index, "commanded")
            for index, angle in enumerate(commanded.T)
            if not evaluation.model.servos[index].absent
        ]
    return Chart(
        "joints",
        "Joint angles",
        "angle (deg)",
        tuple(lines),
        "Angle sensors and adjacent gyros, fused. Commanded: at the schedule's mean speed. Band: ± 1 standard "
        "deviation.",
    )


def commanded_rad(evaluation: Evaluation) -> FloatArray | None:
    """(n, joints) at the samples' times; None if the maneuver is not known."""
    if evaluation.schedule is None:
        return None
    t_s = evaluation.motion.t_s
    angles = np.tile([servo.start_rad for servo in evaluation.model.servos], (len(t_s), 1))
    for timed, stroke in zip(evaluation.schedule.strokes, evaluation.strokes, strict=True):
        begin = stroke.logged_s if np.isfinite(stroke.logged_s) else timed.t_s
        # A ramp at the average speed; at least the clock's microsecond, so that nothing divides by 0.
        took = max(s_from_us(timed.end_us - timed.t_us), 1e-6)
        share = np.clip((t_s - begin) / took, 0.0, 1.0)
        angles[:, timed.joint - 1] += np.deg2rad(timed.angle_deg) * share
    return np.asarray(angles)


def gyro_residual_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of each gyro's residual against the motion that fits all of them best."""
    residual_deg_s = np.rad2deg(evaluation.motion.fused.residual_rad_s)
    residual_deg_s = np.where(evaluation.motion.samples.fall[:, None, None], residual_deg_s, np.nan)
    # (n, bodies, 3) body by body, each smoothed along time.
    averaged = np.stack([_moving_average(body) for body in residual_deg_s.swapaxes(0, 1)], axis=1)
    return Chart(
        "gyro_residuals",
        "Disagreement of adjacent gyros",
        "rate, norm (deg/s)",
        _norms(averaged),
        f"Each gyro − the motion that fits all gyros best; moving average over {AVERAGED} samples. Visible while "
        "joints move: misalignment or scale; always: bias.",
    )


def force_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of the specific force, the accelerometers' readings less their zero-g output."""
    return Chart(
        "forces",
        "Micro-gravity",
        "specific force, norm (g)",
        _norms(specific_force_g(evaluation)),
        "Accelerometer − its zero-g output (mean from release to first stroke). Before the release: 1 g. During "
        "strokes: accelerations of sensors off the center of mass.",
        log_y=True,
    )


def specific_force_g(evaluation: Evaluation) -> FloatArray:
    """(n, 4, 3) at the motion's samples, body axes, less the zero-g output; NaN where that or the sample is missing."""
    log, t_s = evaluation.log, evaluation.motion.t_s
    # Calibrate only the part that the motion covers: a log may be minutes on the hook.
    first, last = np.searchsorted(log.t_s, [t_s[0], t_s[-1]])
    part = rows_of(log, slice(int(first), int(last) + 1))
    calibrated = apply_calibration(Counts.from_log(part), evaluation.calibration, evaluation.model)
    # The motion's samples are some of the log's: find each by its time.
    rows = np.searchsorted(part.t_s, t_s)
    forces = calibrated.specific_force_m_s2[rows] / STANDARD_GRAVITY_M_S2
    # A body without a quiet window has no zero-g output, hence no force: NaN.
    zero = np.full(forces.shape[1:], np.nan)
    quiet = evaluation.micro_gravity.windows[0]
    for body in quiet.bodies:
        zero[body.body - 1] = body.residual_g
    return np.asarray(forces - zero)


def _norms(vectors: FloatArray) -> tuple[Line, ...]:
    """Build a line for each body from the norms of (n, bodies, 3) vectors."""
    norms = np.linalg.norm(vectors, axis=2)
    return tuple(Line(f"body {body + 1}", norm, body, "measured") for body, norm in enumerate(norms.T))


def _moving_average(values: FloatArray) -> FloatArray:
    """(n, 3) moving average; NaN where a sample of it is missing, as at both ends."""
    weights, half = np.full(AVERAGED, 1.0 / AVERAGED), AVERAGED // 2
    averaged = np.full(values.shape, np.nan)
    if len(values) >= AVERAGED:
        # Full windows only: both ends stay NaN instead of being averaged with zeros.
        inner = [np.convolve(column, weights, mode="valid") for column in values.T]
        averaged[half : len(values) - half] = np.column_stack(inner)
    return averaged


def window_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of the spectral leakage of the windows: the spectrum they show for a pure sine."""
    t_s = evaluation.explained.driven.flown.t_s
    shares = {window: leakage(t_s, window, SHOWN_HZ) for window in WINDOWS}
    lines = [
        # The floor gives exact zeros a place on the logarithmic axis.
        Line(f"{window} window", np.maximum(share, _FLOOR), 3 if window == "Hann" else 0, "measured")
        for window, (_, share) in shares.items()
    ]
    return Chart(
        "window",
        "Window leakage of the spectra",
        "share of the amplitude",
        tuple(lines),
        "Spectrum of a single sine at these samples' times, by distance from its frequency.",
        x=shares["rectangular"][0],
        x_label="distance in frequency (Hz)",
        log_y=True,
    )
