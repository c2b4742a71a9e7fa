"""What `preflight` shows: each check, GO or NO-GO, and what to type next, with this run's files and these devices."""

from __future__ import annotations

import argparse
import re
import shlex
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.advice import device_option
from tfsat_host.preflight import GoNoGo, PreflightCheck, may_drop
from tfsat_host.preflight.check import SEE
from tfsat_host.preflight.evidence import Missing, Running
from tfsat_host.run.certificate_notices import command_options
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE

if TYPE_CHECKING:
    from rich.text import Text

    from tfsat_host.preflight.evidence import Evidence
    from tfsat_host.present.output import Output
    from tfsat_host.run.preflight import WrittenResult

_WORDS = {GoNoGo.GO: "GO", GoNoGo.NO_GO: "NO-GO", GoNoGo.NOT_MADE: "NOT MADE"}
_WIDTH = 110
_MANEUVER = "--file maneuver.toml"
_SEQUENCER = re.compile(rf"tfsat-host (?:disarm|jog|upload-servos|upload-sequence {_MANEUVER})")
_LOGGER = re.compile(
    r"tfsat-host (?:logger-settings set(?: --(?:rate \d+|clock|factory))?|"
    r"log (?:list|(?:fetch|erase)(?: (?:ram|all))?)|record (?:start|stop))"
)
_CALIBRATE = re.compile(r"tfsat-host calibrate (?P<quantity>[a-z]+)(?: --[a-z]+(?: (?:[\dN]+|[xyz] \d+))?)*")


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
    out.table(("check", "", "what was found"), [(one.name, _word(one), text) for one, text in _once(checks)])
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
    """Each with its sentence; where it stands above already, with where to look instead."""
    first: dict[str, str] = {}
    for one in checks:
        name = first.setdefault(one.sentence, one.name)
        see = one.next_step if one.follows else ""
        yield one, f"{one.sentence} {see}".strip() if name == one.name else see or f"{SEE}{name}."


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


def typed_here(
    checks: Iterable[PreflightCheck],
    args: argparse.Namespace,
    maneuver: Path,
    certificate: str,
    *,
    emulated: bool,
) -> tuple[PreflightCheck, ...]:
    """The checks with their next steps as they are to be typed.

    Args:
        checks: As they were judged.
        args: The command's.
        maneuver: The run's file.
        certificate: The run's; empty: there is none.
        emulated: The robot is no real one.
    """
    at_sequencer = device_option(args)
    at_logger = at_sequencer if args.emulated else logger_port(args, "--port")
    file = Path(certificate or (EMULATED_CERTIFICATE if emulated else CERTIFICATE))
    of_certificate = command_options(file, emulated=args.emulated)

    def calibrating(found: re.Match[str]) -> str:
        port = "" if args.emulated or found["quantity"] == "show" else at_logger
        return found[0] + of_certificate + port

    def here(step: str) -> str:
        step = _CALIBRATE.sub(calibrating, step)
        step = _LOGGER.sub(lambda found: found[0] + at_logger, step)
        step = _SEQUENCER.sub(lambda found: found[0] + at_sequencer, step)
        return step.replace(_MANEUVER, f"--file {shlex.quote(str(maneuver))}")

    return tuple(replace(check, next_step=here(check.next_step)) for check in checks)


def logger_port(args: argparse.Namespace, option: str) -> str:
    """The logger's port as it was given, under that option, with a space before; empty where it was not."""
    return "" if args.logger_port is None else f" {option} {shlex.quote(args.logger_port)}"
