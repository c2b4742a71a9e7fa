"""An event that must stand in the log."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.sdlog import DropEvent


@dataclass(frozen=True, slots=True)
class Due:
    """One event, as what really happened tells it.

    Attributes:
        earliest_us, latest_us: Between them lies its time.
        known_us: The logger knows of it by then.
        arg: None: any.
        value: Least and greatest; None: any.
        may_lack: It is none when it stands there, and may be absent.
    """

    name: str
    earliest_us: int
    latest_us: int
    known_us: int
    index: int
    arg: int | None
    value: tuple[int, int] | None = (0, 0)
    may_lack: bool = False

    def matches(self, event: DropEvent) -> bool:
        """It is this one."""
        return (
            (event.name, event.index) == (self.name, self.index)
            and self.earliest_us <= event.t_us <= self.latest_us
            and self.arg in (None, event.arg)
            and (self.value is None or self.value[0] <= event.value <= self.value[1])
        )
