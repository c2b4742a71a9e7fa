"""What `preflight` asks of both boards, and its next steps completed with this run's files and ports."""

from __future__ import annotations

import argparse
import os
import signal
import time
from collections.abc import Iterable
from contextlib import ExitStack, closing
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.cli.boards import emulated_transports, open_port
from tfsat_host.cli.next_steps import complete_command
from tfsat_host.cli.stopping import SIGNALS, handle_signals
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.serial_ports import BoardName, PortError, PortProblem, port_variable
from tfsat_host.devices.transport import Transport
from tfsat_host.errors import Interrupted, TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight import PreflightCheck
from tfsat_host.preflight.board_queries import ask_boards
from tfsat_host.preflight.logger_queries import WATCH_S, Trace
from tfsat_host.preflight.preflight_evidence import BoardEvidence, Evidence
from tfsat_host.present.output import Output
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE, MANEUVER, command_options, robot_options
from tfsat_host.run.prepared_run import PreparedRun

_NOTHING_LEFT = "Sequencer unchanged, no recording of this preflight left on the card."


def transports(
    args: argparse.Namespace, files: PreparedRun, stack: ExitStack, out: Output
) -> dict[BoardName, Transport | TfsatError]:
    """Open the links of both boards, closed with `stack`; a board that cannot be reached gives its error.

    Raises BuildError.
    """
    if args.emulated:
        links = emulated_transports(out, stack, model=files.robot, as_built=True)
        # It came to power with this command: no one could have set its clock.
        LoggerClient.connect(links["logger"]).set_clock(time.time_ns() // 1000)
        return {**links}
    by_board: dict[BoardName, Transport | TfsatError] = {}
    named: dict[BoardName, str | None] = {"sequencer": args.port, "logger": args.logger_port}
    for board, port in named.items():
        try:
            if board == "logger" and port is None and args.port is not None:
                _require_named_logger()
            by_board[board] = stack.enter_context(closing(open_port(board, port, out)))
        except TfsatError as error:
            by_board[board] = error
    return by_board


def _require_named_logger() -> None:
    """Raise PortError unless the environment names the logger's port.

    With an explicit `--port` no other ports are scanned.
    """
    variable = port_variable("logger")
    if not os.environ.get(variable):
        raise PortError(
            PortProblem.NONE_FOUND,
            what="The logger was not asked: --port names the sequencer only.",
            next_step=f"Name the logger's port too: --logger-port PORT (or {variable}=PORT).",
        )


def evidence_of(args: argparse.Namespace, files: PreparedRun, out: Output) -> tuple[Evidence, str]:
    """Collect what boards and files say, and describe what was left on the boards.

    Raises NotNow, Interrupted, TfsatError.
    """
    trace = Trace()
    try:
        # A closed terminal or a `kill` is a Ctrl-C: a recording that was begun is ended and removed.
        with ExitStack() as stack, handle_signals(SIGNALS, signal.default_int_handler):
            opened = transports(args, files, stack, out)
            sequencer_image, logger_image = files.images()
            expected = Evidence(
                robot=files.robot,
                schedule=files.schedule,
                facility=files.facility(),
                sequencer_board=BoardEvidence("sequencer", sequencer_image),
                logger_board=BoardEvidence("logger", logger_image),
                recordings=args.drops,
                now=datetime.now(UTC),
                newest_file=files.newest(),
            )
            with out.progress("Reading the sensors, recording onto the card", total=WATCH_S) as advance:
                evidence = ask_boards(opened, expected, files.calibration, trace, time.time, advance)
                evidence = replace(evidence, acceptance=files.acceptance(emulated=evidence.runs_natively))
    except (KeyboardInterrupt, Interrupted):
        raise Interrupted(
            what="Interrupted.",
            meaning=f"{trace.left or _NOTHING_LEFT} There is no result, and none was written.",
            next_step=Advice(
                NextStep("record stop"), ", then ", NextStep("log list"), " shows what to erase."
            )
            if trace.left
            else "Run the same command again when ready.",
        ) from None
    return evidence, trace.left


def complete_steps(
    checks: Iterable[PreflightCheck],
    args: argparse.Namespace,
    maneuver: Path,
    robot: Path,
    certificate: str,
    *,
    emulated: bool,
) -> tuple[PreflightCheck, ...]:
    """Complete the checks' next steps with this command's options, ready to be typed.

    `maneuver` and `certificate` (empty: there is none) are the run's files, `robot` its robot's.
    """
    file = Path(certificate or (EMULATED_CERTIFICATE if emulated else CERTIFICATE))
    of_certificate = command_options(file, robot, emulated=args.emulated)

    def complete(step: NextStep) -> NextStep:
        arguments = tuple(str(maneuver) if word == MANEUVER else word for word in step.arguments)
        if step.command.startswith("calibrate "):
            arguments += of_certificate
        if step.command == "acceptance":
            arguments += robot_options(robot)
        return complete_command(NextStep(step.command, arguments), args)

    return tuple(
        replace(check, next_step=check.next_step.with_commands(complete))
        if isinstance(check.next_step, Advice)
        else check
        for check in checks
    )
