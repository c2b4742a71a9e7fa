"""The command line: one file per command, no mathematics.

`import tfsat_host.cli` comes first of all, and so a Ctrl-C while the rest is imported shows no traceback.
"""

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import TracebackType

_show = sys.excepthook


def _interrupted_or_shown(
    kind: type[BaseException], error: BaseException, trace: "TracebackType | None"
) -> None:
    if issubclass(kind, KeyboardInterrupt):
        sys.stderr.write("Interrupted.\n")  # Python then ends by the signal: 130 in a shell
    else:
        _show(kind, error, trace)


sys.excepthook = _interrupted_or_shown
