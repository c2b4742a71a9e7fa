"""What a command prints, and where: results to stdout, everything else to stderr.

Nothing here imports Rich until something is shown that needs it, and nothing is coloured unless the
stream is a terminal (and NO_COLOR is unset).
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Any, TextIO

from tfsat_host.errors import RefusedError, TfsatError, UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import printable
from tfsat_host.present.keys import single_keys
from tfsat_host.present.wrapping import stream_columns, wrap_line

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

Advance = Callable[[float], None]
GREEN, YELLOW, RED = "32", "33", "1;31"
"""Colours of verdicts on a terminal, as select-graphic-rendition sequences have them."""

_PIPED_TABLE_COLUMNS = 120


class NotConfirmed(RefusedError):
    """A person answered a question with anything but what lets it go on."""


class Output:
    """The voice of one command.

    Args:
        json_mode: Print exactly one JSON object to stdout and keep prose out of it.
        yes: Answer every question with yes; nothing is asked.
        stdout: Where results go.
        stderr: Where diagnostics, questions and progress go.
        stdin: Where answers come from.

    Attributes:
        complete_command: Adds what the running command was given to a command that is shown as advice.
        stdout_error: Why a part of the result could not be written; None: all of it was.
        stderr_error: Likewise, of the diagnostics.
    """

    def __init__(
        self,
        *,
        json_mode: bool = False,
        yes: bool = False,
        stdout: TextIO | None = None,
        stderr: TextIO | None = None,
        stdin: TextIO | None = None,
    ) -> None:
        self.json_mode = json_mode
        self.yes = yes
        self._stdout = stdout or sys.stdout
        self._stderr = stderr or sys.stderr
        self._stdin = stdin or sys.stdin
        self._result_given = False
        self.complete_command: Callable[[NextStep], NextStep] = lambda step: step
        self.stdout_error: OSError | None = None
        self.stderr_error: OSError | None = None

    @property
    def can_ask(self) -> bool:
        """Whether an operator is there to choose what to do next: a terminal, and neither `--json` nor `--yes`."""
        return not self.json_mode and not self.yes and self._stdin.isatty()

    def result(self, data: Mapping[str, Any], text: str | Callable[[], None] = "") -> None:
        """Write the result of the command, once.

        Args:
            data: The JSON object; NaN and infinity become null, as JSON has no such numbers.
            text: What a person sees instead: text, or a function that prints by `line` and `table`.
        """
        if self._result_given:
            raise RuntimeError("a command has one result")
        self._result_given = True
        if self.json_mode:
            self._print_json(data)
        elif callable(text):
            text()
        elif text:
            self.line(text)

    def line(self, text: str = "", *, no_wrap: bool = False, colored: str = "", color: str = "") -> None:
        """Write one line of the result for people; nothing with `--json`.

        Args:
            text: A line or several.
            no_wrap: For a program that reads lines: it is not wrapped.
            colored: A word of it that has a colour on a terminal.
            color: As a select-graphic-rendition sequence has it.
        """
        if self.json_mode:
            return
        columns = None if no_wrap else stream_columns(self._stdout)
        rows = "\n".join(_rows(_visible(self.complete(text)), columns))
        if colored and _has_color(self._stdout):
            rows = rows.replace(colored, f"\x1b[{color}m{colored}\x1b[0m", 1)
        with self._writing_stdout():
            print(rows, file=self._stdout)

    def table(self, columns: Sequence[str], rows: Iterable[Sequence[object]], *, title: str = "") -> None:
        """Write a table of the result for people; nothing with `--json`. Numbers are aligned right.

        A cell may be Rich's `Text`, with its colours. No word is broken: if the table's columns are too many for
        the terminal, each row is a block of lines.
        """
        if self.json_mode:
            return
        from rich.text import Text

        from tfsat_host.present.text_tables import table_of

        listed = [
            [self.complete(value) if isinstance(value, str) else value for value in row] for row in rows
        ]
        cells = [[_cell(value) for value in row] for row in listed]
        # A column is aligned right if all of its cells are numbers.
        numeric = [bool(cells) and all(row[index][1] for row in cells) for index in range(len(columns))]
        texts = [
            [
                value if isinstance(value, Text) else Text(text)
                for value, (text, _) in zip(row, row_cells, strict=True)
            ]
            for row, row_cells in zip(listed, cells, strict=True)
        ]
        heads = [Text(_visible(name)) for name in columns]
        console = self._console(self._stdout)
        with self._writing_stdout():
            # Rich pads lines to its width: capture them, to write them without spaces at the end.
            with console.capture() as captured:
                console.print(table_of(heads, texts, numeric, _visible(title), console.width))
            print("\n".join(map(str.rstrip, captured.get().splitlines())), file=self._stdout)

    def stream(self, data: Mapping[str, Any]) -> None:
        """Write a JSON object on a line of its own, for a command that has many; nothing without `--json`."""
        if self.json_mode:
            self._print_json(data)
            self._stdout.flush()

    @contextlib.contextmanager
    def live(self, *, diagnostic: bool = False) -> Iterator[Callable[[RenderableType], None] | None]:
        """Open a view on stdout (stderr if `diagnostic`); each call of its function redraws it in place.

        Yields None where lines are wanted instead: the stream is no terminal, or `--json`.
        """
        stream = self._stderr if diagnostic else self._stdout
        if self.json_mode or not stream.isatty():
            yield None
            return
        from rich.live import Live

        with Live(console=self._console(stream), auto_refresh=False, transient=diagnostic) as view:
            yield lambda picture: view.update(picture, refresh=True)

    def note(self, text: str) -> None:
        """Write a diagnostic to stderr: something a person should know that is not the result."""
        self._tell(text)

    def warn(self, text: str) -> None:
        """Write a warning to stderr, marked as one."""
        self._tell(text, "Warning: ", "33")

    def warn_each(self, texts: Iterable[str]) -> None:
        """Warnings; one that begins with a space goes on with the one before."""
        for text in texts:
            (self.note if text.startswith(" ") else self.warn)(text)

    def error(self, error: TfsatError) -> int:
        """Shows an error (with `--json`, as the one JSON object) and gives its exit code."""
        # One JSON object for each command: an error after the result goes to stderr as text.
        if self.json_mode and not self._result_given:
            self._result_given = True
            from tfsat_host.error_columns import error_columns
            from tfsat_host.quantity import record

            self._print_json({"error": record(error_columns(error), error)})
            return error.exit_code
        code_text = f" ({refusal_name(error.code)})" if isinstance(error.code, IntEnum) else ""
        self._tell(f"{error.what}{code_text}", "Error: ", "1;31")
        for text in filter(None, (error.meaning, self.complete(error.next_step))):
            self._tell("  " + text.replace("\n", "\n  "))
        return error.exit_code

    def confirm(self, question: str, *, meaning: str) -> None:
        """Asks a yes/no question on the terminal; `--yes` answers it.

        Raises:
            NotConfirmed: the answer was not yes.
            UsageError: there is no terminal to ask on, and no `--yes`.
        """
        if self.yes:
            return
        self.ask(f"{question} [y/N] ", meaning=meaning, accept=("y", "yes"))

    def ask(self, prompt: str, *, meaning: str, accept: Sequence[str]) -> None:
        """Waits until a person types one of `accept` (any case); anything else refuses."""
        self._require_terminal(prompt, meaning)
        print(_visible(prompt), end="", file=self._stderr, flush=True)
        # The end of input reads as an empty line, which accepts nothing.
        if self._stdin.readline().strip().lower() not in accept:
            raise NotConfirmed(
                what="Not confirmed.", meaning=meaning, next_step="Run the same command again when ready."
            )

    def ask_key(self, prompt: str, *, meaning: str, keys: str) -> str:
        """Return which of these keys a person presses; Enter is `\n`. No Enter follows a key.

        What was typed before the prompt counts for nothing: a key that bounces must not answer the next question.

        Raises UsageError: there is no terminal.
        """
        self._require_terminal(prompt, meaning)
        with single_keys(self._stdin) as read_key:
            print(_visible(prompt), end="", file=self._stderr, flush=True)
            while not (key := read_key().lower()) or key not in keys:
                if not key:
                    raise NotConfirmed(
                        what="The terminal was closed.",
                        meaning=meaning,
                        next_step="Run the same command again.",
                    )
        print(file=self._stderr)
        return key

    def _require_terminal(self, prompt: str, meaning: str) -> None:
        if not self._stdin.isatty():
            raise UsageError(
                what=f"No terminal for the answer to: {prompt.strip()}",
                meaning=meaning,
                next_step="Run it in a terminal, or add --yes.",
            )

    @contextlib.contextmanager
    def progress(self, description: str, total: float | None = None) -> Iterator[Advance]:
        """Shows that work is going on; gives a function that advances it by some units of `total`.

        On a terminal a bar, elsewhere one line at the start. Nothing with `--json`.
        """
        if self.json_mode:
            yield lambda _amount: None
            return
        if not self._stderr.isatty():
            # No terminal: a bar's control sequences would litter a log file.
            self.note(f"{description} …")
            yield lambda _amount: None
            return
        from rich import progress

        columns: list[progress.ProgressColumn] = [
            progress.SpinnerColumn(),
            progress.TextColumn("{task.description}", markup=False),
            progress.BarColumn(),
        ]
        if total is None:
            columns.append(progress.TimeElapsedColumn())
        else:
            columns += [progress.TaskProgressColumn(), progress.TimeRemainingColumn()]
        with progress.Progress(*columns, console=self._console(self._stderr), transient=True) as bar:
            task = bar.add_task(_visible(description), total=total)
            yield lambda amount: bar.advance(task, amount)

    def _print_json(self, data: Mapping[str, Any]) -> None:
        import json

        from tfsat_host.json_values import jsonable

        with self._writing_stdout():
            # NaN is null by now; should one be left, fail rather than write what is no JSON.
            print(json.dumps(jsonable(data, self.complete), allow_nan=False), file=self._stdout)

    def _console(self, stream: TextIO) -> Console:
        from rich.console import Console

        width = stream_columns(stream) or _PIPED_TABLE_COLUMNS
        return Console(file=stream, highlight=False, width=width, no_color=not _has_color(stream))

    def _tell(self, text: str, mark: str = "", sgr: str = "") -> None:
        """Print to stderr, wrapped on a terminal."""
        rows = _rows(f"{mark}{_visible(self.complete(text))}", stream_columns(self._stderr))
        if mark and _has_color(self._stderr):
            rows[0] = rows[0].replace(mark.rstrip(), f"\x1b[{sgr}m{mark.rstrip()}\x1b[0m", 1)
        try:
            print("\n".join(rows), file=self._stderr, flush=True)
        except BrokenPipeError:
            raise
        except OSError as error:
            # A full disk under stderr must not end the command: keep the first error for its end.
            self.stderr_error = self.stderr_error or error

    def complete(self, text: str) -> str:
        """Complete the commands of an advice as they are to be typed; any other text stays as it is."""
        return text.with_commands(self.complete_command) if isinstance(text, Advice) else text

    @contextlib.contextmanager
    def _writing_stdout(self) -> Iterator[None]:
        """Keep the first error of writing to stdout, such as a full disk, so that the command goes on.

        A BrokenPipeError is raised.
        """
        try:
            yield
        except BrokenPipeError:
            # The reader has gone, as with `| head`: nobody wants the rest.
            raise
        except OSError as error:
            self.stdout_error = self.stdout_error or error


def _rows(text: str, columns: int | None) -> list[str]:
    """Split a text into lines, wrapped if there is a width."""
    rows = text.split("\n")
    return rows if columns is None else [line for row in rows for line in wrap_line(row, columns)]


def refusal_name(code: IntEnum) -> str:
    """Format a board's refusal by number and name, as people quote it."""
    return f"refusal {int(code)}, {code.name.lower()}"


def _has_color(stream: TextIO) -> bool:
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def _visible(text: str) -> str:
    """Without what would move the cursor, ring, colour the screen or turn the writing: names come from anywhere."""
    lines = text.split("\n")
    return text if all(map(str.isprintable, lines)) else "\n".join(map(printable, lines))


def _cell(value: object) -> tuple[str, bool]:
    """Return a cell's text and whether it is a number."""
    # Before int, which bool is a kind of.
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "–"}[value], False
    if isinstance(value, int | float):
        return f"{value:g}" if isinstance(value, float) else str(value), True
    return _visible(str(value)), False
