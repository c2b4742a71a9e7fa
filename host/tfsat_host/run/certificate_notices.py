"""What stands against a calibration where sensors are used: other sensors, something missing, a landing since."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.archive import measured_after
from tfsat_host.calibration.certificate.certificate import (
    Calibration,
    Shortcoming,
    of_another_robot,
    quantities,
)
from tfsat_host.calibration.steps.evidence import Origin
from tfsat_host.protocol.limits import IMU_COUNT
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE

_NAMED = 3
_CLOCKS_APART = timedelta(minutes=1)


def command_options(file: Path, *, emulated: bool) -> str:
    """What makes a `calibrate` command work on that certificate, with a space before; empty where nothing need be."""
    default = Path(EMULATED_CERTIFICATE if emulated else CERTIFICATE)
    out = "" if file.resolve() == default.resolve() else f" --out {shlex.quote(str(file))}"
    return out + (" --emulated" if emulated else "")


def notices(
    calibration: Calibration,
    origin: Origin | None,
    file: Path,
    before: datetime | None = None,
    now: datetime | None = None,
    *,
    servos: bool = True,
) -> list[str]:
    """All that stands against using a calibration, a sentence or two each; nothing: it can be used.

    Args:
        calibration: As it was read.
        origin: Whose sensors it would be used for; None: not known.
        file: The certificate that further steps are to go into.
        before: When its samples were taken: later landings do not matter, but what was measured after one may
            have been otherwise. None: now.
        now: By the computer's clock, unless given.
        servos: Whether theirs count; no sensor's reading rests on them.
    """
    if origin is not None and (other := _of_another_robot(calibration, origin)):
        return [other]
    objections = [] if origin is None else _of_other_imus(calibration, origin)
    options = command_options(file, emulated=calibration.subject.emulated)
    shortcomings = _shortcomings(calibration, before, servos=servos)
    for reason, words in (
        ("missing", "The calibration lacks"),
        ("stale", "Measured before the last landing, which may have changed it:"),
    ):
        lacking = [one for one in shortcomings if one.reason == reason]
        if lacking:
            commands = _commands((one.command for one in lacking), options)
            objections.append(f"{words} {_listed([one.name for one in lacking])}. To measure: {commands}")
    later = [] if before is None else _measured_after_a_landing(calibration, before)
    if later:
        objections.append(
            f"Measured only after the landing that followed, which may have changed it: {_listed(later)}. "
            "A calibration from before the drop says more."
        )
    return objections + _of_the_future(calibration, file, now or datetime.now(UTC))


def as_json(
    calibration: Calibration,
    file: Path,
    objections: list[str],
    before: datetime | None = None,
    into: Path | None = None,
    *,
    servos: bool = True,
) -> dict[str, Any]:
    """For `--json`, under `calibration`; `into` is the certificate that further steps go into, if not `file`."""
    options = command_options(into or file, emulated=calibration.subject.emulated)
    return {
        "file": str(file),
        "usable": not objections,
        "shortcomings": [
            _shortcoming_as_json(one, options) for one in _shortcomings(calibration, before, servos=servos)
        ],
        "sentences": objections,
    }


def unreadable_as_json(file: Path, sentence: str) -> dict[str, Any]:
    """The same of a certificate that could not be read."""
    return {"file": str(file), "usable": False, "shortcomings": [], "sentences": [sentence]}


def _shortcomings(calibration: Calibration, before: datetime | None, *, servos: bool) -> list[Shortcoming]:
    return [one for one in calibration.shortcomings(before) if servos or not one.name.startswith("servo ")]


def _shortcoming_as_json(shortcoming: Shortcoming, options: str) -> dict[str, Any]:
    return {
        "quantity": shortcoming.name,
        "reason": shortcoming.reason,
        "taken": None if shortcoming.taken is None else shortcoming.taken.isoformat(),
        "command": f"tfsat-host calibrate {shortcoming.command}{options}",
    }


def _of_another_robot(calibration: Calibration, origin: Origin) -> str:
    """Empty if it is of the same."""
    other = of_another_robot(calibration.subject, origin)
    return other and f"The calibration{other.removeprefix('It')} None of its numbers hold."


def _of_other_imus(calibration: Calibration, origin: Origin) -> list[str]:
    calibrated, found = calibration.subject.who_am_i, origin.who_am_i
    if calibrated == found:
        return []
    bodies = [
        str(body)
        for body in range(1, IMU_COUNT + 1)
        if calibrated[2 * body - 2 : 2 * body] != found[2 * body - 2 : 2 * body]
    ]
    return [
        f"The IMU of body {' and '.join(bodies)} is another than the one that was calibrated, or does not answer "
        f"(WHO_AM_I {found}, calibrated {calibrated}): its numbers do not hold."
    ]


def _measured_after_a_landing(calibration: Calibration, moment: datetime) -> list[str]:
    """What a landing after `moment` may have changed before it was measured."""
    landing = next((landing.at for landing in calibration.landings if landing.at >= moment), None)
    return [] if landing is None else measured_after(calibration, landing)


def _of_the_future(calibration: Calibration, file: Path, now: datetime) -> list[str]:
    """A certificate takes no step that is older than the one it has: one of the future needs another file."""
    early = [
        one for one in quantities(calibration) if one.taken is not None and one.taken > now + _CLOCKS_APART
    ]
    if not early:
        return []
    last = max(one.taken for one in early if one.taken is not None)
    another = command_options(file.with_name(f"{file.stem}-anew.toml"), emulated=calibration.subject.emulated)
    return [
        f"{_listed([one.name for one in early])} {'was' if len(early) == 1 else 'were'} measured in the future "
        f"({last.astimezone(UTC):%Y-%m-%d %H:%M} UTC): the clock was wrong then or is now; landings cannot end it. "
        f"Set the clock if it is wrong now; else measure again into another certificate: "
        f"{_commands((one.command for one in early), another)}"
    ]


def _commands(commands: Iterable[str], options: str) -> str:
    return _listed(list(dict.fromkeys(f"tfsat-host calibrate {command}{options}" for command in commands)))


def _listed(names: list[str]) -> str:
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")
