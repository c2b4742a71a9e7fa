"""The settings' file: TOML that people write, checked key by key before anything else sees it.

    format = 1
    frame_ms = 20.0            # from pulse to pulse, 5 to 20

    [[servo]]                  # one for each joint
    joint = 1
    zero_us = 1000             # pulse that holds 0 deg; the board keeps whole microseconds
    us_per_deg = 11.111        # change of the pulse for each degree, to 0.001
    reversed = false           # true: shorter pulses open the joint
    limits_deg = [0.0, 90.0]   # what may be commanded, to 0.01

A key that is not known is an error: a misspelt limit must not be silently ignored.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from tfsat_host.config import ConfigKind, Fault, Table, format_config, parse_config, read_config
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings.settings import (
    FRAME,
    NOTHING_CHANGED,
    NS_PER_US,
    ServoSettings,
    SettingsDefect,
    SettingsError,
    find_defect,
)
from tfsat_host.units import CDEG_PER_DEG, exact

FORMAT: Final = 1
_US_PER_MS = 1000
_RESOLVED = {
    "frame_ms": (_US_PER_MS, "ms", "milliseconds, such as 20"),
    "zero_us": (1, "us", "the pulse width at 0 deg in microseconds, such as 1000"),
    "us_per_deg": (NS_PER_US, "us per deg", "microseconds for each degree, such as 11.111"),
    "limits_deg": (CDEG_PER_DEG, "deg", "two numbers in degrees, such as [0, 90]"),
}
"""Of each entry with a unit: how many steps of the board's one of it has, its name, and what is wanted."""
_LARGEST = 1e9
"""Beyond every unit's range, and far from where a float's steps are larger than what the board resolves."""
_KIND = ConfigKind(
    name="file of servo settings",
    error=SettingsError,
    meaning=NOTHING_CHANGED,
    cure="For a file to start from: tfsat-host upload-servos --show --out servos.toml",
    format=("format", FORMAT),
    codes={Fault.NOT_TEXT: Fault.UNREADABLE},
    bytes_max=1_000_000,
)


def read_settings_file(path: Path) -> tuple[ServoSettings, list[str]]:
    """Reads and checks a settings' file; also what was rounded, one sentence each.

    Raises:
        SettingsError: the file cannot be read or understood, or no servo can follow it; names file, line
            and cure.
    """
    return _settings(read_config(path, _KIND))


def parse_settings(text: str, *, source: str = "settings") -> tuple[ServoSettings, list[str]]:
    """The settings in the text of a file, and what was rounded; `source` is the name that errors give it.

    Raises:
        SettingsError: syntax, format, keys, types, joints, or a rule of the board's.
    """
    return _settings(parse_config(text, source, _KIND))


def format_settings(settings: ServoSettings) -> str:
    """The text of a settings' file; `parse_settings` gives the same settings back."""
    servos = [
        {
            "joint": joint,
            "zero_us": servo.zero_us,
            "us_per_deg": servo.ns_per_deg / NS_PER_US,
            "reversed": bool(servo.reversed),
            "limits_deg": [servo.min_cdeg / CDEG_PER_DEG, servo.max_cdeg / CDEG_PER_DEG],
        }
        for joint, servo in enumerate(settings.servos, 1)
    ]
    return format_config(
        {"format": FORMAT, "frame_ms": settings.frame_us / _US_PER_MS, "servo": servos},
        heading="tfsat servo settings: how the joints' servos turn pulses into angles",
        comments={
            "frame_ms": "from pulse to pulse",
            "zero_us": "pulse that holds 0 deg",
            "us_per_deg": "change of the pulse for each degree",
            "reversed": "true: shorter pulses open the joint",
            "limits_deg": "what may be commanded",
        },
    )


def _settings(top: Table) -> tuple[ServoSettings, list[str]]:
    top.only("format frame_ms servo")
    notices: list[str] = []
    (frame_us,) = _whole(top, "", "frame_ms", notices)
    keys = "joint zero_us us_per_deg reversed limits_deg"
    entries = top.numbered("servo", "joint", JOINT_COUNT, keys, code=SettingsDefect.FILE_JOINTS)
    servos = [_servo(entry, f"joint {joint}: ", notices) for joint, entry in entries.items()]
    settings = ServoSettings(frame_us, tuple(servos))
    finding = find_defect(settings)
    if finding is not None:
        entry = top if finding.index == FRAME else entries[finding.index + 1]
        entry.fail(finding.key, finding.problem, finding.cure, finding.code)
    return settings, notices


def _servo(entry: Table, place: str, notices: list[str]) -> ServoSetting:
    (zero_us,) = _whole(entry, place, "zero_us", notices)
    (ns_per_deg,) = _whole(entry, place, "us_per_deg", notices)
    reversed_ = entry.flag("reversed", "false, or true where shorter pulses open the joint")
    low_cdeg, high_cdeg = _whole(entry, place, "limits_deg", notices, 2)
    return ServoSetting(zero_us, ns_per_deg, int(reversed_), low_cdeg, high_cdeg)


def _whole(entry: Table, place: str, key: str, notices: list[str], *shape: int) -> list[int]:
    """Numbers in what the board resolves, to the nearest whole (half to even), with a notice of what was rounded."""
    scale, unit, wanted = _RESOLVED[key]
    found = []
    for value in entry.numbers(key, *shape, wanted=wanted):
        if abs(value) > _LARGEST:
            entry.fail(key, f"{value:g} is beyond every servo", f"Give `{key}` {wanted}.")
        exactly = exact(value) * scale
        found.append(round(exactly))
        if found[-1] != exactly:
            notices.append(
                f"{place}{key} was rounded from {value} to {found[-1] / scale:g} {unit}: "
                f"the board resolves {1 / scale:g} {unit}."
            )
    return found
