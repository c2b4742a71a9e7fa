"""What `arm` asks of the logger: whether the drop will be on its card, and which sensors will see it."""

from __future__ import annotations

import argparse
import os
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tfsat_host.cli.advice import device_option
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.steps.evidence import Origin
    from tfsat_host.devices.card_trouble import NotOnCard
    from tfsat_host.protocol.messages import LoggerStatusReply


@dataclass(frozen=True)
class LoggerAnswer:
    """What is known of the logger.

    Attributes:
        recording: Whether the drop would be on its card; None: it was not asked, or did not say.
        origin: Whose sensors hang on it; None likewise.
    """

    recording: bool | None = None
    origin: Origin | None = None


def look_at_logger(args: argparse.Namespace, out: Output) -> LoggerAnswer:
    """Asks the logger whether the drop would be on its card, with a warning if not, and whose sensors it has.

    An explicit `--port` scans no others: then only the environment names a logger.

    Raises:
        NotOnCard: a recording was started and does not reach its card, and nobody said `--unrecorded`.
    """
    from tfsat_host.devices.ports import PortError, find_port, port_variable

    if args.port is not None and not os.environ.get(port_variable("logger")):
        out.warn(
            f"The logger was not asked whether it records: --port names the sequencer only. A drop that is not "
            f"recorded leaves no data. To have it asked, set {port_variable('logger')}=PORT"
        )
        return LoggerAnswer()
    try:
        port = find_port("logger")
    except PortError as error:
        out.warn(
            f"The logger was not asked whether it records: a drop that is not recorded leaves no data. {error.what}"
        )
        return LoggerAnswer()
    try:
        status, danger, origin = _ask(port)
    except TfsatError as error:
        out.warn(f"The logger did not say whether it records. {error.what}")
        return LoggerAnswer()
    if danger is not None:
        if not args.unrecorded:
            danger.meaning = f"{danger.meaning} Nothing was armed."
            danger.next_step = (
                f"{danger.next_step}\nTo arm all the same: tfsat-host arm --unrecorded{device_option(args)}"
            )
            raise danger
        out.warn(f"{danger.what} {danger.meaning}")
        return LoggerAnswer(False, origin)
    if not _records(status):
        out.warn(
            f"The logger at {port} is not recording ({status.state.name.lower()}): a drop now would leave no data. "
            "Start it: tfsat-host record start"
        )
    return LoggerAnswer(_records(status), origin)


def _ask(port: str) -> tuple[LoggerStatusReply, NotOnCard | None, Origin]:
    from tfsat_host.devices.card_trouble import stalled_recording
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.transport import SerialTransport
    from tfsat_host.preflight.origin import origin_of_logger

    with closing(SerialTransport(port)) as transport:
        logger = LoggerClient.connect(transport)
        status = logger.status()
        origin = origin_of_logger(logger.identity, status.who_am_i)
        return status, stalled_recording(logger, status), origin


def _records(status: LoggerStatusReply) -> bool:
    from tfsat_host.protocol.enums import LoggerState

    return status.state == LoggerState.RECORDING
