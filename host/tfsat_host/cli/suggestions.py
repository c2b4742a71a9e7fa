"""What may have been meant by a command, an option or an action that does not exist, and what there is."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable, Sequence
from typing import NoReturn

from tfsat_host.errors import UsageError

_NOTHING_DONE = "Nothing was done."


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
