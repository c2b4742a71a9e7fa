"""Ctrl-C as a wish that a loop grants in order: a request is not cut in half, a joint is let go."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable, Iterable, Iterator
from types import FrameType

SIGNALS: list[signal.Signals] = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]
"""Windows has no SIGHUP."""
_SUSPEND: signal.Signals | None = getattr(signal, "SIGTSTP", None)
"""Ctrl-Z; Windows has none."""
SUSPEND: list[signal.Signals] = [] if _SUSPEND is None else [_SUSPEND]


class StopWish:
    """Says when called whether the user wants to stop.

    Attributes:
        suspend: He typed Ctrl-Z: `suspend_now` once everything is in order.
    """

    def __init__(self) -> None:
        self.suspend = False
        self._wished = False

    def __call__(self) -> bool:
        """Return whether to stop."""
        return self._wished

    def on_signal(self, number: int, _frame: FrameType | None) -> None:
        """Handle a signal by noting the wish to stop; a second Ctrl-C interrupts at once."""
        if number == _SUSPEND:
            self.suspend = True
        elif self._wished:
            raise KeyboardInterrupt
        self._wished = True


@contextlib.contextmanager
def handle_signals(
    signals: Iterable[signal.Signals], handler: Callable[[int, FrameType | None], object]
) -> Iterator[None]:
    """Send these signals to the handler while the block runs."""
    before = {number: signal.signal(number, handler) for number in signals}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


@contextlib.contextmanager
def stop_wish(*, before_suspension: bool = False) -> Iterator[StopWish]:
    """Gives the user's wish to stop.

    `before_suspension`: Ctrl-Z is such a wish as well, for what must not go on unattended.
    """
    wish = StopWish()
    suspension = [_SUSPEND] if before_suspension and _SUSPEND is not None else []
    with handle_signals([*SIGNALS, *suspension], wish.on_signal):
        yield wish


def suspend_now() -> None:
    """Stops this process as Ctrl-Z does; returns when it is continued."""
    if _SUSPEND is not None:
        os.kill(os.getpid(), _SUSPEND)
