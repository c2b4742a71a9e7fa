"""What a person can do to the emulated robot, as lines of text. docs/emulator.md is the reference."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from tfsat_host.emulated.card import CardDefect
from tfsat_host.emulated.robot import FALL_S, US_PER_S, BoardIndex, EmulatedRobot, Reset
from tfsat_host.errors import TfsatError

LONGEST_WAIT_S = 3600.0
LONGEST_FALL_S = 60.0
LONGEST_KNOCK_S = 10.0
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)", re.ASCII)
_DURATION = re.compile(r"(\d+\.?\d*|\.\d+)(us|ms|s)?", re.ASCII)
_UNITS_S = {"us": 1e-6, "ms": 1e-3, "s": 1.0, None: 1.0}

Due = Callable[[], bool]
"""Whether a reply may be given: a wait is over."""


class ControlError(TfsatError):
    """A line that is not understood or cannot be done; nothing was changed."""

    def __init__(self, what: str) -> None:
        super().__init__(what=what, meaning="Nothing was changed.", next_step="help")


class Bench(Protocol):
    """What the lines act on: the robot and what is around it."""

    @property
    def robot(self) -> EmulatedRobot:
        """The robot itself."""

    def set_power(self, board: BoardIndex, on: bool) -> None:
        """Switches a board's supply; without it its port goes."""

    def set_cable(self, board: BoardIndex, plugged: bool) -> None:
        """Plugs or pulls a board's USB cable; without it its port goes."""

    def reset(self, cause: Reset) -> None:
        """Restarts the sequencer; its port goes and comes. Raises TfsatError without power."""

    def save_card(self, path: Path | None) -> tuple[Path, int]:
        """Copies the card's recording; where to, and its bytes. Raises TfsatError."""

    def stop(self) -> None:
        """Ends the server after this line's reply."""


@dataclass(frozen=True)
class Reply:
    """One line of answer; `due` says when it may be given (None: now)."""

    text: str
    due: Due | None = None


@dataclass(frozen=True)
class _Verb:
    usage: str
    n_words: tuple[int, int]
    do: Callable[[Bench, list[str]], str | Reply]


def execute(line: str, bench: Bench) -> Reply | None:
    """Does what one line says; an empty line or a comment (#) gets no reply.

    The reply is `ok`, perhaps with values after it, or `error` and a reason. Never raises for what the
    line says.
    """
    try:
        words = shlex.split(line, comments=True)
        return _do(words, bench) if words else None
    except ValueError as error:
        return _refusal(ControlError(f"{line.strip()}: {str(error).lower()}."))
    except TfsatError as error:
        return _refusal(error)
    except OSError as error:
        return _refusal(ControlError(f"{error.filename}: {error.strerror}."))


def _do(words: list[str], bench: Bench) -> Reply:
    name, arguments = words[0].lower(), words[1:]
    verb = _VERBS.get(name)
    if verb is None:
        raise ControlError(f"There is no command {words[0]!r}.")
    least, most = verb.n_words
    if not least <= len(arguments) <= most:
        raise ControlError(f"Write: {verb.usage}.")
    done = verb.do(bench, arguments)
    return done if isinstance(done, Reply) else Reply(f"ok {done}".rstrip())


def _refusal(error: TfsatError) -> Reply:
    parts = [error.what] if isinstance(error, ControlError) else [error.what, error.meaning, error.next_step]
    return Reply("error " + " ".join(" ".join(parts).split()))


def _hold(bench: Bench, words: list[str]) -> str:
    _not_falling(bench)
    bench.robot.hold([_whole(word, "body") for word in words])
    return ""


def _swing(bench: Bench, words: list[str]) -> str:
    _not_falling(bench)
    joint, cycles = _whole(words[0], "joint"), _whole(words[3], "number of cycles")
    angle_deg, period_s = _decimal(words[1], "angle"), _duration_s(words[2], LONGEST_WAIT_S)
    if not 1 <= cycles <= 1000:
        raise ControlError("Swing 1 to 1000 cycles.")
    bench.robot.swing(joint, angle_deg, period_s, cycles)
    return f"for {cycles * period_s:g} s"


def _seat(bench: Bench, words: list[str]) -> str:  # noqa: ARG001
    _not_falling(bench)
    bench.robot.seat()
    return ""


def _press(bench: Bench, words: list[str]) -> str:
    bench.robot.set_switch(_whole(words[0], "switch"), True)
    return ""


def _let_go(bench: Bench, words: list[str]) -> str:
    bench.robot.set_switch(_whole(words[0], "switch"), False)
    return ""


def _knock(bench: Bench, words: list[str]) -> str:
    bench.robot.knock(_whole(words[0], "switch"), round(_duration_s(words[1], LONGEST_KNOCK_S) * US_PER_S))
    return ""


def _power(bench: Bench, words: list[str]) -> str:
    bench.set_power(_board(words[0]), _choice(words[1], "on", "off"))
    return ""


def _cable(bench: Bench, words: list[str]) -> str:
    bench.set_cable(_board(words[0]), _choice(words[1], "plug", "pull"))
    return ""


