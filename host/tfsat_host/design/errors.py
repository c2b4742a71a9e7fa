"""What can be wrong with a design problem."""

from __future__ import annotations

from tfsat_host.errors import UsageError


class DesignError(UsageError):
    """No maneuver can be designed with these settings.

    Attributes:
        setting: Which one is at fault.
    """

    def __init__(self, setting: str, what: str) -> None:
        super().__init__(
            what=what,
            meaning="Nothing was designed.",
            next_step=f"Correct the {setting}: tfsat-host design --help",
        )
        self.setting = setting
