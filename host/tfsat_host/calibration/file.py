"""Axes of a misalignment calibration as a TOML file."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host import __version__
from tfsat_host.calibration.misalignment import AxisEstimate
from tfsat_host.protocol.limits import PROTOCOL_HASH

MARK = "# tfsat misalignment"


@dataclass(frozen=True, slots=True)
class Subject:
    """What a calibration is of: two files of the same subject may stand for each other.

    Attributes:
        joint: 1 to 3.
        logger_serial: Of the board that the gyros hang on, hexadecimal.
        emulated: It was no real robot.
    """

    joint: int
    logger_serial: str
    emulated: bool

    def default_name(self) -> str:
        """The file's name where the user gives none; an emulated one never looks like a real one."""
        return f"misalignment-joint-{self.joint}{'-emulated' if self.emulated else ''}.toml"

    def describe(self) -> str:
        """For people."""
        kind = "the emulated logger" if self.emulated else "logger"
        return f"joint {self.joint} on {kind} {self.logger_serial or 'without a serial number'}"


def read_subject(path: Path) -> Subject | None:
    """What the file at `path` is a calibration of; None where it does not say."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except ValueError:  # not UTF-8, or not TOML
        return None
    joint, serial, emulated = (table.get(key) for key in ("joint", "logger_serial", "emulated"))
    if isinstance(joint, int) and isinstance(serial, str) and isinstance(emulated, bool):
        return Subject(joint, serial, emulated)
    return None


def format_axes(axes: Sequence[AxisEstimate], subject: Subject, taken: datetime) -> str:
    """The file's text: one `[[axis]]` per moved body, in sensor axes, with its uncertainty."""
    lines = [
        f"{MARK}: joint axes as the gyros see them",
        f"taken = {taken.astimezone(UTC).isoformat(timespec='seconds')}",
        f"joint = {subject.joint}",
        f'logger_serial = "{subject.logger_serial}"',
        f"emulated = {str(subject.emulated).lower()}",
        f'tool_version = "{__version__}"',
        f'protocol_hash = "{PROTOCOL_HASH.hex()}"',
    ]
    for axis in axes:
        lines += [
            "",
            "[[axis]]",
            f"joint = {axis.joint}",
            f"body = {axis.body}",
            f"axis_sensor = [{', '.join(f'{value:.8f}' for value in axis.axis)}]",
            f"nominal_sensor = [{', '.join(f'{value:.8f}' for value in axis.nominal)}]",
            f"angle_deg = {axis.angle_deg:.5f}",
            f"axis_std_deg = {axis.std_deg:.6f}",
            f"bias_deg_s = [{', '.join(f'{value:.6f}' for value in axis.bias_deg_s)}]",
            f"bias_std_deg_s = [{', '.join(f'{value:.6f}' for value in axis.bias_std_deg_s)}]",
            f"rms_rate_deg_s = {axis.rms_rate_deg_s:.3f}",
        ]
    return "\n".join(lines) + "\n"
