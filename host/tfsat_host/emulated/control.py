"""What a person can do to the emulated robot, as lines of text. docs/emulator.md is the reference."""

from __future__ import annotations

import math
import re
import shlex
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.calibration.steps.step import TURN_ROUNDS, Axis
from tfsat_host.emulated.emulated_operator import sweep_motion, turn_axis, turn_motion
from tfsat_host.emulated.emulated_robot import FALL_S, US_PER_S, BoardIndex, EmulatedRobot, Reset
from tfsat_host.emulated.fault_injection import CardDefect
from tfsat_host.emulated.manual_motion import Operator
from tfsat_host.emulated.server import RobotServer
from tfsat_host.errors import TfsatError

STALL_EVERY_S = 2.0
WIDEST_TURN_DEG = 720.0
MAX_LINE_BYTES = 4096
"""Bytes of one line; more is no line of this protocol."""
# ASCII digits only: float() and int() would also take those of other scripts.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)", re.ASCII)
_DURATION = re.compile(r"(\d+\.?\d*|\.\d+)(us|ms|s)?", re.ASCII)
_UNITS_S = {"us": 1e-6, "ms": 1e-3, "s": 1.0, None: 1.0}
_WHOLE = ("BODY", "JOINT", "SENSOR", "CYCLES", "ROUNDS", "PIN")
_DECIMAL = ("DEGREES", "PPM", "OHM")
_MAX_DURATION_S = {
    "DURATION": 3600.0,
    "PERIOD": 3600.0,
    "FALL": 60.0,
    "KNOCK": 10.0,
    "BOUNCE": 1.0,
    "STALL": 100.0,
    "EVERY": 1000.0,
}


class ControlError(TfsatError):
    """A line that is not understood or cannot be done; nothing was changed."""

    def __init__(self, what: str) -> None:
        super().__init__(what=what, meaning="Nothing was changed.", next_step="help")


@dataclass(frozen=True)
class Reply:
    """One line of answer; `due` is true as soon as it may be given (None: now)."""

    text: str
    due: Callable[[], bool] | None = None


@dataclass(frozen=True)
class _Verb:
    """A line.

    Attributes:
        words: That follow the verb: `a|b` is one of these, upper case a value, `[...]` may be left out, `...` repeats.
        do: What it does with the server and the values: gives values for the reply, or the reply.
    """

    words: str
    do: Callable[..., str | Reply | None]

    def execute(self, name: str, words: list[str], server: RobotServer) -> str | Reply | None:
        """Raises ControlError: it is not understood."""
        # The help text is the grammar: [X] may be left out, a last X... takes one word or more.
        parameters = self.words.split()
        needed = sum(not parameter.startswith("[") for parameter in parameters)
        if self.words.endswith("...") and len(words) > len(parameters):
            parameters += parameters[-1:] * (len(words) - len(parameters))
        # Count the words first, so that a method is never called with too few or too many values.
        if not needed <= len(words) <= len(parameters):
            raise ControlError(f"Write: {name} {self.words}".rstrip() + ".")
        return self.do(server, *map(_value, parameters, words))


def execute(line: str, server: RobotServer) -> Reply | None:
    """Does what one line asks; an empty line or a comment (#) gets no reply.

    The reply is `ok`, perhaps with values after it, or `error` and a reason. Never raises for what the line says.
    """
    try:
        # Split as a shell does: quotes allow spaces in a path, # begins a comment.
        words = shlex.split(line, comments=True)
        if not words:
            return None
        name = words[0].lower()
        # A fault's part belongs to the verb: `fault imu` and `fault card` take different values.
        if name == "fault" and len(words) > 1:
            name += f" {words[1].lower()}"
        if name == "fault":
            raise ControlError(f"Write: fault {'|'.join(_FAULTS)} ...")
        if name not in _VERBS:
            hint = f" {', '.join(_FAULTS)}." if name.startswith("fault ") else ""
            raise ControlError(f"There is no command {name!r}.{hint}")
        reply = _VERBS[name].execute(name, words[len(name.split()) :], server)
        return reply if isinstance(reply, Reply) else Reply(f"ok {reply or ''}".rstrip())
    except ValueError as error:
        # A quote that is not closed, or a value that the robot's method refuses.
        return _refusal(ControlError(f"{line.strip()}: {str(error).lower()}."))
    except TfsatError as error:
        return _refusal(error)
    except OSError as error:
        return _refusal(ControlError(f"{error.filename}: {error.strerror}."))


def _refusal(error: TfsatError) -> Reply:
    parts = [error.what] if isinstance(error, ControlError) else [error.what, error.meaning, error.next_step]
    return Reply("error " + " ".join(" ".join(parts).split()))


