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

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings.entries import Entries
from tfsat_host.servo_settings.errors import SettingsDefect, SettingsError
from tfsat_host.servo_settings.rules import FRAME, find_defect
from tfsat_host.servo_settings.settings import NS_PER_US, ServoSettings
from tfsat_host.units import CDEG_PER_DEG

FORMAT: Final = 1
_US_PER_MS = 1000
_FILE_BYTES_MAX = 1_000_000
_START_FROM = "For a file to start from: tfsat-host upload-servos --show --out servos.toml"


def read_settings_file(path: Path) -> tuple[ServoSettings, list[str]]:
    """Reads and checks a settings' file; also what was rounded, one sentence each.

    Raises:
        SettingsError: the file cannot be read or understood, or no servo can follow it; names file, line
            and cure.
    """
    try:
        if path.stat().st_size > _FILE_BYTES_MAX:
            raise SettingsError(
                SettingsDefect.FILE_SYNTAX,
                what=f"{path}: this is no file of servo settings: it is too large.",
                next_step=_START_FROM,
            )
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = (error.strerror or str(error)) if isinstance(error, OSError) else "it is not UTF-8 text"
        raise SettingsError(
            SettingsDefect.FILE_UNREADABLE,
            what=f"The servo settings' file {path} cannot be read: {reason}.",
            next_step=f"Give the path of a settings' file. {_START_FROM}",
        ) from error
    return parse_settings(text, source=str(path))


def parse_settings(text: str, *, source: str = "settings") -> tuple[ServoSettings, list[str]]:
    """The settings in the text of a file, and what was rounded; `source` is the name that errors give it.

    Raises:
        SettingsError: syntax, format, keys, types, joints, or a rule of the board's.
    """
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also numbers and nesting beyond Python's own limits
        raise SettingsError(
            SettingsDefect.FILE_SYNTAX, what=f"{source}: this is no TOML: {error}.", next_step=_START_FROM
        ) from error
    top = Entries(source, text, "", 0, table)
    _check_format(top, table)
    top.allow(("format", "frame_ms", "servo"))
    notices: list[str] = []
    frame_us = top.scaled("frame_ms", _US_PER_MS, notices)
    entries = top.tables("servo")
    servos = [_servo(entry, notices) for entry in entries]
    by_joint = _by_joint(top, entries)
    settings = ServoSettings(frame_us, tuple(servos[by_joint[joint]] for joint in sorted(by_joint)))
    finding = find_defect(settings)
    if finding is not None:
        entry = top if finding.index == FRAME else entries[by_joint[finding.index + 1]]
        raise entry.error(finding.code, finding.key, finding.problem, finding.cure)
    return settings, notices


def format_settings(settings: ServoSettings) -> str:
    """The text of a settings' file; `parse_settings` gives the same settings back."""
    lines = [
        "# tfsat servo settings: how the joints' servos turn pulses into angles",
        f"format = {FORMAT}",
        f"frame_ms = {settings.frame_us / _US_PER_MS!r}  # from pulse to pulse",
    ]
    for joint, servo in enumerate(settings.servos, 1):
        low_deg, high_deg = servo.min_cdeg / CDEG_PER_DEG, servo.max_cdeg / CDEG_PER_DEG
        lines += [
            "",
            "[[servo]]",
            f"joint = {joint}",
            f"zero_us = {servo.zero_us}  # pulse that holds 0 deg",
            f"us_per_deg = {servo.ns_per_deg / NS_PER_US!r}  # change of the pulse for each degree",
            f"reversed = {str(bool(servo.reversed)).lower()}  # true: shorter pulses open the joint",
            f"limits_deg = [{low_deg!r}, {high_deg!r}]  # what may be commanded",
        ]
    return "\n".join(lines) + "\n"


def _check_format(top: Entries, table: Mapping[str, object]) -> None:
    top.require("format", f"Add the line format = {FORMAT} at the top of the file.")
    if type(table["format"]) is not int or table["format"] != FORMAT:
        raise top.error(
            SettingsDefect.FILE_FORMAT,
            "format",
            f"this tfsat-host reads format {FORMAT}",
            f"Write format = {FORMAT}, or use the tfsat-host that made the file.",
        )


def _servo(entry: Entries, notices: list[str]) -> ServoSetting:
    entry.allow(("joint", "zero_us", "us_per_deg", "reversed", "limits_deg"))
    entry.require("joint", "Say which joint this servo moves: joint = 1, 2 or 3.")
    zero_us = entry.scaled("zero_us", 1, notices)
    ns_per_deg = entry.scaled("us_per_deg", NS_PER_US, notices)
    reversed_ = entry.flag("reversed")
    low_cdeg, high_cdeg = entry.scaled_pair("limits_deg", CDEG_PER_DEG, notices)
    return ServoSetting(zero_us, ns_per_deg, int(reversed_), low_cdeg, high_cdeg)


def _by_joint(top: Entries, entries: list[Entries]) -> dict[int, int]:
    """Index of each joint's entry. Raises SettingsError unless each joint has exactly one."""
    found: dict[int, int] = {}
    for index, entry in enumerate(entries):
        joint = entry.joint()
        if joint in found:
            raise entry.error(
                SettingsDefect.FILE_JOINTS, "joint", f"joint {joint} is described twice", "Keep one of them."
            )
        found[joint] = index
    missing = [joint for joint in range(1, JOINT_COUNT + 1) if joint not in found]
    if missing:
        raise top.error(
            SettingsDefect.FILE_JOINTS,
            "servo",
            f"there is no servo of joint {' and '.join(map(str, missing))}",
            f"Describe each of joints 1 to {JOINT_COUNT} below its own line [[servo]].",
        )
    return found
