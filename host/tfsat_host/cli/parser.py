"""The argument parsers of the commands; a command's module is imported with its parser."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Container
from types import ModuleType
from typing import Any, NoReturn

from tfsat_host import __version__
from tfsat_host.cli.commands import EXAMPLES, HELPS, overview
from tfsat_host.cli.suggestions import refuse_choice, refuse_missing_action
from tfsat_host.cli.usage import accept_negative_numbers
from tfsat_host.errors import UsageError

_MODULES = {"calibrate": "calibrate.command", "arm": "arming", "disarm": "arming"}
"""Where a command is done, if not in the module of its name."""


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are tfsat's."""

    def error(self, message: str) -> NoReturn:
        if message.startswith("the following arguments are required"):
            refuse_missing_action(self)
        raise UsageError(
            what=f"{message[:1].upper()}{message[1:].rstrip('.')}.",
            meaning="Nothing was done.",
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


def _formatter(prog: str) -> argparse.HelpFormatter:
    """Rich's formatter on a terminal, plain text elsewhere."""
    if not sys.stdout.isatty():
        return argparse.HelpFormatter(prog, max_help_position=28)
    from rich_argparse import RichHelpFormatter

    return RichHelpFormatter(prog, max_help_position=28)
