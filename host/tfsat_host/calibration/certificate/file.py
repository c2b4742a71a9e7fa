"""The certificate as a file: `calibration.toml`, which people read and no command changes behind their back."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import asdict, fields
from os import PathLike
from pathlib import Path
from typing import Any, Final

from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.certificate.certificate import QUANTITY_NAMES, Calibration, Landing, Subject
from tfsat_host.calibration.certificate.certificate_tables import (
    LANDING,
    RECORDING,
    REPLACEMENT,
    dynamics_table,
    gyro_table,
    joint_table,
    read_dynamics,
    read_gyro,
    read_joint,
    read_recording,
    read_servo,
    servo_table,
)
from tfsat_host.calibration.certificate.layout import Item, read_values, text, written_values
from tfsat_host.calibration.replacements import Replacement
from tfsat_host.config import ConfigKind, Table, format_config, parse_config, read_config
from tfsat_host.config.table import shorten_value
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT

FORMAT: Final = 1
_HEADING = """\
tfsat calibration: values with their uncertainty, in the unit and frame that stand next to them.
A key that is not there was never measured. std: one standard deviation, by the covariance.
measured: body axis, and when the direction of it, or the scale factor about it, was measured."""
_SEAL = "# sha256 of all that stands above: "
_KIND = ConfigKind(
    name="certificate",
    error=CalibrationError,
    meaning="Without a certificate that can be read, nothing is known of the sensors' errors.",
    cure="A step of tfsat-host calibrate writes the file again from its recordings, if you move this one away.",
    format=("format", FORMAT),
    computed=True,
)


def read_calibration(path: str | PathLike[str]) -> Calibration:
    """Read the calibration in a file.

    Raises:
        CalibrationError: the file cannot be read or understood; names file, line and cure.
    """
    return _calibration(read_config(Path(path), _KIND))


def parse_calibration(text: str, source: str = "calibration.toml") -> Calibration:
    """Parse the calibration in the text of a file; `source` is the file's name in errors.

    The hash of another protocol is kept and not refused: measured values do not change with it.

    Raises:
        CalibrationError: wrong syntax, format, keys, shapes, units or frames, or impossible values.
    """
    return _calibration(parse_config(text, source, _KIND))


def certificate_values(calibration: Calibration) -> dict[str, Any]:
    """Return all values of the certificate's file, by key."""
    return written_values(
        _TOP,
        {
            **{field.name: getattr(calibration, field.name) for field in fields(calibration)},
            **asdict(calibration.subject),
            "gyros": [gyro_table(gyro) for gyro in calibration.gyros],
            "joints": [joint_table(sensors) for sensors in calibration.joints],
            "servo_maps": [servo_table(servo_map) for servo_map in calibration.servo_maps],
            "servo_dynamics": [dynamics_table(dynamics) for dynamics in calibration.servo_dynamics],
            "recordings": [
                written_values(RECORDING, asdict(recording)) for recording in calibration.recordings
            ],
            "landings": [asdict(landing) for landing in calibration.landings],
            "replacements": [asdict(entry) for entry in calibration.replacements] or None,
        },
    )


def format_calibration(calibration: Calibration) -> str:
    """Format the certificate's file text; `parse_calibration` restores the same calibration."""
    drawn_comment = "never measured; a rehearsal drew it from the emulated robot's hidden truth"
    text = format_config(certificate_values(calibration), _HEADING, {"drawn": drawn_comment})
    # The seal is a comment to TOML, and so no part of what it hashes.
    return f'{text}\n{_SEAL}"{_seal_of(text)}"\n'


def _calibration(top: Table) -> Calibration:
    values = read_values(top, _TOP)
    _check_seal(top)
    subject = Subject(**{field.name: values.pop(field.name) for field in fields(Subject)})
    return Calibration(
        subject=subject,
        simulated_quantities=tuple(values.pop("simulated_quantities") or ()),
        landings=tuple(sorted(values.pop("landings"), key=lambda landing: landing.at)),
        replacements=tuple(sorted(values.pop("replacements") or (), key=lambda entry: entry.at)),
        **values,
    )


def _seal_of(text: str) -> str:
    """SHA-256 of a certificate's text, hexadecimal; its seal and the kind of its line ends do not count."""
    # Editors and transfers change line ends and blank lines at the end: no value changes with these.
    lines = [line for line in text.splitlines() if not line.startswith(_SEAL)]
    return hashlib.sha256("\n".join(lines).rstrip().encode()).hexdigest()


def _check_seal(top: Table) -> None:
    """Last: what is wrong with a unit or a number is worth more than that it was typed."""
    seals = [line for line in top.file_text.splitlines() if line.startswith(_SEAL)]
    if seals != [f'{_SEAL}"{_seal_of(top.file_text)}"']:
        raise CalibrationError(
            what=f"{top.source} was changed since tfsat-host wrote it: the SHA-256 in its last line does not match.",
            meaning="Its values are not those that its recordings tell; a drop must not be evaluated with them.",
            next_step="Copy the newest certificate-….toml from its recordings' folder over it.",
        )


def _read_drawn_steps(top: Table, key: str) -> list[str]:
    requirement = f"a list of some of {', '.join(QUANTITY_NAMES)}"
    names = top.value(key, requirement)
    if not isinstance(names, list) or not all(
        isinstance(name, str) and name in QUANTITY_NAMES for name in names
    ):
        top.fail(key, f"{shorten_value(names)} is not {requirement}")
    return names


def _all(read: Callable[[Table], Any]) -> Callable[[Table, str], tuple[Any, ...]]:
    """Build a reader of a list of tables, in the file's order."""
    return lambda top, key: tuple(read(entry) for entry in top.tables(key))


def _each(
    of: str, count: int, read: Callable[[Table], Any], *, require_all: bool = True
) -> Callable[[Table, str], tuple[Any, ...]]:
    """Build a reader of a list of tables, by the number of each one's body or joint."""

    def by_number(top: Table, key: str) -> tuple[Any, ...]:
        return tuple(
            read(entry) for entry in top.tables_by_number(key, of, count, require_all=require_all).values()
        )

    return by_number


_TOP = {
    "format": FORMAT,
    "written": Item("written", Table.time),
    "robot": text("robot"),
    "logger_serial": text("logger_serial"),
    "who_am_i": text("who_am_i"),
    "emulated": Item("emulated", Table.flag),
    "tool_version": text("tool_version"),
    "protocol_hash": text("protocol_hash"),
    "logger_image?": text("logger_image"),
    "drawn?": Item("simulated_quantities", _read_drawn_steps),
    "gyro": Item("gyros", _each("body", IMU_COUNT, read_gyro)),
    "joint": Item("joints", _each("joint", JOINT_COUNT, read_joint)),
    "servo": Item("servo_maps", _each("joint", JOINT_COUNT, read_servo, require_all=False)),
    "servo_dynamics": Item("servo_dynamics", _all(read_dynamics)),
    "recording": Item("recordings", _all(read_recording)),
    "replaced?": Item("replacements", _all(lambda entry: Replacement(**read_values(entry, REPLACEMENT)))),
    "landing": Item("landings", _all(lambda entry: Landing(**read_values(entry, LANDING)))),
}
