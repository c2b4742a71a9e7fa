"""`tfsat-host preflight`: GO or NO-GO before a drop, with the evidence for it."""

from __future__ import annotations

import argparse
from pathlib import Path

from tfsat_host.cli.options import add_device_options, file_name, port_name, whole_number
from tfsat_host.errors import RefusedError
from tfsat_host.present.output import Output

DROPS = 10
"""A day's, with rehearsals in the releaser."""


def configure(parser: argparse.ArgumentParser) -> None:
    """The run, its files, what the boards should run, and where they are."""
    parser.description = (
        "Look at everything that must be right before a drop, and say GO or NO-GO. Nothing moves; a recording of some "
        "seconds is made on the card, read back and removed. The result goes into RUN/preflight.json and, by its hash, "
        "into the run's record. Exit code 0 for GO, 4 for NO-GO. docs/preflight.md explains every check."
    )
    parser.add_argument(
        "run",
        metavar="RUN",
        nargs="?",
        type=file_name,
        default=Path(),
        help="folder of the drop, with maneuver.toml and calibration.toml (default: the current one)",
    )
    files = parser.add_argument_group("what the drop is checked against")
    for name, text in (
        ("maneuver", "what is to be flown (default: maneuver.toml in RUN)"),
        ("calibration", "certificate of the sensors (default: calibration.toml in RUN or here; of an emulated robot "
         "calibration-emulated.toml)"),
        ("robot", "a robot file, or the name of a robot that tfsat brings along (default: robot.toml in RUN, else "
         "drop_tower)"),
        ("facility", "a facility file (default: COSMOTORRE's)"),
    ):  # fmt: skip
        files.add_argument(f"--{name}", metavar="FILE", type=file_name, help=text)
    files.add_argument(
        "--drops",
        metavar="N",
        type=whole_number("drops", 1, 999),
        default=DROPS,
        help=f"for how many recordings the card must have room (default {DROPS})",
    )
    files.add_argument(
        "--sequencer-image",
        metavar="HEX",
        type=file_name,
        help="HEX that the sequencer should run, or its CRC (default: that of make firmware in this checkout)",
    )
    files.add_argument(
        "--logger-image",
        metavar="CRC",
        type=_crc,
        help="CRC of the image that the logger should run, 8 hex digits: image_crc of tfsat-host status --json right "
        "after it was flashed (default: what it ran when it was calibrated, by the certificate)",
    )
    parser.add_argument(
        "--logger-port",
        metavar="PORT",
        type=port_name,
        help="serial port of the logger, in addition to the sequencer's --port; without it TFSAT_LOGGER_PORT, "
        "else, without --port, the one port that looks like this board",
    )
    add_device_options(parser, "sequencer")


def run(args: argparse.Namespace, out: Output) -> int:
    """Asks, judges, writes, shows."""
    from tfsat_host.cli.preflight_boards import evidence_of
    from tfsat_host.cli.preflight_words import show, typed_here
    from tfsat_host.preflight import judge, may_drop
    from tfsat_host.run.preflight import PreparedRun, result_of, runs_natively, write_result

    files = PreparedRun.open(
        args.run,
        maneuver=args.maneuver,
        certificate=args.calibration,
        robot=args.robot,
        facility=args.facility,
        sequencer_image=args.sequencer_image,
        logger_image=args.logger_image,
    )
    evidence, left = evidence_of(args, files, out)
    emulated = runs_natively(evidence)
    checks = typed_here(judge(evidence), args, files.maneuver, evidence.calibration_file, emulated=emulated)
    result = result_of(evidence, checks, files.hashes(evidence.calibration_file), left)
    written = write_result(files.folder, result, evidence.now)
    shown = {**result, "file": str(written.file), "signed": written.sha256}
    out.result(shown, lambda: show(checks, evidence, written, args, out, emulated=emulated))
    if left:
        out.warn(left)
    if written.error is not None:
        raise written.error
    return 0 if may_drop(checks) else RefusedError.exit_code


def _crc(text: str) -> str:
    if len(text) != 8 or any(digit not in "0123456789abcdefABCDEF" for digit in text):
        raise argparse.ArgumentTypeError(f"{text!r} is no CRC: write its 8 hexadecimal digits")
    return text.lower()
