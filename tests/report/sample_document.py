"""Plausible documents of the report: the paper's robot flies 59/70 for 2.9 s, seen by noisy sensors.

Not an evaluation: errors and uncertainties are drawn, so that the page has everything to show.
"""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.report.sample_flight import STROKES, angles_rad, flight, replay
from tfsat_host.robot import load_robot

Array = NDArray[np.float64]

SAMPLES = 240
END_S = 2.5
_KINDS = ("measured", "before", "after")


def sample_document(names: tuple[str, ...] = ("drop 1",), *, samples: int = SAMPLES) -> dict[str, Any]:
    """A report of as many drops as there are names; every drop has its own seed, verdict and initial rates."""
    return {
        "format": 1,
        "title": f"Drop tower robot, maneuver 59/70: {', '.join(names)}",
        "made_by": "tfsat-host 0.1.0",
        "made_at": "2025-06-30 14:05 UTC",
        "drops": [deepcopy(_drop(name, seed, samples)) for seed, name in enumerate(names)],
    }


@cache
def _drop(name: str, seed: int, samples: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    robot = load_robot()
    t_s = np.linspace(-0.1, 2.8, samples)
    angles = angles_rad(t_s, scale=1 + 0.01 * rng.standard_normal(len(STROKES)))
    initial = np.radians(rng.normal(0, 1.2, 3))
    measured = flight(robot, t_s, angles, initial)
    before = flight(robot, t_s, angles * (1 + 0.03 * (1 + seed)), initial)
    after = flight(robot, t_s, angles * 1.004, initial)
    flights = dict(zip(_KINDS, (measured, before, after), strict=True))
    return {
        "name": name,
        "verdict": _verdict(seed),
        "key_numbers": _key_numbers(measured, rng),
        "notes": [
            "Gyro of body 4 read its full scale for 12 ms at landing; those samples are not used.",
            "No laser tracks were given: the release velocity is not known.",
        ],
        "t_s": t_s.tolist(),
        "window_s": [0.0, END_S],
        "events": _events(),
        "plots": _plots(t_s, angles, flights, rng),
        "replay": replay(robot, t_s, angles, measured, before),
        "tables": _tables(),
    }


def _verdict(seed: int) -> dict[str, Any]:
    return (
        {
            "level": "good",
            "sentence": "The robot turned by 25.9 deg; the corrected model says so within 0.3 deg.",
            "reasons": ["All six integrity checks passed.", "Every sample from release to landing is there."],
        },
        {
            "level": "doubtful",
            "sentence": "The robot turned by 23.4 deg, but joint 1 fell 4 deg short in its first stroke.",
            "reasons": [
                "Stroke 1 reached 54.8 of 59.0 deg.",
                "Angle sensors of joint 2 disagree by 0.8 deg.",
            ],
        },
        {
            "level": "failed",
            "sentence": "Angular momentum is not constant: do not use this drop.",
            "reasons": [
                "Momentum drifts by 9 sigma; the likely cause is a stale calibration of body 2's gyro."
            ],
        },
    )[seed % 3]


def _key_numbers(measured: tuple[Rotation, Array], rng: np.random.Generator) -> list[dict[str, Any]]:
    turned_deg = float(np.degrees((measured[0][-1] * measured[0][0].inv()).magnitude()))
    numbers = [
        ("Reorientation", turned_deg, 0.083, "deg", "rotation angle of body 3 over the maneuver"),
        ("Attitude error before", 1.21, 0.11, "deg", "model as designed, at the end"),
        ("Attitude error after", 0.27, 0.09, "deg", "centers of mass corrected"),
        ("Initial rate", 1.34, 0.021, "deg/s", ""),
        ("Residual momentum", 3.1e-05, 4.2e-06, "N m s", "rms about its mean"),
        (
            "CoM offset, body 2 z",
            -7.10,
            2.31,
            "mm",
            "weakly determined: trades against a gyro's scale factor",
        ),
        ("Micro-gravity", 2.53, None, "s", "release to landing"),
        ("Release velocity", None, None, "mm/s", "no laser tracks"),
    ]
    return [
        {
            "label": label,
            "value": None if value is None else value * (1 + 0.03 * rng.standard_normal()),
            "std": std,
            "unit": unit,
            "note": note,
        }
        for label, value, std, unit, note in numbers
    ]


def _events() -> list[dict[str, Any]]:
    moments = [(0.0, "release", "release"), (END_S + 0.04, "landing", "landing")]
    events: list[dict[str, Any]] = [
        {"t_s": t, "kind": kind, "label": label, "until_s": None} for t, kind, label in moments
    ]
    events += [
        {"t_s": start, "kind": "stroke", "label": f"joint {joint + 1}, {delta:+.0f} deg", "until_s": end}
        for joint, delta, start, end in STROKES
    ]
    return [*events, {"t_s": 2.62, "kind": "gap", "label": "samples lost", "until_s": 2.66}]


def _plots(
    t_s: Array, angles: Array, flights: dict[str, tuple[Rotation, Array]], rng: np.random.Generator
) -> list[dict[str, Any]]:
    inside = np.clip(t_s, 0, END_S) / END_S
    euler = {
        kind: np.degrees(np.unwrap(attitude.as_euler("ZYX")[:, ::-1], axis=0))
        for kind, (attitude, _) in flights.items()
    }
    euler_series = [
        _series(
            f"{name} {kind}",
            euler[kind][:, i],
            i,
            kind,
            std=0.02 + 0.35 * inside if kind == "measured" else None,
        )
        for i, name in enumerate(("roll", "pitch", "yaw"))
        for kind in _KINDS
    ]
    rates = np.degrees(flights["measured"][1]) + rng.normal(0, 0.25, (len(t_s), 3))
    momentum = 2e-5 * (rng.normal(0, 1, (len(t_s), 3)) + np.sin(2 * np.pi * 4 * t_s)[:, None] * [1, 0.6, 0.3])
    momentum = np.column_stack([momentum, np.linalg.norm(momentum, axis=1)])
    commanded = np.degrees(angles_rad(t_s, np.ones(len(STROKES))))
    joints = np.degrees(angles) + rng.normal(0, 0.12, angles.shape)
    errors = {
        kind: np.degrees((flights[kind][0] * flights["measured"][0].inv()).magnitude())
        for kind in ("before", "after")
    }
    return [
        _plot(
            "euler",
            "Attitude of body 3",
            "Euler angles, z-y-x (deg)",
            euler_series,
            "Band: one standard deviation.",
        ),
        _plot(
            "rates",
            "Angular rate of body 3",
            "rate (deg/s)",
            [_series(f"ω {'xyz'[i]}", rates[:, i], i, "measured") for i in range(3)],
        ),
        _plot(
            "joints",
            "Joint angles",
            "angle (deg)",
            [
                _series(f"joint {i + 1}", joints[:, i], i, "measured", std=np.full(len(t_s), 0.3))
                for i in range(3)
            ]
            + [_series(f"joint {i + 1} commanded", commanded[:, i], i, "commanded") for i in range(2)],
        ),
        _plot(
            "momentum",
            "Angular momentum in the inertial frame",
            "N m s",
            [_series(("x", "y", "z", "norm")[i], momentum[:, i], i, "measured") for i in range(4)],
            "It is constant in free fall: what moves here is an error of a sensor or of the model.",
        ),
        _plot(
            "attitude_error",
            "Attitude error of the model",
            "rotation angle (deg)",
            [_series(f"{kind} correction", errors[kind], 3, kind) for kind in ("before", "after")],
        ),
        _spectrum("momentum_spectrum", "Spectrum of the momentum", "N m s/√Hz", 4e-6, rng),
        _spectrum("rate_spectrum", "Spectrum of the rate of body 3", "(deg/s)/√Hz", 2.0, rng),
        _spectrum(
            "error_spectrum", "Spectrum of the attitude error", "deg/√Hz", 0.3, rng, kinds=("before", "after")
        ),
    ]


def _plot(
    plot_id: str, title: str, y_label: str, series: list[dict[str, Any]], caption: str = ""
) -> dict[str, Any]:
    return {
        "id": plot_id,
        "title": title,
        "x_label": "time after release (s)",
        "y_label": y_label,
        "x": None,
        "log_x": False,
        "log_y": False,
        "band": None,
        "caption": caption,
        "series": series,
    }


def _spectrum(
    plot_id: str,
    title: str,
    y_label: str,
    level: float,
    rng: np.random.Generator,
    kinds: tuple[str, ...] = ("measured",),
) -> dict[str, Any]:
    f_hz = np.geomspace(0.4, 160, 240)
    series = [
        _series(
            f"{'xyz'[i]} {kind}",
            level / (1 + 0.4 * i) / (1 + k) / (1 + (f_hz / 6) ** 2) * np.exp(rng.normal(0, 0.35, len(f_hz)))
            + level * 1e-3,
            i,
            kind,
        )
        for k, kind in enumerate(kinds)
        for i in range(3)
    ]
    return {
        **_plot(plot_id, title, y_label, series, "Shaded: below the moving average's cutoff."),
        "x_label": "frequency (Hz)",
        "x": f_hz.tolist(),
        "log_x": True,
        "log_y": True,
        "band": [0.4, 5.6],
    }


def _series(label: str, values: Array, component: int, kind: str, std: Array | None = None) -> dict[str, Any]:
    return {
        "label": label,
        "values": values.tolist(),
        "std": None if std is None else std.tolist(),
        "component": component,
        "kind": kind,
    }


def _tables() -> list[dict[str, Any]]:
    strokes = [
        [
            str(i + 1),
            str(joint + 1),
            f"{delta:+.1f}",
            f"{0.985 * delta:+.1f}",
            f"{start:.2f}",
            f"{abs(delta) / (end - start):.0f}",
        ]
        for i, (joint, delta, start, end) in enumerate(STROKES)
    ]
    checks = [
        ["Angular momentum is constant", "passed", "1.2 σ", "3 σ", ""],
        ["Adjacent gyros agree", "passed", "0.4 deg/s", "1.5 deg/s", ""],
        ["Gravity before release", "passed", "9.79 m/s²", "9.81 ± 0.15 m/s²", ""],
        ["Angle sensors agree", "doubtful", "0.8 deg", "0.5 deg", "sensor 2 of joint 2 slipped on its shaft"],
    ]
    return [
        {
            "title": "Strokes",
            "columns": ["stroke", "joint", "commanded (deg)", "measured (deg)", "start (s)", "speed (deg/s)"],
            "rows": strokes,
            "caption": "What the joints were told and what they did.",
        },
        {
            "title": "Integrity checks",
            "columns": ["check", "verdict", "found", "threshold", "likely cause"],
            "rows": checks,
            "caption": "They need no truth: free fall and geometry say what must hold.",
        },
        {
            "title": "Provenance",
            "columns": ["what", "is"],
            "rows": [["log", "run/SD.bin, session 7f3a"], ["calibration", "calibration.toml of 2025-06-29"]],
            "caption": "Where these numbers come from.",
        },
    ]
