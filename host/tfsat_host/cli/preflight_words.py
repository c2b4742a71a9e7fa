"""What `preflight` shows: a line for each check, GO or NO-GO at the end, and what to do next."""

from __future__ import annotations

import argparse
import shlex
import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from tfsat_host.cli.advice import device_option
from tfsat_host.cli.preflight_commands import logger_port
from tfsat_host.preflight import GoNoGo, PreflightCheck, may_drop
from tfsat_host.preflight.check import SEE
from tfsat_host.preflight.evidence import Missing, Running

if TYPE_CHECKING:
    from rich.text import Text

    from tfsat_host.preflight.evidence import Evidence
    from tfsat_host.present.output import Output
    from tfsat_host.run.preflight import WrittenResult

_WORDS = {GoNoGo.GO: "GO", GoNoGo.NO_GO: "NO-GO", GoNoGo.NOT_MADE: "NOT MADE"}
_WIDTH = 110


def show(
    checks: Sequence[PreflightCheck],
    evidence: Evidence,
    written: WrittenResult,
    args: argparse.Namespace,
    out: Output,
    *,
    emulated: bool,
) -> None:
    """The table, the reasons with what to do, and the verdict last."""
    out.table(("check", "", "what was found"), [(one.name, _word(one), said) for one, said in _once(checks)])
    wrong = [one for one in checks if one.blocks and not one.follows]
    waiting = sum(one.blocks and one.follows for one in checks)
    # What was found wrong first: what could not be made often follows from it.
    wrong.sort(key=lambda one: one.verdict == GoNoGo.NOT_MADE)
    for step in dict.fromkeys(one.next_step for one in wrong):
        names = ", ".join(one.name for one in wrong if one.next_step == step)
        for line in textwrap.wrap(f"{names}: {step}", _WIDTH, subsequent_indent="    "):
            out.line(f"  {line}")
    signed = f"signed {written.sha256[:12]}" if written.sha256 else "NOT SIGNED"
    out.line(f"WrittenResult: {written.file} ({signed})")
    no_real = " The robot is an emulated one: this says nothing of a real one." if emulated else ""
    if may_drop(checks):
        optional = [one.name for one in checks if one.verdict == GoNoGo.NOT_MADE]
        without = f" Not looked at, by design: {', '.join(optional)}." if optional else ""
        out.line(f"GO: {len(checks) - len(optional)} checks.{without}{no_real}")
        if not args.emulated:
            out.line(f"Next: {_next(evidence, args)}")
        return
    more = f" {waiting} more could not be made for that reason." if waiting else ""
    out.line(f"NO-GO: {', '.join(one.name for one in wrong)}.{more}{no_real}")
    devices = f"{device_option(args)}{logger_port(args, '--logger-port')}"
    out.line(f"Then again: tfsat-host preflight {shlex.quote(str(args.run))}{devices}")


def _once(checks: Sequence[PreflightCheck]) -> Iterator[tuple[PreflightCheck, str]]:
    """Each with its sentence; where one above said the same, with where to look instead."""
    first: dict[str, str] = {}
    for one in checks:
        said = first.setdefault(one.sentence, one.name)
        see = one.next_step if one.follows else ""
        yield one, f"{one.sentence} {see}".strip() if said == one.name else see or f"{SEE}{said}."


def _next(evidence: Evidence, args: argparse.Namespace) -> str:
    arm = f"tfsat-host arm{device_option(args)}"
    runs = not isinstance(evidence.logger, Missing) and isinstance(evidence.logger.card, Running)
    if runs:
        return arm
    return f"tfsat-host record start{logger_port(args, '--port')}, then {arm}"


def _word(check: PreflightCheck) -> Text:
    from rich.text import Text

    style = "green" if check.verdict == GoNoGo.GO else "bold red" if check.blocks else "yellow"
    return Text(_WORDS[check.verdict], style=style)
