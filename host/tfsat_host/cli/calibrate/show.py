"""`tfsat-host calibrate show`: what is calibrated, how old it is, and what the next drop cannot rely on."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.archive import recordings_folder
from tfsat_host.calibration.certificate.certificate import Calibration, Paper, in_words, quantities
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.findings import Row, value_rows, value_text
from tfsat_host.calibration.steps.evidence import sha256
from tfsat_host.cli.calibrate.flow import OF_EMULATED
from tfsat_host.cli.calibrate.options import certificate_path
from tfsat_host.present.output import Output
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.quantity import UNKNOWN
from tfsat_host.robot import RobotModel, load_robot

_STATES = {"valid": "valid", "stale": "STALE: a landing since", "missing": "MISSING"}
_MATCHES = {
    "matches": "as recorded",
    "changed": "CHANGED since",
    "gone": "NOT THERE",
    "unreadable": "UNREADABLE",
}
_CLOCKS_DIFFER = timedelta(minutes=2)


def run(args: argparse.Namespace, out: Output) -> int:
    """Reads one file and changes nothing.

    Raises:
        CalibrationError: there is no certificate, or it cannot be understood.
    """
    now = datetime.now(UTC)
    file = certificate_path(args, emulated=args.emulated)
    if not file.exists():
        raise _none_yet(args, file)
    calibration = read_calibration(file)
    rows = _rows(calibration, load_robot(args.robot), _options(args), now)
    papers = [
        asdict(paper) | {"taken": paper.taken.isoformat(), "state": _state(file, paper)}
        for paper in calibration.papers
    ]
    lacking = [row for row in rows if row["state"] != "valid"]
    future = [row for row in rows if (row["age_s"] or 0.0) < -_CLOCKS_DIFFER.total_seconds()]
    unproven = [paper for paper in papers if paper["state"] != "matches"]
    found: dict[str, Any] = {
        "file": file,
        "subject": asdict(calibration.subject),
        "written": calibration.written.isoformat(),
        "tool_version": calibration.tool_version,
        "protocol_hash": calibration.protocol_hash,
        "same_protocol": calibration.protocol_hash == PROTOCOL_HASH.hex(),
        "ready": not (lacking or unproven or future),
        "quantities": rows,
        "drawn": list(calibration.drawn),
        "commands": list(dict.fromkeys(row["command"] for row in lacking)),
        "recordings": papers,
        "landings": [
            {"at": landing.at.isoformat(), "told_by": landing.told_by} for landing in calibration.landings
        ],
    }

    def show() -> None:
        _show_quantities(calibration, found, out)
        if lacking:
            out.line(f"{len(lacking)} of {len(rows)} quantities are missing for the next drop. Type:")
            for command in found["commands"]:
                out.line(f"  {command}")
        elif unproven or future:
            out.line("Every quantity is there, but see below.")
        else:
            out.line("Nothing is missing for the next drop.")
        for row in future:
            out.line(
                f"The {row['quantity']} was measured in the future: the clock was wrong then, or is now. No landing "
                "can end it."
            )
        _show_papers(papers, unproven, now, out)
        _show_landings(calibration, now, out)

    out.result(found, show)
    return 0


def _none_yet(args: argparse.Namespace, file: Path) -> CalibrationError:
    """Names the certificate of a real or an emulated robot where the other one was asked for."""
    meaning = "Without one a drop cannot be evaluated: a bias of 1 deg/s alone is 2.5 deg over a fall."
    begin = f"tfsat-host calibrate bias{_options(args)}"
    next_step = f"Begin with: {begin}"
    other = certificate_path(args, emulated=not args.emulated)
    if other != file and other.exists():
        kind, option = ("a real", "") if args.emulated else ("an emulated", " --emulated")
        meaning = f"{other} is here, but it is that of {kind} robot. {meaning}"
        next_step = f"To see that one: tfsat-host calibrate show{option}. To begin: {begin}"
    return CalibrationError(
        what=f"There is no calibration yet: no file {file}.", meaning=meaning, next_step=next_step
    )


def _options(args: argparse.Namespace) -> str:
    """What makes the next command work on the same certificate."""
    out = f" --out {shlex.quote(str(args.out))}" if args.out else ""
    return out + (" --emulated" if args.emulated else "")


def _rows(calibration: Calibration, model: RobotModel, options: str, now: datetime) -> list[Row]:
    """All that a drop needs, in the order in which it is measured; `options` end every command."""
    states = {one.name: one.reason for one in calibration.shortcomings()}
    values = value_rows(calibration, model)
    unknown = {"value": None, "std": None, "unit": None}
    return [
        {
            "quantity": one.name,
            "state": states.get(one.name, "valid"),
            **(unknown if one.taken is None else values[one.name]),
            "taken": None if one.taken is None else one.taken.isoformat(),
            "age_s": None if one.taken is None else (now - one.taken).total_seconds(),
            "command": f"tfsat-host calibrate {one.command}{options}",
        }
        for one in quantities(calibration)
    ]


def _state(certificate: Path, paper: Paper) -> str:
    """Whether a recording is as the certificate says."""
    try:
        data = (recordings_folder(certificate) / paper.file).read_bytes()
    except FileNotFoundError:
        return "gone"
    except OSError:
        return "unreadable"
    return "matches" if sha256(data) == paper.sha256 else "changed"


def _show_quantities(calibration: Calibration, found: Mapping[str, Any], out: Output) -> None:
    table = [
        (
            row["quantity"],
            UNKNOWN if row["value"] is None else value_text(row),
            UNKNOWN if row["age_s"] is None else age_words(timedelta(seconds=row["age_s"])),
            _STATES[row["state"]],
        )
        for row in found["quantities"]
    ]
    out.table(("quantity", "value ± 1 std", "measured", "for the next drop"), table, title=str(found["file"]))
    out.line(
        "Biases are along the sensors' own axes; misalignments and scale factors, about the bodies' axes."
    )
    out.line(f"Of {calibration.subject.describe()}, written {calibration.written:%Y-%m-%d %H:%M} UTC.")
    if calibration.subject.emulated:
        out.line(OF_EMULATED)
    if calibration.drawn:
        out.line(f"Drawn for a rehearsal, never measured: {in_words(calibration.drawn)}.")
    if not found["same_protocol"]:
        out.line("It was written by a tfsat of another protocol; its values hold all the same.")
    out.line()


def _show_papers(
    papers: Sequence[Mapping[str, Any]], unproven: Sequence[Mapping[str, Any]], now: datetime, out: Output
) -> None:
    if papers:
        out.line()
        out.table(
            ("recording", "measured", "file", "SHA-256"),
            [
                (
                    paper["step"],
                    age_words(now - datetime.fromisoformat(paper["taken"])),
                    paper["file"],
                    _MATCHES[paper["state"]],
                )
                for paper in papers
            ],
        )
    for paper in unproven:
        out.line(
            f"NOT PROVEN: the recording of {paper['step']} is not as it was. Take it from a copy, or repeat the step; "
            "it counts no more when another step is accepted."
        )


def _show_landings(calibration: Calibration, now: datetime, out: Output) -> None:
    if not calibration.landings:
        out.line(
            "No landing since the campaign began, as far as is known: decode and evaluate tell of landings."
        )
        return
    *earlier, last = calibration.landings
    more = f" ({len(earlier)} earlier)" if earlier else ""
    ago = age_words(now - last.at)
    out.line(f"Last landing: {last.at:%Y-%m-%d %H:%M:%S} UTC, {ago}, by {last.told_by}{more}.")


def age_words(age: timedelta) -> str:
    """Such as `3 h ago`."""
    if age < timedelta(minutes=-1):
        return "in the future"
    if age < timedelta(minutes=2):
        return "just now"
    for limit, step, unit in (
        (timedelta(hours=2), timedelta(minutes=1), "min"),
        (timedelta(days=2), timedelta(hours=1), "h"),
    ):
        if age < limit:
            return f"{age // step} {unit} ago"
    return f"{age.days} days ago"
