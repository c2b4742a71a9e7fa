"""What came of a rehearsed day's preflight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tfsat_host.errors import RefusedError
from tfsat_host.preflight import Check, may_drop
from tfsat_host.preflight.evidence import Evidence


@dataclass(frozen=True, eq=False)
class Checked:
    """See the module.

    Attributes:
        evidence: What the boards and the day's files said.
        checks: Made of that.
    """

    evidence: Evidence
    checks: tuple[Check, ...]

    @property
    def go(self) -> bool:
        """Nothing stands against a drop."""
        return may_drop(self.checks)

    @property
    def wrong(self) -> tuple[Check, ...]:
        """What stands against it."""
        return tuple(check for check in self.checks if check.blocks)


class NoGo(RefusedError):
    """The preflight says NO-GO, and nobody drops a robot then (exit code 4)."""

    code = "no-go"

    def __init__(self, wrong: Sequence[Check]) -> None:
        super().__init__(
            what=f"Preflight says NO-GO: {', '.join(check.name for check in wrong)}. "
            + " ".join(check.sentence for check in wrong),
            meaning="Nobody drops a robot then.",
            next_step="To see what would have come of it: the same command with --despite-preflight.",
        )
