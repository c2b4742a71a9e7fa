"""All tables of what was found in a drop, the checks, the calibration, and the reasons of a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from math import isfinite
from typing import Any

import numpy as np

from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.calibration.sensors.gyro import MOUNTING, GyroCalibration
from tfsat_host.evaluation.checks.check import Check
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.result.drop_result import (
    BODIES,
    FALL,
    INITIAL_RATE,
    JOINTS,
    LAG,
    STANDING,
    STROKES,
    TURN,
    BodyResult,
    bodies,
    clock_table,
    joint_table,
    joints,
    standing_table,
    stroke_table,
)
from tfsat_host.evaluation.result.model_result import MODEL, error_table, offset_table
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.next_step import Advice
from tfsat_host.quantity import UNKNOWN, Column, Columns, Table, fields, number, vector
from tfsat_host.sdlog import DropLog


def tables_of(evaluation: Evaluation) -> list[Table]:
    """Build the tables that have content."""
    builders = (
        stroke_table,
        joint_table,
        standing_table,
        error_table,
        offset_table,
        check_table,
        cause_table,
        clock_table,
    )
    tables = [table(evaluation) for table in builders]
    return [table for table in tables if table.rows]


_ORDER = ("failed", "not possible", "passed")


def _with_unit(attribute: str) -> Callable[[Check], str]:
    def text(check: Check) -> str:
        value = getattr(check, attribute)
        return f"{number(value, '.3g')} {check.unit}".rstrip() if isfinite(value) else UNKNOWN

    return text


def _explain_check(check: Check) -> str:
    """Format a check's finding, the likely cause and the next step of a failed one."""
    parts = [check.sentence]
    parts += [f"Likely cause: {check.cause}"] if check.cause else []
    parts += [Advice("Next step: ", check.next_step)] if check.next_step else []
    ended = [part if part.endswith((".", "!", "?")) else Advice(part, ".") for part in parts]
    # Put spaces between the parts; the commands in them stay commands.
    return Advice(*[piece for part in ended for piece in (" ", part)][1:])


CHECKS: Columns = (
    Column("name", "check"),
    Column("verdict", "verdict"),
    Column("value", "value", words=_with_unit("value")),
    Column("threshold", "limit", words=_with_unit("threshold")),
    Column("sentence", "finding", words=_explain_check),
    *fields("unit cause next_step"),
)


def check_table(evaluation: Evaluation) -> Table:
    """Build the table of checks; failed ones come first and passed ones are folded."""
    checks = sorted(evaluation.checks, key=lambda check: _ORDER.index(check.verdict))
    passed = sum(check.verdict == "passed" for check in checks)
    return Table(
        "Integrity checks",
        CHECKS,
        checks,
        "Consistency of the sensors with each other and with free fall.",
        folded=passed,
        fold=f"{passed} of {len(checks)} checks passed",
    )


CAUSES: Columns = (
    Column("cause", "cause"),
    Column("probability", "posterior", form=".3f"),
    Column("next_step", "next step"),
)


def cause_table(evaluation: Evaluation) -> Table:
    """Build the table of the failed checks' causes; without rows if no failed check can have such a cause."""
    return Table(
        "Causes",
        CAUSES,
        evaluation.causes,
        "Causes with posterior >= 0.001 (uniform prior). Ratio < 3: indistinguishable.",
    )


def _of_body_1(value: Callable[[BodyResult], Any], evaluation: Evaluation) -> Any:
    return value(bodies(evaluation)[0])


EVALUATION: Columns = (
    # The turn of body 1 under the keys that everybody looks for first.
    *(
        replace(
            column,
            of=partial(_of_body_1, column.value),
            std=column.std and partial(_of_body_1, column.std_of),
        )
        for column in (*TURN, *INITIAL_RATE)
        if column.key != "bridged"
    ),
    Column("strokes", columns=STROKES),
    Column("standing", columns=STANDING),
    *MODEL,
    Column("checks", columns=CHECKS),
    Column("causes", columns=CAUSES),
    *fields("left_out=left_out.name"),
    Column("bodies", of=bodies, columns=BODIES),
    Column("joints", of=joints, columns=JOINTS),
    Column("until_s", of=lambda evaluation: float(evaluation.motion.t_s[-1])),
    Column(
        "lag",
        of=lambda evaluation: evaluation.motion.lag if evaluation.is_given("rates") else None,
        columns=LAG,
    ),
    *FALL,
)
"""One evaluated drop as a JSON object: docs/evaluation.md."""


NEARLY_ALL = 0.5
"""Of the checks that were possible: no single sensor makes so many fail."""