def _reset(bench: Bench, words: list[str]) -> str:
    causes = {cause.name.lower().replace("_", "-"): cause for cause in Reset}
    if words[0].lower() not in causes:
        raise ControlError(f"There is no reset {words[0]!r}: {', '.join(causes)}.")
    bench.reset(causes[words[0].lower()])
    return ""


def _drop(bench: Bench, words: list[str]) -> str:
    _not_falling(bench)
    fall_s = _duration_s(words[0], LONGEST_FALL_S) if words else FALL_S
    bench.robot.drop(fall_s=fall_s)
    return f"falls for {fall_s:g} s"


def _angles(bench: Bench, words: list[str]) -> str:  # noqa: ARG001
    return " ".join(f"{angle_deg:.2f}" for angle_deg in bench.robot.joint_angles_deg())


def _card(bench: Bench, words: list[str]) -> str:
    slot = bench.robot.card_slot
    hands: dict[str, Callable[[], None]] = {
        "remove": slot.remove,
        "insert": slot.insert,
        "fill": lambda: slot.fill(0),
        "write-protect": lambda: slot.spoil(CardDefect.WRITE_PROTECTED),
        "unformat": lambda: slot.spoil(CardDefect.UNREADABLE),
        "fail": lambda: slot.spoil(CardDefect.FAILING),
    }
    if words and words[0] in hands:
        hands[words[0]]()
        return ""
    path, n_bytes = bench.save_card(Path(words[0]) if words else None)
    return f"{n_bytes} bytes in {path}"


def _time(bench: Bench, words: list[str]) -> str:  # noqa: ARG001
    robot = bench.robot
    motion = "falling" if robot.falling else "swinging" if robot.swinging else "still"
    return f"{robot.now_us / US_PER_S:.6f} {motion}"


def _wait(bench: Bench, words: list[str]) -> Reply:
    robot = bench.robot
    if words[0] == "still":
        return Reply("ok", lambda: not robot.falling and not robot.swinging)
    end_us = robot.now_us + round(_duration_s(words[0], LONGEST_WAIT_S) * US_PER_S)
    return Reply("ok", lambda: robot.now_us >= end_us)


def _quit(bench: Bench, words: list[str]) -> str:  # noqa: ARG001
    bench.stop()
    return ""


def _help(bench: Bench, words: list[str]) -> str:  # noqa: ARG001
    return " | ".join(verb.usage for verb in _VERBS.values())


def _not_falling(bench: Bench) -> None:
    if bench.robot.falling:
        raise ControlError("The robot is falling; nobody can touch it. Wait for the landing: wait still")


def _whole(word: str, what: str) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 6):
        raise ControlError(f"{word!r} is no {what}: write a whole number.")
    return int(word)


def _decimal(word: str, what: str) -> float:
    if not _NUMBER.fullmatch(word):
        raise ControlError(f"{word!r} is no {what}: write a number.")
    return float(word)


def _duration_s(word: str, longest_s: float) -> float:
    match = _DURATION.fullmatch(word.lower())
    if not match:
        raise ControlError(f"{word!r} is no duration: write seconds, or such as 20ms.")
    seconds = float(match[1]) * _UNITS_S[match[2]]
    if not 1e-6 <= seconds <= longest_s:
        raise ControlError(f"{word} is out of range: more than zero, at most {longest_s:g} s.")
    return seconds


def _board(word: str) -> BoardIndex:
    boards = {board.name.lower(): board for board in BoardIndex}
    if word.lower() not in boards:
        raise ControlError(f"There is no board {word!r}: {' or '.join(boards)}.")
    return boards[word.lower()]


def _choice(word: str, yes: str, no: str) -> bool:
    if word.lower() not in (yes, no):
        raise ControlError(f"{word!r} is not understood: {yes} or {no}.")
    return word.lower() == yes


_VERBS = {
    "hold": _Verb("hold BODY...", (1, 4), _hold),
    "swing": _Verb("swing JOINT DEGREES PERIOD CYCLES", (4, 4), _swing),
    "seat": _Verb("seat", (0, 0), _seat),
    "press": _Verb("press 1|2", (1, 1), _press),
    "release": _Verb("release 1|2", (1, 1), _let_go),
    "knock": _Verb("knock 1|2 DURATION", (2, 2), _knock),
    "power": _Verb("power sequencer|logger on|off", (2, 2), _power),
    "cable": _Verb("cable sequencer|logger plug|pull", (2, 2), _cable),
    "reset": _Verb("reset watchdog|brown-out|button", (1, 1), _reset),
    "drop": _Verb("drop [DURATION]", (0, 1), _drop),
    "angles": _Verb("angles", (0, 0), _angles),
    "card": _Verb("card [remove|insert|fill|write-protect|unformat|fail|FILE]", (0, 1), _card),
    "time": _Verb("time", (0, 0), _time),
    "wait": _Verb("wait DURATION|still", (1, 1), _wait),
    "help": _Verb("help", (0, 0), _help),
    "quit": _Verb("quit", (0, 0), _quit),
}
