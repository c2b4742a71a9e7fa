"""What commands take: each kind of value, and usages, declared as their help shows it: a line for each argument.

    A drop is checked against a facility.        the command's description, then an empty line

    RUN                a recording               a positional; [RUN] may be left out, RUN... takes several: `runs`
    options of time:                             the title of a group; `options:` goes back to the command's own
    --until S          until this time           takes a value: its kind is by its name, `S` is a number
    --rate X Y Z       angular rate              takes three
    --order {4,6}      order                     takes one of these
    --force            overwrite files           takes none
    | --port PORT      at most one of such lines that follow each other
    ! --target z:DEG   likewise, and one of them is needed
    * --hex FILE       is needed

Two spaces or more separate an argument from its help, which goes on in lines that begin with a space.
"""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from textwrap import dedent
from typing import Any

from tfsat_host.devices.serial_ports import BoardName, port_variable
from tfsat_host.errors import UsageError
from tfsat_host.output_files import refuse_special
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.units import cdeg_from_deg
from tfsat_host.whole_file import is_special

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NEGATIVE = re.compile(r"-(\.?\d|inf|nan).*", re.ASCII | re.IGNORECASE)
_SEED_LIMIT = 2**63
_MAX_ANGLE_DEG = 180.0


def accept_negative_numbers(parser: argparse.ArgumentParser) -> None:
    """Takes every word that begins like a negative number for a value: argparse knows -59, but not -1e3."""
    parser._negative_number_matcher = _NEGATIVE


def port_name(text: str) -> str:
    """Check the name of a serial port (argparse type).

    Raises ArgumentTypeError for an empty name, such as that of an unset variable.
    """
    if not text.strip():
        raise argparse.ArgumentTypeError(
            "the name of the port is empty (an unset variable?): leave --port out to search for the board"
        )
    return text


def file_name(text: str) -> Path:
    """Parse a file name (argparse type).

    Raises:
        argparse.ArgumentTypeError: it is empty, which would mean the current folder; or a device, pipe or
            socket, which could be waited for without end.
    """
    if not text.strip():
        raise argparse.ArgumentTypeError("the name of the file is empty (an unset variable?)")
    if is_special(Path(text)):
        raise argparse.ArgumentTypeError(f"{text!r} is a device, pipe or socket, not a file: save it to one")
    return Path(text)


def output_file_name(text: str) -> Path:
    """Parse the name of a file to be written (argparse type).

    Raises ArgumentTypeError as `file_name` does, and for a name that ends like a folder's.
    """
    if text.endswith(("/", "/.", os.sep)):
        raise argparse.ArgumentTypeError(
            f"{text!r} is a folder: name the file in it, such as {text.rstrip('.')}NAME"
        )
    return file_name(text)


def refuse_existing(path: Path, *, force: bool) -> None:
    """Raises UsageError for a file that is there already, without `--force`, and for what is no file."""
    refuse_special(path)
    if path.exists() and not force:
        raise UsageError(
            what=f"{path} exists already.",
            meaning="Nothing was overwritten and nothing was sent.",
            next_step="Give another name to --out, or add --force to overwrite it.",
        )


def number(text: str) -> float:
    """Parse a decimal number (argparse type); `nan` and `inf` pass, to be refused by name later.

    Raises:
        argparse.ArgumentTypeError: this is no number.
    """
    if _NUMBER.fullmatch(text):
        return float(text)
    if text.lower().lstrip("+-") in ("nan", "inf", "infinity"):
        return math.nan if "nan" in text.lower() else float(text)
    hint = " (write the decimals after a point)" if "," in text else ""
    raise argparse.ArgumentTypeError(f"{text!r} is not a number{hint}")


def joint_angle_cdeg(text: str) -> int:
    """Parse a joint angle in degrees, to 0.01, into cdeg (argparse type).

    Raises ArgumentTypeError if no joint can have it.
    """
    angle_deg = number(text)
    if not abs(angle_deg) <= _MAX_ANGLE_DEG:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no angle of a joint: write degrees, at most {_MAX_ANGLE_DEG:g}"
        )
    return cdeg_from_deg(angle_deg)


def duration_s(text: str) -> float:
    """Parse a duration in seconds (argparse type).

    Raises ArgumentTypeError unless it is greater than zero and finite.
    """
    seconds = number(text)
    if not 0 < seconds < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no duration: write seconds, more than zero")
    return seconds


def seed(text: str) -> int:
    """Parse the seed of an emulated robot (argparse type).

    Raises ArgumentTypeError unless it is a whole number from 0.
    """
    if not (text.isascii() and text.isdigit() and len(text) < 20 and int(text) < _SEED_LIMIT):
        raise argparse.ArgumentTypeError(f"{text!r} is no seed: write a whole number from 0")
    return int(text)


def whole_number(what: str, low: int, high: int) -> Callable[[str], int]:
    """Build an argparse type that parses a whole number within limits.

    The type raises ArgumentTypeError otherwise; `what` names the things counted.
    """

    def count(text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) < 20 and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(
                f"{text!r} is no number of {what}: write a whole number from {low} to {high}"
            )
        return int(text)

    return count


def session_id(text: str) -> int:
    """Parse a recording's id (argparse type).

    Raises ArgumentTypeError unless it has up to 8 hexadecimal digits.
    """
    try:
        number = int(text, 16)
    except ValueError:
        number = -1
    if not 0 <= number <= 0xFFFFFFFF:
        raise argparse.ArgumentTypeError(f"{text!r} is no recording's id (8 hexadecimal digits)")
    return number


