"""Errors a person can act on.

Every failure that tfsat foresees is a `TfsatError`: it says what happened, what that means for
the drop, and what to type or do next. The command line prints these three and ends with
`exit_code`; it never shows a traceback for them.
"""

from __future__ import annotations

from tfsat_host.exit_code import ExitCode

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, ClassVar, Self

    from tfsat_host.quantity import Columns


class TfsatError(Exception):
    """Something failed.

    Args:
        what: What happened, one sentence, with the names and numbers involved.
        meaning: What it means for the drop (what is lost, unsafe, unchanged).
        next_step: What to do now; commands to type in an `Advice`.
        code: A stable name for `--json`, where callers tell such errors apart.

    Attributes:
        columns: What else `--json` has of it.
    """

    exit_code: ClassVar[ExitCode] = ExitCode.FAILED
    code: Any = None
    columns: Columns = ()

    def __init__(self, *, what: str, meaning: str, next_step: str, code: object = None) -> None:
        super().__init__(what)
        if code is not None:
            self.code = code
        self.what = what
        self.meaning = meaning
        self.next_step = next_step

    def with_words(
        self, *, what: str | None = None, meaning: str | None = None, next_step: str | None = None
    ) -> Self:
        """Return the same error for another reader: what is given replaces its words."""
        other = type(self).__new__(type(self), *self.args)
        other.__dict__.update(self.__dict__)
        other.what = self.what if what is None else what
        other.meaning = self.meaning if meaning is None else meaning
        other.next_step = self.next_step if next_step is None else next_step
        return other

    def __str__(self) -> str:
        return "\n".join(line for line in (self.what, self.meaning, self.next_step) if line)


class UsageError(TfsatError):
    """The command was called in a way it does not understand."""

    exit_code: ClassVar[ExitCode] = ExitCode.USAGE


class RefusedError(TfsatError):
    """An interlock refused; nothing was changed."""

    exit_code: ClassVar[ExitCode] = ExitCode.REFUSED


class Interrupted(TfsatError):
    """Ctrl-C while a board was connected."""

    exit_code: ClassVar[ExitCode] = ExitCode.INTERRUPTED
