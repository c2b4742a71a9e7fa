"""What an acceptance has shown so far: kept after each step, so that an interrupted one resumes at its next."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

from tfsat_host import __version__
from tfsat_host.devices.board_identity import BoardIdentity
from tfsat_host.errors import TfsatError
from tfsat_host.json_values import format_json, parse_dataclass
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.preflight_check import CHECK, GoNoGo, PreflightCheck
from tfsat_host.quantity import Column, Columns, fields, record
from tfsat_host.whole_file import write_whole

FILE, EMULATED_FILE = "acceptance.json", "acceptance-emulated.json"
MADE_BY = "tfsat-host acceptance"


@dataclass(frozen=True, slots=True)
class AcceptedBoard:
    """A board, as it was when the acceptance began; see `BoardIdentity`."""

    serial: str
    firmware: str
    image_crc: str

    @classmethod
    def of(cls, identity: BoardIdentity) -> AcceptedBoard:
        """Take from HELLO what is kept."""
        return cls(identity.serial, identity.firmware, identity.image_crc)


def _checks(rows: Any) -> tuple[PreflightCheck, ...]:
    return tuple(
        PreflightCheck(
            row["name"], GoNoGo(row["verdict"]), row["sentence"], row["evidence"], row["next_step"]
        )
        for row in rows
    )


@dataclass(frozen=True, slots=True)
class StepResult:
    """One step that was done.

    Attributes:
        name: Of the step.
        at: When it was done.
        checks: What it has shown.
    """

    name: str
    at: datetime
    checks: Annotated[tuple[PreflightCheck, ...], _checks]

    @property
    def passed(self) -> bool:
        """Whether no check blocks."""
        return not any(check.blocks for check in self.checks)


@dataclass(frozen=True, slots=True)
class Acceptance:
    """An acceptance of one robot's boards, finished or not.

    Attributes:
        emulated: The robot is an emulated one.
        parts_sha256: `hash_wired_parts` of the robot that it was held against.
        steps_due: Names of all steps, in order.
        sequencer, logger: The boards.
        steps: Those that were done, in order.
    """

    emulated: bool
    parts_sha256: str
    steps_due: tuple[str, ...]
    sequencer: AcceptedBoard
    logger: AcceptedBoard
    steps: tuple[StepResult, ...] = ()

    @property
    def remaining(self) -> tuple[str, ...]:
        """Steps that are not done, or did not pass."""
        passed = {step.name for step in self.steps if step.passed}
        return tuple(name for name in self.steps_due if name not in passed)

    @property
    def checks(self) -> list[PreflightCheck]:
        """Of all steps."""
        return [check for step in self.steps for check in step.checks]

    @property
    def verdict_line(self) -> str:
        """Whether the robot is accepted, and what is missing or wrong."""
        count = f"{len(self.steps_due) - len(self.remaining)} of {len(self.steps_due)} steps passed"
        emulated = ", emulated robot" if self.emulated else ""
        if not self.remaining:
            return f"ACCEPTED: {count}{emulated}"
        return f"NOT ACCEPTED: {', '.join(self.remaining)} ({count}{emulated})"

    def with_step(self, result: StepResult) -> Acceptance:
        """Return the acceptance with this step's result in place of an earlier one."""
        # Servos and supply rest on the angles that the motion has shown.
        kept = self.without(("servos", "supply")) if result.name == "motion" else self
        by_name = {step.name: step for step in (*kept.steps, result)}
        return replace(self, steps=tuple(by_name[name] for name in self.steps_due if name in by_name))

    def without(self, names: Iterable[str]) -> Acceptance:
        """Return the acceptance with these steps still to be done."""
        return replace(self, steps=tuple(step for step in self.steps if step.name not in set(names)))

    def evidence(self, check: str, key: str) -> Any:
        """Return a number of an earlier check; None: it was not made."""
        return next((entry.evidence.get(key) for entry in self.checks if entry.name == check), None)


_BOARD = fields("serial firmware image_crc")
COLUMNS: Columns = (
    Column("verdict", of=lambda acceptance: "not-accepted" if acceptance.remaining else "accepted"),
    *fields("emulated parts_sha256 steps_due remaining"),
    Column("sequencer", columns=_BOARD),
    Column("logger", columns=_BOARD),
    Column(
        "steps",
        columns=(
            *fields("name passed"),
            Column("at", of=lambda step: step.at.isoformat()),
            Column("checks", columns=CHECK),
        ),
    ),
)


def write_acceptance(acceptance: Acceptance, path: Path) -> None:
    """Write the record. Raises OSError."""
    made_by = {"made_by": MADE_BY, "format": 1, "tfsat_version": __version__}
    write_whole(path, format_json({**made_by, **record(COLUMNS, acceptance)}).encode())


def read_acceptance(path: Path) -> Acceptance:
    """Read a record. Raises TfsatError: it is none, or damaged."""
    try:
        return parse_dataclass(Acceptance, json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise TfsatError(
            what=f"{path} is no record of an acceptance, or it is damaged: {error}.",
            meaning="What it showed cannot be read.",
            next_step=Advice("Delete it and begin anew: ", NextStep("acceptance")),
        ) from error
