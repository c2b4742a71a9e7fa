"""Options that mean the same in every command."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Callable
from pathlib import Path

from tfsat_host.devices.ports import BoardName, port_variable
from tfsat_host.errors import UsageError
from tfsat_host.units import cdeg_from_deg

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NEGATIVE = re.compile(r"-(\.?\d|inf|nan).*", re.ASCII | re.IGNORECASE)
_SEED_LIMIT = 2**63
_LARGEST_DEG = 180.0


def add_output_options(parser: argparse.ArgumentParser) -> None:
    """`--json` and `--yes`."""
    group = parser.add_argument_group("output")
    group.add_argument("--json", action="store_true", help="print one JSON object to stdout instead of text")
    group.add_argument("--yes", action="store_true", help="answer every question with yes; needs no terminal")


def add_device_options(parser: argparse.ArgumentParser, board: BoardName) -> None:
    """`--port` or `--emulated`, and the output options, for a command that talks to one board."""
    group = parser.add_argument_group("device").add_mutually_exclusive_group()
    group.add_argument(
        "--port",
        metavar="PORT",
        type=port_name,
        help=f"serial port of the {board}, such as /dev/ttyACM0 or COM3; without it the environment's "
        f"{port_variable(board)}, else the one port that looks like this board",
    )
    group.add_argument(
        "--emulated", action="store_true", help="use the emulated robot in this process: no cable needed"
    )
    add_output_options(parser)


def accept_negative_numbers(parser: argparse.ArgumentParser) -> None:
    """Takes every word that begins like a negative number for a value: argparse knows -59, but not -1e3."""
    parser._negative_number_matcher = _NEGATIVE


def port_name(text: str) -> str:
    """An argparse type: a serial port. Raises ArgumentTypeError for nothing, such as an unset variable."""
    if not text.strip():
        raise argparse.ArgumentTypeError(
            "the name of the port is empty (an unset variable?): leave --port out to search for the board"
        )
    return text


def file_name(text: str) -> Path:
    """An argparse type: a file. Raises ArgumentTypeError for nothing, which would mean the current folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError("the name of the file is empty (an unset variable?)")
    return Path(text)


def output_file_name(text: str) -> Path:
    """An argparse type: a file to be written. Raises ArgumentTypeError also for what ends like a folder's name."""
    if text.endswith(("/", "/.", os.sep)):
        raise argparse.ArgumentTypeError(
            f"{text!r} is a folder: name the file in it, such as {text.rstrip('.')}NAME"
        )
    return file_name(text)


def refuse_existing(path: Path, *, force: bool) -> None:
    """Raises UsageError for a file that is there already, without `--force`."""
    if path.exists() and not force:
        raise UsageError(
            what=f"{path} exists already.",
            meaning="Nothing was overwritten and nothing was sent.",
            next_step="Give another name to --out, or add --force to overwrite it.",
        )


def number(text: str) -> float:
    """An argparse type: a decimal number as people write it (`nan` and `inf` pass, to be refused by name).

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
    """An argparse type: a joint's angle in degrees, to 0.01. Raises ArgumentTypeError: it is none of a joint."""
    angle_deg = number(text)
    if not abs(angle_deg) <= _LARGEST_DEG:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no angle of a joint: write degrees, at most {_LARGEST_DEG:g}"
        )
    return cdeg_from_deg(angle_deg)


def duration_s(text: str) -> float:
    """An argparse type: how long something takes. Raises ArgumentTypeError unless more than zero and finite."""
    seconds = number(text)
    if not 0 < seconds < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no duration: write seconds, more than zero")
    return seconds


def seed(text: str) -> int:
    """An argparse type: the seed of an emulated robot. Raises ArgumentTypeError unless a whole number from 0."""
    if not (text.isascii() and text.isdigit() and len(text) < 20 and int(text) < _SEED_LIMIT):
        raise argparse.ArgumentTypeError(f"{text!r} is no seed: write a whole number from 0")
    return int(text)


def whole_number(what: str, low: int, high: int) -> Callable[[str], int]:
    """An argparse type: how many of something, within limits; ArgumentTypeError otherwise."""

    def count(text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) < 20 and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(
                f"{text!r} is no number of {what}: write a whole number from {low} to {high}"
            )
        return int(text)

    return count


def session_id(text: str) -> int:
    """An argparse type: a recording's id. Raises ArgumentTypeError unless up to 8 hexadecimal digits."""
    try:
        number = int(text, 16)
    except ValueError:
        number = -1
    if not 0 <= number <= 0xFFFFFFFF:
        raise argparse.ArgumentTypeError(f"{text!r} is no recording's id (8 hexadecimal digits)")
    return number


def drop_number(text: str) -> int:
    """An argparse type: a drop of a campaign, also by its folder. Raises ArgumentTypeError: it is no number."""
    digits = text.removeprefix("drop-")
    if not (digits.isascii() and digits.isdigit() and 0 < int(digits[:9]) < 10**6):
        raise argparse.ArgumentTypeError(f"{text!r} is no drop's number: write a whole number from 1")
    return int(digits[:9])
