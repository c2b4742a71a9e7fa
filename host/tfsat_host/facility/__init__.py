"""The place where the robot is dropped: fall, test space and release mechanism, and whether a maneuver fits them.

Knows nothing of ports, terminals or boards. Units in names; millimetres, as the paper's section on the facility.
"""

from tfsat_host.facility.envelope import (
    Envelope,
    EnvelopeError,
    envelope_of,
    permissible_transversal_velocities,
)
from tfsat_host.facility.precheck import Check, check_maneuver
from tfsat_host.facility.tower import DropTower, FacilityFileError, default_facility_path, load_tower

__all__ = [
    "Check",
    "DropTower",
    "Envelope",
    "EnvelopeError",
    "FacilityFileError",
    "check_maneuver",
    "default_facility_path",
    "envelope_of",
    "load_tower",
    "permissible_transversal_velocities",
]
