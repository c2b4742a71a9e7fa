"""What all robots have in common: errors put together, and whether each target is met."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.campaign import Proof
from tests.validation.evaluation_proof.errors import BODY_2_Z, join_errors
from tests.validation.evaluation_proof.figures import COVERED, covered_share, rms
from tests.validation.evaluation_proof.flights import FLIGHTS, Flight
from tests.validation.targets import Target

Proofs = Mapping[int, Proof]

RMS_MAX_DEG = {"reorientation of body 1": {"42 Hz": 0.1, "5 Hz": 0.2, "42 Hz, joints together": 0.1}}
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


def flights(proofs: Proofs, flight_name: str) -> list[Flight]:
    """Return the flights of all robots of that name, in order."""
    return [proof.flights[flight_name] for _, proof in sorted(proofs.items())]


def errors(proofs: Proofs, flight_name: str, quantity: str) -> Errors:
    """Return all errors of a quantity, robot by robot."""
    return join_errors(flight.errors[quantity] for flight in flights(proofs, flight_name))


def part(of: Errors, index: int, width: int) -> Errors:
    """Select the errors of one axis from errors that repeat every `width` values."""
    return Errors(of.error[index::width], of.std[index::width])


def nearer(proofs: Proofs, flight_name: str) -> float:
    """Share of the drops in which the corrected model ends nearer to the measured attitude."""
    return float(
        # Nearer at the end of the fall, where the paper compares attitudes.
        np.mean([flight.after.final_deg < flight.before.final_deg for flight in flights(proofs, flight_name)])
    )


def find_targets(proofs: Proofs) -> list[Target]:
    """Return every target of each drop."""
    targets: list[Target] = []
    for flight_name in FLIGHTS:
        for quantity, rms_max in RMS_MAX_DEG.items():
            value = rms(errors(proofs, flight_name, quantity).error)
            targets.append(
                Target(
                    f"rms error of {quantity}, {flight_name}", value, high=rms_max[flight_name], unit="deg"
                )
            )
        targets += _com_targets(proofs, flight_name)
        for quantity, parts in STATED.items():
            # Intervals are judged by the kind of quantity, all drops together.
            share = covered_share(join_errors(errors(proofs, flight_name, part) for part in parts))
            bounds = (100.0 * COVERED[0], 100.0 * COVERED[1])
            targets.append(
                Target(
                    f"95 % intervals of {quantity} that hold, {flight_name}",
                    round(100.0 * share, 1),
                    *bounds,
                    "%",
                )
            )
        share = nearer(proofs, flight_name)
        targets.append(
            Target(
                f"corrected model nearer, {flight_name}",
                round(100.0 * share, 1),
                100.0 * BETTER,
                unit="% of drops",
            )
        )
    return targets


def _com_targets(proofs: Proofs, flight_name: str) -> list[Target]:
    # One rms an axis over all robots: the worst axis must keep the target, not their mean.
    each = [rms(part(errors(proofs, flight_name, "CoM"), k, 9).error) for k in range(9)]
    worst = max(value for k, value in enumerate(each) if k != BODY_2_Z)
    return [
        Target(
            f"rms error of CoM, worst axis but body 2 z, {flight_name}", worst, high=COM_MAX_MM, unit="mm"
        ),
        Target(f"rms error of CoM, body 2 z, {flight_name}", each[BODY_2_Z], high=BODY_2_Z_MAX_MM, unit="mm"),
    ]
