"""Both boards of a preflight: found by the options of its command, and asked."""

from __future__ import annotations

import argparse
import os
import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.devices.ports import BoardName, port_variable
from tfsat_host.errors import Interrupted, TfsatError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from types import FrameType

    from tfsat_host.devices.transport import Transport
    from tfsat_host.preflight.evidence import Evidence
    from tfsat_host.run.preflight import PreparedRun

_NOTHING_LEFT = "The sequencer is as it was, and no recording of this preflight is left on the card."
_SIGNALS = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]


@contextmanager
def _interruptible_by_signals() -> Iterator[None]:
    """A closed terminal or a `kill` is a Ctrl-C: a recording that was begun is ended and removed."""

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def transports(
    args: argparse.Namespace, files: PreparedRun, stack: ExitStack, out: Output
) -> dict[BoardName, Transport | TfsatError]:
    """Both boards' links, closed with `stack`; why not, for one that is not to be had. Raises BuildError."""
    from tfsat_host.cli.connection import emulated_transports, open_port

    if args.emulated:
        from tfsat_host.devices.logger import LoggerClient

        links = emulated_transports(out, stack, model=files.robot, as_built=True)
        # It came to power with this command: no one could have set its clock.
        LoggerClient.connect(links["logger"]).set_clock(time.time_ns() // 1000)
        return {**links}
    found: dict[BoardName, Transport | TfsatError] = {}
    named: dict[BoardName, str | None] = {"sequencer": args.port, "logger": args.logger_port}
    for board, port in named.items():
        try:
            if board == "logger" and port is None and args.port is not None:
                _require_named_logger()
            found[board] = stack.enter_context(closing(open_port(board, port, out)))
        except TfsatError as error:
            found[board] = error
    return found


def _require_named_logger() -> None:
    """An explicit `--port` scans no others. Raises PortError unless the environment names the logger."""
    from tfsat_host.devices.ports import PortError, PortProblem

    variable = port_variable("logger")
    if not os.environ.get(variable):
        raise PortError(
            PortProblem.NONE_FOUND,
            what="The logger was not asked: --port names the sequencer only.",
            next_step=f"Name the logger's port too: --logger-port PORT (or {variable}=PORT).",
        )


def evidence_of(args: argparse.Namespace, files: PreparedRun, out: Output) -> tuple[Evidence, str]:
    """All that boards and files say, and what was left on the boards. Raises NotNow, Interrupted, TfsatError."""
    from tfsat_host.preflight.boards import ask_boards
    from tfsat_host.preflight.evidence import BoardEvidence, Evidence
    from tfsat_host.preflight.logger import WATCH_S, Trace

    trace = Trace()
    try:
        with ExitStack() as stack, _interruptible_by_signals():
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
            with out.progress("reading the sensors, recording onto the card", total=WATCH_S) as advance:
                evidence = ask_boards(opened, expected, files.calibration, trace, time.time, advance)
    except (KeyboardInterrupt, Interrupted):
        raise Interrupted(
            what="Interrupted.",
            meaning=f"{trace.left or _NOTHING_LEFT} There is no result, and none was written.",
            next_step="tfsat-host record stop, then tfsat-host log list shows what to erase."
            if trace.left
            else "Run the same command again when ready.",
        ) from None
    return evidence, trace.left
