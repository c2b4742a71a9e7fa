"""All tables of what was found in a drop, the checks, the calibration, and the reasons of a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from math import isfinite

import numpy as np

from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.evaluation.checks.check import Check
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.result.drop_result import clock_table, joint_table, standing_table, stroke_table
from tfsat_host.evaluation.result.model_result import error_table, offset_table
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


def _format_advice(check: Check) -> str:
    """Format a check's sentence, for a failed one with the likely cause and the next step."""
    cause = f"Likely cause: {check.cause.rstrip('.')}." if check.cause else ""
    return _join(part for part in (check.sentence, cause, check.next_step) if part)


def _join(texts: Iterable[str]) -> str:
    """Put spaces between texts; the commands in them stay commands."""
    return Advice(*[part for text in texts for part in (" ", text)][1:])


CHECKS: Columns = (
    Column("name", "check"),
    Column("verdict", "verdict"),
    Column("value", "found", words=_with_unit("value")),
    Column("threshold", "at most", words=_with_unit("threshold")),
    Column("sentence", "finding", words=_format_advice),
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
        "Without any truth: sensors that contradict each other, or free fall, cannot all be right.",
        folded=passed,
        fold=f"{passed} of {len(checks)} checks passed",
    )


CAUSES: Columns = (
    Column("cause", "cause"),
    Column("probability", "probability", form=".3f"),
    Column("next_step", "what to do"),
)


def cause_table(evaluation: Evaluation) -> Table:
    """Build the table of the failed checks' causes; without rows if no failed check can have such a cause."""
    return Table(
        "Causes",
        CAUSES,
        evaluation.causes,
        "All causes that were compared for the checks above, as likely as another before the drop: what is left out "
        "is less likely than 0.001. Two of which the one is less than 3 times as likely cannot be told apart.",
    )


NEARLY_ALL = 0.5
"""Of the checks that were possible: no single sensor makes so many fail."""


def reasons_of(evaluation: Evaluation, verdict: Verdict) -> tuple[str, ...]:
    """Sentences.

    Where nearly everything failed at once, the causes that single checks name would mend nothing: then all checks are
    one sentence.

    Args:
        evaluation: One drop.
        verdict: Its verdict.
    """
    failed = {check.sentence: check for check in evaluation.failed_checks}
    possible = sum(check.verdict != "not possible" for check in evaluation.checks)
    # Few failures: each has its own likely cause and next step.
    if len(evaluation.failed_checks) <= NEARLY_ALL * possible:
        return tuple(_explain_check(failed[text]) if text in failed else text for text in verdict.reasons)
    # Nearly all failed: the common input is wrong, and single causes would send people astray.
    everything = (
        f"{len(evaluation.failed_checks)} of {possible} checks failed at once, which no single sensor "
        "brings about: most "
        "likely the calibration, the robot file or the order of the bodies is not this robot's."
    )
    return (everything, *(text for text in verdict.reasons if text not in failed))


def _explain_check(check: Check) -> str:
    """Format a check's finding, likely cause and next step."""
    parts = [f"{check.name}: {check.sentence}"]
    parts += [f"Likely cause: {check.cause}"] if check.cause else []
    parts += [check.next_step] if check.next_step else []
    return _join(part if part.endswith((".", "!", "?")) else Advice(part, ".") for part in parts)


_COLUMNS = tuple(Column(name, name) for name in ("quantity", "value", "unit", "taken"))


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
    calibration, date_of = evaluation.calibration, _Taken(evaluation)
    rows = []
    for gyro in calibration.gyros:
        name = f"bias of body {gyro.body}"
        std = np.rad2deg(np.sqrt(np.diag(gyro.covariance)[:3]))
        rows.append([name, vector(np.rad2deg(gyro.bias_rad_s), std), "deg/s", date_of(name)])
    rows += [
        [*_misalignment_row(gyro, evaluation), date_of(f"misalignment of body {gyro.body}")]
        for gyro in calibration.gyros
    ]
    rows += [[*_scale(gyro), date_of("scale factor", f"of body {gyro.body}")] for gyro in calibration.gyros]
    for joint in calibration.joints:
        name = f"zero point of joint {joint.joint}"
        std = np.rad2deg(np.sqrt(np.diag(joint.zero_covariance)))
        rows.append([name, vector(np.rad2deg(joint.zero_rad) % 360.0, std), "deg", date_of(name)])
    return Table(
        "Calibration",
        _COLUMNS,
        [dict(zip(("quantity", "value", "unit", "taken"), row, strict=True)) for row in rows],
        "± is the greatest standard deviation of a row. What stands in for something that was never measured, "
        "or not since a landing, is shown next to the verdict.",
    )


class _Taken:
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


def _misalignment_row(gyro: GyroCalibration, evaluation: Evaluation) -> list[str]:
    """Format the angle between the sensor's mounting and its design."""
    # Rotation from the designed to the measured mounting; its angle follows from the trace.
    turn = gyro.rotation @ evaluation.model.imus[gyro.body - 1].sensor_to_body.T
    # Rounding may take the cosine beyond one: clip it.
    angle = np.rad2deg(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)))
    # Principal deviations of the tilt; the row shows the greatest, which holds in any direction.
    std = np.rad2deg(np.sqrt(np.linalg.eigvalsh(gyro.covariance[3:6, 3:6])))
    return [f"misalignment of body {gyro.body}", vector(np.array([angle]), std), "deg"]


def _scale(gyro: GyroCalibration) -> list[str]:
    """About each body axis."""
    values, std = np.array([gyro.scale_about(axis) for axis in range(3)]).T
    return [f"scale factors of body {gyro.body}", vector(values, std), "1"]
