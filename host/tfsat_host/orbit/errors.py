"""What can be wrong with a question about maneuvers on orbit."""

from __future__ import annotations

from tfsat_host.errors import TfsatError


class OrbitError(TfsatError):
    """The grid, the target or the robot does not allow an answer (exit code 1)."""
