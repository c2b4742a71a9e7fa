"""What a certificate says before a drop: the state of each quantity, and whether its recordings are as they were."""

from __future__ import annotations

from dataclasses import asdict
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.certificate import Calibration, Paper, quantities
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder
from tfsat_host.calibration.findings import Row, value_rows
from tfsat_host.calibration.steps.evidence import sha256
from tfsat_host.next_step import Advice
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.robot import RobotModel

# Clocks of two computers may disagree by so much before a time counts as in the future.
CLOCKS_DIFFER = timedelta(minutes=2)
_AGES = ((timedelta(hours=2), timedelta(minutes=1), "min"), (timedelta(days=2), timedelta(hours=1), "h"))
_UNKNOWN = {"value": None, "std": None, "unit": None}


def review(file: Path, calibration: Calibration, model: RobotModel, now: datetime) -> dict[str, Any]:
    """Collect all that a drop needs, in measuring order, with its proof; for `calibrate show --json`.

    Args:
        file: The certificate.
        calibration: Its contents.
        model: The robot.
        now: Time to which ages count.
    """
    rows = _quantity_rows(calibration, model, now)
    lacking = [row for row in rows if row["state"] != "valid"]
    papers = [
        asdict(paper) | {"taken": paper.taken.isoformat(), "state": _state(file, paper)}
        for paper in calibration.papers
    ]
    # Values count only with their proof: each recording as it was when they were computed.
    unproven = any(paper["state"] != "matches" for paper in papers)
    return {
        "file": file,
        "subject": asdict(calibration.subject),
        "written": calibration.written.isoformat(),
        "tool_version": calibration.tool_version,
        "protocol_hash": calibration.protocol_hash,
        "same_protocol": calibration.protocol_hash == PROTOCOL_HASH.hex(),
        "ready": not (lacking or unproven or any(map(in_future, rows))),
        "quantities": rows,
        "drawn": list(calibration.drawn),
        "commands": list(dict.fromkeys(row["command"] for row in lacking)),
        "recordings": papers,
        "landings": [asdict(landing) | {"at": landing.at.isoformat()} for landing in calibration.landings],
    }


def in_future(row: Row) -> bool:
    """Return whether a quantity was measured later than now: a clock is wrong."""
    return (row["age_s"] or 0.0) < -CLOCKS_DIFFER.total_seconds()


def _quantity_rows(calibration: Calibration, model: RobotModel, now: datetime) -> list[Row]:
    states = {gap.name: gap.reason for gap in calibration.shortcomings()}
    values = value_rows(calibration, model)
    return [
        {
            "quantity": quantity.name,
            "state": states.get(quantity.name, "valid"),
            **(_UNKNOWN if quantity.taken is None else values[quantity.name]),
            "taken": None if quantity.taken is None else quantity.taken.isoformat(),
            "age_s": None if quantity.taken is None else (now - quantity.taken).total_seconds(),
            "command": Advice(quantity.command),
        }
        for quantity in quantities(calibration)
    ]


def _state(certificate: Path, paper: Paper) -> str:
    """Compare a recording with the certificate: `matches`, `changed`, `gone` or `unreadable`."""
    try:
        data = (recordings_folder(certificate) / paper.file).read_bytes()
    except FileNotFoundError:
        return "gone"
    except OSError:
        return "unreadable"
    return "matches" if sha256(data) == paper.sha256 else "changed"


def landing_words(calibration: Calibration, now: datetime) -> str:
    """Format the last landing as a sentence."""
    if not calibration.landings:
        return (
            "No landing since the campaign began, as far as is known: decode and evaluate tell of landings."
        )
    *earlier, last = calibration.landings
    earlier_note = f" ({len(earlier)} earlier)" if earlier else ""
    return (
        f"Last landing: {last.at:%Y-%m-%d %H:%M:%S} UTC, {age_words(now - last.at)}, by "
        f"{last.told_by}{earlier_note}."
    )


def age_words(age: timedelta) -> str:
    """Format an age in words, such as `3 h ago`."""
    if age < timedelta(minutes=-1):
        return "in the future"
    if age < timedelta(minutes=2):
        return "just now"
    older = (f"{age // step} {unit} ago" for limit, step, unit in _AGES if age < limit)
    return next(older, f"{age.days} days ago")
