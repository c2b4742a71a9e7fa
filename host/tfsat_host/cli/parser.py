"""The argument parsers of the commands, and what may have been meant by a word that does not exist.

A command's module is imported with its parser.
"""

from __future__ import annotations

import argparse
import importlib
import shlex
import sys
from collections.abc import Container, Iterable, Sequence
from types import ModuleType
from typing import Any, NoReturn

from tfsat_host import __version__
from tfsat_host.cli.commands import EXAMPLES, HELPS, overview
from tfsat_host.cli.usage import accept_negative_numbers
from tfsat_host.errors import UsageError

_MODULES = {"calibrate": "calibrate.command", "arm": "arming", "disarm": "arming"}
"""Where a command is done, if not in the module of its name."""
_NOTHING_DONE = "Nothing was done."


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are tfsat's."""

    def error(self, message: str) -> NoReturn:
        if message.startswith("the following arguments are required"):
            refuse_missing_action(self)
        raise UsageError(
            what=f"{message[:1].upper()}{message[1:].rstrip('.')}.",
            meaning=_NOTHING_DONE,
            next_step=f"{self.prog} --help",
        )

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and isinstance(value, str) and value not in action.choices:
            refuse_choice(self.prog, action, value)
        super()._check_value(action, value)


class _Overview(Parser):
    def format_help(self) -> str:
        return overview()


def module_of(command: str) -> str:
    """Return the name of the module of a command.

    The module defines `configure(parser)` and `run(args, out) -> exit code`.
    """
    return f"tfsat_host.cli.{_MODULES.get(command, command.replace('-', '_'))}"


def parser_with(names: Container[str]) -> tuple[Parser, dict[str, ModuleType]]:
    """Build a parser for these commands and their arguments; return it with the commands' modules."""
    parser = _Overview(prog="tfsat-host", allow_abbrev=False)
    parser.add_argument("--version", action="version", version=f"tfsat-host {__version__}")
    subparsers = parser.add_subparsers(
        title="commands", metavar="COMMAND", dest="command", parser_class=Parser
    )
    modules = {}
    for name, text in HELPS.items():
        if name in names:
            subparser = subparsers.add_parser(
                name,
                help=text,
                description=f"{text[:1].upper()}{text[1:]}.",
                epilog=f"Example: tfsat-host {EXAMPLES[name]}",
                formatter_class=_formatter,
                allow_abbrev=False,
            )
            modules[name] = importlib.import_module(module_of(name))
            accept_negative_numbers(subparser)
            modules[name].configure(subparser)
    return parser, modules


class _Formatter(argparse.HelpFormatter):
    """Leaves room for the longest word that follows a command: argparse forgets that these are indented."""

    def add_argument(self, action: argparse.Action) -> None:
        super().add_argument(action)
        if isinstance(action, argparse._SubParsersAction):
            indent = self._current_indent + self._indent_increment
            longest = indent + max(map(len, action.choices))
            self._action_max_length = max(self._action_max_length, longest)


def _formatter(prog: str) -> argparse.HelpFormatter:
    """Rich's formatter on a terminal, plain text elsewhere."""
    if not sys.stdout.isatty():
        return _Formatter(prog, max_help_position=28)
    from rich_argparse import RichHelpFormatter

    class RichFormatter(_Formatter, RichHelpFormatter):
        """Likewise, coloured."""

    return RichFormatter(prog, max_help_position=28)


def refuse_command(word: str, argv: Sequence[str], commands: Iterable[str]) -> NoReturn:
    """Raise UsageError for a command that does not exist, with the line as it may have been meant."""
    nearest = _find_nearest(word, commands)
    raise UsageError(
        what=f"There is no command {word!r}.",
        meaning=_NOTHING_DONE,
        next_step="tfsat-host --help lists all commands."
        if nearest is None
        else f"Did you mean: tfsat-host {shlex.join(nearest if argument == word else argument for argument in argv)}",
    )


def refuse_unknown_options(parser: argparse.ArgumentParser, argv: Sequence[str]) -> None:
    """Raise UsageError for the first `--option` that the command in `argv` does not have.

    argparse would first complain of its value, which it takes for something else.
    """
    options = set(parser._option_string_actions)
    for word in argv:
        chosen = _actions_of(parser).get(word)
        if chosen is not None:
            parser, options = chosen, options | set(chosen._option_string_actions)
    if "--" in argv:
        argv = argv[: list(argv).index("--")]
    for word in argv:
        option = word.partition("=")[0]
        if option.startswith("--") and option not in options:
            nearest = _find_nearest(option, options)
            raise UsageError(
                what=f"{parser.prog} has no option {option}.",
                meaning=_NOTHING_DONE,
                next_step=f"{'' if nearest is None else f'Did you mean {nearest}? '}All options: {parser.prog} --help",
            )


def refuse_choice(prog: str, action: argparse.Action, word: str) -> NoReturn:
    """Raise UsageError for a word that is none of an argument's choices."""
    choices = list(map(str, action.choices or ()))
    nearest = _find_nearest(word, choices)
    what = action.option_strings[-1] if action.option_strings else str(action.metavar or action.dest).lower()
    raise UsageError(
        what=f"{prog}: there is no {what} {word!r}.",
        meaning=_NOTHING_DONE,
        next_step=f"{'' if nearest is None else f'Did you mean {nearest}? '}There is: {', '.join(choices)}",
    )


def refuse_missing_action(parser: argparse.ArgumentParser) -> None:
    """Raise UsageError with a command's actions, a line each, if it has any."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            width = max(len(choice.dest) for choice in action._choices_actions)
            lines = [
                f"{parser.prog} {choice.dest:{width}}  {choice.help}" for choice in action._choices_actions
            ]
            kind = str(action.metavar or action.dest).lower()
            raise UsageError(
                what=f"{parser.prog} needs {'an' if kind[0] in 'aeiou' else 'a'} {kind}.",
                meaning=_NOTHING_DONE,
                next_step="\n".join(lines),
            )


def _actions_of(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Return the parsers of a parser's commands or actions, by name."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return dict(action.choices)
    return {}


def _find_nearest(word: str, candidates: Iterable[str]) -> str | None:
    from difflib import get_close_matches  # only a word that does not exist waits for it

    return next(iter(get_close_matches(word, list(candidates), 1)), None)
