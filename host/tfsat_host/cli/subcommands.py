"""Words that follow a command, such as `log fetch`: each one a parser of its own."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from tfsat_host.cli.options import accept_negative_numbers


def add_subcommands(
    parser: argparse.ArgumentParser,
    helps: Mapping[str, str],
    *,
    title: str = "actions",
    dest: str = "action",
    required: bool = True,
) -> dict[str, argparse.ArgumentParser]:
    """A parser for each word, in the style of the command's.

    Args:
        parser: The command's.
        helps: What each word does, without a capital and a full stop; with them it describes the word's own help.
        title: Of all words in the command's help.
        dest: What one of them is called, and where the arguments hold it.
        required: Whether the command does nothing without one.
    """
    subparsers = parser.add_subparsers(title=title, metavar=dest.upper(), dest=dest, required=required)
    added = {}
    for name, text in helps.items():
        added[name] = subparsers.add_parser(
            name,
            help=text,
            description=f"{text[:1].upper()}{text[1:]}.",
            formatter_class=type(parser._get_formatter()),
            allow_abbrev=False,
        )
        accept_negative_numbers(added[name])
    return added
