"""What can be wrong with a campaign."""

from __future__ import annotations

from tfsat_host.errors import TfsatError


class CampaignError(TfsatError):
    """A campaign cannot be read, or must not be changed so (exit code 1)."""
