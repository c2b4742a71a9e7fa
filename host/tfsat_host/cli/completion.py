"""`tfsat-host completion bash|zsh|fish`: a script that completes commands, options and files, made from the parser."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping

import shtab

from tfsat_host.cli.commands import HELPS
from tfsat_host.cli.parser import parser_with
from tfsat_host.cli.usage import OUTPUT, add_options
from tfsat_host.present.output import Output

SHELLS = ("bash", "zsh", "fish")

# What a metavar of the commands stands for. The rest is numbers and names: nothing to propose.
_FILES = ("FILE", "RUN", "BUNDLE", "PATH", "HEX")
_FOLDERS = ("DIR", "D")
_PORTS = ("PORT",)
_FAULT = "--fault"

# Boards as Linux (with the names of tools/udev) and macOS show them; Windows has none of these shells.
_PORT_PATTERNS = "/dev/tfsat-* /dev/ttyACM* /dev/cu.usbmodem*"
_PORT_FUNCTION = "_tfsat_ports"
_PREAMBLE = {
    "bash": f"""\
{_PORT_FUNCTION}() {{
  local port
  for port in {_PORT_PATTERNS}; do [[ -e $port ]] && compgen -W "$port" -- "$1"; done
  compgen -f -- "$1"
}}""",
    "zsh": f"""\
{_PORT_FUNCTION}() {{
  local -a ports
  ports=({" ".join(f"{pattern}(N)" for pattern in _PORT_PATTERNS.split())})
  compadd -a ports
  _files
}}""",
    "fish": f"""\
function {_PORT_FUNCTION}
  for port in {_PORT_PATTERNS}
    echo $port
  end
  __fish_complete_path (commandline -ct)
end""",
}
_PORT_COMPLETION: Mapping[str, str | dict[str, str]] = {
    "bash": _PORT_FUNCTION,
    "zsh": _PORT_FUNCTION,
    "fish": f"({_PORT_FUNCTION})",
}


_USAGE = f"""
Print a script that completes the commands, options and files of tfsat-host in a shell. docs/guide/computer.md says
where it belongs.

shell {{bash,zsh,fish}}  which shell will read it
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the shell argument."""
    add_options(parser, _USAGE)


def run(args: argparse.Namespace, out: Output) -> int:
    """Builds the whole parser, every command's arguments included, and prints the script."""
    script = completion_script(args.shell)
    out.result({"shell": args.shell, "script": script}, lambda: out.line(script, no_wrap=True))
    return 0


def completion_script(shell: str) -> str:
    """Build the completion script for one of `SHELLS` from the parsers of all commands."""
    from tfsat_host.rehearsal.faults.fault_catalog import FAULTS

    parser, _ = parser_with(HELPS)
    for action in _actions(parser):
        if isinstance(action, argparse._SubParsersAction):
            _describe_briefly(action)
        if _FAULT in action.option_strings:
            # For the script alone: the command also takes NAME@MOMENT, and must not import them to show its help.
            action.choices = [fault.name for fault in FAULTS]
        if action.choices is None and (words := _completion_of(action.metavar)) is not None:
            setattr(action, "complete", words)  # noqa: B010  the attribute is shtab's, not argparse's
    script: str = shtab.complete(parser, shell, preamble=_PREAMBLE[shell])
    return script.rstrip("\n")


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of the parser and of all its subparsers."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for below in dict.fromkeys(action.choices.values()):
                yield from _actions(below)


def _describe_briefly(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Replace each command's description by its one line of help.

    shtab would otherwise put the whole description into the list of commands.
    """
    for command in commands._choices_actions:
        commands.choices[command.dest].description = command.help


def _completion_of(metavar: object) -> Mapping[str, str | dict[str, str]] | None:
    """Return the completion that shtab shall propose for an argument with this metavar; None for none."""
    if metavar in _FILES:
        return shtab.FILE
    if metavar in _FOLDERS:
        return shtab.DIRECTORY
    return _PORT_COMPLETION if metavar in _PORTS else None
