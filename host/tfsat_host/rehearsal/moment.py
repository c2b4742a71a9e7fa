"""The moments of the day at which something may go wrong, in their order."""

from __future__ import annotations

from enum import Enum

GUARD_US = 100_000
"""Before and after the landing."""


class Moment(Enum):
    """Each is named after what has just been done, or is just about to be."""

    POWERED = "boards have started"
    UPLOADED = "maneuver uploaded and read back"
    CHECKED = "preflight made"
    RECORDING = "recording, hanging in the releaser"
    ARMED = "armed"
    LIFTED = "cables pulled, on the crane's hook"
    RELEASE = "about to be let go"
    FALLING = "halfway through the fall"
    BEFORE_LANDING = "100 ms before the landing"
    LANDING = "landing"
    LANDED = "100 ms after the landing"

    @property
    def typed(self) -> str:
        """As people type it."""
        return self.name.lower().replace("_", "-")
