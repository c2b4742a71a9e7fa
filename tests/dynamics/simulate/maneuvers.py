"""Maneuver files for the tests of `simulate`."""

from __future__ import annotations

from pathlib import Path

from tfsat_host.maneuver import Maneuver, Stroke, write_maneuver


def maneuver(*strokes: tuple[int, float]) -> Maneuver:
    """Strokes (joint, degrees) at the usual speed."""
    return Maneuver(tuple(Stroke(joint, angle_deg) for joint, angle_deg in strokes))


def write(path: Path, *strokes: tuple[int, float]) -> Path:
    """Write the maneuver of these strokes to a file and return its path."""
    write_maneuver(maneuver(*strokes), path)
    return path
