"""What an evaluation refuses."""

from __future__ import annotations

from tfsat_host.errors import TfsatError


class EvaluationError(TfsatError):
    """The recording does not hold what an evaluation needs."""
