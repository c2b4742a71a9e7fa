"""The result of a preflight: GO or NO-GO with every check, as JSON and on one screen."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host import __version__
from tfsat_host.devices.board_identity import IDENTITY, BoardIdentity
from tfsat_host.devices.serial_ports import BoardName
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.checks import may_drop
from tfsat_host.preflight.preflight_check import CHECK, SEE, GoNoGo, PreflightCheck
from tfsat_host.preflight.preflight_evidence import Evidence, Missing, RunningRecording
from tfsat_host.present.output import GREEN, RED, Output
from tfsat_host.present.terminal import bullets, sentences, write_verdict
from tfsat_host.quantity import Column, Columns, by_name, fields

if TYPE_CHECKING:
    from rich.text import Text


_WORDS = {GoNoGo.GO: "GO", GoNoGo.NO_GO: "NO-GO", GoNoGo.NOT_MADE: "NOT MADE"}


@dataclass(frozen=True, eq=False)
class PreflightResult:
    """What a preflight came to.

    Attributes:
        evidence: What boards and files gave.
        checks: Made of the evidence.
        files: Path and SHA-256 of each file that was looked at, by what it is.
        left_on_boards: What of the preflight is left on the logger; empty: nothing.
        file: Where the result was written; None: it was not.
        sha256: As the run's record has it; None: it could not be signed.
    """

    evidence: Evidence
    checks: Sequence[PreflightCheck]
    files: Mapping[str, Any]
    left_on_boards: str = ""
    file: Path | None = None
    sha256: str | None = None

    @property
    def verdict(self) -> str:
        """`go` or `no-go`."""
        return (GoNoGo.GO if may_drop(self.checks) else GoNoGo.NO_GO).value

    @property
    def failed(self) -> list[PreflightCheck]:
        """Checks that block the drop by themselves, what was found wrong first."""
        failed = [check for check in self.checks if check.blocks and not check.follows]
        return sorted(failed, key=lambda check: check.verdict == GoNoGo.NOT_MADE)

    @property
    def verdict_line(self) -> str:
        """GO or NO-GO, the checks that failed, and how many passed."""
        passed = sum(check.verdict == GoNoGo.GO for check in self.checks)
        count = f"{passed} of {len(self.checks)} checks passed"
        emulated = ", emulated robot" if self.evidence.runs_natively else ""
        if may_drop(self.checks):
            return f"GO: {count}{emulated}"
        return f"NO-GO: {', '.join(check.name for check in self.failed)} ({count}{emulated})"

    def show(self, out: Output, *, full: bool, ask_for_drop: bool) -> None:
        """Show the verdict, what failed with what to type next, and the verdict again.

        `full`: every check. `ask_for_drop`: after GO, show what comes next, recording and arming.
        """
        color = GREEN if may_drop(self.checks) else RED
        write_verdict(self.verdict_line, color, out)
        if full:
            rows = [(check.name, _color_verdict(check), text) for check, text in _once(self.checks)]
            out.table(("check", "", "finding"), rows)
        bullets(self._failures(), out)
        sentences(self._facts(), out)
        if not full:
            sentences([Advice("All checks: ", self._again("--full"))], out)
        if not may_drop(self.checks):
            sentences([Advice("Next: ", self._again())], out)
        elif ask_for_drop:
            sentences([Advice("Next: ", *self._next())], out)
        write_verdict(self.verdict_line, color, out)

    def _failures(self) -> Iterator[str]:
        # Checks that failed for the same reason share a line.
        reasons = list(dict.fromkeys((check.sentence, check.next_step) for check in self.failed))
        for index, (sentence, next_step) in enumerate(reasons):
            names = ", ".join(check.name for check in self.failed if check.sentence == sentence)
            # What cures several of them stands below the last.
            shared = any(later == next_step for _, later in reasons[index + 1 :])
            text = f"{names}: {sentence}"
            yield text if shared else Advice(f"{text} Next: ", next_step)

    def _facts(self) -> Iterator[str]:
        if waiting := [check.name for check in self.checks if check.blocks and check.follows]:
            yield f"Not checked because of these failures: {', '.join(waiting)}"
        for check in self.checks:
            if check.verdict == GoNoGo.NOT_MADE and not check.blocks:
                yield f"Not checked by design: {check.name} ({check.next_step.rstrip('.')})"
        if self.file is not None:
            signed = f"signed {self.sha256[:12]}" if self.sha256 else "NOT SIGNED"
            yield f"Result: {self.file} ({signed})"

    def _again(self, *options: str) -> NextStep:
        folder = () if self.file is None else (str(self.file.parent),)
        return NextStep("preflight", (*folder, *options))

    def _next(self) -> tuple[NextStep | str, ...]:
        logger = self.evidence.logger
        if not isinstance(logger, Missing) and isinstance(logger.card, RunningRecording):
            return (NextStep("arm"),)
        return (NextStep("record start"), ", then ", NextStep("arm"))


def _once(checks: Sequence[PreflightCheck]) -> Iterator[tuple[PreflightCheck, str]]:
    """Yield each check with its sentence.

    A sentence that an earlier check already has is replaced by a reference to where to look.
    """
    first: dict[str, str] = {}
    for check in checks:
        name = first.setdefault(check.sentence, check.name)
        see = check.next_step if check.follows else ""
        yield check, f"{check.sentence} {see}".strip() if name == check.name else see or f"{SEE}{name}."


def _color_verdict(check: PreflightCheck) -> Text:
    from rich.text import Text

    style = "green" if check.verdict == GoNoGo.GO else "bold red" if check.blocks else "yellow"
    return Text(_WORDS[check.verdict], style=style)


def _identity(board: BoardName) -> Column:
    """Column of a board's identity; None of one that was not reached."""

    def identity(evidence: Evidence) -> BoardIdentity | None:
        reply = getattr(evidence, f"{board}_board").identity
        return None if isinstance(reply, Missing) else reply

    return Column(board, of=identity, columns=IDENTITY)


RESULT: Columns = (
    Column("verdict"),
    Column("at", of=lambda result: result.evidence.now.astimezone(UTC).isoformat()),
    Column("tfsat_version", of=lambda _result: __version__),
    Column("emulated", of="evidence.runs_natively"),
    Column("reasons", of=lambda result: [check.name for check in result.checks if check.blocks]),
    Column("checks", columns=CHECK),
    Column("boards", of="evidence", columns=(_identity("sequencer"), _identity("logger"))),
    Column("files", columns=by_name(fields("path sha256"))),
    *fields("left_on_the_boards=left_on_boards"),
)
"""What `preflight.json` holds."""
PRINTED: Columns = (*RESULT, *fields("file signed=sha256"))
"""What `--json` prints."""
