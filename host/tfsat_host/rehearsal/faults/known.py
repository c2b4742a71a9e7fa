"""All faults there are."""

from __future__ import annotations

from tfsat_host.errors import UsageError
from tfsat_host.rehearsal.faults.boards import BOARD_FAULTS
from tfsat_host.rehearsal.faults.card import CARD_FAULTS
from tfsat_host.rehearsal.faults.fault import AT, Fault
from tfsat_host.rehearsal.faults.release import RELEASE_FAULTS
from tfsat_host.rehearsal.faults.sensors import SENSOR_FAULTS
from tfsat_host.rehearsal.moment import Moment

FAULTS = (*RELEASE_FAULTS, *BOARD_FAULTS, *SENSOR_FAULTS, *CARD_FAULTS)


def fault_named(typed: str) -> Fault:
    """By its name, or at another moment than its own by NAME@MOMENT. Raises UsageError for one that does not exist."""
    name, at, when = typed.partition(AT)
    fault = next((one for one in FAULTS if one.name == name), None)
    moment = next((one for one in Moment if one.typed == when), None)
    if fault is None:
        raise UsageError(
            what=f"There is no fault {name!r}.",
            meaning="Nothing was flown.",
            next_step="See them all: tfsat-host rehearse --list-faults",
        )
    if not at:
        return fault
    if moment is None:
        raise UsageError(
            what=f"There is no moment {when!r}.",
            meaning="Nothing was flown.",
            next_step=f"Write {name}{AT} and one of {', '.join(one.typed for one in Moment)}.",
        )
    return fault.at(moment)