def _value(parameter: str, word: str) -> Any:
    """Parse one argument word as the type that `parameter` specifies.

    Returns:
        None for `none`, a number for a number, seconds for a duration, a path for a file, else the choice in
        lower case.

    Raises:
        ControlError: the word does not fit or is out of range.
    """
    parameter = parameter.strip("[].")
    # Alternatives in small letters are taken literally; one in capitals stands for a value.
    *choices, value = parameter.split("|")
    if not value.isupper():
        choices.append(value)
    # Words come before values: a file named like one of them is to be written with its folder (./fill).
    if word.lower() in choices:
        return {"none": None}.get(word.lower(), int(word) if word.isdigit() else word.lower())
    # Five digits hold every body, sensor and count, and overflow no int of the C interface.
    if value in _WHOLE and word.isascii() and word.isdigit() and len(word) < 6:
        return int(word)
    if value in _DECIMAL and _NUMBER.fullmatch(word):
        return float(word)
    if value in _MAX_DURATION_S and (match := _DURATION.fullmatch(word.lower())):
        # Virtual time has whole microseconds: anything shorter would be rounded to none.
        seconds = float(match[1]) * _UNITS_S[match[2]]
        if not 1e-6 <= seconds <= _MAX_DURATION_S[value]:
            raise ControlError(
                f"{word} is out of range: more than zero, at most {_MAX_DURATION_S[value]:g} s."
            )
        return seconds
    if value == "FILE":
        return Path(word)
    example = ": seconds, or such as 20ms" if value in _MAX_DURATION_S else ""
    raise ControlError(f"{word!r} is not understood as {parameter}{example}.")


def _us(seconds: float | None) -> int | None:
    return None if seconds is None else round(seconds * US_PER_S)


def _held_robot(server: RobotServer) -> EmulatedRobot:
    """Return the robot; raise ControlError while it is falling and an operator cannot reach it."""
    if server.robot.falling:
        raise ControlError("The robot is falling. Wait for the landing: wait still")
    return server.robot


def _swing_joint(server: RobotServer, joint: int, angle_deg: float, period_s: float, cycles: int) -> str:
    if not 1 <= cycles <= 1000:
        raise ControlError("Swing 1 to 1000 cycles.")
    _held_robot(server).swing(joint, angle_deg, period_s, cycles)
    return f"for {cycles * period_s:g} s"


def _sweep(server: RobotServer, joint: int) -> str:
    robot = _held_robot(server)
    ranges = robot.model.joint_limits_rad
    if not 1 <= joint <= len(ranges):
        raise ControlError(f"There is no joint {joint}.")
    # A steady operator varies nothing, so the generator's seed decides nothing.
    motion = sweep_motion(ranges[joint - 1], Operator.steady(), np.random.default_rng(0))
    robot.operator.move_joint(joint, motion)
    return f"for {motion.duration_s:g} s"


def _turn(server: RobotServer, axis: Axis, angle_deg: float, rounds: int = TURN_ROUNDS) -> str:
    robot = _held_robot(server)
    if not 0 < abs(angle_deg) <= WIDEST_TURN_DEG:
        raise ControlError(f"Turn by at most {WIDEST_TURN_DEG:g} deg, either way.")
    if not 1 <= rounds <= 100:
        raise ControlError("Turn 1 to 100 rounds.")
    random = np.random.default_rng(0)
    motion = turn_motion(angle_deg, rounds, Operator.steady(), random)
    # Hold every body: the robot then turns as one rigid body, its joints at rest.
    robot.hold(range(1, robot.model.n_bodies + 1))
    robot.operator.turn(turn_axis(axis, Operator.steady(), random), motion)
    return f"for {motion.duration_s:g} s"


def _drop(server: RobotServer, fall_s: float = FALL_S) -> str:
    _held_robot(server).drop(fall_s=fall_s)
    return f"falls for {fall_s:g} s"


def _card(server: RobotServer, act: str | Path | None = None) -> str:
    slot = server.robot.card_slot
    match act:
        case "remove":
            slot.remove()
        case "insert":
            slot.insert()
        case "fill":
            slot.fill(0)
        case str():
            slot.spoil(_DEFECTS[act])
        case _:
            path, n_bytes = server.save_card(act)
            return f"{n_bytes} bytes in {path}"
    return ""


_DEFECTS = {
    "write-protect": CardDefect.WRITE_PROTECTED,
    "unformat": CardDefect.UNREADABLE,
    "fail": CardDefect.FAILING,
}


def _time(server: RobotServer) -> str:
    robot = server.robot
    motion = "falling" if robot.falling else "swinging" if robot.swinging else "still"
    return f"{robot.now_us / US_PER_S:.6f} {motion}"


def _wait(server: RobotServer, until: float | str) -> Reply:
    robot = server.robot
    if isinstance(until, str):
        return Reply("ok", lambda: not robot.falling and not robot.swinging)
    # By virtual time: a script gives the same run on a slow computer.
    end_us = robot.now_us + round(until * US_PER_S)
    return Reply("ok", lambda: robot.now_us >= end_us)


def _imu_fault(server: RobotServer, body: int, kind: Any, other: int | None = None) -> None:
    """Raises EmulationError: there is no such part, or no such fault of it; likewise the others."""
    faults = server.robot.faults
    if kind == "glitch" and other is None:
        faults.glitch(body)
    else:
        faults.imu(body, kind, other)


