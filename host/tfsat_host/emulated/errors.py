"""What the emulated robot refuses."""

from __future__ import annotations

from tfsat_host.errors import TfsatError


class EmulationError(TfsatError):
    """The emulated robot cannot do this, or its processor crashed."""
