"""The words of control lines: numbers, durations, boards. What is not understood is refused in one sentence."""

from __future__ import annotations

import re

from tfsat_host.calibration.steps.step import AXES, Axis
from tfsat_host.emulated.robot import BoardIndex
from tfsat_host.errors import TfsatError

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)", re.ASCII)
_DURATION = re.compile(r"(\d+\.?\d*|\.\d+)(us|ms|s)?", re.ASCII)
_UNITS_S = {"us": 1e-6, "ms": 1e-3, "s": 1.0, None: 1.0}


class ControlError(TfsatError):
    """A line that is not understood or cannot be done; nothing was changed."""

    def __init__(self, what: str) -> None:
        super().__init__(what=what, meaning="Nothing was changed.", next_step="help")


def whole(word: str, what: str) -> int:
    """A whole number without a sign. Raises ControlError."""
    if not (word.isascii() and word.isdigit() and len(word) < 6):
        raise ControlError(f"{word!r} is no {what}: write a whole number.")
    return int(word)


def decimal(word: str, what: str) -> float:
    """A number. Raises ControlError."""
    if not _NUMBER.fullmatch(word):
        raise ControlError(f"{word!r} is no {what}: write a number.")
    return float(word)


def duration_s(word: str, longest_s: float) -> float:
    """Seconds, or with a unit; more than zero. Raises ControlError."""
    match = _DURATION.fullmatch(word.lower())
    if not match:
        raise ControlError(f"{word!r} is no duration: write seconds, or such as 20ms.")
    seconds = float(match[1]) * _UNITS_S[match[2]]
    if not 1e-6 <= seconds <= longest_s:
        raise ControlError(f"{word} is out of range: more than zero, at most {longest_s:g} s.")
    return seconds


def board(word: str) -> BoardIndex:
    """By its name. Raises ControlError."""
    boards = {board.name.lower(): board for board in BoardIndex}
    if word.lower() not in boards:
        raise ControlError(f"There is no board {word!r}: {' or '.join(boards)}.")
    return boards[word.lower()]


def choice(word: str, yes: str, no: str) -> bool:
    """Whether it is the first of two words. Raises ControlError."""
    if word.lower() not in (yes, no):
        raise ControlError(f"{word!r} is not understood: {yes} or {no}.")
    return word.lower() == yes


def axis_of(word: str) -> Axis:
    """Of a body. Raises ControlError."""
    for axis in AXES:
        if word.lower() == axis:
            return axis
    raise ControlError(f"There is no axis {word!r}: {', '.join(AXES)}.")
