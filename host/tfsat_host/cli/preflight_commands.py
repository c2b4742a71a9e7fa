"""Commands that a preflight recommends, as they are to be typed here: with this run's files and these devices."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.advice import device_option
from tfsat_host.run.certificate_notices import command_options
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE

if TYPE_CHECKING:
    from tfsat_host.preflight import PreflightCheck

_MANEUVER = "--file maneuver.toml"
_SEQUENCER = re.compile(rf"tfsat-host (?:disarm|jog|upload-servos|upload-sequence {_MANEUVER})")
_LOGGER = re.compile(
    r"tfsat-host (?:logger-settings set(?: --(?:rate \d+|clock|factory))?|"
    r"log (?:list|(?:fetch|erase)(?: (?:ram|all))?)|record (?:start|stop))"
)
_CALIBRATE = re.compile(r"tfsat-host calibrate (?P<quantity>[a-z]+)(?: --[a-z]+(?: (?:[\dN]+|[xyz] \d+))?)*")


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
