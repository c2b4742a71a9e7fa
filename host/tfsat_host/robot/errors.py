"""What can be wrong with a robot file."""

from __future__ import annotations

from tfsat_host.errors import TfsatError


class RobotFileError(TfsatError):
    """The robot file cannot be read or does not describe a robot (exit code 1)."""
