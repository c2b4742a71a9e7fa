"""What a person can do to the emulated robot, as lines of text. docs/emulator.md is the reference."""

from __future__ import annotations

import re
import shlex
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from tfsat_host.calibration.steps.step import AXES, TURN_ROUNDS, Axis
from tfsat_host.emulated.faults import CardDefect, Faults
from tfsat_host.emulated.hands import Hands, sweep_motion, turn_axis, turn_motion
from tfsat_host.emulated.robot import FALL_S, US_PER_S, BoardIndex, EmulatedRobot, Reset
from tfsat_host.errors import TfsatError

LONGEST_WAIT_S = 3600.0
LONGEST_FALL_S = 60.0
LONGEST_KNOCK_S = 10.0
LONGEST_BOUNCE_S = 1.0
LONGEST_STALL_S = 100.0
STALL_EVERY_S = 2.0
WIDEST_TURN_DEG = 720.0
LONGEST_LINE = 4096
"""Bytes of one line; more is no line of this protocol."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)", re.ASCII)
_DURATION = re.compile(r"(\d+\.?\d*|\.\d+)(us|ms|s)?", re.ASCII)
_UNITS_S = {"us": 1e-6, "ms": 1e-3, "s": 1.0, None: 1.0}

Words = list[str]
Acted = TypeVar("Acted")


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


class ControlError(TfsatError):
    """A line that is not understood or cannot be done; nothing was changed."""

    def __init__(self, what: str) -> None:
        super().__init__(what=what, meaning="Nothing was changed.", next_step="help")


@dataclass(frozen=True)
class Reply:
    """One line of answer; `due` tells whether it may be given (None: now)."""

    text: str
    due: Callable[[], bool] | None = None


@dataclass(frozen=True)
class _Verb(Generic[Acted]):
    """How it is written, how many words follow it, and what it does: its values for the reply, or the reply."""

    usage: str
    least: int
    most: int
    do: Callable[[Acted, Words], str | Reply | None]

    def done(self, on: Acted, words: Words) -> str | Reply | None:
        """Raises ControlError: it is not understood."""
        if not self.least <= len(words) <= self.most:
            raise ControlError(f"Write: {self.usage}.")
        return self.do(on, words)


def execute(line: str, bench: Bench) -> Reply | None:
    """Does what one line asks; an empty line or a comment (#) gets no reply.

    The reply is `ok`, perhaps with values after it, or `error` and a reason. Never raises for what stands in the line.
    """
    try:
        words = shlex.split(line, comments=True)
        if not words:
            return None
        verb = _VERBS.get(words[0].lower())
        if verb is None:
            raise ControlError(f"There is no command {words[0]!r}.")
        done = verb.done(bench, words[1:])
        return done if isinstance(done, Reply) else Reply(f"ok {done or ''}".rstrip())
    except ValueError as error:
        return _refusal(ControlError(f"{line.strip()}: {str(error).lower()}."))
    except TfsatError as error:
        return _refusal(error)
    except OSError as error:
        return _refusal(ControlError(f"{error.filename}: {error.strerror}."))


def _refusal(error: TfsatError) -> Reply:
    parts = [error.what] if isinstance(error, ControlError) else [error.what, error.meaning, error.next_step]
    return Reply("error " + " ".join(" ".join(parts).split()))


def _whole(word: str, what: str) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 6):
        raise ControlError(f"{word!r} is no {what}: write a whole number.")
    return int(word)


def _decimal(word: str, what: str) -> float:
    if not _NUMBER.fullmatch(word):
        raise ControlError(f"{word!r} is no {what}: write a number.")
    return float(word)


def _duration_s(word: str, longest_s: float) -> float:
    """Seconds, or with a unit; more than zero."""
    match = _DURATION.fullmatch(word.lower())
    if not match:
        raise ControlError(f"{word!r} is no duration: write seconds, or such as 20ms.")
    seconds = float(match[1]) * _UNITS_S[match[2]]
    if not 1e-6 <= seconds <= longest_s:
        raise ControlError(f"{word} is out of range: more than zero, at most {longest_s:g} s.")
    return seconds


def _us(word: str, longest_s: float) -> int:
    return round(_duration_s(word, longest_s) * US_PER_S)


def _one_of(word: str, choices: dict[str, Acted], unknown: str) -> Acted:
    if word.lower() not in choices:
        raise ControlError(f"There is no {unknown} {word!r}: {', '.join(choices)}.")
    return choices[word.lower()]


_BOARDS = {board.name.lower(): board for board in BoardIndex}
_RESETS = {cause.name.lower().replace("_", "-"): cause for cause in Reset}
_AXES: dict[str, Axis] = {axis: axis for axis in AXES}


def _choice(word: str, yes: str, no: str) -> bool:
    if word.lower() not in (yes, no):
        raise ControlError(f"{word!r} is not understood: {yes} or {no}.")
    return word.lower() == yes


def _held(bench: Bench) -> EmulatedRobot:
    """The robot while hands can reach it."""
    if bench.robot.falling:
        raise ControlError("The robot is falling; nobody can touch it. Wait for the landing: wait still")
    return bench.robot


def _swing(bench: Bench, words: Words) -> str:
    robot = _held(bench)
    joint, cycles = _whole(words[0], "joint"), _whole(words[3], "number of cycles")
    angle_deg, period_s = _decimal(words[1], "angle"), _duration_s(words[2], LONGEST_WAIT_S)
    if not 1 <= cycles <= 1000:
        raise ControlError("Swing 1 to 1000 cycles.")
    robot.swing(joint, angle_deg, period_s, cycles)
    return f"for {cycles * period_s:g} s"


def _sweep(bench: Bench, words: Words) -> str:
    robot = _held(bench)
    joint, ranges = _whole(words[0], "joint"), robot.model.joint_limits_rad
    if not 1 <= joint <= len(ranges):
        raise ControlError(f"There is no joint {joint}.")
    motion = sweep_motion(ranges[joint - 1], Hands.steady(), np.random.default_rng(0))
    robot.hands.move_joint(joint, motion)
    return f"for {motion.duration_s:g} s"


def _turn(bench: Bench, words: Words) -> str:
    robot = _held(bench)
    axis, angle_deg = _one_of(words[0], _AXES, "axis"), _decimal(words[1], "angle")
    rounds = _whole(words[2], "number of rounds") if len(words) == 3 else TURN_ROUNDS
    if not 0 < abs(angle_deg) <= WIDEST_TURN_DEG:
        raise ControlError(f"Turn by at most {WIDEST_TURN_DEG:g} deg, either way.")
    if not 1 <= rounds <= 100:
        raise ControlError("Turn 1 to 100 rounds.")
    random = np.random.default_rng(0)
    motion = turn_motion(angle_deg, rounds, Hands.steady(), random)
    robot.hold(range(1, robot.model.n_bodies + 1))
    robot.hands.turn(turn_axis(axis, Hands.steady(), random), motion)
    return f"for {motion.duration_s:g} s"


def _drop(bench: Bench, words: Words) -> str:
    fall_s = _duration_s(words[0], LONGEST_FALL_S) if words else FALL_S
    _held(bench).drop(fall_s=fall_s)
    return f"falls for {fall_s:g} s"


def _card(bench: Bench, words: Words) -> str:
    slot = bench.robot.card_slot
    acts: dict[str, Callable[[], None]] = {
        "remove": slot.remove,
        "insert": slot.insert,
        "fill": lambda: slot.fill(0),
        "write-protect": lambda: slot.spoil(CardDefect.WRITE_PROTECTED),
        "unformat": lambda: slot.spoil(CardDefect.UNREADABLE),
        "fail": lambda: slot.spoil(CardDefect.FAILING),
    }
    if words and words[0] in acts:
        acts[words[0]]()
        return ""
    path, n_bytes = bench.save_card(Path(words[0]) if words else None)
    return f"{n_bytes} bytes in {path}"


def _time(bench: Bench, _words: Words) -> str:
    robot = bench.robot
    motion = "falling" if robot.falling else "swinging" if robot.swinging else "still"
    return f"{robot.now_us / US_PER_S:.6f} {motion}"


def _wait(bench: Bench, words: Words) -> Reply:
    robot = bench.robot
    if words[0] == "still":
        return Reply("ok", lambda: not robot.falling and not robot.swinging)
    end_us = robot.now_us + _us(words[0], LONGEST_WAIT_S)
    return Reply("ok", lambda: robot.now_us >= end_us)


def _kind(word: str) -> Any:
    """`Faults` refuses what it does not know."""
    return None if word.lower() == "none" else word.lower()


def _fault(bench: Bench, words: Words) -> None:
    """Raises ControlError, or EmulationError: there is no such part, or no such fault of it."""
    part, arguments = words[0].lower(), words[1:]
    if part not in _FAULTS:
        raise ControlError(f"There is no fault of {words[0]!r}: {', '.join(list(_FAULTS)[1:])}.")
    _FAULTS[part].done(bench.robot.faults, arguments)


def _imu_fault(faults: Faults, words: Words) -> None:
    body = _whole(words[0], "body")
    if len(words) == 2 and words[1].lower() == "glitch":
        faults.glitch(body)
    else:
        faults.imu(body, _kind(words[1]), _whole(words[2], "body") if len(words) == 3 else None)


def _angle_fault(faults: Faults, words: Words) -> None:
    turned_deg = _decimal(words[2], "angle") if len(words) == 3 else None
    faults.angle_sensor(_whole(words[0], "sensor"), _kind(words[1]), turned_deg)


def _card_fault(faults: Faults, words: Words) -> None:
    if _kind(words[0]) is None:
        faults.card_stalls(None)
        return
    every_us = round(STALL_EVERY_S * US_PER_S) if len(words) == 1 else _us(words[1], 10 * LONGEST_STALL_S)
    faults.card_stalls(_us(words[0], LONGEST_STALL_S), every_us)


def _clock_fault(faults: Faults, words: Words) -> None:
    board: Any = _one_of(words[0], _BOARDS, "board").name.lower()
    faults.clock(board, _decimal(words[1], "number of ppm"))


_FAULTS: dict[str, _Verb[Faults]] = {
    "none": _Verb("fault none", 0, 0, lambda faults, _: faults.heal()),
    "imu": _Verb(
        "fault imu BODY dead|frozen|saturated|glitch|none, or imu BODY swapped BODY", 2, 3, _imu_fault
    ),
    "bus": _Verb(
        "fault bus 1|2 stuck|none",
        2,
        2,
        lambda faults, words: faults.bus(_whole(words[0], "bus"), _choice(words[1], "stuck", "none")),
    ),
    "angle": _Verb("fault angle SENSOR dead|frozen|none, or angle SENSOR turned DEGREES", 2, 3, _angle_fault),
    "servo": _Verb(
        "fault servo JOINT dead|slow|reversed|none",
        2,
        2,
        lambda faults, words: faults.servo(_whole(words[0], "joint"), _kind(words[1])),
    ),
    "switch": _Verb(
        "fault switch 1|2 stuck-closed|stuck-open|none",
        2,
        2,
        lambda faults, words: faults.switch(_whole(words[0], "switch"), _kind(words[1])),
    ),
    "bounce": _Verb(
        "fault bounce DURATION|none",
        1,
        1,
        lambda faults, words: faults.bounce(_kind(words[0]) and _us(words[0], LONGEST_BOUNCE_S)),
    ),
    "card": _Verb("fault card STALL|none [EVERY]", 1, 2, _card_fault),
    "clock": _Verb("fault clock sequencer|logger PPM", 2, 2, _clock_fault),
}
_VERBS: dict[str, _Verb[Bench]] = {
    "hold": _Verb(
        "hold BODY...", 1, 4, lambda bench, words: _held(bench).hold([_whole(one, "body") for one in words])
    ),
    "swing": _Verb("swing JOINT DEGREES PERIOD CYCLES", 4, 4, _swing),
    "sweep": _Verb("sweep JOINT", 1, 1, _sweep),
    "turn": _Verb("turn x|y|z DEGREES [ROUNDS]", 2, 3, _turn),
    "seat": _Verb("seat", 0, 0, lambda bench, _: _held(bench).seat()),
    "press": _Verb(
        "press 1|2", 1, 1, lambda bench, words: bench.robot.set_switch(_whole(words[0], "switch"), True)
    ),
    "release": _Verb(
        "release 1|2", 1, 1, lambda bench, words: bench.robot.set_switch(_whole(words[0], "switch"), False)
    ),
    "knock": _Verb(
        "knock 1|2 DURATION",
        2,
        2,
        lambda bench, words: bench.robot.knock(_whole(words[0], "switch"), _us(words[1], LONGEST_KNOCK_S)),
    ),
    "power": _Verb(
        "power sequencer|logger on|off",
        2,
        2,
        lambda bench, words: bench.set_power(
            _one_of(words[0], _BOARDS, "board"), _choice(words[1], "on", "off")
        ),
    ),
    "cable": _Verb(
        "cable sequencer|logger plug|pull",
        2,
        2,
        lambda bench, words: bench.set_cable(
            _one_of(words[0], _BOARDS, "board"), _choice(words[1], "plug", "pull")
        ),
    ),
    "reset": _Verb(
        "reset watchdog|brown-out|button",
        1,
        1,
        lambda bench, words: bench.reset(_one_of(words[0], _RESETS, "reset")),
    ),
    "fault": _Verb(f"fault {'|'.join(_FAULTS)} ...", 1, 4, _fault),
    "drop": _Verb("drop [DURATION]", 0, 1, _drop),
    "angles": _Verb(
        "angles", 0, 0, lambda bench, _: " ".join(f"{one:.2f}" for one in bench.robot.joint_angles_deg())
    ),
    "card": _Verb("card [remove|insert|fill|write-protect|unformat|fail|FILE]", 0, 1, _card),
    "time": _Verb("time", 0, 0, _time),
    "wait": _Verb("wait DURATION|still", 1, 1, _wait),
    "help": _Verb("help", 0, 0, lambda _bench, _words: " | ".join(verb.usage for verb in _VERBS.values())),
    "quit": _Verb("quit", 0, 0, lambda bench, _: bench.stop()),
}


class LineTooLong(ValueError):
    """The sender does not speak this protocol."""


class ControlLines:
    """One sender's lines, in order: a `wait` holds back those after it, and no one else's."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._partial = b""
        self._lines: deque[str] = deque()
        self._pending: Reply | None = None

    def feed(self, data: bytes) -> None:
        """Takes what has arrived, in pieces of any size. Raises LineTooLong."""
        *lines, self._partial = (self._partial + data).split(b"\n")
        if len(self._partial) > LONGEST_LINE:
            raise LineTooLong
        self._lines.extend(line.decode(errors="replace") for line in lines)

    def end(self) -> None:
        """No more will come: a last line without its end counts."""
        if self._partial:
            self._lines.append(self._partial.decode(errors="replace"))
            self._partial = b""

    @property
    def done(self) -> bool:
        """Every line has its reply."""
        return self._pending is None and not self._lines

    def replies(self) -> list[str]:
        """Does what can be done now; the replies that are due."""
        due: list[str] = []
        while True:
            if self._pending is not None:
                if self._pending.due is not None and not self._pending.due():
                    return due
                due.append(self._pending.text)
                self._pending = None
            if not self._lines:
                return due
            self._pending = execute(self._lines.popleft(), self._bench)