def reasons_of(evaluation: Evaluation, verdict: Verdict) -> tuple[str, ...]:
    """Sentences.

    Where nearly everything failed at once, the causes that single checks name would mend nothing: then all checks are
    one sentence.
    """
    failed = {check.sentence: check for check in evaluation.failed_checks}
    possible = sum(check.verdict != "not possible" for check in evaluation.checks)
    # Few failures: each has its own likely cause and next step, which are named once.
    if len(evaluation.failed_checks) <= NEARLY_ALL * possible:
        return tuple(_name_causes_once(verdict.reasons, failed))
    # Nearly all failed: the common input is wrong, and single causes would send people astray.
    everything = (
        f"{len(evaluation.failed_checks)} of {possible} checks failed, more than a single sensor causes. Likely cause: "
        "calibration, robot file or order of the bodies of another robot."
    )
    return (everything, *(text for text in verdict.reasons if text not in failed))


def _name_causes_once(reasons: Iterable[str], failed: Mapping[str, Check]) -> Iterator[str]:
    """Yield the reasons, of each failed check its name, and cause and next step where no reason before has them."""
    named: set[str] = set()
    for reason in reasons:
        check = failed.get(reason)
        if check is None:
            yield reason
        elif check.cause in named:
            yield f"{check.name}: {check.sentence} Same likely cause."
        else:
            named.add(check.cause or "")
            yield Advice(f"{check.name}: ", _explain_check(check))


_CALIBRATION = ("quantity", "value", "unit", "measured")


def release_time(log: DropLog) -> datetime | None:
    """Return the release's time of day; None if the logger did not know it, or recorded no release."""
    if log.release_us is None or log.unix_offset_us is None:
        return None
    return datetime.fromtimestamp((log.release_us + log.unix_offset_us) * 1e-6, UTC)


def utc(moment: datetime | None) -> str:
    """Format a time of day to the minute, in UTC."""
    return UNKNOWN if moment is None else f"{moment.astimezone(UTC):%Y-%m-%d %H:%M} UTC"


def calibration_table(evaluation: Evaluation) -> Table:
    """Build the table of the calibration used, with when each quantity was measured."""
    calibration, date_of = evaluation.calibration, _MeasuredDates(evaluation)
    rows = []
    for gyro in calibration.present_gyros:
        name = f"bias of body {gyro.body}"
        std = np.rad2deg(np.sqrt(np.diag(gyro.covariance)[:3]))
        rows.append((name, vector(np.rad2deg(gyro.bias_rad_s), std), "deg/s", date_of(name)))
    for gyro in calibration.present_gyros:
        name = f"misalignment of body {gyro.body}"
        rows.append((name, _misalignment_deg(gyro, evaluation), "deg", date_of(name)))
    for gyro in calibration.present_gyros:
        values, std = np.array([gyro.scale_about(axis) for axis in range(3)]).T
        measured = date_of("scale factor", f"of body {gyro.body}")
        rows.append((f"scale factors of body {gyro.body}", vector(values, std), "1", measured))
    for joint in calibration.present_joints:
        name = f"zero point of joint {joint.joint}"
        std = np.rad2deg(np.sqrt(np.diag(joint.zero_covariance)))
        zeros = vector(np.rad2deg(joint.zero_rad) % 360.0, std)
        rows.append((name, zeros, "deg", date_of(name)))
    return Table(
        "Calibration",
        tuple(Column(name, name) for name in _CALIBRATION),
        [dict(zip(_CALIBRATION, row, strict=True)) for row in rows],
        "±: greatest standard deviation of a row. Default values for what was never measured, or not since a landing: "
        "see the reasons of the verdict.",
    )


class _MeasuredDates:
    """When quantities were measured: the earliest of those that a row holds, and whether they hold yet."""

    def __init__(self, evaluation: Evaluation) -> None:
        self._quantities = quantities(evaluation.calibration)
        self._lacking = {
            defect.name: defect.state
            for defect in evaluation.calibration.shortcomings(release_time(evaluation.log))
        }

    def __call__(self, *parts: str) -> str:
        """Format when the quantities whose names contain all parts were measured."""
        of_row = [quantity for quantity in self._quantities if all(part in quantity.name for part in parts)]
        missing = sum(quantity.measured_at is None for quantity in of_row)
        if missing == len(of_row):
            return "never"
        earliest = min(quantity.measured_at for quantity in of_row if quantity.measured_at is not None)
        remarks = [f"{missing} of {len(of_row)} never"] if missing else []
        if any(self._lacking.get(quantity.name) == "stale" for quantity in of_row):
            remarks.append("before a landing")
        return ", ".join([utc(earliest), *remarks])


def _misalignment_deg(gyro: GyroCalibration, evaluation: Evaluation) -> str:
    """Format the angle between the sensor's mounting and its design."""
    # Rotation from the designed to the measured mounting; its angle follows from the trace.
    turn = gyro.rotation @ evaluation.model.imus[gyro.body - 1].sensor_to_body.T
    # Rounding may take the cosine beyond one: clip it.
    angle = np.rad2deg(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)))
    # Principal deviations of the tilt; the row shows the greatest, which holds in any direction.
    std = np.rad2deg(np.sqrt(np.linalg.eigvalsh(gyro.covariance[MOUNTING, MOUNTING])))
    return vector(np.array([angle]), std)
