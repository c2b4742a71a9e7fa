"""`tfsat-host calibrate show`: what is calibrated, how old it is, and what the next drop cannot rely on."""

from __future__ import annotations

import argparse
import shlex
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.calibrate.options import certificate_path
from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.present.output import Output
from tfsat_host.quantity import UNKNOWN, fields, record

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.certificate import Calibration, Paper
    from tfsat_host.calibration.errors import CalibrationError
    from tfsat_host.cli.calibrate.show_rows import Row

_VALUE = fields("value std unit")
_STATES = {"valid": "valid", "stale": "STALE: a landing since", "missing": "MISSING"}
_MATCHES = {
    "matches": "as recorded",
    "changed": "CHANGED since",
    "gone": "NOT THERE",
    "unreadable": "UNREADABLE",
}

_CLOCKS_DIFFER = timedelta(minutes=2)


def configure(parser: argparse.ArgumentParser) -> None:
    """Which certificate."""
    group = parser.add_argument_group("certificate")
    group.add_argument(
        "--out",
        metavar="FILE",
        type=file_name,
        help="the certificate that the steps went into (default as theirs)",
    )
    group.add_argument(
        "--robot", metavar="FILE", type=file_name, help="robot file (default: the drop tower robot)"
    )
    group.add_argument("--emulated", action="store_true", help="that of the emulated robot")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Shows it as of now."""
    return show(args, out, datetime.now(UTC))


def show(args: argparse.Namespace, out: Output, now: datetime) -> int:
    """Reads one file and changes nothing.

    Raises:
        CalibrationError: there is no certificate, or it cannot be understood.
    """
    from tfsat_host.calibration.certificate.file import read_calibration
    from tfsat_host.cli.calibrate.show_rows import rows_of
    from tfsat_host.robot import load_robot

    file = certificate_path(args, emulated=args.emulated)
    if not file.exists():
        raise _none_yet(args, file)
    calibration = read_calibration(file)
    rows = rows_of(calibration, load_robot(args.robot), _options(args))
    papers = [(paper, _paper_state(file, paper)) for paper in calibration.papers]
    out.result(
        _as_json(calibration, file, rows, papers, now),
        lambda: _show(calibration, file, rows, papers, now, out),
    )
    return 0


def _none_yet(args: argparse.Namespace, file: Path) -> CalibrationError:
    """Names the certificate of a real or an emulated robot where the other one was asked for."""
    from tfsat_host.calibration.errors import CalibrationError

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


def _paper_state(certificate: Path, paper: Paper) -> str:
    from tfsat_host.calibration.steps.evidence import sha256

    folder = certificate.with_name(f"{certificate.stem}-recordings")
    try:
        data = (folder / paper.file).read_bytes()
    except FileNotFoundError:
        return "gone"
    except OSError:
        return "unreadable"
    return "matches" if sha256(data) == paper.sha256 else "changed"


def _as_json(
    calibration: Calibration, file: Path, rows: list[Row], papers: list[tuple[Paper, str]], now: datetime
) -> dict[str, Any]:
    from dataclasses import asdict

    lacking = [row for row in rows if row.state != "valid"]
    return {
        "file": file,
        "subject": asdict(calibration.subject),
        "written": calibration.written.isoformat(),
        "tool_version": calibration.tool_version,
        "protocol_hash": calibration.protocol_hash,
        "same_protocol": _same_protocol(calibration),
        "ready": not (lacking or _unproven(papers) or _future(rows, now)),
        "quantities": [_row_as_json(row, now) for row in rows],
        "drawn": list(calibration.drawn),
        "commands": list(dict.fromkeys(row.command for row in lacking)),
        "recordings": [
            asdict(paper) | {"taken": paper.taken.isoformat(), "state": state} for paper, state in papers
        ],
        "landings": [
            {"at": landing.at.isoformat(), "told_by": landing.told_by} for landing in calibration.landings
        ],
    }


def _unproven(papers: list[tuple[Paper, str]]) -> list[Paper]:
    return [paper for paper, state in papers if state != "matches"]


def _future(rows: list[Row], now: datetime) -> list[Row]:
    return [row for row in rows if row.taken is not None and row.taken > now + _CLOCKS_DIFFER]


def _row_as_json(row: Row, now: datetime) -> dict[str, Any]:
    value = row.value
    found = (
        {"value": None, "std": None, "unit": None} if value is None else record(_VALUE, value) | value.more
    )
    return {
        "quantity": row.name,
        "state": row.state,
        **found,
        "taken": None if row.taken is None else row.taken.isoformat(),
        "age_s": None if row.taken is None else (now - row.taken).total_seconds(),
        "command": row.command,
    }


def _same_protocol(calibration: Calibration) -> bool:
    from tfsat_host.protocol.limits import PROTOCOL_HASH

    return calibration.protocol_hash == PROTOCOL_HASH.hex()


def _show(
    calibration: Calibration,
    file: Path,
    rows: list[Row],
    papers: list[tuple[Paper, str]],
    now: datetime,
    out: Output,
) -> None:
    table = [
        (
            row.name,
            "–" if row.value is None else row.value.text,
            age_words(row.taken, now),
            _STATES[row.state],
        )
        for row in rows
    ]
    out.table(("quantity", "value ± 1 std", "measured", "for the next drop"), table, title=str(file))
    out.line(
        "Biases are along the sensors' own axes; misalignments and scale factors, about the bodies' axes."
    )
    out.line(f"Of {calibration.subject.describe()}, written {calibration.written:%Y-%m-%d %H:%M} UTC.")
    if calibration.subject.emulated:
        out.line("These are the errors of an emulated robot: of no use for a real one.")
    if calibration.drawn:
        from tfsat_host.calibration.certificate.drawn import in_words

        out.line(f"Drawn for a rehearsal, never measured: {in_words(calibration.drawn)}.")
    if not _same_protocol(calibration):
        out.line("It was written by a tfsat of another protocol; its values hold all the same.")
    out.line()
    _show_lacking(rows, out, doubtful=bool(_unproven(papers) or _future(rows, now)))
    for row in _future(rows, now):
        out.line(
            f"The {row.name} was measured in the future: the clock was wrong then, or is now. No landing can end it."
        )
    _show_papers(papers, now, out)
    _show_landings(calibration, now, out)


def _show_lacking(rows: list[Row], out: Output, *, doubtful: bool) -> None:
    lacking = [row for row in rows if row.state != "valid"]
    if not lacking:
        out.line(
            "Every quantity is there, but see below." if doubtful else "Nothing is missing for the next drop."
        )
        return
    out.line(f"{len(lacking)} of {len(rows)} quantities are missing for the next drop. Type:")
    for command in dict.fromkeys(row.command for row in lacking):
        out.line(f"  {command}")


def _show_papers(papers: list[tuple[Paper, str]], now: datetime, out: Output) -> None:
    if papers:
        out.line()
        out.table(
            ("recording", "measured", "file", "SHA-256"),
            [
                (paper.step, age_words(paper.taken, now), paper.file, _MATCHES[state])
                for paper, state in papers
            ],
        )
    for paper in _unproven(papers):
        out.line(
            f"NOT PROVEN: the recording of {paper.step} is not as it was. Take it from a copy, or repeat the step; "
            "it counts no more when another step is accepted."
        )


def _show_landings(calibration: Calibration, now: datetime, out: Output) -> None:
    if calibration.landings:
        last = calibration.landings[-1]
        earlier = len(calibration.landings) - 1
        more = f" ({earlier} earlier)" if earlier else ""
        out.line(
            f"Last landing: {last.at:%Y-%m-%d %H:%M:%S} UTC, {age_words(last.at, now)}, told by {last.told_by}{more}."
        )
    else:
        out.line(
            "No landing since the campaign began, as far as is known: decode and evaluate tell of landings."
        )


def age_words(taken: datetime | None, now: datetime) -> str:
    """Such as `3 h ago`; a dash for never."""
    if taken is None:
        return UNKNOWN
    age = now - taken
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
