"""What all robots have in common: errors put together, and whether each target is met."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.campaign import Proof
from tests.validation.evaluation_proof.errors import BODY_2_Z, join_errors
from tests.validation.evaluation_proof.figures import COVERED, covered_share, rms
from tests.validation.evaluation_proof.flights import LOW_PASSES, Flight
from tests.validation.targets import Target

Proofs = Mapping[int, Proof]

RMS_MAX_DEG = {"reorientation of body 1": {"42 Hz": 0.1, "5 Hz": 0.2}}
COM_MAX_MM, BODY_2_Z_MAX_MM = 1.0, 2.5
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


def flights(proofs: Proofs, low_pass: str) -> list[Flight]:
    """Return the flights of all robots at a low-pass setting, in order."""
    return [proof.flights[low_pass] for _, proof in sorted(proofs.items())]


def errors(proofs: Proofs, low_pass: str, quantity: str) -> Errors:
    """Return all errors of a quantity, robot by robot."""
    return join_errors(flight.errors[quantity] for flight in flights(proofs, low_pass))


def part(of: Errors, index: int, width: int) -> Errors:
    """Select the errors of one axis from errors that repeat every `width` values."""
    return Errors(of.error[index::width], of.std[index::width])


def nearer(proofs: Proofs, low_pass: str) -> float:
    """Share of the drops in which the corrected model ends nearer to the measured attitude."""
    return float(
        # Nearer at the end of the fall, where the paper compares attitudes.
        np.mean([flight.after.final_deg < flight.before.final_deg for flight in flights(proofs, low_pass)])
    )


def find_targets(proofs: Proofs) -> list[Target]:
    """Return every target at both low-passes."""
    targets: list[Target] = []
    for low_pass in LOW_PASSES:
        for quantity, rms_max in RMS_MAX_DEG.items():
            value = rms(errors(proofs, low_pass, quantity).error)
            targets.append(
                Target(f"rms error of {quantity}, {low_pass}", value, high=rms_max[low_pass], unit="deg")
            )
        targets += _com_targets(proofs, low_pass)
        for quantity, parts in STATED.items():
            # Intervals are judged by the kind of quantity, all drops together.
            share = covered_share(join_errors(errors(proofs, low_pass, part) for part in parts))
            bounds = (100.0 * COVERED[0], 100.0 * COVERED[1])
            targets.append(
                Target(
                    f"95 % intervals of {quantity} that hold, {low_pass}",
                    round(100.0 * share, 1),
                    *bounds,
                    "%",
                )
            )
        share = nearer(proofs, low_pass)
        targets.append(
            Target(
                f"corrected model nearer, {low_pass}",
                round(100.0 * share, 1),
                100.0 * BETTER,
                unit="% of drops",
            )
        )
    return targets


def _com_targets(proofs: Proofs, low_pass: str) -> list[Target]:
    # One rms an axis over all robots: the worst axis must keep the target, not their mean.
    each = [rms(part(errors(proofs, low_pass, "CoM"), k, 9).error) for k in range(9)]
    worst = max(value for k, value in enumerate(each) if k != BODY_2_Z)
    return [
        Target(f"rms error of CoM, worst axis but body 2 z, {low_pass}", worst, high=COM_MAX_MM, unit="mm"),
        Target(f"rms error of CoM, body 2 z, {low_pass}", each[BODY_2_Z], high=BODY_2_Z_MAX_MM, unit="mm"),
    ]
