"""docs/evaluation-proof.md: how far evaluations were from the truth, and whether they knew it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof import causes, learning, mismatch_page
from tests.validation.evaluation_proof.errors import BODY_2_Z, LABELS, joined
from tests.validation.evaluation_proof.flights import BODIES, LOW_PASSES, Flight
from tests.validation.evaluation_proof.paper_page import paper_page, paper_tables
from tests.validation.evaluation_proof.summary import Proofs, errors, flights, judged, nearer, part
from tests.validation.evaluation_proof.tables import csv_text, figures, percent, rms, table

_HEAD = """# What the evaluation was measured to do

Written by `make evaluation-report`; do not edit. {robots} emulated robots (those of docs/calibration-proof.md) were
each calibrated once by the steps of docs/calibration.md and dropped twice with the maneuver 59/70: with the gyros'
low-pass at 42 Hz and at 5 Hz. `evaluate` had the recording, the robot file, the calibration and the schedule. The
paper's setting with them: [paper-setting.md](paper-setting.md). Of each robot

- the centers of mass of bodies 1 to 3 lie within 10 mm, along each axis, of where its file has them;
- servos are 5 % off in gain, with up to 1 deg of play; each board's clock is off by 20 ppm rms;
- the rates at the release are 0.7 deg/s rms about each axis;
- gyros have what no calibration finds: 0.1 deg/s for each g, a bias that wanders and follows the die's temperature;
- masses, inertias, hinge points and axes and body 4's center of mass are off by what the robot file's `[uncertainty]`
  says, each drawn from it; the hinges leaned when the sensors were calibrated against them;
- each IMU converts and filters by an oscillator of its own, within 1 %.

## Targets

"""
_ERRORS = """
## Errors and intervals

deg, deg/s, and mm for CoM. z: rms of the error in stated standard deviations (1: they are right); 95 % hold: how
often the interval holds the truth. Reorientation is from the release to 0.05 s before the landing, joint angles are
at both ends of that, `measured less predicted` are the Euler angles z-y-x of body 1 less those of the corrected
model, at the end. By quantity: [errors.csv](evaluation-proof/errors.csv); axis by axis:
[axes.csv](evaluation-proof/axes.csv); drop by drop: [drops.csv](evaluation-proof/drops.csv).
"""
_MODEL = """
## Does the corrected model predict better?

Measured less predicted attitude of body 1, norm of three Euler angles, deg: median over the drops, at the end and rms
over the fall. Other drop: corrected by the robot's drop at the other low-pass. Nearer: share of the drops that the
correction brings nearer to the measurement. Excess: variance left by the fit over that of the sensors' noise.

"""
_OTHERS = """
## Other ways to evaluate the same drops

- [swarm.csv](evaluation-proof/swarm.csv): the nine offsets by the paper's swarm, rms of the error, mm. It minimizes the
  paper's objective, N = 25, over the same bounds: the best of ten searches. Spread: standard deviation over the ten.
  Least: where a descent from there ends. The objective is right with calibrated sensors; the swarm stops long before.
- [uncalibrated.csv](evaluation-proof/uncalibrated.csv): without any calibration: mountings known to 5 deg, scales to
  3 %, biases from the rest before the release, joints within 6 deg of where their servos start. Four gyros measure
  twelve numbers of a motion that has six; that and the angle sensors calibrate them from the drop itself, but for where
  a joint began.
- [dead-gyro.csv](evaluation-proof/dead-gyro.csv): at 42 Hz, {robots} robots with the gyro of one body silent, its
  body's rate from its neighbours and the angle sensors between them.
