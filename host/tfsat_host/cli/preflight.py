"""`tfsat-host preflight`: GO or NO-GO before a drop, with the evidence for it."""

from __future__ import annotations

import argparse
from pathlib import Path

from tfsat_host.cli.usage import add_options, device, whole_number
from tfsat_host.exit_code import ExitCode
from tfsat_host.present.output import Output
from tfsat_host.quantity import record

DROPS = 10
"""A day's, with rehearsals in the releaser."""


_USAGE = f"""
Look at everything that must be right before a drop, and say GO or NO-GO. Nothing moves; a recording of some seconds
is made on the card, read back and removed. The result goes into RUN/preflight.json and, by its hash, into the run's
record. Exit code 0 for GO, 4 for NO-GO. docs/preflight.md explains every check.

--full              for people: show every check, also those that passed
[RUN]               folder of the drop, with maneuver.toml and calibration.toml (default: the current one)
--logger-port PORT  serial port of the logger, in addition to the sequencer's --port; without it TFSAT_LOGGER_PORT,
                    else, without --port, the one port that looks like this board
what the drop is checked against:
--maneuver FILE        what is to be flown (default: maneuver.toml in RUN)
--calibration FILE     certificate of the sensors (default: calibration.toml in RUN or here; of an emulated robot
                       calibration-emulated.toml)
--robot FILE           a robot file, or the name of a robot that tfsat brings along (default: robot.toml in RUN, else
                       drop_tower)
--facility FILE        a facility file (default: COSMOTORRE's)
--drops N              for how many recordings the card must have room (default {DROPS})
--sequencer-image HEX  HEX that the sequencer should run, or its CRC (default: that of make firmware in this checkout)
--logger-image CRC     CRC of the image that the logger should run, 8 hex digits: image_crc of tfsat-host status --json
                       right after it was flashed (default: what it ran when it was calibrated, by the certificate)
{device("sequencer")}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for the run, its files, the boards' expected images, and their ports."""
    add_options(parser, _USAGE, drops=whole_number("drops", 1, 999), logger_image=_crc)
    parser.set_defaults(run=Path(), drops=DROPS)


def run(args: argparse.Namespace, out: Output) -> int:
    """Asks, judges, writes, shows."""
    from tfsat_host.cli.preflight_report import complete_steps, evidence_of
    from tfsat_host.preflight import judge, may_drop
    from tfsat_host.preflight.preflight_result import PRINTED, PreflightResult
    from tfsat_host.run.prepared_run import PreparedRun, write_result

    files = PreparedRun.open(
        args.run,
        maneuver=args.maneuver,
        certificate=args.calibration,
        robot=args.robot,
        facility=args.facility,
        sequencer_image=args.sequencer_image,
        logger_image=args.logger_image,
    )
    evidence, leftovers = evidence_of(args, files, out)
    certificate = evidence.calibration_file
    emulated = evidence.runs_natively
    checks = complete_steps(
        judge(evidence), args, files.maneuver, files.robot.path, certificate, emulated=emulated
    )
    result = PreflightResult(evidence, checks, files.hashes(certificate), leftovers)
    result, unsigned = write_result(files.folder, result)
    out.result(
        record(PRINTED, result), lambda: result.show(out, full=args.full, ask_for_drop=not args.emulated)
    )
    if leftovers:
        out.warn(leftovers)
    if unsigned is not None:
        raise unsigned
    return 0 if may_drop(checks) else ExitCode.REFUSED


def _crc(text: str) -> str:
    if len(text) != 8 or any(digit not in "0123456789abcdefABCDEF" for digit in text):
        raise argparse.ArgumentTypeError(f"{text!r} is no CRC: write its 8 hexadecimal digits")
    return text.lower()
