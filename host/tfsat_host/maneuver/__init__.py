"""Maneuvers: strokes, when they happen, whether the robot may fly them, and the file they live in.

Pure: knows nothing of ports, terminals or boards.
"""

from tfsat_host.maneuver.errors import Defect, ManeuverError
from tfsat_host.maneuver.file import format_maneuver, parse_maneuver, read_maneuver, write_maneuver
from tfsat_host.maneuver.limits import SEQUENCER, Limits
from tfsat_host.maneuver.maneuver import Maneuver, four_stroke
from tfsat_host.maneuver.schedule import Schedule, TimedStroke, schedule_maneuver
from tfsat_host.maneuver.stroke import Stroke

__all__ = [
    "SEQUENCER",
    "Defect",
    "Limits",
    "Maneuver",
    "ManeuverError",
    "Schedule",
    "Stroke",
    "TimedStroke",
    "format_maneuver",
    "four_stroke",
    "parse_maneuver",
    "read_maneuver",
    "schedule_maneuver",
    "write_maneuver",
]
