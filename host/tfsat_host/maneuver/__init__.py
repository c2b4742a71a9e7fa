"""Maneuvers: strokes, when they happen, whether the robot may fly them, and the file they live in.

Pure: knows nothing of ports, terminals or boards.
"""

from tfsat_host.maneuver.maneuver import (
    Defect,
    Maneuver,
    ManeuverError,
    Stroke,
    format_maneuver,
    four_stroke,
    parse_maneuver,
    read_maneuver,
    write_maneuver,
)
from tfsat_host.maneuver.schedule import Schedule, TimedStroke, count_moving, schedule_maneuver
from tfsat_host.maneuver.stroke_checks import SEQUENCER, Limits

__all__ = [
    "SEQUENCER",
    "Defect",
    "Limits",
    "Maneuver",
    "ManeuverError",
    "Schedule",
    "Stroke",
    "TimedStroke",
    "count_moving",
    "format_maneuver",
    "four_stroke",
    "parse_maneuver",
    "read_maneuver",
    "schedule_maneuver",
    "write_maneuver",
]
