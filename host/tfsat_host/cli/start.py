"""Where the program begins: Ctrl-C ends it without a traceback, even before it knows a command."""

from __future__ import annotations

import signal
import sys

_CAN_BE_INTERRUPTED = signal.getsignal(signal.SIGINT) is signal.default_int_handler
"""Not under nohup, nor where a shell has put it into the background."""
if _CAN_BE_INTERRUPTED:
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from tfsat_host.blas_threads import use_one_thread  # noqa: E402  under the handler above

use_one_thread()

from tfsat_host.cli.main import main  # noqa: E402  before anything loads numpy


def start() -> int:
    """Run one command; gives its exit code."""
    code = main(heed_interrupts=_CAN_BE_INTERRUPTED)
    if _CAN_BE_INTERRUPTED:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return code


if __name__ == "__main__":
    sys.exit(start())