def _card_fault(server: RobotServer, stall_s: float | None, every_s: float = STALL_EVERY_S) -> None:
    server.robot.faults.card_stalls(_us(stall_s), round(every_s * US_PER_S))


_FAULTS = {
    "none": _Verb("", lambda server: server.robot.faults.heal()),
    "imu": _Verb("BODY dead|frozen|saturated|glitch|swapped|none [BODY]", _imu_fault),
    "battery": _Verb("none|OHM", lambda server, ohm: server.robot.faults.battery(ohm)),
    "bus": _Verb("1|2 stuck|none", lambda server, bus, kind: server.robot.faults.bus(bus, kind is not None)),
    "angle": _Verb(
        "SENSOR dead|frozen|turned|none [DEGREES]",
        lambda server, *fault: server.robot.faults.angle_sensor(*fault),
    ),
    "servo": _Verb("JOINT dead|slow|reversed|none", lambda server, *fault: server.robot.faults.servo(*fault)),
    "switch": _Verb(
        "1|2 stuck-closed|stuck-open|none", lambda server, *fault: server.robot.faults.switch(*fault)
    ),
    "wire": _Verb(
        "angle|servo|sequencer-switch|logger-switch|stroke-line PIN none|PIN",
        lambda server, *wire: server.robot.faults.connect(*wire),
    ),
    "bounce": _Verb("none|BOUNCE", lambda server, time_s: server.robot.faults.bounce(_us(time_s))),
    "card": _Verb("none|STALL [EVERY]", _card_fault),
    "clock": _Verb("sequencer|logger PPM", lambda server, *fault: server.robot.faults.clock(*fault)),
}
_VERBS: dict[str, _Verb] = {
    "hold": _Verb("BODY...", lambda server, *bodies: _held_robot(server).hold(bodies)),
    "swing": _Verb("JOINT DEGREES PERIOD CYCLES", _swing_joint),
    "sweep": _Verb("JOINT", _sweep),
    "close": _Verb("JOINT", lambda server, joint: _held_robot(server).operator.put_joint(joint)),
    "open": _Verb(
        "JOINT DEGREES",
        lambda server, joint, angle_deg: _held_robot(server).operator.put_joint(
            joint, math.radians(angle_deg)
        ),
    ),
    "turn": _Verb("x|y|z DEGREES [ROUNDS]", _turn),
    "seat": _Verb("", lambda server: _held_robot(server).seat()),
    "press": _Verb("1|2", lambda server, switch: server.robot.set_switch(switch, True)),
    "release": _Verb("1|2", lambda server, switch: server.robot.set_switch(switch, False)),
    "knock": _Verb("1|2 KNOCK", lambda server, switch, time_s: server.robot.knock(switch, _us(time_s))),
    "power": _Verb(
        "sequencer|logger on|off",
        lambda server, board, state: server.set_power(BoardIndex[board.upper()], state == "on"),
    ),
    "cable": _Verb(
        "sequencer|logger plug|pull",
        lambda server, board, state: server.set_cable(BoardIndex[board.upper()], state == "plug"),
    ),
    "reset": _Verb(
        "watchdog|brown-out|button",
        lambda server, cause: server.reset(Reset[cause.upper().replace("-", "_")]),
    ),
    **{f"fault {name}": verb for name, verb in _FAULTS.items()},
    "drop": _Verb("[FALL]", _drop),
    "angles": _Verb(
        "", lambda server: " ".join(f"{angle_deg:.2f}" for angle_deg in server.robot.joint_angles_deg())
    ),
    "card": _Verb("[remove|insert|fill|write-protect|unformat|fail|FILE]", _card),
    "time": _Verb("", _time),
    "wait": _Verb("still|DURATION", _wait),
    "help": _Verb("", lambda _: " | ".join(f"{name} {verb.words}".rstrip() for name, verb in _VERBS.items())),
    "quit": _Verb("", lambda server: server.stop()),
}


class LineTooLong(ValueError):
    """The sender does not speak this protocol."""


class ControlLines:
    """One sender's lines, in order: a `wait` holds back those after it, and no one else's."""

    def __init__(self, server: RobotServer) -> None:
        self._server = server
        self._partial = b""
        self._lines: deque[str] = deque()
        self._pending: Reply | None = None

    def feed(self, data: bytes) -> None:
        """Takes what has arrived, in pieces of any size. Raises LineTooLong."""
        # What follows the last line feed is the start of a line whose rest has not arrived yet.
        *lines, self._partial = (self._partial + data).split(b"\n")
        # Bound the buffer: a sender that never ends its line must not fill the memory.
        if len(self._partial) > MAX_LINE_BYTES:
            raise LineTooLong
        self._lines.extend(line.decode(errors="replace") for line in lines)

    def end(self) -> None:
        """Mark the end of the input: an unterminated last line counts as a line."""
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
            # At most one reply is outstanding: a `wait` that is not due yet holds back the lines behind it.
            if self._pending is not None:
                if self._pending.due is not None and not self._pending.due():
                    return due
                due.append(self._pending.text)
                self._pending = None
            if not self._lines:
                return due
            self._pending = execute(self._lines.popleft(), self._server)
