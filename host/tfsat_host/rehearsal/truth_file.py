"""`truth.json`: everything of a rehearsed drop that no instrument tells, for whoever wants to judge an evaluation."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

import numpy as np

from tfsat_host.rehearsal.drop import Drop
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel


def truth_text(truth: Truth, drop: Drop, filed: RobotModel, faults: tuple[str, ...]) -> str:
    """JSON; angles in rad, lengths in m, times in s of the rehearsal's clock."""
    errors = truth.imperfections
    told: dict[str, Any] = {
        "format": 1,
        "seed": truth.seed,
        "faults": list(faults),
        "imu": truth.imu,
        "released_s": drop.released_s,
        "landed_s": drop.landed_s,
        "rate_rad_s": truth.rate_rad_s,
        "com_offset_m": truth.model.com_m - filed.com_m,
        "imperfections": {one.name: getattr(errors, one.name) for one in fields(errors)},
    }
    return json.dumps(told, indent=1, default=_plain) + "\n"


def _plain(value: object) -> object:
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value)} is not in a truth")
