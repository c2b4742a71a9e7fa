"""What can be wrong with a campaign."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    from tfsat_host.campaign.entries import DropEntry


class CampaignError(TfsatError):
    """A campaign cannot be read, or must not be changed so (exit code 1)."""


class SameDropError(CampaignError):
    """A recording is of a drop that the campaign has (exit code 1).

    Attributes:
        drop: That one.
    """

    def __init__(self, drop: DropEntry, *, what: str, meaning: str, next_step: str) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.drop = drop
