"""`tfsat-host calibrate show`: what is calibrated, how old it is, and what the next drop cannot rely on."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from tfsat_host.calibration.certificate.certificate import Calibration, commands_of
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.review import KINDS, REVIEW, SUMMARY, Review, full_tables, group_by_kind, review
from tfsat_host.cli.calibrate.arguments import certificate_path, none_yet
from tfsat_host.cli.next_steps import complete_command
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import sentences, show, show_facts, show_rows
from tfsat_host.quantity import record
from tfsat_host.robot.absent_parts import describe_absent, load_robot_of_boards


def run(args: argparse.Namespace, out: Output) -> int:
    """Reads one file and changes nothing.

    Raises:
        CalibrationError: there is no certificate, or it cannot be understood.
    """
    file = certificate_path(args, emulated=args.emulated)
    if not file.exists():
        raise none_yet(args, file)
    calibration = read_calibration(file)
    show_certificate(file, calibration, args, out, full=args.full)
    return 0


def show_certificate(
    file: Path, calibration: Calibration, args: argparse.Namespace, out: Output, *, full: bool = False
) -> None:
    """Give the result: what the certificate holds."""
    # What is to be typed next is for the robot of the certificate: its word, not that of the options.
    of_certificate = argparse.Namespace(**{**vars(args), "emulated": calibration.subject.emulated})
    out.complete_command = partial(complete_command, args=of_certificate)
    robot = load_robot_of_boards(args.robot)
    if absent := describe_absent(robot):
        out.note(absent)
    result = review(file, calibration.of_robot(robot), robot, datetime.now(UTC))
    put_on = calibration.parts_put_on(robot)
    out.result(record(REVIEW, result), lambda: _show(result, put_on, out, full=full))


def _show(result: Review, put_on: Sequence[str], out: Output, *, full: bool) -> None:
    """One screen: the verdict, what it rests on, what to type; with `full` every value before that."""
    sentences([result.verdict], out)
    show_facts(SUMMARY, result, out)
    show_rows(KINDS, group_by_kind(result), out)
    if full:
        show(full_tables(result), out)
    if commands := commands_of(result.shortcomings):
        out.line("To measure:")
        if put_on:
            out.line(Advice("  ", NextStep("calibrate replaced", tuple(put_on)), " (put on since), then"))
        for command in commands:
            out.line(Advice("  ", command))
    if not full:
        out.line(Advice("Every value: ", NextStep("calibrate show", ("--full",))))
    sentences([result.verdict], out)