"""
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


def files(
    proofs: Proofs, mismatched: mismatch_page.Drops, named: causes.Drops, lessons: Sequence[learning.Lesson]
) -> dict[str, str]:
    """The page and its tables, by their paths in docs/."""
    tables = {
        "errors": _errors(proofs),
        "axes": _axes(proofs),
        "swarm": _swarm(proofs),
        "uncalibrated": _bare(proofs),
        "dead-gyro": _deaf(proofs),
        "drops": _rows(proofs),
        "causes": causes.causes_csv(named),
        "learning": learning.learning_csv(lessons),
        **mismatch_page.mismatch_tables(mismatched),
        **paper_tables(proofs),
    }
    return {
        "evaluation-proof.md": _page(proofs, mismatched, lessons),
        "paper-setting.md": paper_page(proofs),
        "causes.md": causes.causes_page(named),
        **{f"evaluation-proof/{name}.csv": text for name, text in tables.items()},
    }


def _page(proofs: Proofs, mismatched: mismatch_page.Drops, lessons: Sequence[learning.Lesson]) -> str:
    targets = [(one.what, one.found, one.wanted, "yes" if one.met else "**no**") for one in judged(proofs)]
    return "".join(
        [
            _HEAD.format(robots=len(proofs)),
            table(("quantity", "found", "wanted", "met"), targets),
            _ERRORS,
            _MODEL,
            _model(proofs),
            _OTHERS.format(robots=sum(bool(proof.deaf) for proof in proofs.values())),
            mismatch_page.section(mismatched),
            learning.learning_page(lessons),
        ]
    )


def _errors(proofs: Proofs) -> str:
    rows = [
        (quantity, low_pass, str(len(found.error)), *figures(found))
        for quantity in LABELS
        for low_pass in LOW_PASSES
        for found in [errors(proofs, low_pass, quantity)]
    ]
    columns = ("quantity", "low-pass", "values", "rms", "largest", "stated std, median", "z", "95 % hold")
    return csv_text(columns, rows)


def _axes(proofs: Proofs) -> str:
    rows = []
    for quantity, labels in LABELS.items():
        for index, label in enumerate(labels if len(labels) > 1 else ()):
            cells: list[str] = []
            for low_pass in LOW_PASSES:
                one = figures(part(errors(proofs, low_pass, quantity), index, len(labels)))
                cells += [one[0], one[2], one[3], one[4]]
            rows.append((quantity, label, *cells))
    columns = [f"{what}, {low_pass}" for low_pass in LOW_PASSES for what in ("rms", "std", "z", "95 % hold")]
    return csv_text(("quantity", "of", *columns), rows)


def _model(proofs: Proofs) -> str:
    rows = []
    for low_pass in LOW_PASSES:
        ones = flights(proofs, low_pass)
        cells = [
            f"{np.median([getattr(getattr(one, side), when) for one in ones]):.4f}"
            for side in ("before", "after", "crossed")
            for when in ("final_deg", "rms_deg")
        ]
        excess = np.array([one.excess for one in ones])
        spread = f"{np.median(excess):.2f}, {np.quantile(excess, 0.95):.2f}, {excess.max():.2f}"
        rows.append((low_pass, *cells, percent(nearer(proofs, low_pass)), spread))
    sides = ("before", "after", "other drop")
    return table(
        (
            "low-pass",
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
        for low_pass in LOW_PASSES:
            ones = flights(proofs, low_pass)
            cells += [
                f"{rms(part(errors(proofs, low_pass, 'CoM'), index, 9).error):.3f}",
                f"{rms(np.array([one.swarm_mm[index] for one in ones])):.2f}",
                f"{rms(np.array([one.swarm_spread_mm[index] for one in ones])):.2f}",
                f"{rms(np.array([one.least_mm[index] for one in ones])):.3f}",
            ]
        rows.append((label, *cells))
    columns = [
        f"{what}, {low_pass}"
        for low_pass in LOW_PASSES
        for what in ("Gauss-Newton", "swarm", "spread", "least")
    ]
    return csv_text(("offset", *columns), rows)


def _bare(proofs: Proofs) -> str:
    rows = [
        (quantity, low_pass, *figures(joined(proof.bare[low_pass][quantity] for proof in proofs.values())))
        for quantity in LABELS
        for low_pass in LOW_PASSES
    ]
    columns = ("quantity", "low-pass", "rms", "largest", "stated std, median", "z", "95 % hold")
    return csv_text(columns, rows)


def _deaf(proofs: Proofs) -> str:
    deaf = [proof.deaf for _, proof in sorted(proofs.items()) if proof.deaf]
    rows = []
    for quantity in LABELS:
        for body in BODIES:
            found = figures(joined(one[body][quantity] for one in deaf))
            rows.append((quantity, f"body {body}", found[0], found[1], found[2], found[3], found[4]))
    columns = ("quantity", "dead gyro", "rms", "largest", "stated std, median", "z", "95 % hold")
    return csv_text(columns, rows)


def _rows(proofs: Proofs) -> str:
    rows = [
        (str(seed), low_pass, *(f"{value:.4f}" for value in row_of(proof.flights[low_pass])))
        for seed, proof in sorted(proofs.items())
        for low_pass in LOW_PASSES
    ]
    return csv_text(("robot", "low-pass", *ROW_COLUMNS), rows)


def row_of(flight: Flight) -> list[float]:
    """One drop in the order of `ROW_COLUMNS`."""
    found: Mapping[str, Errors] = flight.errors
    com = found["CoM"].error
    return [
        float(found["reorientation of body 1"].error[0]),
        *(
            rms(found[name].error)
            for name in ("final attitude of body 1", "initial rate", "joint angle", "stroke")
        ),
        rms(np.delete(com, BODY_2_Z)),
        float(com[BODY_2_Z]),
        flight.before.final_deg,
        flight.after.final_deg,
        flight.crossed.final_deg,
        flight.excess,
    ]
