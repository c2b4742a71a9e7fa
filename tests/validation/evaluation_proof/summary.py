"""What all robots have in common: errors put together, and whether each target is met."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.campaign import Proof
from tests.validation.evaluation_proof.errors import BODY_2_Z, joined
from tests.validation.evaluation_proof.flights import LOW_PASSES, Flight
from tests.validation.evaluation_proof.tables import COVERED, covered, percent, rms

Proofs = Mapping[int, Proof]

TARGETS = {"reorientation of body 1": {"42 Hz": 0.1, "5 Hz": 0.2}}
"""Root mean square, deg."""
COM_MM, BODY_2_Z_MM = 1.0, 2.5
BETTER = 0.95
"""Share of the drops in which the corrected model must be nearer to the measurement."""
STATED = {
    "reorientation": ("reorientation of body 1", "reorientation of bodies 2 to 4"),
    "initial rate": ("initial rate",),
    "joint angle": ("joint angle",),
    "stroke": ("stroke",),
    "CoM": ("CoM",),
}
"""Their intervals are judged: by these quantities."""


@dataclass(frozen=True, slots=True)
class Judged:
    """One target.

    Attributes:
        what: It is of.
        found: In words.
        wanted: Likewise.
        met: It is.
    """

    what: str
    found: str
    wanted: str
    met: bool


def flights(proofs: Proofs, low_pass: str) -> list[Flight]:
    """Of all robots, in order."""
    return [proof.flights[low_pass] for _, proof in sorted(proofs.items())]


def errors(proofs: Proofs, low_pass: str, quantity: str) -> Errors:
    """All values of a quantity, robot by robot."""
    return joined(flight.errors[quantity] for flight in flights(proofs, low_pass))


def part(of: Errors, index: int, width: int) -> Errors:
    """Those of one axis, of errors that repeat every `width` values."""
    return Errors(of.error[index::width], of.std[index::width])


def nearer(proofs: Proofs, low_pass: str) -> float:
    """Share of the drops in which the corrected model ends nearer to the measured attitude."""
    return float(np.mean([one.after.final_deg < one.before.final_deg for one in flights(proofs, low_pass)]))


def judged(proofs: Proofs) -> list[Judged]:
    """Every target at both low-passes."""
    found: list[Judged] = []
    for low_pass in LOW_PASSES:
        for quantity, wanted in TARGETS.items():
            value, most = rms(errors(proofs, low_pass, quantity).error), wanted[low_pass]
            found.append(
                Judged(f"{quantity}, {low_pass}", f"{value:.4f} deg rms", f"{most:g} deg", value <= most)
            )
        found += _com(proofs, low_pass)
        for quantity, parts in STATED.items():
            share = covered(joined(errors(proofs, low_pass, one) for one in parts))
            good = COVERED[0] <= share <= COVERED[1]
            found.append(
                Judged(f"95 % intervals of {quantity}, {low_pass}", percent(share), "90 to 99 %", good)
            )
        share = nearer(proofs, low_pass)
        found.append(
            Judged(f"corrected model nearer, {low_pass}", percent(share), percent(BETTER), share >= BETTER)
        )
    return found


def _com(proofs: Proofs, low_pass: str) -> list[Judged]:
    each = [rms(part(errors(proofs, low_pass, "CoM"), k, 9).error) for k in range(9)]
    worst = max(value for k, value in enumerate(each) if k != BODY_2_Z)
    return [
        Judged(
            f"CoM, worst axis but body 2 z, {low_pass}",
            f"{worst:.3f} mm rms",
            f"{COM_MM:g} mm",
            worst <= COM_MM,
        ),
        Judged(
            f"CoM, body 2 z, {low_pass}",
            f"{each[BODY_2_Z]:.3f} mm rms",
            f"{BODY_2_Z_MM:g} mm",
            each[BODY_2_Z] <= BODY_2_Z_MM,
        ),
    ]
