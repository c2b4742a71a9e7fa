"""All faults there are."""

from __future__ import annotations

from tfsat_host.errors import UsageError
from tfsat_host.rehearsal.faults.boards import BOARD_FAULTS
from tfsat_host.rehearsal.faults.card import CARD_FAULTS
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.faults.release import RELEASE_FAULTS
from tfsat_host.rehearsal.faults.sensors import SENSOR_FAULTS

FAULTS = (*RELEASE_FAULTS, *BOARD_FAULTS, *SENSOR_FAULTS, *CARD_FAULTS)


def fault_named(name: str) -> Fault:
    """By its name. Raises UsageError for one that does not exist."""
    for fault in FAULTS:
        if fault.name == name:
            return fault
    raise UsageError(
        what=f"There is no fault {name!r}.",
        meaning="Nothing was flown.",
        next_step="See them all: tfsat-host rehearse --list-faults",
    )
