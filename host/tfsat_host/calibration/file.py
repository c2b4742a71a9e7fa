"""Axes of a misalignment calibration as a TOML file."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from tfsat_host.calibration.misalignment import AxisEstimate

MARK = "# tfsat misalignment"


def format_axes(axes: Sequence[AxisEstimate], logger_serial: str, taken: datetime) -> str:
    """The file's text: one `[[axis]]` per moved body, in sensor axes, with its uncertainty."""
    lines = [
        f"{MARK}: joint axes as the gyros see them",
        f"taken = {taken.astimezone(UTC).isoformat(timespec='seconds')}",
        f'logger_serial = "{logger_serial}"',
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
            f"rms_rate_deg_s = {axis.rms_rate_deg_s:.3f}",
        ]
    return "\n".join(lines) + "\n"
