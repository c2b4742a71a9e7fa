"""The certificate as a file: `calibration.toml`, which people read and no command changes behind their back."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

from tfsat_host.calibration.certificate.certificate import DRAWABLE, Calibration, Subject
from tfsat_host.calibration.certificate.entries import REWRITE, UNREADABLE, Entry
from tfsat_host.calibration.certificate.tables import (
    read_gyro,
    read_joint,
    read_landing,
    read_paper,
    read_servo,
)
from tfsat_host.calibration.certificate.text import FORMAT, MARK, format_calibration, seal_in, seal_of
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT
from tfsat_host.toml_values import shown

__all__ = ["MARK", "format_calibration", "parse_calibration", "read_calibration"]

_FILE_BYTES_MAX = 4_000_000
"""A full certificate has about 40 kB."""
_TOP = (
    "format",
    "written",
    "robot",
    "logger_serial",
    "who_am_i",
    "emulated",
    "tool_version",
    "protocol_hash",
    "logger_image",
    "drawn",
)
_TABLES = ("gyro", "joint", "servo", "recording", "landing")


def read_calibration(path: str | PathLike[str]) -> Calibration:
    """The calibration in a file.

    Raises:
        CalibrationError: the file cannot be read or understood; names file, line and cure.
    """
    path = Path(path)
    try:
        if path.stat().st_size > _FILE_BYTES_MAX:
            raise CalibrationError(
                what=f"{path} is no certificate of a calibration: it is too large.",
                meaning=UNREADABLE,
                next_step="Name another file: tfsat-host calibrate writes calibration.toml.",
            )
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = (error.strerror or str(error)) if isinstance(error, OSError) else "it is not UTF-8 text"
        raise CalibrationError(
            what=f"The certificate {path} cannot be read: {reason}.",
            meaning=UNREADABLE,
            next_step="Name a certificate that tfsat-host calibrate wrote; the first step is: "
            "tfsat-host calibrate bias",
        ) from error
    return parse_calibration(text, source=str(path))


def parse_calibration(text: str, source: str = "calibration.toml") -> Calibration:
    """The calibration in the text of a file; `source` is the name that errors give it.

    The hash of another protocol is kept and not refused: what was measured does not change with it.

    Raises:
        CalibrationError: syntax, format, keys, shapes, units, frames, or values that cannot be.
    """
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also numbers and nesting beyond Python's own limits
        raise CalibrationError(
            what=f"{source}: this is no TOML: {error}.", meaning=UNREADABLE, next_step=REWRITE
        ) from error
    top = Entry(source, text, "", 0, values)
    _check_format(top)
    top.allow(*_TOP, *_TABLES)
    gyro_entries, joint_entries, servo_entries = (top.tables(key) for key in ("gyro", "joint", "servo"))
    gyros = [read_gyro(entry) for entry in gyro_entries]
    joints = [read_joint(entry) for entry in joint_entries]
    servos = [read_servo(entry) for entry in servo_entries]
    _check_each_once(top, "body", gyro_entries, [gyro.body for gyro in gyros], range(1, IMU_COUNT + 1))
    _check_each_once(top, "joint", joint_entries, [one.joint for one in joints], range(1, JOINT_COUNT + 1))
    _check_each_once(top, "joint", servo_entries, [one.joint for one, _ in servos], ())
    servos.sort(key=lambda one: one[0].joint)
    calibration = Calibration(
        subject=Subject(
            top.text("robot"), top.text("logger_serial"), top.text("who_am_i"), top.flag("emulated")
        ),
        gyros=tuple(sorted(gyros, key=lambda gyro: gyro.body)),
        joints=tuple(sorted(joints, key=lambda one: one.joint)),
        servo_maps=tuple(servo_map for servo_map, _ in servos),
        servo_taken=tuple(taken for _, taken in servos),
        papers=tuple(read_paper(entry) for entry in top.tables("recording")),
        landings=tuple(
            sorted((read_landing(entry) for entry in top.tables("landing")), key=lambda one: one.at)
        ),
        written=top.time("written"),
        tool_version=top.text("tool_version"),
        protocol_hash=top.text("protocol_hash"),
        logger_image=top.text("logger_image") if top.has("logger_image") else None,
        drawn=_drawn(top),
    )
    _check_seal(text, source)
    return calibration


def _drawn(top: Entry) -> tuple[str, ...]:
    names = top.require("drawn") if top.has("drawn") else []
    if not isinstance(names, list) or not all(isinstance(name, str) and name in DRAWABLE for name in names):
        top.fail("drawn", f"drawn is {shown(names)}, not a list of some of {', '.join(DRAWABLE)}")
    return tuple(names)


def _check_seal(text: str, source: str) -> None:
    """Last: what is wrong with a unit or a number is worth more than that it was typed."""
    if seal_in(text) != seal_of(text):
        raise CalibrationError(
            what=f"{source} was changed since tfsat-host wrote it: the SHA-256 in its last line does not match.",
            meaning="Its values are not those that its recordings tell; a drop must not be evaluated with them.",
            next_step="Copy the newest certificate-….toml from its recordings' folder over it.",
        )


def _check_format(top: Entry) -> None:
    found = top.require("format")
    if type(found) is not int or found != FORMAT:
        top.fail(
            "format",
            f"the format is {shown(found)}; this program writes and reads {FORMAT}",
            "Use the tfsat-host that made the file.",
        )


def _check_each_once(
    top: Entry, what: str, entries: Iterable[Entry], numbers: list[int], wanted: Iterable[int]
) -> None:
    """Refuses a body or joint that is described twice, or, of those that must be there, not at all."""
    seen: set[int] = set()
    for entry, number in zip(entries, numbers, strict=True):
        if number in seen:
            entry.fail(what, f"{entry.label} is described twice", "Keep one of the two.")
        seen.add(number)
    missing = [number for number in wanted if number not in seen]
    if missing:
        table = "gyro" if what == "body" else "joint"
        top.fail(table, f"there is no [[{table}]] of {what} {' and '.join(map(str, missing))}")
