"""`tfsat-host record start` and `record stop`: the recording of a real drop."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass

from tfsat_host.cli.boards import open_logger, refuse_emulated
from tfsat_host.cli.usage import add_actions, device
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.logger import LoggerClient, recording_in_danger
from tfsat_host.errors import RefusedError
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import ErrorCode, LoggerState
from tfsat_host.protocol.limits import IMU_COUNT
from tfsat_host.protocol.messages import LoggerStatusReply, RecordStartReply, RecordStopReply
from tfsat_host.quantity import Column, Columns, columns_of, fields, record
from tfsat_host.run.held_maneuver import ask_sequencer, note_held


@dataclass(frozen=True, slots=True)
class StartedRecording:
    """A recording that the card takes.

    Attributes:
        status: The logger's.
        session: Hexadecimal.
        imu_present: Whether each IMU answers.
        maneuver_crc: Of the maneuver that the sequencer holds, hexadecimal; None: not known.
        device: The logger.
    """

    status: LoggerStatusReply
    session: str
    imu_present: Sequence[bool]
    maneuver_crc: str | None
    device: Device


@dataclass(frozen=True, slots=True)
class StoppedRecording:
    """A recording that is closed on the card.

    Attributes:
        reply: The logger's answer to the stop.
        session: Hexadecimal.
        number: On the card; None: the card does not list it.
        file_full: It ended by itself, as its file was full.
        device: The logger.
    """

    reply: RecordStopReply
    session: str
    number: int | None
    file_full: bool
    device: Device


_STARTED: Columns = (
    *columns_of("status", fields("state blocks_written rate_hz unix_s=unix_us")),
    *fields("session imu_present maneuver_crc"),
    Column("device", columns=DEVICE),
)
_STOPPED: Columns = (
    *columns_of("reply", fields("state samples samples_dropped")),
    *fields("session number file_full"),
    Column("device", columns=DEVICE),
)
_ACTIONS = """
start  start a recording and wait until the card really takes it
stop   end the recording and wait until the card holds all of it
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Start or stop; the device."""
    add_actions(parser, _ACTIONS, after=device("logger"))


def run(args: argparse.Namespace, out: Output) -> int:
    """Starts or stops, whichever was typed."""
    refuse_emulated(args, f"record {args.action}", "The recording would be gone with the command.")
    return _start(args, out) if args.action == "start" else _stop(args, out)


def _start(args: argparse.Namespace, out: Output) -> int:
    with open_logger(args, out) as logger:
        held_maneuver = ask_sequencer(out.note, logger_named=args.port is not None)
        maneuver_crc = None if held_maneuver is None else held_maneuver.stored.crc
        started = _begin(logger, maneuver_crc)
        with out.progress("Waiting until the card takes blocks"):
            status = logger.wait_for_card()
        present = [bool(status.imu_present >> bit & 1) for bit in range(IMU_COUNT)]
        silent = (body for body, here in enumerate(present, 1) if not here)
        out.warn_each(
            f"IMU {body} does not answer: the rates of body {body} are not recorded." for body in silent
        )
        session = f"{started.session:08x}"
        if held_maneuver is not None:
            note_held(held_maneuver, started.session, "record start", out.note)
        crc = None if maneuver_crc is None else f"{maneuver_crc:04x}"
        holds = "" if crc is None else f" The sequencer holds maneuver {crc}."
        out.result(
            record(_STARTED, StartedRecording(status, session, present, crc, logger.device())),
            Advice(
                f"Recording: session {session}, {status.rate_hz} Hz, the card takes blocks.{holds} "
                "Pulling the cable does not stop it; it closes automatically after the landing.\nAfter the drop: ",
                NextStep("record stop"),
            ),
        )
    return 0


def _begin(logger: LoggerClient, maneuver_crc: int | None) -> RecordStartReply:
    """Start a recording whose header names the maneuver that the sequencer holds.

    Raises BoardError, and RefusedError if one is running already: a good recording is not to be ended.
    """
    try:
        return logger.start_recording(unix_us=time.time_ns() // 1000, maneuver_crc=maneuver_crc)
    except BoardError as error:
        status = logger.status()
        if error.code != ErrorCode.WRONG_STATE or status.state != LoggerState.RECORDING:
            raise
    if danger := recording_in_danger(status):
        raise danger
    raise RefusedError(
        what=f"The logger is recording already: session {status.session:08x}, {status.samples} samples, "
        f"{status.samples_dropped} dropped.",
        meaning="That recording goes on, and nothing was changed: the robot may be dropped.",
        next_step=Advice(
            "To see its state: ",
            NextStep("status"),
            "\nOnly for a separate file of the next drop, end this recording first: ",
            NextStep("record stop"),
        ),
        code=ErrorCode.WRONG_STATE,
    )


def _stop(args: argparse.Namespace, out: Output) -> int:
    with open_logger(args, out) as logger:
        logger.end_capture()  # refuses at once where there is nothing to wait for
        with out.progress("Waiting until the recording's end is on the card"):
            stopped = logger.stop_recording()
        session, lost = f"{stopped.session:08x}", stopped.samples_dropped
        on_card = (
            entry.number for entry in logger.logs() if entry.session == stopped.session and entry.number
        )
        number = next(on_card, None)
        file_full = logger.status().error == ErrorCode.CARD_FULL
        out.result(
            record(_STOPPED, StoppedRecording(stopped, session, number, file_full, logger.device())),
            Advice(
                f"Recording: session {session}, stopped and closed on the card, {stopped.samples} samples, "
                f"{lost} dropped\n"
                "Next: ",
                NextStep("log fetch", (str(number or "all"),)),
            ),
        )
        if lost:
            out.warn(f"{lost} samples were dropped because the card was too slow; decode says where.")
        if file_full:
            out.warn(
                Advice(
                    "It ended automatically, before it was stopped: its file was full. More room for the next one: ",
                    NextStep("logger-settings set", ("--file-mib", "64")),
                )
            )
    return ExitCode.DATA_LOSS if lost or file_full else 0
