"""Stated uncertainties under the names and in the units of a robot file's table `[uncertainty]`."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

from tfsat_host.errors import UsageError
from tfsat_host.robot import Uncertainty

_DEG = math.radians(1.0)
_FIELDS = {
    "mass_relative": ("mass_relative", 1.0),
    "com_mm": ("com_m", 1e-3),
    "inertia_relative": ("inertia_relative", 1.0),
    "joint_point_mm": ("joint_point_m", 1e-3),
    "joint_axis_deg": ("joint_axis_rad", _DEG),
    "stroke_deg": ("stroke_rad", _DEG),
    "stroke_relative": ("stroke_relative", 1.0),
    "servo_speed_relative": ("servo_speed_relative", 1.0),
}
KEYS = tuple(_FIELDS)
"""In the order of the table; `docs/sensitivity.md` explains them."""
LARGEST_SHARE = 0.2
"""Of a relative figure, as in robot files: something must be left of a mass in the worst sample."""


def overridden(stated: Uncertainty | None, values: Mapping[str, float]) -> Uncertainty:
    """`stated`, or nothing uncertain if None, with other figures for some keys.

    Raises:
        UsageError: a key is unknown, or a figure is no standard deviation or too large a share.
    """
    fields = {} if stated is None else dataclasses.asdict(stated)
    found = {name: fields.get(name, 0.0) for name, _ in _FIELDS.values()}
    for key, value in values.items():
        if key not in _FIELDS:
            raise _error(f"{key!r} is no uncertainty", f"Known are: {', '.join(KEYS)}.")
        if not (math.isfinite(value) and value >= 0.0):
            raise _error(f"{key}={value:g} is no standard deviation", f"Give 0 or more: --sigma {key}=0")
        if key.endswith("_relative") and value > LARGEST_SHARE:
            raise _error(
                f"{key}={value:g} is too large: five of them would leave nothing",
                f"Give a share up to {LARGEST_SHARE:g}, such as --sigma {key}=0.05 for 5 %.",
            )
        name, unit = _FIELDS[key]
        found[name] = value * unit
    return Uncertainty(**found)


def as_stated(uncertainty: Uncertainty) -> dict[str, float]:
    """By key, in the keys' units."""
    return {key: float(f"{getattr(uncertainty, name) / unit:.12g}") for key, (name, unit) in _FIELDS.items()}


def _error(problem: str, cure: str) -> UsageError:
    return UsageError(what=f"--sigma: {problem}.", meaning="Nothing was computed.", next_step=cure)
