"""How far evaluations were from the truth, and whether they knew it: the tables of docs/evaluation-proof.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof import causes, learning, mismatch_tables
from tests.validation.evaluation_proof.errors import BODY_2_Z, LABELS, join_errors
from tests.validation.evaluation_proof.figures import figures, percent, rms
from tests.validation.evaluation_proof.flights import BODIES, FLIGHTS, Flight
from tests.validation.evaluation_proof.paper_tables import paper_tables
from tests.validation.evaluation_proof.summary import Proofs, errors, find_targets, flights, nearer, part
from tests.validation.tables import csv_text
from tests.validation.targets import targets_csv

ROW_COLUMNS = (
    "reorientation",
    "attitude",
    "initial rate",
    "joint angle",
    "stroke",
    "CoM but body 2 z",
    "body 2 z",
    "before",
    "after",
    "other drop",
    "excess",
)


def make_tables(
    proofs: Proofs, mismatched: mismatch_tables.Drops, named: causes.Drops, lessons: Sequence[learning.Lesson]
) -> dict[str, str]:
    """Return the text of each CSV file by its name."""
    tables = {
        "targets": targets_csv(find_targets(proofs)),
        "errors": _errors(proofs),
        "axes": _axes(proofs),
        "model": _model(proofs),
        "swarm": _swarm(proofs),
        "uncalibrated": _bare(proofs),
        "dead-gyro": _deaf(proofs),
        "drops": _rows(proofs),
        "causes": causes.causes_csv(named),
        "cause-counts": causes.count_causes(named),
        "learning": learning.learning_csv(lessons),
        "learning-errors": learning.compare_maneuvers(lessons),
        **mismatch_tables.make_mismatch_tables(mismatched),
        **paper_tables(proofs),
    }
    return {f"{name}.csv": text for name, text in tables.items()}


def describe_campaign(
    proofs: Proofs, mismatched: mismatch_tables.Drops, named: causes.Drops, lessons: Sequence[learning.Lesson]
) -> dict[str, object]:
    """Return how many robots and drops there were."""
    return {
        "robots": len(proofs),
        "robots with a dead gyro": sum(bool(proof.deaf) for proof in proofs.values()),
        "drops a row of what is not as filed": max(map(len, mismatched.values())),
        "of all of them GOOD with an error beyond 4 ±, by chance": (
            f"{mismatch_tables.expect_by_chance(mismatched):.1f} at most"
        ),
        "drops a cause": max(map(len, named.values())),
        "robots of the maneuver that learns": len(lessons),
    }


def _errors(proofs: Proofs) -> str:
    rows = [
        (quantity, flight_name, str(len(quantity_errors.error)), *figures(quantity_errors))
        for quantity in LABELS
        for flight_name in FLIGHTS
        for quantity_errors in [errors(proofs, flight_name, quantity)]
    ]
    columns = ("quantity", "drop", "values", "rms", "largest", "stated std, median", "z", "95 % hold")
    return csv_text(columns, rows)


def _axes(proofs: Proofs) -> str:
    rows = []
    for quantity, labels in LABELS.items():
        # A quantity of one value needs no row for each axis.
        for index, label in enumerate(labels if len(labels) > 1 else ()):
            cells: list[str] = []
            for flight_name in FLIGHTS:
                quantity_errors = errors(proofs, flight_name, quantity)
                # Not every maneuver has as many strokes as another.
                width = len(quantity_errors.error) // len(proofs)
                if index >= width:
                    cells += ["–"] * 4
                    continue
                axis_figures = figures(part(quantity_errors, index, width))
                cells += [axis_figures[0], axis_figures[2], axis_figures[3], axis_figures[4]]
            rows.append((quantity, label, *cells))
    columns = [
        f"{what}, {flight_name}" for flight_name in FLIGHTS for what in ("rms", "std", "z", "95 % hold")
    ]
    return csv_text(("quantity", "of", *columns), rows)


def _model(proofs: Proofs) -> str:
    rows = []
    for flight_name in FLIGHTS:
        ones = flights(proofs, flight_name)
        cells = [
            # `before` and `after` are Differences, each with its end and its rms over the fall.
            f"{np.median([getattr(getattr(flight, side), when) for flight in ones]):.4f}"
            for side in ("before", "after", "crossed")
            for when in ("final_deg", "rms_deg")
        ]
        excess = np.array([flight.excess for flight in ones])
        spread = f"{np.median(excess):.2f}, {np.quantile(excess, 0.95):.2f}, {excess.max():.2f}"
        rows.append((flight_name, *cells, percent(nearer(proofs, flight_name)), spread))
    sides = ("before", "after", "other drop")
    return csv_text(
        (
            "drop",
            *(f"{side}, {when}" for side in sides for when in ("end", "rms")),
            "nearer",
            "excess: median, 95 %, largest",
        ),
        rows,
    )


def _swarm(proofs: Proofs) -> str:
    rows = []
    for index, label in enumerate(LABELS["CoM"]):
        cells = []
        for flight_name in FLIGHTS:
            ones = flights(proofs, flight_name)
            cells += [
                f"{rms(part(errors(proofs, flight_name, 'CoM'), index, 9).error):.3f}",
                f"{rms(np.array([flight.swarm_mm[index] for flight in ones])):.2f}",
                f"{rms(np.array([flight.swarm_spread_mm[index] for flight in ones])):.2f}",
                f"{rms(np.array([flight.least_mm[index] for flight in ones])):.3f}",
            ]
        rows.append((label, *cells))
    columns = [
        f"{what}, {flight_name}"
        for flight_name in FLIGHTS
        for what in ("Gauss-Newton", "swarm", "spread", "least")
    ]
    return csv_text(("offset", *columns), rows)


def _bare(proofs: Proofs) -> str:
    rows = [
        (
            quantity,
            flight_name,
            *figures(join_errors(proof.bare[flight_name][quantity] for proof in proofs.values())),
        )
        for quantity in LABELS
        for flight_name in FLIGHTS
    ]
    columns = ("quantity", "drop", "rms", "largest", "stated std, median", "z", "95 % hold")
    return csv_text(columns, rows)


def _deaf(proofs: Proofs) -> str:
    # Only the first robots flew with dead gyros.
    deaf = [proof.deaf for _, proof in sorted(proofs.items()) if proof.deaf]
    rows = []
    for quantity in LABELS:
        for body in BODIES:
            body_figures = figures(join_errors(robot_errors[body][quantity] for robot_errors in deaf))
            rows.append(
                (
                    quantity,
                    f"body {body}",
                    body_figures[0],
                    body_figures[1],
                    body_figures[2],
                    body_figures[3],
                    body_figures[4],
                )
            )
    columns = ("quantity", "dead gyro", "rms", "largest", "stated std, median", "z", "95 % hold")
    return csv_text(columns, rows)


def _rows(proofs: Proofs) -> str:
    rows = [
        (str(seed), flight_name, *(f"{value:.4f}" for value in row_of(proof.flights[flight_name])))
        for seed, proof in sorted(proofs.items())
        for flight_name in FLIGHTS
    ]
    return csv_text(("robot", "drop", *ROW_COLUMNS), rows)


def row_of(flight: Flight) -> list[float]:
    """Return the values of one drop in the order of `ROW_COLUMNS`."""
    flight_errors: Mapping[str, Errors] = flight.errors
    com = flight_errors["CoM"].error
    return [
        float(flight_errors["reorientation of body 1"].error[0]),
        *(
            rms(flight_errors[name].error)
            for name in ("final attitude of body 1", "initial rate", "joint angle", "stroke")
        ),
        rms(np.delete(com, BODY_2_Z)),
        float(com[BODY_2_Z]),
        flight.before.final_deg,
        flight.after.final_deg,
        flight.crossed.final_deg,
        flight.excess,
    ]
