"""`tfsat-host calibrate show`: what is calibrated, how old it is, and what the next drop cannot rely on."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime

from tfsat_host.calibration.certificate.certificate import Calibration, in_words
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.findings import Row, value_text
from tfsat_host.calibration.review import age_words, in_future, landing_words, review
from tfsat_host.cli.calibrate.arguments import certificate_path, none_yet
from tfsat_host.cli.calibrate.person import OF_EMULATED
from tfsat_host.next_step import Advice
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import UNKNOWN, Column
from tfsat_host.robot import load_robot

_STATES = {
    "valid": "valid",
    "stale": "STALE: a landing since",
    "missing": "MISSING",
    "matches": "as recorded",
    "changed": "CHANGED since",
    "gone": "NOT THERE",
    "unreadable": "UNREADABLE",
}


def run(args: argparse.Namespace, out: Output) -> int:
    """Reads one file and changes nothing.

    Raises:
        CalibrationError: there is no certificate, or it cannot be understood.
    """
    now = datetime.now(UTC)
    file = certificate_path(args, emulated=args.emulated)
    if not file.exists():
        raise none_yet(args, file)
    calibration = read_calibration(file)
    result = review(file, calibration, load_robot(args.robot), now)

    def age(row: Row) -> str:
        return UNKNOWN if row["taken"] is None else age_words(now - datetime.fromisoformat(row["taken"]))

    def state(row: Row) -> str:
        return _STATES[row["state"]]

    def show() -> None:
        value = Column("", "value ± 1 std", words=value_text)
        columns = (
            Column("quantity", "quantity"),
            value,
            Column("", "measured", words=age),
            Column("", "for the next drop", words=state),
        )
        show_rows(columns, result["quantities"], out, title=str(file))
        for line in _below(calibration, result):
            out.line(line)
        if papers := result["recordings"]:
            out.line()
            named = (Column("step", "recording"), Column("", "measured", words=age), Column("file", "file"))
            show_rows((*named, Column("", "SHA-256", words=state)), papers, out)
        for paper in papers:
            if paper["state"] != "matches":
                out.line(
                    f"NOT PROVEN: the recording of {paper['step']} is not as it was. Copy it back, or repeat the step; "
                    "it counts no more when another step is accepted."
                )
        out.line(landing_words(calibration, now))

    out.result(result, show)
    return 0


def _below(calibration: Calibration, result: Row) -> list[str]:
    """Lines below the quantities."""
    lines = [
        "Biases are along the sensors' own axes; misalignments and scale factors, about the bodies' axes."
    ]
    lines.append(f"Of {calibration.subject.describe()}, written {calibration.written:%Y-%m-%d %H:%M} UTC.")
    if calibration.subject.emulated:
        lines.append(OF_EMULATED)
    if calibration.drawn:
        lines.append(f"Drawn for a rehearsal, never measured: {in_words(calibration.drawn)}.")
    if not result["same_protocol"]:
        lines.append("It was written by a tfsat of another protocol; its values hold all the same.")
    rows, commands = result["quantities"], result["commands"]
    if commands:
        lacking = sum(row["state"] != "valid" for row in rows)
        lines += ["", f"{lacking} of {len(rows)} quantities are missing for the next drop. Type:"]
        lines += [Advice("  ", command) for command in commands]
    else:
        ready = "Nothing is missing for the next drop."
        lines += ["", ready if result["ready"] else "Every quantity is there, but see below."]
    lines += [
        f"The {row['quantity']} was measured in the future: the clock was wrong then, or is now. No landing can end it."
        for row in rows
        if in_future(row)
    ]
    return lines
