"""Plausible documents of the report: four bodies fly 59/70 for 2.9 s, seen by noisy sensors.

Not an evaluation: attitudes, errors and uncertainties are drawn, so that the page has everything to show.
"""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import Multibody, poses
from tfsat_host.robot import load_robot

Array = NDArray[np.float64]

SAMPLES = 240
END_S = 2.5
TIME_PLOTS = ("euler", "rates", "joints", "momentum", "attitude_error")
SPECTRA = ("momentum_spectrum", "rate_spectrum", "error_spectrum")
STROKES = ((0, 59.0, 0.70, 1.05), (1, 70.0, 1.05, 1.47), (0, -59.0, 1.47, 1.82), (1, -70.0, 1.82, 2.23))
"""Joint, angle in deg, start and end in s."""
# Any mixture will do: it makes body 1 turn about all axes while joints move.
_TURN_PER_ANGLE = np.array([[0.3, 0.1, 0.0], [0.05, 0.35, 0.1], [0.0, 0.1, 0.2]])
_VERDICTS = (
    ("good", "The robot turned by 25.9 deg; the corrected model says so within 0.3 deg."),
    ("doubtful", "The robot turned by 23.4 deg, but joint 1 fell 4 deg short in its first stroke."),
    ("failed", "Angular momentum is not constant: do not use this drop."),
)
_NUMBERS = (
    ("Attitude error before", 1.21, 0.11, "deg", "model as designed, at the end"),
    ("Initial rate", 1.34, 0.021, "deg/s", ""),
    ("Residual momentum", 3.1e-05, 4.2e-06, "N m s", "rms about its mean"),
    ("CoM offset, body 2 z", -7.10, 2.31, "mm", "weakly determined"),
    ("Micro-gravity", 2.53, None, "s", "release to landing"),
    ("Release velocity", None, None, "mm/s", "no laser tracks"),
)


def sample_document(names: tuple[str, ...] = ("drop 1",), *, samples: int = SAMPLES) -> Any:
    """Build a report document of one drop per name; each drop has its own seed and verdict."""
    return {
        "format": 2,
        "title": f"Drop tower robot, maneuver 59/70: {', '.join(names)}",
        "made_by": "tfsat-host 0.1.0",
        "made_at": "2025-06-30 14:05 UTC",
        "drops": [deepcopy(_drop(name, seed, samples)) for seed, name in enumerate(names)],
    }