def drop_number(text: str) -> int:
    """Parse the number of a campaign's drop, or the name of its folder (argparse type).

    Raises ArgumentTypeError if it is no number.
    """
    digits = text.removeprefix("drop-")
    if not (digits.isascii() and digits.isdigit() and 0 < int(digits[:9]) < 10**6):
        raise argparse.ArgumentTypeError(f"{text!r} is no drop's number: write a whole number from 1")
    return int(digits[:9])


OUTPUT = """\
output:
--json  print one JSON object to stdout instead of text
--yes   answer every question with yes; needs no terminal"""
FORCE = "--force  overwrite a file that this command did not make"
FULL = "--full  every number and table, not one screen"
ROBOT = "--robot FILE  a robot file, or the name of a robot that tfsat brings along (default: drop_tower)"
INITIAL_RATE = (
    "--initial-rate X Y Z  angular rate of the base body at the release, in its own axes, deg/s "
    "(default: no angular momentum)"
)
JOINT = {"type": int, "choices": range(1, JOINT_COUNT + 1)}
_KINDS = {
    **dict.fromkeys(("FILE", "DIR", "D", "PATH", "RUN", "BUNDLE", "HEX"), file_name),
    **dict.fromkeys(("A", "B", "X", "K", "P", "S", "DEG", "DEG_S"), number),
    "SECONDS": duration_s,
    "ID": session_id,
    "PORT": port_name,
}
"""What a value is, by its name in the help; text where no kind is given."""
_ROW = re.compile(r"(?P<mark>[|!*] )?(?P<name>\S+)(?P<values>(?: \S+)*)(?P<text>  .*)")


def device(board: BoardName) -> str:
    """`--port` or `--emulated`, and the output options, of a command that talks to one board."""
    return f"""\
device:
| --port PORT  serial port of the {board}, such as /dev/ttyACM0 or COM3; without it the environment's
               {port_variable(board)}, else the one port that looks like this board
| --emulated   use the emulated robot in this process: no cable needed
{OUTPUT}"""


def add_options(parser: argparse.ArgumentParser, usage: str, **kinds: Any) -> None:
    """Adds all that a usage declares.

    `kinds`: by an argument's name what its value is, where the usage does not say it: a function that reads
    the text, or keywords of `add_argument`.
    """
    about, described, rows = usage.strip("\n").partition("\n\n")
    if described:
        parser.description = " ".join(about.split())
    place: argparse._ActionsContainer = parser
    either: argparse._MutuallyExclusiveGroup | None = None
    for lines in filter(None, re.split(r"\n(?! )", (rows if described else about).strip("\n"))):
        row = re.sub(r"\n +", " ", lines)
        match = _ROW.fullmatch(row)
        if match is None:
            place = parser if row == "options:" else parser.add_argument_group(row.removesuffix(":"))
            either = None
            continue
        if match["mark"] not in ("| ", "! "):
            either = None
        elif either is None:
            either = place.add_mutually_exclusive_group(required=match["mark"] == "! ")
        name, keywords = _argument(match["name"], match["values"].split(), kinds)
        if match["mark"] == "* ":
            keywords["required"] = True
        (either or place).add_argument(name, help=match["text"].strip(), **keywords)


def _argument(name: str, values: list[str], kinds: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Build the name and keywords of an argument for argparse."""
    is_option = name.startswith("-")
    stem = re.sub(r"\.\.\.$", "s", name.strip("-[]")).replace("-", "_").lower()
    kind = kinds.get(stem, {})
    overrides = dict(kind) if isinstance(kind, Mapping) else {"type": kind}
    words = values if is_option or values else [name]
    keywords: dict[str, Any] = {}
    if not words:
        keywords = {} if "choices" in overrides else {"action": "store_true"}
    elif words[0].startswith("{"):
        read = overrides.get("type", str)
        keywords["choices"] = tuple(read(choice) for choice in words[0][1:-1].split(","))
    else:
        metavars = [word[1:-1] if word.startswith("[") else word.removesuffix("...") for word in words]
        keywords = {
            "metavar": metavars[0] if len(metavars) == 1 else tuple(metavars),
            "type": _KINDS.get(metavars[0]),
        }
        if len(metavars) > 1 or metavars != words:
            keywords["nargs"] = (
                len(metavars) if len(metavars) > 1 else "?" if words[0].startswith("[") else "+"
            )
    return name if is_option else overrides.pop("dest", stem), {**keywords, **overrides}


def add_actions(
    parser: argparse.ArgumentParser,
    usages: str,
    before: str = "",
    after: str = "",
    *,
    title: str = "actions",
    dest: str = "action",
    required: bool = True,
    **kinds: Any,
) -> dict[str, argparse.ArgumentParser]:
    """Adds words that follow a command, such as `log fetch`: each one a parser of its own, in the command's style.

    Args:
        parser: The command's.
        usages: A line for each word with what it does, without a full stop; indented below, what it takes.
        before, after: What each of them takes before that, and after.
        title: Of all words in the command's help.
        dest: What one of them is called, and where the arguments hold it.
        required: Whether the command does nothing without one.
        kinds: See `add_options`.
    """
    subparsers = parser.add_subparsers(title=title, metavar=dest.upper(), dest=dest, required=required)
    added = {}
    for action in re.split(r"\n(?=\S)", usages.strip("\n")):
        head, _, own = action.partition("\n")
        name, text = head.split(maxsplit=1)
        added[name] = subparsers.add_parser(
            name,
            help=text,
            description=f"{text[:1].upper()}{text[1:]}.",
            formatter_class=type(parser._get_formatter()),
            allow_abbrev=False,
        )
        accept_negative_numbers(added[name])
        add_options(added[name], "\n".join(filter(None, (before, dedent(own), after))), **kinds)
    return added
