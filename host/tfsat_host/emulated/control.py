"""What a person can do to the emulated robot, as lines of text. docs/emulator.md is the reference."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from tfsat_host.calibration.steps.step import TURN_ROUNDS
from tfsat_host.emulated.card import CardDefect
from tfsat_host.emulated.control_faults import FAULT_USAGE, break_or_heal
from tfsat_host.emulated.control_words import ControlError, axis_of, board, choice, decimal, duration_s, whole
from tfsat_host.emulated.hands import Hands
from tfsat_host.emulated.motions import sweep_motion, turn_axis, turn_motion
from tfsat_host.emulated.robot import FALL_S, US_PER_S, BoardIndex, EmulatedRobot, Reset
from tfsat_host.errors import TfsatError

LONGEST_WAIT_S = 3600.0
LONGEST_FALL_S = 60.0
LONGEST_KNOCK_S = 10.0
WIDEST_TURN_DEG = 720.0

Due = Callable[[], bool]
"""Whether a reply may be given: a wait is over."""


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
    bench.robot.hold([whole(word, "body") for word in words])
    return ""


def _swing(bench: Bench, words: list[str]) -> str:
    _not_falling(bench)
    joint, cycles = whole(words[0], "joint"), whole(words[3], "number of cycles")
    angle_deg, period_s = decimal(words[1], "angle"), duration_s(words[2], LONGEST_WAIT_S)
    if not 1 <= cycles <= 1000:
        raise ControlError("Swing 1 to 1000 cycles.")
    bench.robot.swing(joint, angle_deg, period_s, cycles)
    return f"for {cycles * period_s:g} s"


def _sweep(bench: Bench, words: list[str]) -> str:
    _not_falling(bench)
    joint, ranges = whole(words[0], "joint"), bench.robot.model.joint_limits_rad
    if not 1 <= joint <= len(ranges):
        raise ControlError(f"There is no joint {joint}.")
    motion = sweep_motion(ranges[joint - 1], Hands.steady(), np.random.default_rng(0))
    bench.robot.hands.move_joint(joint, motion)
    return f"for {motion.duration_s:g} s"


def _turn(bench: Bench, words: list[str]) -> str:
    _not_falling(bench)
    axis, angle_deg = axis_of(words[0]), decimal(words[1], "angle")
    rounds = whole(words[2], "number of rounds") if len(words) == 3 else TURN_ROUNDS
    if not 0 < abs(angle_deg) <= WIDEST_TURN_DEG:
        raise ControlError(f"Turn by at most {WIDEST_TURN_DEG:g} deg, either way.")
    if not 1 <= rounds <= 100:
        raise ControlError("Turn 1 to 100 rounds.")
    random = np.random.default_rng(0)
    motion = turn_motion(angle_deg, rounds, Hands.steady(), random)
    bench.robot.hold(range(1, bench.robot.model.n_bodies + 1))
    bench.robot.hands.turn(turn_axis(axis, Hands.steady(), random), motion)
    return f"for {motion.duration_s:g} s"


def _seat(bench: Bench, words: list[str]) -> str:  # noqa: ARG001
    _not_falling(bench)
    bench.robot.seat()
    return ""


def _press(bench: Bench, words: list[str]) -> str:
    bench.robot.set_switch(whole(words[0], "switch"), True)
    return ""


def _let_go(bench: Bench, words: list[str]) -> str:
    bench.robot.set_switch(whole(words[0], "switch"), False)
    return ""


def _knock(bench: Bench, words: list[str]) -> str:
    bench.robot.knock(whole(words[0], "switch"), round(duration_s(words[1], LONGEST_KNOCK_S) * US_PER_S))
    return ""


def _power(bench: Bench, words: list[str]) -> str:
    bench.set_power(board(words[0]), choice(words[1], "on", "off"))
    return ""


def _cable(bench: Bench, words: list[str]) -> str:
    bench.set_cable(board(words[0]), choice(words[1], "plug", "pull"))
    return ""


def _reset(bench: Bench, words: list[str]) -> str:
    causes = {cause.name.lower().replace("_", "-"): cause for cause in Reset}
    if words[0].lower() not in causes:
        raise ControlError(f"There is no reset {words[0]!r}: {', '.join(causes)}.")
    bench.reset(causes[words[0].lower()])
    return ""


def _fault(bench: Bench, words: list[str]) -> str:
    break_or_heal(bench.robot.faults, words)
    return ""


def _drop(bench: Bench, words: list[str]) -> str:
    _not_falling(bench)
    fall_s = duration_s(words[0], LONGEST_FALL_S) if words else FALL_S
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
    end_us = robot.now_us + round(duration_s(words[0], LONGEST_WAIT_S) * US_PER_S)
    return Reply("ok", lambda: robot.now_us >= end_us)


def _quit(bench: Bench, words: list[str]) -> str:  # noqa: ARG001
    bench.stop()
    return ""


def _help(bench: Bench, words: list[str]) -> str:  # noqa: ARG001
    return " | ".join(verb.usage for verb in _VERBS.values())


def _not_falling(bench: Bench) -> None:
    if bench.robot.falling:
        raise ControlError("The robot is falling; nobody can touch it. Wait for the landing: wait still")


_VERBS = {
    "hold": _Verb("hold BODY...", (1, 4), _hold),
    "swing": _Verb("swing JOINT DEGREES PERIOD CYCLES", (4, 4), _swing),
    "sweep": _Verb("sweep JOINT", (1, 1), _sweep),
    "turn": _Verb("turn x|y|z DEGREES [ROUNDS]", (2, 3), _turn),
    "seat": _Verb("seat", (0, 0), _seat),
    "press": _Verb("press 1|2", (1, 1), _press),
    "release": _Verb("release 1|2", (1, 1), _let_go),
    "knock": _Verb("knock 1|2 DURATION", (2, 2), _knock),
    "power": _Verb("power sequencer|logger on|off", (2, 2), _power),
    "cable": _Verb("cable sequencer|logger plug|pull", (2, 2), _cable),
    "reset": _Verb("reset watchdog|brown-out|button", (1, 1), _reset),
    "fault": _Verb(FAULT_USAGE, (1, 4), _fault),
    "drop": _Verb("drop [DURATION]", (0, 1), _drop),
    "angles": _Verb("angles", (0, 0), _angles),
    "card": _Verb("card [remove|insert|fill|write-protect|unformat|fail|FILE]", (0, 1), _card),
    "time": _Verb("time", (0, 0), _time),
    "wait": _Verb("wait DURATION|still", (1, 1), _wait),
    "help": _Verb("help", (0, 0), _help),
    "quit": _Verb("quit", (0, 0), _quit),
}
