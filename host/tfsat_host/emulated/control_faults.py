"""Control lines that break the emulated robot and heal it."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from tfsat_host.emulated.control_words import ControlError, board, choice, decimal, duration_s, whole
from tfsat_host.emulated.faults import (
    AngleSensorFault,
    ClockedBoard,
    Faults,
    ImuFault,
    ServoFault,
    SwitchFault,
)
from tfsat_host.emulated.robot import US_PER_S

LONGEST_BOUNCE_S = 1.0
LONGEST_STALL_S = 100.0
STALL_EVERY_S = 2.0
_USAGES = {
    "imu": "BODY dead|frozen|saturated|glitch|none, or imu BODY swapped BODY",
    "bus": "1|2 stuck|none",
    "angle": "SENSOR dead|frozen|none, or angle SENSOR turned DEGREES",
    "servo": "JOINT dead|slow|reversed|none",
    "switch": "1|2 stuck-closed|stuck-open|none",
    "bounce": "DURATION|none",
    "card": "STALL|none [EVERY]",
    "clock": "sequencer|logger PPM",
}
FAULT_USAGE = f"fault none|{'|'.join(_USAGES)} ..."


def break_or_heal(faults: Faults, words: list[str]) -> None:
    """What follows `fault` in a line.

    Raises:
        ControlError: it is not understood.
        EmulationError: there is no such part, or no such fault of it.
    """
    part, arguments = words[0].lower(), words[1:]
    if part == "none":
        if arguments:
            raise ControlError("Write: fault none.")
        faults.heal()
        return
    if part not in _PARTS:
        raise ControlError(f"There is no fault of {words[0]!r}: {', '.join(_PARTS)}.")
    (least, most), act = _PARTS[part]
    if not least <= len(arguments) <= most:
        raise ControlError(f"Write: fault {part} {_USAGES[part]}.")
    act(faults, arguments)


def _kind(word: str) -> str | None:
    """Faults refuses what it does not know."""
    return None if word.lower() == "none" else word.lower()


def _imu(faults: Faults, words: list[str]) -> None:
    if len(words) == 2 and words[1].lower() == "glitch":
        faults.glitch(whole(words[0], "body"))
        return
    other = whole(words[2], "body") if len(words) == 3 else None
    faults.imu(whole(words[0], "body"), cast("ImuFault | None", _kind(words[1])), other)


def _bus(faults: Faults, words: list[str]) -> None:
    faults.bus(whole(words[0], "bus"), choice(words[1], "stuck", "none"))


def _angle(faults: Faults, words: list[str]) -> None:
    turned_deg = decimal(words[2], "angle") if len(words) == 3 else None
    faults.angle_sensor(
        whole(words[0], "sensor"), cast("AngleSensorFault | None", _kind(words[1])), turned_deg
    )


def _servo(faults: Faults, words: list[str]) -> None:
    faults.servo(whole(words[0], "joint"), cast("ServoFault | None", _kind(words[1])))


def _switch(faults: Faults, words: list[str]) -> None:
    faults.switch(whole(words[0], "switch"), cast("SwitchFault | None", _kind(words[1])))


def _bounce(faults: Faults, words: list[str]) -> None:
    none = words[0].lower() == "none"
    faults.bounce(None if none else round(duration_s(words[0], LONGEST_BOUNCE_S) * US_PER_S))


def _card(faults: Faults, words: list[str]) -> None:
    if words[0].lower() == "none":
        faults.card_stalls(None)
        return
    every_s = STALL_EVERY_S if len(words) == 1 else duration_s(words[1], 10 * LONGEST_STALL_S)
    faults.card_stalls(round(duration_s(words[0], LONGEST_STALL_S) * US_PER_S), round(every_s * US_PER_S))


def _clock(faults: Faults, words: list[str]) -> None:
    named = cast("ClockedBoard", board(words[0]).name.lower())
    faults.clock(named, decimal(words[1], "number of ppm"))


_PARTS: dict[str, tuple[tuple[int, int], Callable[[Faults, list[str]], None]]] = {
    "imu": ((2, 3), _imu),
    "bus": ((2, 2), _bus),
    "angle": ((2, 3), _angle),
    "servo": ((2, 2), _servo),
    "switch": ((2, 2), _switch),
    "bounce": ((1, 1), _bounce),
    "card": ((1, 2), _card),
    "clock": ((2, 2), _clock),
}