@cache
def _drop(name: str, seed: int, samples: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    # From before the release to after the landing, so that the page has to mark both.
    t_s = np.linspace(-0.1, 2.8, samples)
    angles = _angles_rad(t_s)
    drift = np.outer(t_s, np.radians(rng.normal(0, 1.2, 3)))
    turns = {
        kind: Rotation.from_rotvec(scale * angles @ _TURN_PER_ANGLE + drift)
        for kind, scale in (("measured", 1.0), ("before", 1.03 + 0.03 * seed), ("after", 1.004))
    }
    level, sentence = _VERDICTS[seed % 3]
    turned = ("Reorientation", 25.0 + seed, 0.083, "deg", "rotation angle of body 3 over the maneuver")
    return {
        "name": name,
        "verdict": {"level": level, "sentence": sentence, "reasons": ["All six integrity checks passed."]},
        "prediction": {
            "title": "Prediction and measurement, release to 2.50 s",
            "columns": ["body 1", "reorientation (deg)", "attitude error (deg)"],
            "rows": [
                ["measured", "25.002 ± 0.083", ""],
                ["nominal model", "26.114", "1.21 ± 0.11"],
                ["fitted model", "25.021", "0.042 ± 0.019"],
            ],
            "caption": "",
        },
        "change": "Correction: body 2 CoM z −7.1\u00a0±\u00a02.3 mm, body 1 CoM x +2.6\u00a0±\u00a00.6 mm; "
        "37 numbers in all (to write them: --corrected-robot FILE).",
        "strokes": {
            "title": "Strokes",
            "columns": ["stroke", "commanded (deg)", "flown (deg)", "start (s)", "end (s)"],
            "rows": [
                [
                    f"{i}: joint {j + 1}",
                    f"{delta:+.2f}",
                    f"{delta:+.4f} ± 0.0091",
                    f"{start:.5f} ± 0.00031",
                    f"{end:.3f}",
                ]
                for i, (j, delta, start, end) in enumerate(STROKES, 1)
            ],
            "caption": "",
        },
        "key_numbers": [
            dict(zip(("label", "value", "std", "unit", "note"), row, strict=True))
            for row in (turned, *_NUMBERS)
        ],
        "notes": ["Gyro of body 4 read its full scale for 12 ms at landing.", "No laser tracks were given."],
        "t_s": t_s.tolist(),
        "window_s": [0.0, END_S],
        "events": [
            {"t_s": t, "kind": kind, "label": label, "until_s": until}
            for t, kind, label, until in (
                (0.0, "release", "release", None),
                (END_S + 0.04, "landing", "landing", None),
                *(
                    (start, "stroke", f"{i}: joint {j + 1}, {delta:+.0f} deg", end)
                    for i, (j, delta, start, end) in enumerate(STROKES, 1)
                ),
                (2.62, "gap", "samples lost", 2.66),
            )
        ],
        "plots": _plots(t_s, angles, turns, rng),
        "replay": _replay(t_s, angles, turns),
        "no_replay": "",
        "tables": [
            _table("Strokes", ["stroke", "joint"], [["1", "1"], ["2", "2"]]),
            _table("Integrity checks", ["check", "verdict"], [["Adjacent gyros agree", "passed"]]),
            _table("Provenance", ["what", "is"], [["log", "run/SD.bin, session 7f3a"]]),
        ],
    }


def _angles_rad(t_s: Array) -> Array:
    """(m, 3): each stroke an S-curve; joint 3 stays shut."""
    angles = np.zeros((len(t_s), 3))
    for joint, delta_deg, start_s, end_s in STROKES:
        share = np.clip((t_s - start_s) / (end_s - start_s), 0, 1)
        # Smooth step: no jump of the rate at either end.
        angles[:, joint] += np.radians(delta_deg) * share**2 * (3 - 2 * share)
    return angles


def _replay(t_s: Array, angles: Array, turns: dict[str, Rotation]) -> dict[str, Any]:
    robot = load_robot()
    rotation, translation = poses(Multibody.of(robot), angles)
    origins = np.einsum("mbij,bj->mbi", rotation, robot.origin_m) + translation
    origins -= origins.mean(axis=1, keepdims=True)

    def place_bodies(turn: Rotation) -> Any:
        places = np.einsum("mij,mbj->mbi", turn.as_matrix(), origins)
        of_bodies = range(rotation.shape[1])
        quaternions = [(turn * Rotation.from_matrix(rotation[:, b])).as_quat() for b in of_bodies]
        return np.concatenate([places, np.stack(quaternions, axis=1)], axis=2).tolist()

    bodies = [
        {"name": name, "boxes_m": [[c.min(0).tolist(), c.max(0).tolist()] for c in shape.reshape(-1, 8, 3)]}
        for name, shape in zip(robot.body_names, robot.shape_m, strict=True)
    ]
    moved = {key: place_bodies(turns[kind]) for key, kind in (("measured", "measured"), ("model", "before"))}
    return {"bodies": bodies, "t_s": t_s.tolist(), **moved}


def _plots(
    t_s: Array, angles: Array, turns: dict[str, Rotation], rng: np.random.Generator
) -> list[dict[str, Any]]:
    band = 0.02 + 0.35 * np.clip(t_s, 0, END_S) / END_S
    euler = {kind: np.degrees(turn.as_euler("ZYX")[:, ::-1]) for kind, turn in turns.items()}
    rates = np.degrees(np.gradient(turns["measured"].as_rotvec(), t_s, axis=0))
    noisy = rates + rng.normal(0, 0.25, rates.shape)
    momentum = 2e-5 * rng.normal(0, 1, (len(t_s), 4))
    joints = np.degrees(angles)
    errors = {
        kind: np.degrees((turns[kind] * turns["measured"].inv()).magnitude()) for kind in ("before", "after")
    }
    return [
        _plot(
            "euler",
            [
                _series(f"{name} {kind}", euler[kind][:, i], i, kind, band if kind == "measured" else None)
                for i, name in enumerate(("roll", "pitch", "yaw"))
                for kind in turns
            ],
        ),
        _plot("rates", [_series(f"ω {'xyz'[i]}", noisy[:, i], i, "measured") for i in range(3)]),
        _plot(
            "joints",
            [_series(f"joint {i + 1}", joints[:, i], i, "measured", 0.3 + 0 * t_s) for i in range(3)]
            + [_series(f"joint {i + 1} commanded", joints[:, i], i, "commanded") for i in range(2)],
        ),
        _plot(
            "momentum",
            [_series(("x", "y", "z", "norm")[i], momentum[:, i], i, "measured") for i in range(4)],
        ),
        _plot(
            "attitude_error",
            [_series(f"{kind} correction", error, 3, kind) for kind, error in errors.items()],
        ),
        _spectrum("momentum_spectrum", 4e-6, rng),
        _spectrum("rate_spectrum", 2.0, rng),
        _spectrum("error_spectrum", 0.3, rng, ("before", "after")),
    ]


def _plot(plot_id: str, series: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "id": plot_id,
        "title": f"The {plot_id.replace('_', ' ')}",
        "x_label": "time after release (s)",
        "y_label": "deg",
        "x": None,
        "log_x": False,
        "log_y": False,
        "band": None,
        "caption": "Band: ± 1 standard deviation.",
        "withheld": "",
        "series": series,
    }


def _spectrum(
    plot_id: str, level: float, rng: np.random.Generator, kinds: tuple[str, ...] = ("measured",)
) -> dict[str, Any]:
    f_hz = np.geomspace(0.4, 160, SAMPLES)
    # A first-order low-pass at 6 Hz, with noise on top.
    falling = level / (1 + (f_hz / 6) ** 2)
    series = [
        _series(f"{'xyz'[i]} {kind}", falling / (1 + i) * np.exp(rng.normal(0, 0.35, SAMPLES)), i, kind)
        for kind in kinds
        for i in range(3)
    ]
    log = {"x_label": "frequency (Hz)", "x": f_hz.tolist(), "log_x": True, "log_y": True, "band": [0.4, 5.6]}
    return {**_plot(plot_id, series), **log}


def _series(label: str, values: Array, component: int, kind: str, std: Array | None = None) -> dict[str, Any]:
    return {
        "label": label,
        "values": values.tolist(),
        "std": None if std is None else std.tolist(),
        "component": component,
        "kind": kind,
    }


def _table(title: str, columns: list[str], rows: list[list[str]]) -> dict[str, Any]:
    return {"title": title, "columns": columns, "rows": rows, "caption": f"All {title.lower()}."}
